"""UserCamera: the camera through which a client's user looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.rendering.camera import Camera
from libgz.geometry import GzCoordPositionAdd, GzPose, GzPosePointAt, GzVector, GzVectorAdd, GzVectorMul, VectorLike

__all__ = ["UserCamera"]

FRAMES = 2.0  # from how many times its size away a visual is looked at


class UserCamera(Camera):
    """A camera with a place to come back to. Arguments as for `Camera`."""

    START = Pose3d(GzPosePointAt(GzVector(5.0, -5.0, 2.0), GzVector(0.0, 0.0, 0.0), GzVector(0.0, 0.0, 1.0)))

    def __init__(self, *values: Any, **options: Any) -> None:
        super().__init__(*values, **options)
        self._controller = "orbit"
        self.view.options.displayGrid = True
        self.GetScene()  # which draws the grid
        self._initial = self.START
        self._focus = Vector3d()
        self.SetDefaultPose(self.START)

    def SetDefaultPose(self, pose: GzPose) -> None:
        """Set the pose that it starts from [m], and go there."""
        self._initial = Pose3d(pose)
        self.SetWorldPose(pose)

    SetInitialPose = SetDefaultPose

    def DefaultPose(self) -> Pose3d:
        """The pose that it starts from [m]."""
        return Pose3d(self._initial)

    InitialPose = DefaultPose

    def SetViewController(self, type: str) -> None:
        """Choose how a mouse would move it: orbit, fps, ortho. It is kept: there is no mouse here."""
        self._controller = type

    SetViewMode = SetViewController

    def GetViewControllerTypeString(self) -> str:
        """How a mouse would move it."""
        return self._controller

    ViewControllerTypeString = GetViewControllerTypeString

    def SetFocalPoint(self, pt: VectorLike) -> None:
        """Set the point that it turns around [m]."""
        self._focus = Vector3d(*pt)

    def FocalPoint(self) -> Vector3d:
        """The point that it turns around [m]."""
        return Vector3d(self._focus)

    def Resize(self, w: int, h: int) -> None:
        """Change the picture's size [px]."""
        self.SetImageSize(w, h)

    def MoveToVisual(self, visual: Any, time: float = 0.5, done: Callable[[], object] | None = None) -> bool:
        """Move so that a visual, itself or by name, is seen whole; whether there is one and it does not move yet."""
        found = self._find(visual)
        if found is None:
            return False
        box, there = found.BoundingBox(), found.WorldPose()
        middle, size = GzCoordPositionAdd(box.Center(), there.pos, there.rot), max(box.Size().Length(), self.NearClip())
        away = GzVectorMul(-FRAMES * size, self.Direction())
        place = GzVectorAdd(middle, away)
        return self.MoveToPositions([GzPose(GzVector(*place), self.view.pose.rot)], time, done)
