"""DrivePlugin: what robots have in common that are driven by ``~/<model>/vel_cmd``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import transport
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugin import ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model

__all__ = ["DrivePlugin"]


class DrivePlugin(ModelPlugin):
    """Hears commands, and runs the wheels in every iteration."""

    command = (0.0, 0.0)  # speed forward [m/s], yaw rate [rad/s] as the message has it

    def listen(self, model: Model) -> None:
        """Begin, when the wheels are known."""
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe(f"~/{model.GetName()}/vel_cmd", self.OnVelMsg)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnVelMsg(self, message: Any) -> None:
        """A new command."""
        self.command = message.position.x, Quaterniond(ConvertIgn(message.orientation)).Yaw()

    def OnUpdate(self) -> None:
        """Run the wheels."""
        raise NotImplementedError

    def Reset(self) -> None:
        """Stop."""
        self.command = (0.0, 0.0)
