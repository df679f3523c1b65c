"""Stands for System plugins of ROS whose work the server does by itself: clock, services, paths."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_SYSTEM_PLUGIN, SystemPlugin


class PartOfServer(SystemPlugin):
    """Does nothing."""

    STATE = ()

    def Load(self, argc: int = 0, argv: list[str] | None = None) -> None:
        """Nothing to do."""


GZ_REGISTER_SYSTEM_PLUGIN(PartOfServer)
