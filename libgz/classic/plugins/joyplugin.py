"""JoyPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class JoyPlugin(WithoutEffect, WorldPlugin):
    """Would publish the movements of a joystick by ignition-transport, which libgz does not have."""

    reason = "it publishes by ignition-transport, which libgz does not have"


GZ_REGISTER_WORLD_PLUGIN(JoyPlugin)
