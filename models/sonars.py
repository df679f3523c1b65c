"""SonarRing: ultrasonic sensors around a robot, and their sonar interface."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from libgz.base.law import law
from libgz.interfaces.sonar import Sonar, SonarData
from libgz.legacy.model import Model
from libgz.models.device import Device
from libgz.models.serving import serve
from libgz.physics.body import Body
from libgz.physics.rays import RayProximity
from libgz.simulation.plan import Plan

__all__ = ["PIONEER2AT_RING", "PIONEER2DX_RING", "SonarRing", "pioneer_ring"]

MAX_RANGE = 5.0  # [m]

_DIRECTIONS = (90, 50, 30, 10, -10, -30, -50, -90, -90, -130, -150, -170, 170, 150, 130, 90)  # [deg]
_SIDES = (0.135, 0.135, 0.06642, -0.00216, 0.00216, -0.06642, -0.135, -0.135)  # y of the front half [m]


def pioneer_ring(front: float, rear: float, z: float) -> list[tuple[float, float, float, float]]:
    """(x, y, z [m], direction [rad]) of a Pioneer 2's sixteen sonars, eight at x = front, eight at x = -rear."""
    sides = (*_SIDES, *(-y for y in _SIDES))
    return [(front if i < 8 else -rear, sides[i], z, math.radians(_DIRECTIONS[i])) for i in range(16)]


# A millimetre outside the hulls, so that the rays do not start inside them.
PIONEER2AT_RING = pioneer_ring(0.24103, 0.24103, 0.25)
PIONEER2DX_RING = pioneer_ring(0.14103, 0.24103, -0.04)


class SonarRing(Device):
    """Sonars fixed to a body, each a ray of at most 5 m.

    Args:
        model: the robot.
        body: the body that they are fixed to.
        poses: (x, y, z [m], direction [rad]) of each sonar, in the body frame.
    """

    STATE: ClassVar[tuple[str, ...]] = ("rays",)

    interface: Sonar

    def __init__(self, model: Model, body: Body, poses: Sequence[tuple[float, float, float, float]]) -> None:
        self.model = model
        self.poses = np.array(poses)
        self._own_places, self._own_yaws = self.poses[:, :3].copy(), self.poses[:, 3].copy()
        self.rays = RayProximity(model.world, body, len(poses))
        for i, (x, y, z, direction) in enumerate(poses):
            end = (x + MAX_RANGE * math.cos(direction), y + MAX_RANGE * math.sin(direction), z)
            self.rays.SetRay(i, (x, y, z), end)
        self.interface = Sonar()

    def Init(self) -> None:
        """Create the interface under the model's id."""
        serve(self.model, self.interface)
        sonar = self.interface
        if sonar.lock():
            self._describe(sonar.data)
            sonar.sonar_ranges[: len(self.poses)] = MAX_RANGE
            sonar.unlock()

    @law
    def _describe(self, data: SonarData) -> None:
        """Write the constant fields, under the lock."""
        count = len(self.poses)
        data.sonar_count = count
        data.max_range = MAX_RANGE
        self.interface.sonar_pos[:count] = self._own_places
        self.interface.sonar_rot[:count, 2] = self._own_yaws

    @law
    def publish(self, data: SonarData) -> None:
        """Write what the rays measured last."""
        data.time = self.model.world.GetSimTime()
        self._describe(data)  # a client may have overwritten them
        self.interface.sonar_ranges[: len(self.poses)] = np.minimum(self.rays.ranges, MAX_RANGE)

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        plan.cast(lambda: self.rays)
        plan.exchange(self.interface, self.publish)
