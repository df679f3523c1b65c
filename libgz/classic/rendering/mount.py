"""Mount: moves a camera that is attached to a visual, tracks one, or follows a path."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from libgz.base.geometry import (
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzPose,
    GzPosePointAt,
    GzQuaternFromAxis,
    GzVector,
    GzVectorAdd,
    GzVectorMul,
    GzVectorSub,
    rotate,
)
from libgz.classic.common.animation import PoseAnimation
from libgz.rendering.camera import Camera as CoreCamera
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.rendering.visual import Visual

__all__ = ["Mount"]

NEAR = 1e-6  # [m] a camera horizontally this close to the visual that it tracks does not turn


class Mount:
    """Moves one camera.

    Attributes:
        clock: the time of motions [s]; classic uses the wall clock.
        tracked: the visual that the camera looks at.
        is_static: whether the camera keeps to `position` while it tracks, instead of following to a distance.
        position: of a static camera [m]; of the world, or of the visual if `in_model_frame`, turned by the visual's yaw
            if `inherit_yaw`.
        least, most: distances [m] that a camera that is not static keeps; 0: no limit.
    """

    STATE = ("_offset", "_turns", "is_static", "position", "least", "most", "in_model_frame", "inherit_yaw")

    def __init__(self, camera: CoreCamera) -> None:
        self._camera = camera
        self.clock: Callable[[], float] = time.monotonic
        self.tracked: Visual | None = None
        self.is_static, self.position = False, GzVector(-5.0, 0.0, 3.0)  # the defaults of <track_visual>
        self.in_model_frame, self.inherit_yaw = True, False
        self.least = self.most = 0.0
        self._carrier: Visual | None = None
        self._offset = GzPose()
        self._turns = True
        self._path: PoseAnimation | None = None
        self._since = 0.0
        self._arrived = Event("CameraMoved")
        self._keep: Connection | None = None

    def attach(self, visual: Visual, turns: bool) -> None:
        """Move with a visual; `turns`: rotate with it, too."""
        self._carrier, self._turns = visual, turns
        here, there = self._camera.pose, visual.WorldPose()
        self._offset = GzCoordPoseSub(here, there) if turns else GzPose(GzVectorSub(here.pos, there.pos), here.rot)

    def track(self, visual: Visual | None) -> None:
        """Look at a visual from now on; None ends that."""
        self.tracked = visual

    @property
    def moving(self) -> bool:
        """Whether the camera follows a path."""
        return self._path is not None

    def move_through(self, poses: Sequence[GzPose], duration: float, done: Callable[[], object] | None) -> bool:
        """Move through poses in a number of seconds; False if the camera is already moving."""
        if self.moving:
            return False
        path = PoseAnimation("camera", max(float(duration), 1e-9), False)
        for i, pose in enumerate([self._camera.pose, *poses]):
            key = path.CreateKeyFrame(path.length * i / len(poses))
            key.Translation(GzVector(*pose.pos))
            key.Rotation(pose.rot)
        self._path, self._since = path, self.clock()
        self._keep = self._arrived.Connect(done) if done is not None else None
        return True

    def update(self) -> None:
        """Move the camera to its present pose; deleted visuals are forgotten."""
        if self._carrier is not None and self._carrier.deleted:
            self._carrier = None
        if self.tracked is not None and self.tracked.deleted:
            self.tracked = None
        if self._path is not None:
            self._follow_path(self._path)
        elif self._carrier is not None:
            there, on = self._carrier.WorldPose(), self._offset
            shifted = GzPose(GzVectorAdd(on.pos, there.pos), on.rot)
            self._camera.SetPose(GzCoordPoseAdd(on, there) if self._turns else shifted)
        if self.tracked is not None:
            self._follow(self.tracked)
            here, goal = self._camera.pose.pos, self.tracked.WorldPose().pos
            if abs(goal.x - here.x) + abs(goal.y - here.y) > NEAR:
                self._camera.SetPose(GzPosePointAt(here, goal, GzVector(0.0, 0.0, 1.0)))

    def _follow(self, visual: Visual) -> None:
        """Keep the place, or the distance, of a camera that tracks a visual."""
        there, here = visual.WorldPose(), self._camera.pose
        if self.is_static:
            offset = self.position
            if self.in_model_frame:
                turn = GzQuaternFromAxis(0.0, 0.0, 1.0, there.Rot().Yaw() if self.inherit_yaw else 0.0)
                offset = GzVectorAdd(there.pos, rotate(turn, offset))
            self._camera.SetPose(GzPose(GzVector(*offset), here.rot))
            return
        way = GzVectorSub(here.pos, there.pos)
        distance = math.sqrt(way.x**2 + way.y**2 + way.z**2)
        wanted = max(distance, self.least)
        wanted = min(wanted, self.most) if self.most > 0.0 else wanted
        if distance > NEAR and wanted != distance:
            place = GzVectorAdd(there.pos, GzVectorMul(wanted / distance, way))
            self._camera.SetPose(GzPose(GzVector(*place), here.rot))

    def _follow_path(self, path: PoseAnimation) -> None:
        path.SetTime(self.clock() - self._since)
        key = path.GetInterpolatedKeyFrame()
        self._camera.SetPose(GzPose(GzVector(*key.Translation()), key.Rotation()))
        if path.time >= path.length:
            self._path = None
            self._arrived()
