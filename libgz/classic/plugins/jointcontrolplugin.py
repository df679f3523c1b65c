"""JointControlPlugin: holds joints at positions or velocities, or applies efforts to them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError, nearest
from libgz.classic.common import PID
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

KINDS = ("force", "position", "velocity")


class JointControlPlugin(ModelPlugin):
    """Gives joints to the model's joint controller, with a target each.

    Elements:
        controller: one a joint, with an attribute `type`: force, position or velocity (force).
            joint: its name.
            target: the effort [N m] or [N], position [rad] or [m], or velocity [rad/s] or [m/s] (0).
            pid: the gains P I D; of Gazebo's own if it is missing. Also pid_gains.
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
            joint, target = named_joint(model, element, "joint"), element.Get(float, "target")
            if kind == "force":
                self.efforts.append((joint, target))
                continue
            name = joint.GetScopedName()
            tag = next((tag for tag in ("pid", "pid_gains") if element.HasElement(tag)), None)
            pid = PID(*element.Get(Vector3d, tag)) if tag is not None else None
            if kind == "position":
                if pid is not None:
                    controller.SetPositionPID(name, pid)
                controller.SetPositionTarget(name, target)
            else:
                if pid is not None:
                    controller.SetVelocityPID(name, pid)
                controller.SetVelocityTarget(name, target)
        if self.efforts:
            self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self) -> None:
        """Apply the efforts, which last one iteration."""
        for joint, target in self.efforts:
            joint.SetForce(0, target)


GZ_REGISTER_MODEL_PLUGIN(JointControlPlugin)
