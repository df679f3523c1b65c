"""Lets worlds of Gazebo classic name C++ plugins."""

from __future__ import annotations

from pathlib import Path

from libgz.classic.loading import register_compiled
from libgz.simulation.plugins import Plugin

__all__ = ["register"]


def _is_plugin(path: Path) -> bool:
    """Whether a file is a C++ plugin; what runs them is imported by worlds that name a shared object."""
    from libgz.classic_cxx.plugin import is_plugin

    return is_plugin(path)


def _load(path: Path) -> Plugin:
    from libgz.classic_cxx.plugin import load

    return load(path)


def register() -> None:
    """From now on, names of plugins may mean shared objects. Can be called twice."""
    register_compiled(_is_plugin, _load)
