"""gazebo_ros_state: states of models, links and entities, in the namespace of the plugin; of ROS 2."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
from libgz.ros.api2 import STATES, StateApi
from libgz.ros.plugin import Endpoint, Parameter, Publishing, Rate, Ticks
from libgz.ros.states import Listed, States
from libgz.ros.world import classic_links, classic_models

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.sdf.element import Element


class GazeboRosState(Publishing, WorldPlugin):
    """Publishes the states of all models and links, and serves those of entities."""

    STATE = ("ticks",)

    parameters = (Parameter("updateRate", Rate(100.0), "[Hz]; 0: each iteration"),)
    endpoints = (
        Endpoint("publishes", "model_states", "gazebo_msgs/ModelStates"),
        Endpoint("publishes", "link_states", "gazebo_msgs/LinkStates"),
        *(Endpoint("in ROS 2 serves", name, kind) for name, kind in STATES.items()),
    )

    def Load(self, world: World, sdf: Element) -> None:
        """Advertise and serve."""
        self.open(sdf, "")
        self.world, self.ticks = world, Ticks(self.given.updateRate)
        models, links = (self.advertise(one.name, one.kind) for one in self.endpoints[:2])
        self.states = [States(world.core, models, self._models), States(world.core, links, self._links)]
        self.api = StateApi(self.ros, world, self.space, self.own_node) if self.two else None
        self.known: Any = None
        self.run()

    def _models(self) -> Listed:
        return classic_models(self.world)

    def _links(self) -> Listed:
        return classic_links(self.world)

    def work(self, now: float) -> None:
        """Publish what has subscribers."""
        wanted = [one for one in self.states if one.publication.listened]
        known = self.world.Models()
        for one in wanted:
            if known != self.known:
                one.forget()
            one.send()
        self.known = known if len(wanted) == len(self.states) else None


GZ_REGISTER_WORLD_PLUGIN(GazeboRosState)
