"""PlaneDemoPlugin: controls engines, thrusters and control surfaces of a model by keys."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import transport
from libgz.classic.common import PID
from libgz.classic.event import Events
from libgz.classic.math import Vector3d, clamp
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint, named_link

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Joint, Link, Model
    from libgz.sdf.element import Element

CENTRE_KEY = ord("c")  # centres all control surfaces
UNLIMITED = 1e16


class _Keys:
    """Two keys that increase and decrease a value."""

    def __init__(self, sdf: Element) -> None:
        self._up, self._down = sdf.Get(int, "inc_key"), sdf.Get(int, "dec_key")

    def direction(self, key: int) -> float:
        """1 for the increase key, -1 for the decrease key, 0 for others."""
        return 1.0 if key == self._up else -1.0 if key == self._down else 0.0


class _Engine:
    """A torque on a joint."""

    STATE = ("torque",)

    def __init__(self, joint: Joint, sdf: Element) -> None:
        self.joint, self.keys = joint, _Keys(sdf)
        limit = joint.GetEffortLimit(0)
        limit = limit if limit >= 0.0 else UNLIMITED
        self.least, self.most = sdf.Get(float, "min_val", -limit)[0], sdf.Get(float, "max_val", limit)[0]
        self.change, self.torque = sdf.Get(float, "inc_val"), 0.0

    def press(self, key: int) -> None:
        self.torque = clamp(self.torque + self.keys.direction(key) * self.change, self.least, self.most)

    def act(self, _seconds: float) -> None:
        self.joint.SetForce(0, self.torque)

    def reset(self) -> None:
        self.torque = 0.0


class _Thruster:
    """A force on a link."""

    STATE = ("force",)

    def __init__(self, link: Link, sdf: Element) -> None:
        self.link, self.keys, self.force = link, _Keys(sdf), Vector3d()
        self.change, self.least, self.most = (sdf.Get(Vector3d, f"{tag}_val") for tag in ("inc", "min", "max"))

    def press(self, key: int) -> None:
        command = self.force + self.change * self.keys.direction(key)
        self.force = Vector3d(*(clamp(v, a, b) for v, a, b in zip(command, self.least, self.most, strict=True)))

    def act(self, _seconds: float) -> None:
        self.link.AddRelativeForce(self.force)

    def reset(self) -> None:
        self.force = Vector3d()


class _Control:
    """A joint that is controlled to a position."""

    STATE = ("target", "pid")

    def __init__(self, joint: Joint, sdf: Element) -> None:
        self.joint, self.keys = joint, _Keys(sdf)
        self.least = sdf.Get(float, "min_val", joint.LowerLimit(0))[0]
        self.most = sdf.Get(float, "max_val", joint.UpperLimit(0))[0]
        self.change, self.target = sdf.Get(float, "inc_val"), joint.Position(0)
        p, i, d, i_max, i_min = (sdf.Get(float, tag) for tag in ("p", "i", "d", "i_max", "i_min"))
        most, least = sdf.Get(float, "cmd_max", 1000.0)[0], sdf.Get(float, "cmd_min", -1000.0)[0]
        self.pid = PID(p, i, d, i_max, i_min, most, least)

    def press(self, key: int) -> None:
        command = 0.0 if key == CENTRE_KEY else self.target + self.keys.direction(key) * self.change
        self.target = clamp(command, self.least, self.most)

    def act(self, seconds: float) -> None:
        self.joint.SetForce(0, self.pid.Update(self.joint.Position(0) - self.target, seconds))

    def reset(self) -> None:
        self.target = clamp(0.0, self.least, self.most)
        self.pid.Reset()


class PlaneDemoPlugin(ModelPlugin):
    """Controls a model by keys, received as msgs.Any with an `int_value` on ~/keyboard/keypress.

    All parts have inc_key and dec_key, numbers of keys (119 is w), and inc_val, the change of the command per key
    press; min_val and max_val limit it. The key c centres the control surfaces.

    Elements:
        engine: a torque [N m] on the joint joint_name; limits are by default the effort limit of the joint.
        thruster: a force [N] on the link link_name, three numbers along its axes, min_val and max_val too.
        control: controls the joint joint_name to a position [rad] with a PID of p, i, d, i_max, i_min, cmd_max (1000),
            cmd_min (-1000); limits are by default the joint's.
    """

    STATE = ("parts", "last")

    def Load(self, model: Model, sdf: Element) -> None:
        """Create the parts, and subscribe to keys."""
        self.parts: list[_Engine | _Thruster | _Control] = [
            *(_Engine(named_joint(model, e, "joint_name"), e) for e in sdf.named("engine")),
            *(_Thruster(named_link(model, e), e) for e in sdf.named("thruster")),
            *(_Control(named_joint(model, e, "joint_name"), e) for e in sdf.named("control")),
        ]
        self.world = model.GetWorld()
        self.last = self.world.SimTime().Double()
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe("~/keyboard/keypress", self.OnKeyHit, kind="Any")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnKeyHit(self, message: Any) -> None:
        """A key was pressed."""
        for part in self.parts:
            part.press(message.int_value)

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply all efforts."""
        now = info.simTime.Double()
        seconds, self.last = now - self.last, now
        for part in self.parts:
            part.act(seconds)

    def Reset(self) -> None:
        """Set all commands to zero."""
        self.last = self.world.SimTime().Double()
        for part in self.parts:
            part.reset()


GZ_REGISTER_MODEL_PLUGIN(PlaneDemoPlugin)
