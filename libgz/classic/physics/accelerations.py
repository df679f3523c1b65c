"""Accelerations: what the last step did to the velocities of all bodies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.classic.math import Vector3d
from libgz.physics.body import Body
from libgz.simulation.world import World

__all__ = ["Accelerations"]


class Accelerations:
    """Velocities just before physics acted, kept from the first question on: what plugins set is no acceleration."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._wanted = False
        self._before: NDArray[np.float64] = np.zeros((0, 6))

    def before(self) -> None:
        """Note the velocities; called before each physics step."""
        if self._wanted:
            self._before = self._world.engine.states[:, 10:16].copy()

    def _of(self, body: Body, first: int) -> Vector3d:
        if body.dummy:
            return Vector3d()
        if not self._wanted or body.row >= len(self._before):
            self._wanted = True
            return Vector3d()
        now = body.GetLinearVel() if first == 0 else body.GetAngularRate()
        change = np.array(now) - self._before[body.row, first : first + 3]
        return Vector3d(*(change / self._world.engine.step_time).tolist())

    def want(self) -> None:
        """Begin to note velocities, so that the first answer is right, too."""
        self._wanted = True

    def linear(self, body: Body) -> Vector3d:
        """Of the centre of mass [m/s^2], global; zero before there was a step to tell from."""
        return self._of(body, 0)

    def angular(self, body: Body) -> Vector3d:
        """[rad/s^2], global; zero before there was a step to tell from."""
        return self._of(body, 3)
