"""gazebo_ros_template: does nothing; in the original it is to be copied."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.sdf.element import Element


class GazeboRosTemplate(WorldPlugin):
    """Does nothing."""

    STATE = ()

    def Load(self, world: World, sdf: Element) -> None:
        """Nothing to do."""


GZ_REGISTER_WORLD_PLUGIN(GazeboRosTemplate)
