"""HarnessPlugin: holds a model by a joint to the world, lowers it by a winch, and lets it loose."""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic import msgs, transport
from libgz.classic.common import PID, gzwarn
from libgz.classic.event import Events
from libgz.classic.math import Pose3d
from libgz.classic.plugin import ModelPlugin
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model

__all__ = ["HarnessPlugin"]

log = logging.getLogger("libgz.classic")


class HarnessPlugin(ModelPlugin):
    """Makes joints between the model and the world, one of which is a winch.

    ~/<model>/harness/velocity takes the winch's velocity as a GzString with a number [m/s], downwards or upwards as the
    joint's axis is; with 0 it holds its position. The controller of the velocity only pulls.
    ~/<model>/harness/detach, a GzString `true`, removes the joint that `<detach>` names; ~/<model>/harness/attach, a
    Pose, then puts the link that this joint held there, and makes the joints again. As in Gazebo 11.1 the joint goes in
    the second iteration if `<winch>` names no joint, and a controller without limits of its command does nothing.

    Elements:
        joint: as in a `<model>`; its child is a link of the model. Several.
        winch: `<joint>`, the name of a prismatic joint; `<pos_pid>` and `<vel_pid>`, the controllers of its position
            [N/m] and velocity [N s/m], with `<p>`, `<i>`, `<d>`, `<i_max>`, `<i_min>`, `<cmd_max>`, `<cmd_min>`, all 0
            if they are missing.
        detach: the name of the joint that is removed. Names that the harness does not have mean its first joint.
    """

    STATE = ("velocity", "target", "winch", "attached", "pos_pid", "vel_pid", "before")

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
        self.named_winch = self._known_joint(winch, "joint")
        self.loose = self._known_joint(sdf, "detach")
        self.pos_pid, self.vel_pid = _pid(winch, "pos_pid"), _pid(winch, "vel_pid")
        for element in self.elements.values():
            if model.CreateJoint(element) is None:
                raise ParameterError(f"{element.where}: joint {element.Get(str, 'name')!r} cannot be made")
        self._begin()
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        topic = f"~/{model.GetName()}/harness"
        self.subscribers = [
            self.node.Subscribe(f"{topic}/velocity", self.OnVelocity, kind="GzString"),
            self.node.Subscribe(f"{topic}/detach", self.OnDetach, kind="GzString"),
            self.node.Subscribe(f"{topic}/attach", self.OnAttach, kind="Pose"),
        ]
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def _known_joint(self, holder: Element, tag: str) -> str:
        """The joint that a child names; an empty string if there is none."""
        if not holder.HasElement(tag):
            return ""
        name, first = holder.Get(str, tag).strip(), next(iter(self.elements))
        if name not in self.elements:
            known = f"the harness has {', '.join(self.elements)}{nearest(name, self.elements)}"
            gzwarn(f"{holder.where}: <{tag}> is {name!r}; {known}; {first!r} is used")
        return name if name in self.elements else first

    def _begin(self) -> None:
        self.winch, self.velocity, self.target, self.before = self.named_winch, 0.0, 0.0, 0.0
        self.attached = True
        for pid in (self.pos_pid, self.vel_pid):
            pid.Reset()

    def Reset(self) -> None:
        """Hold the model again where it started."""
        self._make_joints()
        self._begin()

    def _make_joints(self) -> None:
        for name, element in self.elements.items():
            if self.model.GetJoint(name) is None:
                self.model.CreateJoint(element)

    def OnVelocity(self, message: Any) -> None:
        """Set the winch's velocity."""
        try:
            velocity = float(message.data)
        except ValueError:
            log.error("HarnessPlugin: the velocity %.200r is no number", message.data)
            return
        self.SetWinchVelocity(velocity)

    def SetWinchVelocity(self, velocity: float) -> None:
        """Set the winch's velocity [m/s]; 0: hold the position."""
        joint = self.model.GetJoint(self.winch) if self.winch else None
        if not math.isfinite(velocity):
            log.error("HarnessPlugin: a velocity of %r is not finite", velocity)
        elif joint is None:
            log.error("HarnessPlugin: there is no winch to set the velocity of")
        else:
            self.velocity = velocity
            if velocity == 0.0:
                self.target = joint.Position(0)
                self.pos_pid.Reset()

    def OnDetach(self, message: Any) -> None:
        """Remove the joint in the next iteration, if the message says so."""
        if message.data in ("true", "True", "TRUE"):
            self.Detach()

    def Detach(self) -> None:
        """Remove the joint that `<detach>` names, in the next iteration."""
        self.winch = ""

    def OnAttach(self, message: Any) -> None:
        """Hold the model again, at the message's pose."""
        try:
            self.Attach(msgs.ConvertIgn(message))
        except ParameterError as error:
            log.error("HarnessPlugin: %s", error)

    def Attach(self, pose: Pose3d) -> None:
        """Hold the model again, with the link that the removed joint held at a pose [m].

        Raises:
            ParameterError: the pose is not finite, or out of range.
        """
        if self.attached:
            log.error("HarnessPlugin: the model is attached already")
            return
        link = self.model.GetLink(self.elements[self.loose].Get(str, "child")) if self.loose else None
        offset = Pose3d() if link is None else link.WorldPose() - self.model.WorldPose()
        self.model.SetWorldPose(-offset + pose)
        self._make_joints()
        self.winch, self.velocity, self.target, self.attached = self.named_winch, 0.0, 0.0, True

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply the winch's force."""
        if not self.attached:
            return
        now = info.simTime.Double()
        if self.before == 0.0:
            self.before = now
            return
        joint = self.model.GetJoint(self.winch) if self.winch else None
        if joint is None:
            self.attached = False
            if self.loose:
                self.model.RemoveJoint(self.loose)
            return
        passed, self.before = now - self.before, now
        behind = joint.Position(0) - self.target if self.velocity == 0.0 else 0.0
        held = self.pos_pid.Update(behind, passed)
        pulled = self.vel_pid.Update(joint.GetVelocity(0) - self.velocity, passed)
        joint.SetForce(0, held + max(pulled, 0.0))


def _pid(winch: Element, tag: str) -> PID:
    """The controller of an element; one that does nothing if there is none."""
    element = next(winch.named(tag), None)
    names = ("p", "i", "d", "i_max", "i_min", "cmd_max", "cmd_min")
    return PID() if element is None else PID(*(element.Get(float, name, 0.0)[0] for name in names))


def _described(joint: Element) -> Element:
    """A `<joint>` with the defaults of SDF, which elements of plugins lack."""
    return SdfFile.from_string(f"<sdf version='1.6'>{joint.ToString()}</sdf>", parts=True).root.child("joint")
