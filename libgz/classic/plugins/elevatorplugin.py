"""ElevatorPlugin, as a plugin of its own."""

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._elevator import ElevatorPlugin

GZ_REGISTER_MODEL_PLUGIN(ElevatorPlugin)
