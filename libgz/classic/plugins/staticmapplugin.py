"""StaticMapPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class StaticMapPlugin(WithoutEffect, WorldPlugin):
    """Would insert a ground with downloaded map tiles; libgz never uses the network unasked."""

    reason = "it downloads map tiles, and libgz never uses the network unasked"


GZ_REGISTER_WORLD_PLUGIN(StaticMapPlugin)
