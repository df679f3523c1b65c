"""ActuatorPlugin: limits the efforts of joints by models of their motors."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from libgz.base.errors import nearest
from libgz.classic.common import gzwarn
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element


@dataclass
class _Motor:
    """A motor.

    Attributes:
        power: [W].
        max_velocity: [rad/s] or [m/s].
        max_torque: [N m] or [N].
    """

    power: float = 0.0
    max_velocity: float = 0.0
    max_torque: float = 0.0


def _electric_motor(motor: _Motor, speed: float) -> float:
    """The effort limit of a motor with so much power; below zero, where it turns backwards, there is none."""
    if speed > motor.max_velocity:
        return motor.power / motor.max_velocity if motor.max_velocity else motor.max_torque
    return min(motor.power / speed, motor.max_torque) if speed else motor.max_torque


def _velocity_limiter(motor: _Motor, speed: float) -> float:
    """The effort limit of a motor that has none above a velocity."""
    return motor.max_torque if abs(speed) < motor.max_velocity else 0.0


MODELS: dict[str, Callable[[_Motor, float], float] | None] = {
    "electric_motor": _electric_motor,
    "velocity_limiter": _velocity_limiter,
    "null": None,
}
NEEDED = {"electric_motor": ("power", "max_velocity", "max_torque"), "velocity_limiter": ("max_velocity", "max_torque")}


class ActuatorPlugin(ModelPlugin):
    """Sets the effort limits of joints in each iteration by what their motors can do at the present speed.

    An electric motor is as in Gazebo 11.1, which computes in single precision and has no limit where it turns
    backwards. There a velocity limiter and `null` keep their joints from moving at all.

    Elements:
        actuator: one a motor.
            joint, index: the joint, and its axis (0).
            type: electric_motor, whose effort is at most max_torque and power / speed, and above max_velocity power /
                max_velocity; velocity_limiter, which has max_torque below max_velocity and none above; null, which
                leaves the joint as it is (null).
            power: [W].
            max_velocity: [rad/s] or [m/s].
            max_torque: [N m] or [N].
    """

    STATE = ()  # limits belong to the joints

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints; an actuator with an error is left out, with a warning."""
        self.motors: list[tuple[Joint, int, _Motor, Callable[[_Motor, float], float]]] = []
        for element in sdf.named("actuator"):
            name, index = element.Get(str, "joint").strip(), element.Get(int, "index", 0)[0]
            kind = element.Get(str, "type", "null")[0].strip()
            joint = model.GetJoint(name)
            missing = [tag for tag in NEEDED.get(kind, ()) if not element.HasElement(tag)]
            if joint is None:
                known = [one.GetName() for one in model.GetJoints()]
                problem = f"there is no joint {name!r}{nearest(name, known)}"
            elif not 0 <= index < joint.DOF():
                problem = f"<index> is {index}; joint {name!r} has {joint.DOF()}"
            elif missing:
                problem = f"<{missing[0]}> is missing"
            else:
                if kind not in MODELS:
                    allowed = f"allowed are {', '.join(MODELS)}{nearest(kind, MODELS)}"
                    gzwarn(f"{element.where}: <type> is {kind!r}; {allowed}; null is used")
                    kind = "null"
                motor = _Motor(*(_single(element.Get(float, tag, 0.0)[0]) for tag in NEEDED["electric_motor"]))
                limit = MODELS[kind]
                if limit is not None:
                    self.motors.append((joint, index, motor, limit))
                continue
            gzwarn(f"{element.where}: <actuator>: {problem}; it is left out")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self) -> None:
        """Set the limits of this iteration."""
        for joint, index, motor, limit in self.motors:
            joint.SetEffortLimit(index, _single(limit(motor, _single(joint.GetVelocity(index)))))


def _single(value: float) -> float:
    return ctypes.c_float(value).value


GZ_REGISTER_MODEL_PLUGIN(ActuatorPlugin)
