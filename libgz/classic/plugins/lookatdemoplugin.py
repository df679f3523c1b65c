"""LookAtDemoPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_GUI_PLUGIN, GUIPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class LookAtDemoPlugin(WithoutEffect, GUIPlugin):
    """Would show input fields for a pose that looks at a point; the client has none."""

    reason = "the client has no input fields for its numbers"


GZ_REGISTER_GUI_PLUGIN(LookAtDemoPlugin)
