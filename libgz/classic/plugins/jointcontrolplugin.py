"""JointControlPlugin: holds joints at positions or velocities, or applies efforts to them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.law import law
from libgz.base.pattern import Pattern
from libgz.classic.common import gzwarn
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, JointController, Model
    from libgz.sdf.element import Element

KINDS = ("force", "position", "velocity")


class JointControlPlugin(ModelPlugin):
    """Gives joints to the model's joint controller, with a target each.

    Elements:
        controller: several, with an attribute `type`: force, position or velocity (force).
            joint: a regular expression that matches the whole names of joints, or a name; several.
            target: the effort [N m] or [N], position [rad] or [m], or velocity [rad/s] or [m/s] (0).
            pid_gains: P I D, with the limits of Gazebo's own controllers: 1 of the integral term, 1,000 of the command;
                those of Gazebo's own (1 0.1 0.01) if it is missing. Also pid.
    """

    STATE = ()  # targets belong to the joint controller

    def Load(self, model: Model, sdf: Element) -> None:
        """Set the targets.

        Raises:
            ParameterError: a controller has another type.
        """
        controller = model.GetJointController()
        self.efforts: list[tuple[Joint, float]] = []
        for element in sdf.named("controller"):
            kind = element.Get(str, "type", "force")[0].strip().lower()
            if kind not in KINDS:
                raise ParameterError(
                    f"{element.where}: <controller> has type {kind!r}; allowed are {', '.join(KINDS)}"
                    + nearest(kind, KINDS)
                )
            for joint in _matching(model, element):
                self._control(controller, joint, kind, element)
        if self.efforts:
            self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def _control(self, controller: JointController, joint: Joint, kind: str, element: Element) -> None:
        """Set the target of a joint."""
        name, target = joint.GetScopedName(), element.Get(float, "target")
        if kind == "force":
            self.efforts.append((joint, target))
            return
        tag = next((tag for tag in ("pid", "pid_gains") if element.HasElement(tag)), None)
        pids, aim = (
            (controller.GetPositionPIDs(), controller.SetPositionTarget)
            if kind == "position"
            else (controller.GetVelocityPIDs(), controller.SetVelocityTarget)
        )
        if tag is not None:
            pid, (p, i, d) = pids[name], element.Get(Vector3d, tag)
            pid.SetPGain(p)
            pid.SetIGain(i)
            pid.SetDGain(d)
        aim(name, target)

    @law
    def OnUpdate(self) -> None:
        """Apply the efforts, which last one iteration."""
        for joint, target in self.efforts:
            joint.SetForce(0, target)


def _matching(model: Model, element: Element) -> list[Joint]:
    """The joints that the `<joint>` of a controller match, each once; one that matches none is a warning.

    Raises:
        NotFoundError: there is no `<joint>`.
    """
    patterns = list(element.named("joint"))
    if not patterns:
        raise NotFoundError(f"{element.where}: <joint> is missing and must name a joint")
    joints = {joint.GetScopedName().removeprefix(f"{model.GetScopedName()}::"): joint for joint in model.all_joints()}
    found: dict[str, Joint] = {}
    for pattern in patterns:
        text = pattern.Get(str).strip()
        try:
            regular: Pattern | None = Pattern(text)
        except ParameterError as error:
            regular = None
            if text not in joints:
                gzwarn(f"{pattern.where}: {error}")
        matches = [name for name in joints if name == text or (regular is not None and regular.matches(name))]
        if not matches:
            known = ", ".join(joints) or "none"
            gzwarn(f"{pattern.where}: <joint> {text!r} matches no joint; there are {known}{nearest(text, joints)}")
        found.update((name, joints[name]) for name in matches)
    return list(found.values())


GZ_REGISTER_MODEL_PLUGIN(JointControlPlugin)
