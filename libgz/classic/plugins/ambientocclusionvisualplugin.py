"""AmbientOcclusionVisualPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_VISUAL_PLUGIN, VisualPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class AmbientOcclusionVisualPlugin(WithoutEffect, VisualPlugin):
    """Would darken corners by ambient occlusion; libgz renders none."""

    reason = "libgz renders no ambient occlusion"


GZ_REGISTER_VISUAL_PLUGIN(AmbientOcclusionVisualPlugin)
