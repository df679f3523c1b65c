"""gazebo_ros_properties: the services that get and set properties, in the namespace of the plugin; of ROS 2."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
from libgz.ros.api2 import PROPERTIES, PropertiesApi
from libgz.ros.plugin import Endpoint, RosPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.sdf.element import Element


class GazeboRosProperties(RosPlugin, WorldPlugin):
    """Serves properties of models, links, joints and lights."""

    STATE = ()

    endpoints = tuple(Endpoint("in ROS 2 serves", name, kind) for name, kind in PROPERTIES.items())

    def Load(self, world: World, sdf: Element) -> None:
        """Serve; in ROS 1 the server itself does."""
        self.open(sdf, "")
        self.api = PropertiesApi(self.ros, world, self.space, self.own_node) if self.two else None


GZ_REGISTER_WORLD_PLUGIN(GazeboRosProperties)
