"""LensFlareSensorPlugin: has no effect here."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.classic.plugins._without_effect import WithoutEffect


class LensFlareSensorPlugin(WithoutEffect, SensorPlugin):
    """Would add lens flares to a camera's image; libgz renders none."""

    reason = "libgz renders no lens flares"


GZ_REGISTER_SENSOR_PLUGIN(LensFlareSensorPlugin)
