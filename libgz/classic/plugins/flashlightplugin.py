"""FlashLightPlugin: switches lights of links on and off in a rhythm."""

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._flash_light import FlashLightPlugin

GZ_REGISTER_MODEL_PLUGIN(FlashLightPlugin)
