"""SegwayRMP: a balancing platform on two wheels side by side.

Of the original source only the names of the bodies are known. Footprint, wheels and track are those published for the
real RMP 200 (64 x 61 cm, 48 cm, 54 cm); the layout of bodies and the controller gains were chosen for libgz.
"""

from __future__ import annotations

import math
from typing import Any, ClassVar, Generic, NamedTuple

from libgz.base.geometry import GzColor, GzVector
from libgz.base.law import Value, clamp, law, unrecorded, usually, where
from libgz.base.records import numbers
from libgz.interfaces.position import PositionData
from libgz.models.drive import DifferentialRobot
from libgz.models.motion import Motion
from libgz.models.parts import DARK, GREY, add_body, fit
from libgz.models.robot import RobotAttributes
from libgz.models.wheels import HARD, Tire
from libgz.ode.types import dParamHiStop, dParamLoStop
from libgz.physics.geoms import BoxGeom
from libgz.physics.joint import SliderJoint
from libgz.simulation.plan import Plan
from libgz.worldfile.attributes import boolean, declaration

TIRE = Tire(0.24, 0.05, 5.0, DARK, hard=True)
TOP_PLATE = (0.0, 0.0, 0.70)  # [m]

# Torque of both wheels together [N m]: per metre of lag, per m/s of excess speed, per radian and per rad/s of pitch.
PLACE_GAIN, SPEED_GAIN, PITCH_GAIN, PITCH_RATE_GAIN = 10.0, 33.0, 144.0, 29.0
# Difference of the wheels' torques: per rad/s of error, of its integral, of its derivative.
TURN_GAIN, TURN_INTEGRAL_GAIN, TURN_DERIVATIVE_GAIN = 2.0, 0.02, 0.1
MAX_TORQUE = 80.0  # [N m], both wheels together
MAX_SPEED, MAX_TURN = 1.5, 1.4  # [m/s], [rad/s]
MAX_LAG = 1.0  # [m]; a longer lag does not increase the torque
# For a soft landing: damper of the tires, and the gains while it falls freely.
LANDING_DAMPER = 1000.0  # [N s/m]
FLIGHT_PITCH_GAIN, FLIGHT_PITCH_RATE_GAIN = 14.0, 9.0
UPRIGHT = math.cos(math.radians(60.0))  # z of its upward axis, below which it stops balancing


@declaration
class SegwayRMPAttributes(RobotAttributes):
    """Attributes of `<model:SegwayRMP>`."""

    softLanding: bool = boolean(False, help="stay upright when it is dropped; true in worldfiles of 0.4")


