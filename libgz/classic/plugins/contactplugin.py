"""ContactPlugin: switches its sensor on; the class itself is in `libgz.classic.plugins.hooks`, to derive from."""

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN
from libgz.classic.plugins.hooks import ContactPlugin

GZ_REGISTER_SENSOR_PLUGIN(ContactPlugin)
