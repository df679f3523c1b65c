"""DrivePlugin: base class of plugins that drive a model by ``~/<model>/vel_cmd``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.law import Number
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

    STATE: ClassVar[tuple[str, ...]] = ("speed", "turn")

    speed = Number()  # commanded, forward [m/s]
    turn = Number()  # commanded yaw rate [rad/s], with the sign of the message

    def listen(self, model: Model) -> None:
        """Subscribe to commands, and start to update."""
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe(f"~/{model.GetName()}/vel_cmd", self.OnVelMsg)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnVelMsg(self, message: Any) -> None:
        """A new command."""
        self.speed = message.position.x
        self.turn = Quaterniond(ConvertIgn(message.orientation)).Yaw()

    def OnUpdate(self) -> None:
        """Run the wheels; called in every iteration. A law runs natively."""
        raise NotImplementedError

    def Reset(self) -> None:
        """Set the command to zero."""
        self.speed = self.turn = 0.0
