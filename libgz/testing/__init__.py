"""Tests of worlds and programs with pytest: the fixture `libgz_world`, which `libgz.testing.plugin` offers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from libgz.testing.worlds import Worlds as Worlds

__all__ = ["Worlds"]


def __getattr__(name: str) -> Any:
    if name != "Worlds":  # imported when it is first used: pytest imports this package in every run
        raise AttributeError(f"module 'libgz.testing' has no attribute {name!r}")
    from libgz.testing.worlds import Worlds

    return Worlds
