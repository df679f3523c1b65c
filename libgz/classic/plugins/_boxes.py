"""Boxes in space that plugins compare places with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.classic.math import Pose3d, Vector3d

if TYPE_CHECKING:
    from collections.abc import Iterable

    from libgz.sdf.element import Element

__all__ = ["Box", "box_of"]


@dataclass
class Box:
    """A box that may be turned.

    Attributes:
        pose: of its centre [m], [rad].
        size: of its sides [m].
    """

    pose: Pose3d
    size: Vector3d

    def contains(self, point: Iterable[float]) -> bool:
        """Whether a point [m] is in it or on its surface."""
        inside = self.pose.Rot().RotateVectorReverse(Vector3d(*point) - self.pose.Pos())
        return all(abs(v) <= side / 2.0 for v, side in zip(inside, self.size, strict=True))


def box_of(element: Element) -> Box:
    """The box of `<pose>` and `<geometry><box><size>` in an element.

    Raises:
        ParameterError: there is no size, or one that is not positive.
    """
    size = element.child("geometry").child("box").Get(Vector3d, "size")
    if not min(size) > 0.0:
        raise ParameterError(f"{element.where}: <geometry><box><size> is {size}; three positive lengths are needed")
    return Box(element.Get(Pose3d, "pose"), size)
