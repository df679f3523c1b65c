"""HydraDemoPlugin: moves a model by the messages of a Hydra game controller."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import transport
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

SPEED = 0.2  # of a joystick that is fully moved [m/s]


class HydraDemoPlugin(ModelPlugin):
    """Sets the model's velocity by the right joystick of each message on ~/hydra: (-0.2 x, 0.2 y, 0) m/s."""

    STATE = ("message",)

    def Load(self, model: Model, sdf: Element) -> None:
        """Subscribe."""
        self.model = model
        self.message: Any = None
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe("~/hydra", self.OnHydra, kind="Hydra")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Forget a message."""
        self.message = None

    def OnHydra(self, message: Any) -> None:
        """A message of the controller."""
        self.message = message

    def OnUpdate(self) -> None:
        """Set the velocity once a message."""
        if self.message is not None:
            stick, self.message = self.message.right, None
            self.model.SetLinearVel(Vector3d(-SPEED * stick.joy_x, SPEED * stick.joy_y, 0.0))


GZ_REGISTER_MODEL_PLUGIN(HydraDemoPlugin)
