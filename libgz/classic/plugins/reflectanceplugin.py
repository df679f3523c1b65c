"""ReflectancePlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_VISUAL_PLUGIN, VisualPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class ReflectancePlugin(WithoutEffect, VisualPlugin):
    """Would set the reflectance map that a depth camera sees; those of libgz have none."""

    reason = "depth cameras of libgz have no reflectance"


GZ_REGISTER_VISUAL_PLUGIN(ReflectancePlugin)
