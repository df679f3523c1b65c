"""LinearBatteryPlugin, as a plugin of its own."""

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._linear_battery import LinearBatteryPlugin

GZ_REGISTER_MODEL_PLUGIN(LinearBatteryPlugin)
