"""CessnaPlugin: the propeller and the control surfaces of an aeroplane."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic import msgs, transport
from libgz.classic.common import PID
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

SURFACES = ("left_aileron", "left_flap", "right_aileron", "right_flap", "elevators", "rudder")
TURN = 2.0 * math.pi
PROPELLER_LIMIT, SURFACES_LIMIT = 20000.0, 20.0  # of the efforts [N m]


class CessnaPlugin(ModelPlugin):
    """Controls the propeller's speed and the angles of six control surfaces by PID controllers.

    ~/<model>/control takes a Cessna message: cmd_propeller_speed as a share of the maximum, from -1 to 1, and the
    angles cmd_left_aileron and so on [rad]; fields that are not set stay as they were. ~/<model>/state has the present
    values and the commands, each iteration.

    Elements:
        propeller, left_aileron, left_flap, right_aileron, right_flap, elevators, rudder: the joints.
        propeller_max_rpm: the propeller's maximum speed [1/min].
        propeller_p_gain, propeller_i_gain, propeller_d_gain: (50, 0.1, 1); the effort is at most 20000 N m.
        surfaces_p_gain, surfaces_i_gain, surfaces_d_gain: (50, 0.1, 1); the effort is at most 20 N m.
    """

    STATE = ("commands", "pids", "last")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and subscribe.

        Raises:
            NotFoundError: an element or a joint is missing.
            ParameterError: the maximum speed is zero.
        """
        if not sdf.HasElement("propeller_max_rpm"):
            raise NotFoundError(f"{sdf.where}: Unable to find the <propeller_max_rpm> parameter.")
        self.most = sdf.Get(float, "propeller_max_rpm") * TURN / 60.0  # [rad/s]
        if self.most == 0.0:
            raise ParameterError(f"{sdf.where}: Maximum propeller RPMs cannot be 0")
        self.joints = {name: named_joint(model, sdf, name) for name in ("propeller", *SURFACES)}
        self.pids = {name: self._pid(sdf, name) for name in self.joints}
        self.commands = dict.fromkeys(self.joints, 0.0)
        self.world = model.GetWorld()
        self.last = self.world.SimTime().Double()
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.Cessna, f"~/{model.GetName()}/state")
        self.subscriber = self.node.Subscribe(f"~/{model.GetName()}/control", self.OnControl, kind="Cessna")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    @staticmethod
    def _pid(sdf: Element, name: str) -> PID:
        prefix, limit = ("propeller", PROPELLER_LIMIT) if name == "propeller" else ("surfaces", SURFACES_LIMIT)
        defaults = {"p": 50.0, "i": 0.1, "d": 1.0}
        p, i, d = (sdf.Get(float, f"{prefix}_{gain}_gain", value)[0] for gain, value in defaults.items())
        return PID(p, i, d, 0.0, 0.0, limit, -limit)

    def Reset(self) -> None:
        """Set all commands to zero."""
        self.commands = dict.fromkeys(self.joints, 0.0)
        self.last = self.world.SimTime().Double()
        for pid in self.pids.values():
            pid.Reset()

    def OnControl(self, message: Any) -> None:
        """New commands."""
        for name in self.joints:
            field = _command(name)
            value = getattr(message, field)
            if message.HasField(field) and math.isfinite(value):
                self.commands[name] = min(max(value, -1.0), 1.0) if name == "propeller" else value

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply the efforts, and publish the state."""
        now = info.simTime.Double()
        for name, joint in self.joints.items():
            joint.SetForce(0, self.pids[name].Update(self._value(name) - self._target(name), now - self.last))
        self.last = now
        state = msgs.Cessna()
        for name in self.joints:
            setattr(state, _command(name), self.commands[name])
            if name == "propeller":
                state.propeller_speed = self._value(name) / self.most
            else:
                setattr(state, name, self._value(name))
        self.publisher.Publish(state)

    def _value(self, name: str) -> float:
        """The speed of the propeller [rad/s], or the angle of a surface [rad]."""
        joint = self.joints[name]
        return joint.GetVelocity(0) if name == "propeller" else joint.Position(0)

    def _target(self, name: str) -> float:
        return self.commands[name] * (self.most if name == "propeller" else 1.0)


def _command(name: str) -> str:
    """The field of a joint's command in a Cessna message."""
    return "cmd_propeller_speed" if name == "propeller" else f"cmd_{name}"


GZ_REGISTER_MODEL_PLUGIN(CessnaPlugin)
