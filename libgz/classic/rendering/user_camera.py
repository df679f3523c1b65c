"""UserCamera: the camera of a client's user."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from libgz.base.geometry import (
    GzCoordPositionAdd,
    GzPose,
    GzPosePointAt,
    GzVector,
    GzVectorAdd,
    GzVectorMul,
    VectorLike,
)
from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.names import takes_names
from libgz.classic.rendering.camera import Camera

__all__ = ["UserCamera"]

FRAMES = 2.0  # distance from which a visual is viewed, in multiples of its size


@takes_names
class UserCamera(Camera):
    """A camera with a default pose. Arguments as for `Camera`."""

    START = Pose3d(GzPosePointAt(GzVector(5.0, -5.0, 2.0), GzVector(0.0, 0.0, 0.0), GzVector(0.0, 0.0, 1.0)))

    def __init__(self, *values: Any, **options: Any) -> None:
        super().__init__(*values, **options)
        self._controller = "orbit"
        self.core.options.displayGrid = True
        self.core.options.shadows = True
        self._initial = self.START
        self._focus = Vector3d()
        self.SetDefaultPose(self.START)

    def SetDefaultPose(self, pose: GzPose) -> None:
        """Set the default pose [m], and move there."""
        self._initial = Pose3d(pose)
        self.SetWorldPose(pose)

    SetInitialPose = SetDefaultPose

    def DefaultPose(self) -> Pose3d:
        """The default pose [m]."""
        return Pose3d(self._initial)

    InitialPose = DefaultPose

    def SetViewController(self, type: str) -> None:
        """Set how a mouse moves it: orbit, fps, ortho. The value is kept, but there is no mouse."""
        self._controller = type

    SetViewMode = SetViewController

    def GetViewControllerTypeString(self) -> str:
        """How a mouse moves it."""
        return self._controller

    ViewControllerTypeString = GetViewControllerTypeString

    def SetFocalPoint(self, pt: VectorLike) -> None:
        """Set the point that it turns around [m]."""
        self._focus = Vector3d(*pt)

    def FocalPoint(self) -> Vector3d:
        """The point that it turns around [m]."""
        return Vector3d(self._focus)

    def Resize(self, w: int, h: int) -> None:
        """Change the image's size [px]."""
        self.SetImageSize(w, h)

    def Visual(self, mousePos: Sequence[int], mod: str = "") -> Any:
        """The visual of a link at a pixel of the last image; None for none. `mod` is for handles, which it has none."""
        return self.GetScene().VisualAt(self, mousePos)

    GetVisual = Visual

    def MoveToVisual(self, visual: Any, time: float = 0.5, done: Callable[[], object] | None = None) -> bool:
        """Move so that all of a visual is visible; False if there is no such visual, or the camera already moves."""
        found = self._find(visual)
        if found is None:
            return False
        box, there = found.BoundingBox(), found.WorldPose()
        middle, size = GzCoordPositionAdd(box.Center(), there.pos, there.rot), max(box.Size().Length(), self.NearClip())
        away = GzVectorMul(-FRAMES * size, self.Direction())
        place = GzVectorAdd(middle, away)
        return self.MoveToPositions([GzPose(GzVector(*place), self.core.pose.rot)], time, done)