class SegwayRMP(DifferentialRobot):
    """A base and a `topPlate` on two wheels; the origin is on the ground under the axle.

    Serves position, with the pitch in rot[1]. It balances from the first step on; with its motors off it falls over.
    Dimensions as published for the real machine; layout chosen for libgz.

    With `softLanding` it stays upright when it is dropped from up to 30 cm: the tires damp the impact, and while it
    falls the wheels only counteract its pitching. Worldfiles of Gazebo 0.4, which start robots above the ground, have
    that without naming it.
    """

    STATE: ClassVar[tuple[str, ...]] = ("motion", "_velocity", "_balance")

    values: SegwayRMPAttributes

    behaviour = "balancing (it falls over); driving; odometry"
    attributes: ClassVar[type[RobotAttributes]] = SegwayRMPAttributes
    wheelSep, wheelDiam = 0.54, 0.48
    maxTorque = MAX_TORQUE / 2.0
    limits = (MAX_SPEED, MAX_TURN)

    def build(self) -> None:  # noqa: D102
        base = add_body(self)
        fit(BoxGeom(base, self.modelSpaceId, 0.22, 0.42, 0.22), (0.0, 0.0, 0.36), 22.0, GREY)
        plate = add_body(self, "topPlate")
        fit(BoxGeom(plate, self.modelSpaceId, 0.45, 0.45, 0.02), (0.0, 0.0, 0.0), 8.0, GzColor(0.8, 0.8, 0.2))
        plate.SetPosition(TOP_PLATE)
        slider = SliderJoint(self.world, name="topPlate")
        slider.Attach(plate, base)
        slider.SetAxis(0.0, 0.0, 1.0)
        slider.SetParam(dParamLoStop, 0.0)
        slider.SetParam(dParamHiStop, 0.0)
        self._hinges = self.add_pair(0.27, 0.24, TIRE)
        self._velocity: GzVector | None = None  # of the base in the previous step [m/s], where landings matter
        if self.values.softLanding:
            self._velocity = GzVector()
            for hinge in self._hinges:
                wheel = hinge.GetJointBody(0)
                for geom in wheel.GetGeoms() if wheel is not None else ():
                    geom.SetHardness(HARD[0], LANDING_DAMPER)
        self.motion = Motion()  # of the base; leaning forward is a positive pitch
        self._balance = numbers(3)()  # see `_Balance`

    @property
    @law
    def pitch(self) -> float:
        """Of the base [rad], leaning forward positive."""
        return self.motion.attitude[1]  # type: ignore[no-any-return]

    @property
    @law
    def pitchRate(self) -> float:
        """Of the base [rad/s], likewise."""
        return self.motion.rate[1]  # type: ignore[no-any-return]

    @law
    def wheel_rates(self) -> tuple[float, float]:
        """Rates at which the wheels roll on the ground [rad/s]: their hinge rates plus the pitch rate of the base."""
        left, right = super().wheel_rates()
        return left + self.pitchRate, right + self.pitchRate

    @law
    def measure(self, step: float) -> None:
        """Attitude, then odometry."""
        self.motion.measure(self.GetBody())
        super().measure(step)

    @law
    def publish(self, data: PositionData) -> None:
        """Odometry and pitch."""
        super().publish(data)
        data.rot[1], data.vel_rot[1] = self.pitch, self.pitchRate

    def run(self, speed: float, turn: float) -> None:
        """Nothing: `act` drives the wheels by torques."""

    def plan_act(self, plan: Plan) -> None:  # noqa: D102
        if self._velocity is not None:
            super().plan_act(plan)
            return
        with plan.when(self._stands):
            plan.do(self.act)

    @law
    def _stands(self) -> Any:
        """Whether it is to balance; if not, the controller begins anew."""
        stands = self.position.enabled & (self.motion.up[2] >= UPRIGHT)
        for i in range(len(self._balance)):
            self._balance[i] = where(stands, self._balance[i], 0.0)
        return stands

    @law
    def act(self, step: float) -> None:
        """Balance."""
        falling = self._velocity is not None and self._falls(step)
        if not usually(self.position.enabled) or not usually(self.motion.up[2] >= UPRIGHT):
            self._balance[:] = (0.0, 0.0, 0.0)
            return
        if falling:
            self._balance[0] = 0.0
            torque = FLIGHT_PITCH_GAIN * self.pitch + FLIGHT_PITCH_RATE_GAIN * self.pitchRate
            torques = torque / 2.0, torque / 2.0
        else:
            speed, turn = self.position.wanted
            motion = *self.odometry.velocity, self.pitch, self.pitchRate
            kept, torques = _balance(step, speed, turn, motion, _Balance(*self._balance))
            self._balance[:] = kept
        for hinge, torque in zip(self._hinges, torques, strict=True):
            hinge.SetTorque(torque)

    @unrecorded
    def _falls(self, step: float) -> bool:
        """Whether the base gained more than half of what gravity gives it in a step [s]."""
        velocity, gravity = self.GetBody().GetLinearVel(), self.world.engine.gravity
        before, self._velocity = self._velocity or GzVector(), velocity
        gained = sum((v - b) * g for v, b, g in zip(velocity, before, gravity, strict=True))
        return gained > 0.5 * step * sum(g * g for g in gravity)


class _Balance(NamedTuple, Generic[Value]):
    """What the controller keeps: how far the robot is ahead of the commanded travel [m], the error of its turn [rad/s],
    and the integral of that.
    """

    lag: Value
    error: Value
    integral: Value


def _balance(
    step: Value, speed: Value, turn: Value, measured: tuple[Value, ...], kept: _Balance[Value]
) -> tuple[_Balance[Value], tuple[Value, Value]]:
    """What is kept, and the torques of the left and the right wheel [N m].

    Args:
        step: its length [s].
        speed, turn: wanted [m/s], [rad/s].
        measured: speed, turn, pitch and its rate.
        kept: of the step before.
    """
    present, turning, pitch, pitch_rate = measured
    speed, turn = clamp(speed, MAX_SPEED), clamp(turn, MAX_TURN)
    excess = present - speed
    lag = clamp(kept.lag + excess * step, MAX_LAG)
    forward = PLACE_GAIN * lag + SPEED_GAIN * excess + PITCH_GAIN * pitch + PITCH_RATE_GAIN * pitch_rate
    error = turn - turning
    integral = clamp(kept.integral + error * step, 1.0 / TURN_INTEGRAL_GAIN)
    sideways = TURN_GAIN * error + TURN_INTEGRAL_GAIN * integral + TURN_DERIVATIVE_GAIN * (error - kept.error) / step
    forward, sideways = clamp(forward, MAX_TORQUE), clamp(sideways, MAX_TORQUE)
    return _Balance(lag, error, integral), ((forward - sideways) / 2.0, (forward + sideways) / 2.0)
