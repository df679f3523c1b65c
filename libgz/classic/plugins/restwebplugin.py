"""RestWebPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_SYSTEM_PLUGIN, SystemPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class RestWebPlugin(WithoutEffect, SystemPlugin):
    """Would report events to a web service; libgz never uses the network unasked."""

    reason = "it reports events to a web service, and libgz never uses the network unasked"


GZ_REGISTER_SYSTEM_PLUGIN(RestWebPlugin)
