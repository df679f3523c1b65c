"""ForceTorquePlugin: activates its sensor; the class is in `libgz.classic.plugins.hooks`, for deriving from it."""

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN
from libgz.classic.plugins.hooks import ForceTorquePlugin

GZ_REGISTER_SENSOR_PLUGIN(ForceTorquePlugin)
