"""Mount: what moves a camera by itself: something it is attached to, looks after, or a way it goes along."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from libgz.classic.common.animation import PoseAnimation
from libgz.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzPosePointAt, GzVector, GzVectorAdd, GzVectorSub
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.rendering.camera import Camera
    from libgz.classic.rendering.visual import Visual

__all__ = ["Mount"]

NEAR = 1e-6  # [m] a camera this near to what it looks after, seen from above, does not turn


class Mount:
    """Moves one camera.

    Attributes:
        clock: gives the time that animations run by [s]; classic's is the wall clock.
        tracked: what the camera looks after.
    """

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self.clock: Callable[[], float] = time.monotonic
        self.tracked: Visual | None = None
        self._carrier: Visual | None = None
        self._offset = GzPose()
        self._turns = True
        self._way: PoseAnimation | None = None
        self._since = 0.0
        self._arrived = Event("CameraMoved")
        self._keep: Connection | None = None

    def attach(self, visual: Visual, turns: bool) -> None:
        """Go along with a visual; `turns`: with its rotation, too."""
        self._carrier, self._turns = visual, turns
        here, there = self._camera.view.pose, visual.WorldPose()
        self._offset = GzCoordPoseSub(here, there) if turns else GzPose(GzVectorSub(here.pos, there.pos), here.rot)

    def track(self, visual: Visual | None) -> None:
        """Look at a visual from now on; None: no more."""
        self.tracked = visual

    @property
    def moving(self) -> bool:
        """Whether the camera goes along a way."""
        return self._way is not None

    def move_through(self, poses: Sequence[GzPose], duration: float, done: Callable[[], object] | None) -> bool:
        """Go through poses in so many seconds; False if the camera is under way already."""
        if self.moving:
            return False
        way = PoseAnimation("camera", max(float(duration), 1e-9), False)
        for i, pose in enumerate([self._camera.view.pose, *poses]):
            key = way.CreateKeyFrame(way.length * i / len(poses))
            key.Translation(GzVector(*pose.pos))
            key.Rotation(pose.rot)
        self._way, self._since = way, self.clock()
        self._keep = self._arrived.Connect(done) if done is not None else None
        return True

    def update(self) -> None:
        """Bring the camera to where it is to be now; what has left the world lets go of it."""
        if self._carrier is not None and self._carrier.gone:
            self._carrier = None
        if self.tracked is not None and self.tracked.gone:
            self.tracked = None
        if self._way is not None:
            self._follow_way(self._way)
        elif self._carrier is not None:
            there, on = self._carrier.WorldPose(), self._offset
            shifted = GzPose(GzVectorAdd(on.pos, there.pos), on.rot)
            self._camera.SetWorldPose(GzCoordPoseAdd(on, there) if self._turns else shifted)
        if self.tracked is not None:
            here, goal = self._camera.view.pose.pos, self.tracked.WorldPose().pos
            if abs(goal.x - here.x) + abs(goal.y - here.y) > NEAR:
                self._camera.SetWorldPose(GzPosePointAt(here, goal, GzVector(0.0, 0.0, 1.0)))

    def _follow_way(self, way: PoseAnimation) -> None:
        way.SetTime(self.clock() - self._since)
        key = way.GetInterpolatedKeyFrame()
        self._camera.SetWorldPose(GzPose(key.Translation(), key.Rotation()))
        if way.time >= way.length:
            self._way = None
            self._arrived()
