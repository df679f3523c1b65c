"""VehiclePlugin: drives a car with four wheels by pedals and a steering wheel."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic import transport
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond, Vector3d
from libgz.classic.msgs import ConvertIgn
from libgz.classic.physics import Joint
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint
from libgz.classic.plugins._wheels import radius_of

if TYPE_CHECKING:
    from libgz.classic.physics import Link, Model
    from libgz.sdf.element import Element

PEDAL_RETURN = 0.1  # effort that returns a pedal [N] or [N m]
SWAY_LIMIT = 15.0  # [N]


class VehiclePlugin(ModelPlugin):
    """Turns the positions of two pedals and a steering wheel into efforts and angles of four wheels.

    A pedal's share is its position over its upper limit. The wheels run at max_speed * (gas - brake), with an effort of
    power * (gas + brake); the front wheels turn with the steering wheel. The force aero_load * speed^2 presses the car
    down, sway bars hold it upright.

    ~/<model>/vel_cmd, a Pose, presses the pedals and turns the steering wheel: x of the position is the speed [m/s],
    negative to brake, yaw of the orientation the angle of the front wheels [rad].

    Elements:
        front_left_joint, front_right_joint: joints of two axes, the first one steers, the second one spins.
        back_left_joint, back_right_joint: joints whose last axis spins.
        gas_joint, brake_joint, steering_joint: of pedals and steering wheel; also gas, brake, steering.
        front_power, rear_power: efforts of the wheels [N m] (50).
        max_speed: [m/s] (10).
        tire_angle_range: from stop to stop [rad] (0.5).
        aero_load: [N s^2/m^2] (0.1).
        swayforce: force of the sway bars per displacement [N/m] (10).
    """

    STATE = ("command",)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and subscribe.

        Raises:
            NotFoundError: a joint is missing.
            ParameterError: a front wheel cannot be steered, or a pedal has no limit.
        """
        names = ("front_left", "front_right", "back_left", "back_right")
        self.wheels = [named_joint(model, sdf, f"{name}_joint", name) for name in names]
        for joint in self.wheels[:2]:
            if joint.DOF() != 2:
                raise ParameterError(
                    f"{sdf.where}: joint {joint.GetName()!r} has one axis; a front wheel needs two (revolute2)"
                )
        self.gas, self.brake = (
            named_joint(model, sdf, "gas_joint", "gas"),
            named_joint(model, sdf, "brake_joint", "brake"),
        )
        self.steering = named_joint(model, sdf, "steering_joint", "steering")
        for pedal in (self.gas, self.brake):
            if not 0.0 < pedal.UpperLimit(0) < 1e6:
                raise ParameterError(f"{sdf.where}: pedal {pedal.GetName()!r} needs a positive upper limit")
        self.front_power, self.rear_power = (sdf.Get(float, f"{end}_power", 50.0)[0] for end in ("front", "rear"))
        self.max_speed = sdf.Get(float, "max_speed", 10.0)[0]
        self.aero_load = sdf.Get(float, "aero_load", 0.1)[0]
        self.sway = sdf.Get(float, "swayforce", 10.0)[0]
        turn = self.steering.UpperLimit(0) - self.steering.LowerLimit(0)
        if not 0.0 < turn < 1e6:
            raise ParameterError(f"{sdf.where}: joint {self.steering.GetName()!r} needs limits")
        self.ratio = sdf.Get(float, "tire_angle_range", 0.5)[0] / turn
        parent: Link | Any = self.wheels[0].GetParent()
        self.chassis: Link = parent if parent is not None else model.GetLinks()[0]
        self.radius = radius_of(self.wheels[0].GetChild())
        if not self.radius > 0.0:
            raise ParameterError(f"{sdf.where}: the wheel of {self.wheels[0].GetName()!r} has no shape with a radius")
        self.command: tuple[float, float] | None = None  # speed [m/s], angle of the front wheels [rad]
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe(f"~/{model.GetName()}/vel_cmd", self.OnVelMsg, kind="Pose")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Release the pedals."""
        self.command = None

    def OnVelMsg(self, message: Any) -> None:
        """A new command."""
        speed, angle = message.position.x, Quaterniond(ConvertIgn(message.orientation)).Yaw()
        if math.isfinite(speed) and math.isfinite(angle):
            self.command = speed, angle

    def OnUpdate(self) -> None:
        """Apply efforts to the wheels, and set their angles."""
        if self.command is not None:
            self._press(*self.command)
        gas, brake = (max(pedal.Position(0), 0.0) / pedal.UpperLimit(0) for pedal in (self.gas, self.brake))
        for pedal in (self.gas, self.brake):
            pedal.SetForce(0, -PEDAL_RETURN)
        rate = max(0.0, gas - brake) * self.max_speed / self.radius
        for i, joint in enumerate(self.wheels):
            spin = joint.DOF() - 1
            effort = (gas + brake) * (self.front_power if i < 2 else self.rear_power)
            joint.SetParam("fmax", spin, effort)
            joint.SetParam("vel", spin, _sense(joint) * rate)
        angle = self.steering.Position(0) * self.ratio
        for joint in self.wheels[:2]:
            joint.SetLowerLimit(0, _sense(joint) * angle)
            joint.SetUpperLimit(0, _sense(joint) * angle)
        speed = self.chassis.WorldLinearVel().SquaredLength()
        self.chassis.AddForce(Vector3d(0.0, 0.0, -self.aero_load * speed))
        self._sway()

    def _press(self, speed: float, angle: float) -> None:
        """Move pedals and steering wheel to where a command has them."""
        share = max(-1.0, min(speed / self.max_speed, 1.0)) if self.max_speed else 0.0
        # Pedals move with the car: they are not stopped in the world.
        self.gas.SetPosition(0, max(share, 0.0) * self.gas.UpperLimit(0), True)
        self.brake.SetPosition(0, max(-share, 0.0) * self.brake.UpperLimit(0), True)
        low, high = self.steering.LowerLimit(0), self.steering.UpperLimit(0)
        self.steering.SetPosition(0, max(low, min(angle / self.ratio, high)) if self.ratio else 0.0, True)

    def _sway(self) -> None:
        """Pull a wheel that is pressed up, down, and its neighbour up."""
        for i, joint in enumerate(self.wheels):
            axis = joint.GlobalAxis(0)
            lift = (joint.Anchor(1) - joint.Anchor(0)).Dot(axis) if joint.DOF() == 2 else 0.0
            if lift > 0.0:
                force = min(lift * self.sway, SWAY_LIMIT)
                for wheel, sign in ((joint, -1.0), (self.wheels[i ^ 1], 1.0)):
                    child = wheel.GetChild()
                    if child is not None:
                        child.AddForce(Vector3d(0.0, 0.0, sign * force))


def _sense(joint: Joint) -> float:
    """-1 for a joint whose positive motion is that of the parent against the child."""
    return -1.0 if joint.HasType(Joint.HINGE2_JOINT) else 1.0


GZ_REGISTER_MODEL_PLUGIN(VehiclePlugin)
