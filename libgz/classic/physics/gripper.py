"""Gripper: what holds things with the links of a model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from libgz.classic.physics.base import Base
    from libgz.sdfworld.gripper import SdfGripper

__all__ = ["Gripper"]


class Gripper:
    """A view on a gripper, which fixes what its links hold to its palm."""

    def __init__(self, model: Base, core: SdfGripper) -> None:
        self._model, self.core = model, core

    def GetName(self) -> str:
        """The name."""
        return self.core.name

    Name = GetName

    def GetModel(self) -> Base | Any:
        """The model that it belongs to."""
        return self._model

    def IsAttached(self) -> bool:
        """Whether something is fixed to the palm."""
        return self.core.attached
