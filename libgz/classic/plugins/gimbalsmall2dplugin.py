"""GimbalSmall2dPlugin: tilts a camera to an angle that comes on a topic."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.common import PID
from libgz.classic.common.console import gzwarn
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import find_joint

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

EFFORT = 1.0  # [N m], at most
ITERATIONS = 101  # between two messages of the angle


class GimbalSmall2dPlugin(ModelPlugin):
    """Holds a joint at an angle by a PID controller with P = 1 and an effort of at most 1 N m.

    ~/<model>/gimbal_tilt_cmd takes the angle [rad] as the text of a GzString; at the start it is pi / 2.
    ~/<model>/gimbal_tilt_status has the present one, every 101 iterations.

    Elements:
        joint: the name of the joint (tilt_joint).
    """

    STATE = ("target", "pid", "last", "iterations")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joint, and subscribe.

        Raises:
            NotFoundError: there is no such joint.
        """
        self.world = model.GetWorld()
        self.joint = find_joint(model, sdf.Get(str, "joint", "tilt_joint")[0].strip())
        self.pid = PID(1.0, 0.0, 0.0, 0.0, 0.0, EFFORT, -EFFORT)
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.publisher = self.node.Advertise(msgs.GzString, f"~/{model.GetName()}/gimbal_tilt_status")
        self.subscriber = self.node.Subscribe(f"~/{model.GetName()}/gimbal_tilt_cmd", self.OnStringMsg, kind="GzString")
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Return to the angle of the start."""
        self.target, self.iterations = math.pi / 2.0, ITERATIONS
        self.last = self.world.SimTime().Double()  # [s]
        self.pid.Reset()

    def OnStringMsg(self, message: Any) -> None:
        """A new angle."""
        try:
            target = float(message.data)
        except ValueError:
            target = math.nan
        if math.isfinite(target):
            self.target = target
        else:
            gzwarn(f"gimbal_tilt_cmd {message.data!r} is no angle in radians; it is ignored")

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply the effort, and publish the angle."""
        now, angle = info.simTime.Double(), self.joint.Position(0)
        if now > self.last:
            self.joint.SetForce(0, self.pid.Update(angle - self.target, now - self.last))
        self.last = now
        self.iterations += 1
        if self.iterations >= ITERATIONS:
            self.iterations = 0
            self.publisher.Publish(msgs.GzString(data=f"{angle:g}"))


GZ_REGISTER_MODEL_PLUGIN(GimbalSmall2dPlugin)
