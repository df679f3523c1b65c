"""WavefieldModelPlugin: names the waves of a world, for the bodies that float on them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._water import waves_of

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class WavefieldModelPlugin(ModelPlugin):
    """Has the waves that libbuoyancy_gazebo_plugin.so of other models names by `<wave_model>`; it shows no water.

    Elements:
        wave: several, as of libbuoyancy_gazebo_plugin.so; also in an element around them.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Check the waves.

        Raises:
            ParameterError: a number is not allowed.
        """
        for element in (sdf, *sdf.children):
            waves_of(element)


GZ_REGISTER_MODEL_PLUGIN(WavefieldModelPlugin)
