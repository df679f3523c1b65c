"""DynamicLines: lines and points that plugins draw."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.classic.math import Color, Vector3d
from libgz.errors import NotFoundError
from libgz.geometry import GzColor, GzCoordPositionSub, GzPose, VectorLike
from libgz.rendering.shot import Lines, pose_matrix
from libgz.sdf.materials import find_material

if TYPE_CHECKING:
    from libgz.classic.rendering.visual import Visual

__all__ = ["DynamicLines", "placed"]

SPOT = 0.02  # [m] of the crosses that points are shown as
CROSS = SPOT / 2.0 * np.array(((-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)), dtype=float)


class DynamicLines:
    """Lines through points in the frame of a visual, without light and shade.

    `Visual.CreateDynamicLine` makes them. A stretch between two points has the colour of the first.
    """

    POINT_LIST: ClassVar[int] = 1  # each point by itself
    LINE_LIST: ClassVar[int] = 2  # a line from each even point to the next
    LINE_STRIP: ClassVar[int] = 3  # one line through all points

    def __init__(self, visual: Visual, type: int = LINE_STRIP) -> None:
        self.visual, self.type = visual, type
        self._points: list[Vector3d] = []
        self._colors: list[Color] = []
        self._following: dict[int, Visual] = {}
        self._visible = True

    def AddPoint(self, point: VectorLike | float, *values: float | GzColor) -> None:
        """Add a point [m], as a vector or as x, y, z; a colour may follow (default white)."""
        if isinstance(point, int | float):
            numbers = [float(v) for v in values[:2] if isinstance(v, int | float)]
            point, values = Vector3d(float(point), *numbers), values[2:]
        color = values[0] if values else Color(1.0, 1.0, 1.0)
        self._points.append(Vector3d(*point))
        self._colors.append(Color(*color) if isinstance(color, GzColor) else Color(1.0, 1.0, 1.0))

    def _check(self, index: int) -> int:
        if not 0 <= index < len(self._points):
            raise NotFoundError(f"these lines have {len(self._points)} points, from 0 on; not {index}")
        return index

    def SetPoint(self, index: int, value: VectorLike) -> None:
        """Move a point [m].

        Raises:
            NotFoundError: there is none of that number.
        """
        self._points[self._check(index)] = Vector3d(*value)

    def Point(self, index: int) -> Vector3d:
        """A point [m].

        Raises:
            NotFoundError: there is none of that number.
        """
        return self._points[self._check(index)]

    GetPoint = Point

    def PointCount(self) -> int:
        """How many points there are."""
        return len(self._points)

    GetPointCount = PointCount

    def SetColor(self, index: int, color: GzColor) -> None:
        """Colour a point, and the line from it."""
        self._colors[self._check(index)] = Color(*color)

    def setMaterial(self, name: str) -> None:
        """Give all points there are the colour of a material."""
        material = find_material(name)
        if material is not None:
            glow = material.emissive if any(material.emissive[:3]) else material.ambient
            self._colors = [Color(*glow) for _ in self._points]

    SetMaterial = setMaterial

    def setVisible(self, visible: bool) -> None:
        """Show or hide them."""
        self._visible = bool(visible)

    def setVisibilityFlags(self, flags: int) -> None:
        """Accepted: all cameras see them."""

    def Clear(self) -> None:
        """Take all points out."""
        self._points.clear()
        self._colors.clear()
        self._following.clear()

    def Update(self) -> None:
        """Classic's request to draw them anew; they always are."""

    def follow(self, index: int, visual: Visual) -> None:
        """Let a point go along with a visual."""
        self._following[index] = visual

    def segments(self) -> list[Lines]:
        """What is to be drawn: lines of each colour."""
        frame = self.visual._world()
        self._following = {index: visual for index, visual in self._following.items() if not visual.gone}
        for index, visual in self._following.items():
            if index < len(self._points):
                self._points[index] = Vector3d(*GzCoordPositionSub(visual._world().pos, frame.pos, frame.rot))
        if not self._visible or not self.visual.Visible():
            return []
        of_color: dict[tuple[float, float, float], list[NDArray[np.float64]]] = {}
        step = 2 if self.type == self.LINE_LIST else 1
        starts = range(0, len(self._points) - (self.type != self.POINT_LIST), step)
        for i in starts:
            if self.type == self.POINT_LIST:
                ends = CROSS + np.array(self._points[i])
            else:
                ends = np.array((tuple(self._points[i]), tuple(self._points[i + 1])))
            color = self._colors[i]
            of_color.setdefault((color.r, color.g, color.b), []).append(ends)
        return [placed(np.concatenate(parts), frame, color) for color, parts in of_color.items()]


def placed(ends: NDArray[np.float64], frame: GzPose, color: tuple[float, float, float]) -> Lines:
    """Lines whose ends [m], shape (2 n, 3), are given in a frame."""
    matrix = pose_matrix(frame)
    return Lines(np.ascontiguousarray(ends @ matrix[:3, :3].T + matrix[:3, 3], dtype=np.float32), color)
