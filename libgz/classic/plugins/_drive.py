"""DrivePlugin: base class of plugins that drive a model by ``~/<model>/vel_cmd``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic import transport
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugin import ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model

__all__ = ["DrivePlugin"]


class DrivePlugin(ModelPlugin):
    """Receives commands, and runs the wheels in every iteration."""

    STATE: ClassVar[tuple[str, ...]] = ("command",)

    command = (0.0, 0.0)  # speed forward [m/s], yaw rate [rad/s] with the sign of the message

    def listen(self, model: Model) -> None:
        """Subscribe to commands, and start to update."""
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe(f"~/{model.GetName()}/vel_cmd", self.OnVelMsg)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnVelMsg(self, message: Any) -> None:
        """A new command."""
        self.command = message.position.x, Quaterniond(ConvertIgn(message.orientation)).Yaw()

    def OnUpdate(self) -> None:
        """Run the wheels; called in every iteration."""
        raise NotImplementedError

    def Reset(self) -> None:
        """Set the command to zero."""
        self.command = (0.0, 0.0)
