"""Launch: what the installed commands call."""

from __future__ import annotations

import gc
from importlib import import_module

__all__ = ["gazebo", "gzclient", "gzserver", "libgz"]


def gazebo() -> int:
    """The command gazebo."""
    return _launch("gazebo")


def gzclient() -> int:
    """The command gzclient."""
    return _launch("gzclient")


def gzserver() -> int:
    """The command gzserver."""
    return _launch("gzserver")


def libgz() -> int:
    """The command libgz."""
    return _launch("libgz")


def _launch(name: str) -> int:
    """Import a command without garbage collection, which would search the same modules for garbage many times."""
    gc.disable()
    command = import_module(f"libgz.apps.{name}")
    gc.freeze()
    gc.enable()
    code: int = command.main()
    return code
