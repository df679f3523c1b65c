"""ShaderParamVisualPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_VISUAL_PLUGIN, VisualPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class ShaderParamVisualPlugin(WithoutEffect, VisualPlugin):
    """Would set parameters of a shader; libgz does not run the shaders of material scripts."""

    reason = "libgz does not run the shaders of material scripts"


GZ_REGISTER_VISUAL_PLUGIN(ShaderParamVisualPlugin)
