"""RestUiPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_GUI_PLUGIN, GUIPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class RestUiPlugin(WithoutEffect, GUIPlugin):
    """Would log in to the web service of RestWebPlugin."""

    reason = "it logs in to the web service of RestWebPlugin, which has no effect either"


GZ_REGISTER_GUI_PLUGIN(RestUiPlugin)
