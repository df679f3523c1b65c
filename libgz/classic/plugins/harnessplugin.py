"""HarnessPlugin: holds a model by a joint to the world, lowers it by a winch, and lets it loose."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic import transport
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._pids import pid_of
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Joint, Model

log = logging.getLogger("libgz.classic")


class HarnessPlugin(ModelPlugin):
    """Makes joints between the model and the world, one of which is a winch.

    ~/<model>/harness/velocity takes the winch's velocity as a GzString with a number [m/s], downwards or upwards as the
    joint's axis is; with 0 it holds its position. ~/<model>/harness/detach, a GzString `true`, removes the joint that
    `<detach>` names.

    Elements:
        joint: as in a `<model>`; its child is a link of the model. Several.
        winch: `<joint>`, the name of a prismatic joint; `<pos_pid>` and `<vel_pid>`, the controllers of its position
            [N/m] and velocity [N s/m], with `<p>`, `<i>`, `<d>`, `<i_max>`, `<i_min>`, `<cmd_max>`, `<cmd_min>`.
        detach: the name of the joint that is removed.
    """

    STATE = ("velocity", "target", "attached", "pos_pid", "vel_pid", "before")

    def Load(self, model: Model, sdf: Element) -> None:
        """Make the joints, and subscribe.

        Raises:
            NotFoundError: a joint is missing.
            ParameterError: a joint cannot be made.
        """
        self.model = model
        self.elements = {element.Get(str, "name"): _described(element) for element in sdf.named("joint")}
        if not self.elements:
            raise NotFoundError(f"{sdf.where}: <joint> is missing; it holds the model")
        winch = next(sdf.named("winch"), Element("winch"))
        self.winch = self._name(sdf, winch.Get(str, "joint").strip(), "winch><joint")
        self.loose = self._name(sdf, sdf.Get(str, "detach").strip(), "detach")
        self.pos_pid = pid_of(winch, "pos_pid", p=1000.0, d=500.0)
        self.vel_pid = pid_of(winch, "vel_pid", p=1000.0)
        for element in self.elements.values():
            if model.CreateJoint(element) is None:
                raise ParameterError(f"{element.where}: joint {element.Get(str, 'name')!r} cannot be made")
        self.attached, self.velocity, self.before = True, 0.0, -1.0
        self.target = self._joint().Position(0) if self.winch else 0.0
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        topic = f"~/{model.GetName()}/harness"
        self.subscribers = [
            self.node.Subscribe(f"{topic}/velocity", self.OnVelocity),
            self.node.Subscribe(f"{topic}/detach", self.OnDetach),
        ]
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def _name(self, sdf: Element, name: str, tag: str) -> str:
        if name and name not in self.elements:
            raise NotFoundError(
                f"{sdf.where}: <{tag}> is {name!r}; the harness has {', '.join(self.elements)}"
                + nearest(name, self.elements)
            )
        return name

    def _joint(self) -> Joint:
        joint = self.model.GetJoint(self.winch)
        if joint is None:
            raise NotFoundError(f"model {self.model.GetName()!r} has no joint {self.winch!r} any more")
        return joint

    def Reset(self) -> None:
        """Hold the model again where it started."""
        for name, element in self.elements.items():
            if self.model.GetJoint(name) is None:
                self.model.CreateJoint(element)
        self.attached, self.velocity, self.before = True, 0.0, -1.0
        self.target = self._joint().Position(0) if self.winch else 0.0
        for pid in (self.pos_pid, self.vel_pid):
            pid.Reset()

    def OnVelocity(self, message: Any) -> None:
        """Set the winch's velocity."""
        try:
            velocity = float(message.data)
        except ValueError:
            log.error("HarnessPlugin: the velocity %r is no number", message.data)
            return
        if self.winch and self.attached:
            if velocity == 0.0 and self.velocity != 0.0:
                self.target = self._joint().Position(0)
            self.velocity = velocity

    def OnDetach(self, message: Any) -> None:
        """Remove the joint, if the message says so."""
        if message.data.strip().lower() in ("true", "1") and self.loose and self.model.RemoveJoint(self.loose):
            self.attached = self.attached and self.loose != self.winch

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply the winch's force."""
        now = info.simTime.Double()
        passed = now - self.before if self.before >= 0.0 else 0.0
        self.before = now
        if not (self.winch and self.attached):
            return
        joint = self._joint()
        if self.velocity == 0.0:
            force = self.pos_pid.Update(joint.Position(0) - self.target, passed)
        else:
            force = self.vel_pid.Update(joint.GetVelocity(0) - self.velocity, passed)
        joint.SetForce(0, force)


def _described(joint: Element) -> Element:
    """A `<joint>` with the defaults of SDF, which elements of plugins lack."""
    text = f"<sdf version='1.6'><model name='harness'><link name='link'/>{joint.ToString()}</model></sdf>"
    return SdfFile.from_string(text).root.child("model").child("joint")


GZ_REGISTER_MODEL_PLUGIN(HarnessPlugin)
