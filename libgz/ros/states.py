"""States: poses and velocities of all models, or of all links, from the tables of the engine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from libgz.physics.body import Body
    from libgz.ros.session import Publication
    from libgz.simulation.world import World

__all__ = ["Listed", "States"]

STATE_SIZE = 16  # numbers of a body that are read here


class Listed(NamedTuple):
    """What a message lists.

    Attributes:
        names: of models or links.
        bodies: whose velocities are theirs.
        poses: what gives the pose of each, x, y, z [m] and the rotation x, y, z, w; empty if it is that of the body.
    """

    names: list[str]
    bodies: list[Body]
    poses: list[Callable[[], Sequence[float]]]


class States:
    """Publishes states.

    Args:
        core: the world.
        publication: of gazebo_msgs/ModelStates or LinkStates.
        listing: lists the models or links.
    """

    def __init__(self, core: World, publication: Publication, listing: Callable[[], Listed]) -> None:
        self.publication = publication
        self._core, self._listing = core, listing
        self._message = publication.kind()
        self._listed: Listed | None = None

    def forget(self) -> None:
        """The list of models has changed."""
        self._listed = None

    def _list(self) -> Listed:
        listed = self._listed = self._listing()
        self._message.name = listed.names
        self._rows = np.array([body.row for body in listed.bodies], np.int64)
        self._fixed = [(index, body) for index, body in enumerate(listed.bodies) if body.row < 0]
        return listed

    def send(self) -> None:
        """Publish."""
        listed = self._listed or self._list()
        table = self._core.engine.states
        states = table[self._rows] if len(table) else np.zeros((len(self._rows), STATE_SIZE))
        poses: NDArray[np.float64] = np.empty((len(states), 7))
        twists: NDArray[np.float64] = np.empty((len(states), 6))
        poses[:, :3], poses[:, 3:6], poses[:, 6] = states[:, :3], states[:, 4:7], states[:, 3]
        twists[:, 3:] = states[:, 13:16]
        twists[:, :3] = states[:, 10:13] + np.cross(states[:, 13:16], states[:, :3] - states[:, 7:10])
        for index, body in self._fixed:
            x, y, z, qu, qx, qy, qz = body.frame()
            poses[index], twists[index] = (x, y, z, qx, qy, qz, qu), 0.0
        for index, pose in enumerate(listed.poses):
            poses[index] = pose()
        self._message.pose, self._message.twist = poses, twists
        self.publication.publish(self._message)
