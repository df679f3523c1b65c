"""RosWorld: a world as ROS sees it: its clock, the states of its models and links, and its services."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from libgz.classic.server import attach
from libgz.ros.api import WorldApi
from libgz.ros.plugin import Ticks
from libgz.ros.session import Publication, Session, set_stamp
from libgz.ros.types import message_type
from libgz.simulation.companion import Stateless
from libgz.simulation.event import unowned

if TYPE_CHECKING:
    from libgz.physics.body import Body
    from libgz.simulation.entity import Entity
    from libgz.simulation.world import World

__all__ = ["RosWorld"]


class RosWorld(Stateless):
    """Publishes /clock and the states of models and links, serves, and delivers messages between steps.

    Args:
        session: of this process.
        core: the engine's world, of SDF.
    """

    def __init__(self, session: Session, core: World) -> None:
        self._session, self._core = session, core
        self._closed = False
        with unowned():
            self._clock = session.publish("/clock", "rosgraph_msgs/Clock", 10)
        self._ticks = Ticks(0.0)
        self._time = message_type("rosgraph_msgs/Clock")()
        self._models: _States | None = None
        self._links: _States | None = None
        self._api: WorldApi | None = None
        core.companions.append(self)

    # Companion of the world --------------------------------------------------------------------------------------

    def start(self) -> None:
        """Advertise topics and services; all models are loaded."""
        session = self._session
        frequency = session.parameter("~pub_clock_frequency", 0)
        self._ticks = Ticks(float(frequency) if isinstance(frequency, int | float) else 0.0)
        if session.parameter("~enable_ros_network", True) is False:
            return
        world = attach(self._core).world
        with unowned():
            names = [("model", "gazebo_msgs/ModelStates"), ("link", "gazebo_msgs/LinkStates")]
            models, links = (session.publish(f"~{name}_states", kind, 10) for name, kind in names)
            self._models = _States(self._core, models, links=False)
            self._links = _States(self._core, links, links=True)
            self._api = WorldApi(session, world)

    def model_added(self, model: Entity) -> None:
        """The list of models has changed."""
        self._forget()

    def model_removed(self, model: Entity) -> None:
        """The list of models has changed."""
        self._forget()

    def _forget(self) -> None:
        for states in (self._models, self._links):
            if states is not None:
                states.bodies = None

    def update(self) -> None:
        """Publish the clock and the states; apply wrenches and efforts."""
        now = self._core.GetSimTime()
        if self._clock.listened and self._ticks.due(now):
            set_stamp(self._time.clock, now)
            self._clock.publish(self._time)
        if self._models is not None and self._models.publication.listened:
            self._models.send()
        if self._links is not None and self._links.publication.listened:
            self._links.send()
        if self._api is not None and self._api.jobs:
            self._api.apply(now)

    def step(self, paused: bool) -> None:
        """Deliver what came during the step, and send what it made."""
        self._session.deliver()

    def reset(self) -> None:
        """Forget wrenches and efforts."""
        if self._api is not None:
            self._api.jobs.clear()

    def close(self) -> None:
        """The world ends: so do its topics and services."""
        self._closed = True
        self._session.node.flush()
        self._models = self._links = self._api = None


class _States:
    """Publishes poses and velocities of all models, or of all links, from the tables of the engine.

    Attributes:
        bodies: the bodies; None when the list of models has changed.
    """

    def __init__(self, core: World, publication: Publication, links: bool) -> None:
        self.publication = publication
        self._core, self._links = core, links
        self._message = publication.kind()
        self.bodies: list[Body] | None = None

    def _list(self) -> list[Body]:
        """List the bodies, and their names in the message."""
        world = attach(self._core).world
        names, bodies = [], []
        for model in world.Models():
            links = model.GetLinks()
            for link in links if self._links else links[:1]:
                names.append(link.GetScopedName() if self._links else model.GetName())
                bodies.append(link.body)
        self._message.name = names
        self._rows = np.array([body.row for body in bodies], np.int64)
        self._fixed = [(index, body) for index, body in enumerate(bodies) if body.row < 0]
        self._offsets = None
        if not self._links:  # the frame of a model is not that of its first link
            self._offsets = [model for model in world.Models() if model.GetLinks()]
        return bodies

    def send(self) -> None:
        """Publish."""
        if self.bodies is None:
            self.bodies = self._list()
        states = self._core.engine.states[self._rows]
        poses: NDArray[np.float64] = np.empty((len(states), 7))
        twists: NDArray[np.float64] = np.empty((len(states), 6))
        poses[:, :3], poses[:, 3:6], poses[:, 6] = states[:, :3], states[:, 4:7], states[:, 3]
        twists[:, 3:] = states[:, 13:16]
        twists[:, :3] = states[:, 10:13] + np.cross(states[:, 13:16], states[:, :3] - states[:, 7:10])
        for index, body in self._fixed:
            x, y, z, qu, qx, qy, qz = body.frame()
            poses[index], twists[index] = (x, y, z, qx, qy, qz, qu), 0.0
        for index, model in enumerate(self._offsets or ()):
            pose = model.pose()
            poses[index] = (*pose.pos, pose.rot.x, pose.rot.y, pose.rot.z, pose.rot.u)
        self._message.pose, self._message.twist = poses, twists
        self.publication.publish(self._message)
