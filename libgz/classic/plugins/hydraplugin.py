"""HydraPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class HydraPlugin(WithoutEffect, WorldPlugin):
    """Would publish the movements of a Hydra game controller on ~/hydra; libgz does not read the device."""

    reason = "libgz does not read the device; any program may publish its messages on ~/hydra"


GZ_REGISTER_WORLD_PLUGIN(HydraPlugin)
