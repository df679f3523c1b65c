"""HeightmapLODPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_VISUAL_PLUGIN, VisualPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class HeightmapLODPlugin(WithoutEffect, VisualPlugin):
    """Would set the level of detail of height maps; libgz renders them in full detail."""

    reason = "libgz renders height maps in full detail"


GZ_REGISTER_VISUAL_PLUGIN(HeightmapLODPlugin)
