"""gazebo_ros_template: does nothing; in the original it is to be copied."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosTemplate(ModelPlugin):
    """Does nothing."""

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Nothing to do."""


GZ_REGISTER_MODEL_PLUGIN(GazeboRosTemplate)
