"""ActuatorPlugin: limits the efforts of joints by models of their motors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint

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

    power: float
    max_velocity: float
    max_torque: float


def _electric_motor(motor: _Motor, speed: float) -> float:
    """The effort limit of a motor with so much power."""
    return min(motor.max_torque, motor.power / speed) if speed > 0.0 else motor.max_torque


def _velocity_limiter(motor: _Motor, speed: float) -> float:
    """The effort limit of a motor that has none above a velocity."""
    return motor.max_torque if speed < motor.max_velocity else 0.0


MODELS: dict[str, Callable[[_Motor, float], float] | None] = {
    "electric_motor": _electric_motor,
    "velocity_limiter": _velocity_limiter,
    "null": None,
}


class ActuatorPlugin(ModelPlugin):
    """Sets the effort limits of joints in each iteration by what their motors can do at the present speed.

    Elements:
        actuator: one a motor.
            joint, index: the joint, and its axis (0).
            type: electric_motor, whose effort is at most max_torque and power / speed; velocity_limiter, which has
                max_torque below max_velocity and none above; null, which leaves the joint as it is (null).
            power: [W].
            max_velocity: [rad/s] or [m/s].
            max_torque: [N m] or [N].
    """

    STATE = ()  # limits belong to the joints

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints.

        Raises:
            NotFoundError: there is no such joint.
            ParameterError: a type is unknown, or a number is missing or negative.
        """
        self.motors: list[tuple[Joint, int, _Motor, Callable[[_Motor, float], float]]] = []
        for element in sdf.named("actuator"):
            joint, index = named_joint(model, element, "joint"), element.Get(int, "index", 0)[0]
            if not 0 <= index < joint.DOF():
                raise ParameterError(
                    f"{element.where}: <index> is {index}; joint {joint.GetName()!r} has {joint.DOF()}"
                )
            kind = element.Get(str, "type", "null")[0].strip()
            if kind not in MODELS:
                raise ParameterError(
                    f"{element.where}: <type> is {kind!r}; allowed are {', '.join(MODELS)}{nearest(kind, MODELS)}"
                )
            limit = MODELS[kind]
            if limit is not None:
                self.motors.append((joint, index, self._motor(element), limit))
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    @staticmethod
    def _motor(element: Element) -> _Motor:
        values = []
        for tag in ("power", "max_velocity", "max_torque"):
            if not element.HasElement(tag):
                raise NotFoundError(f"{element.where}: <{tag}> is missing")
            values.append(element.Get(float, tag))
            if not values[-1] >= 0.0:
                raise ParameterError(f"{element.where}: <{tag}> is {values[-1]:g}; it must not be negative")
        return _Motor(*values)

    def OnUpdate(self) -> None:
        """Set the limits of this iteration."""
        for joint, index, motor, limit in self.motors:
            joint.SetEffortLimit(index, limit(motor, abs(joint.GetVelocity(index))))


GZ_REGISTER_MODEL_PLUGIN(ActuatorPlugin)
