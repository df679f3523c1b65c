"""DynamicLines: lines and points that plugins add to images."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import NotFoundError
from libgz.base.geometry import GzColor, GzCoordPositionSub, GzPose, VectorLike
from libgz.classic.math import Color, Vector3d
from libgz.classic.names import takes_names
from libgz.rendering.shot import Lines, pose_matrix
from libgz.sdf.materials import find_material

__all__ = ["DynamicLines", "LineFrame", "placed"]

SPOT = 0.02  # [m] size of the crosses that show points
CROSS = SPOT / 2.0 * np.array(((-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)), dtype=float)


class LineFrame(Protocol):
    """The visual in whose frame lines are, as they use it."""

    @property
    def deleted(self) -> bool:
        """Whether its body was deleted."""

    def Name(self) -> str:
        """Its full name."""

    def Visible(self) -> bool:
        """Whether it is shown."""

    def world_pose(self) -> GzPose:
        """Global pose [m]."""


@takes_names
class DynamicLines:
    """Unlit lines through points in the frame of a visual.

    `Visual.CreateDynamicLine` makes them. The line between two points has the colour of the first.

    Attributes:
        attached: the visuals that points move with, by the points' numbers.
    """

    STATE = ("type", "_packed", "_visible")

    POINT_LIST: ClassVar[int] = 0  # each point by itself
    LINE_LIST: ClassVar[int] = 1  # a line from each even point to the next one
    LINE_STRIP: ClassVar[int] = 2  # one line through all points

    def __init__(self, visual: LineFrame, type: int = LINE_STRIP) -> None:
        self.visual, self.type = visual, type
        self._points, self._colors = array("d"), array("d")  # numbers: x, y, z of each; r, g, b, a
        self.attached: dict[int, LineFrame] = {}
        self._visible = True

    def AddPoint(self, point: VectorLike | float, *values: float | GzColor) -> None:
        """Add a point [m], as a vector or as x, y, z; a colour may follow (default white)."""
        if isinstance(point, int | float):
            numbers = [float(v) for v in values[:2] if isinstance(v, int | float)]
            point, values = Vector3d(float(point), *numbers), values[2:]
        color = values[0] if values else Color(1.0, 1.0, 1.0)
        self._points.extend(Vector3d(*point))
        self._colors.extend(color if isinstance(color, GzColor) else Color(1.0, 1.0, 1.0))

    @property
    def _packed(self) -> tuple[bytes, bytes]:
        """Points and colours, as the bytes of their numbers."""
        return self._points.tobytes(), self._colors.tobytes()

    @_packed.setter
    def _packed(self, packed: tuple[bytes, bytes]) -> None:
        self._points, self._colors = (array("d", part) for part in packed)

    def _check(self, index: int) -> int:
        count = self.PointCount()
        if not 0 <= index < count:
            raise NotFoundError(f"these lines have {count} points, from 0 on; not {index}")
        return index

    def _set_point(self, index: int, point: Iterable[float]) -> None:
        self._points[3 * index : 3 * index + 3] = array("d", point)

    def SetPoint(self, index: int, value: VectorLike) -> None:
        """Move a point [m].

        Raises:
            NotFoundError: there is no such point.
        """
        self._set_point(self._check(index), Vector3d(*value))

    def Point(self, index: int) -> Vector3d:
        """A point [m].

        Raises:
            NotFoundError: there is no such point.
        """
        at = 3 * self._check(index)
        return Vector3d(*self._points[at : at + 3])

    GetPoint = Point

    def PointCount(self) -> int:
        """The number of points."""
        return len(self._points) // 3

    GetPointCount = PointCount

    def SetColor(self, index: int, color: GzColor) -> None:
        """Set the colour of a point and of the line from it."""
        at = 4 * self._check(index)
        self._colors[at : at + 4] = array("d", Color(*color))

    def setMaterial(self, name: str) -> None:
        """Give all present points the colour of a material."""
        material = find_material(name)
        if material is not None:
            glow = material.emissive if any(material.emissive[:3]) else material.ambient
            self._colors = array("d", Color(*glow)) * self.PointCount()

    SetMaterial = setMaterial

    def setVisible(self, visible: bool) -> None:
        """Show or hide them."""
        self._visible = bool(visible)

    def setVisibilityFlags(self, flags: int) -> None:
        """Accepted, and ignored: all cameras show them."""

    def Clear(self) -> None:
        """Remove all points."""
        del self._points[:], self._colors[:]
        self.attached.clear()

    def Update(self) -> None:
        """Accepted: every image shows the present points."""

    def attach(self, index: int, visual: LineFrame) -> None:
        """Attach a point to a visual: it moves with the visual."""
        self.attached[index] = visual

    def segments(self) -> list[Lines]:
        """The lines to render, by colour."""
        frame = self.visual.world_pose()
        self.attached = {index: visual for index, visual in self.attached.items() if not visual.deleted}
        for index, visual in self.attached.items():
            if index < self.PointCount():
                self._set_point(index, GzCoordPositionSub(visual.world_pose().pos, frame.pos, frame.rot))
        if not self._visible or not self.visual.Visible():
            return []
        of_color: dict[tuple[float, float, float], list[NDArray[np.float64]]] = {}
        step = 2 if self.type == self.LINE_LIST else 1
        points = np.array(self._points).reshape(-1, 3)
        for i in range(0, len(points) - (self.type != self.POINT_LIST), step):
            ends = CROSS + points[i] if self.type == self.POINT_LIST else points[i : i + 2]
            red, green, blue = self._colors[4 * i : 4 * i + 3]
            of_color.setdefault((red, green, blue), []).append(ends)
        return [placed(np.concatenate(parts), frame, color) for color, parts in of_color.items()]


def placed(ends: NDArray[np.float64], frame: GzPose, color: tuple[float, float, float]) -> Lines:
    """Lines whose ends [m], shape (2 n, 3), are given in a frame."""
    matrix = pose_matrix(frame)
    return Lines(np.ascontiguousarray(ends @ matrix[:3, :3].T + matrix[:3, 3], dtype=np.float32), color)
