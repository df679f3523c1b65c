"""DrivePlugin: base class of plugins that drive a model by ``~/<model>/vel_cmd``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import transport
from libgz.classic.math import Quaterniond
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugin import ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model

__all__ = ["DrivePlugin"]


class DrivePlugin(ModelPlugin):
    """Receives commands."""

    def listen(self, model: Model) -> None:
        """Subscribe to commands."""
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe(f"~/{model.GetName()}/vel_cmd", self.OnVelMsg, kind="Pose")

    def OnVelMsg(self, message: Any) -> None:
        """A new command."""
        self.command(message.position.x, Quaterniond(ConvertIgn(message.orientation)).Yaw())

    def command(self, speed: float, turn: float) -> None:
        """Obey a command: the speed forward [m/s], the yaw rate [rad/s] with the sign of the message."""
        raise NotImplementedError
