"""LinearBatteryConsumerPlugin: a constant load on a battery."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_battery, named_link
from libgz.simulation.event import AtEnd

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class LinearBatteryConsumerPlugin(ModelPlugin):
    """A constant power load on a battery, as long as the plugin runs.

    Elements:
        link_name, battery_name: link and name of the battery.
        power_load: the power [W].
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Add the load."""
        battery = named_battery(named_link(model, sdf), sdf)
        number = battery.AddConsumer()
        battery.SetPowerLoad(number, sdf.Get(float, "power_load"))
        self.ending = AtEnd(lambda: battery.RemoveConsumer(number))


GZ_REGISTER_MODEL_PLUGIN(LinearBatteryConsumerPlugin)
