"""Joints between bodies.

Anchors and axes are global at the moment of the call, and the bodies must be in their places by then: angles and
positions are zero where they stood when anchor or axis was set.

All models attach the moving part first, the base second: a positive velocity about +y then rolls a wheel forward.
Only Hinge2Joint (`two_axes`) wants the chassis first, for its first axis belongs to the first body.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.errors import ClosedError, ParameterError
from libgz.geometry import GzVector
from libgz.ode.lib import ode
from libgz.ode.types import (
    JointFeedback,
    JointType,
    dParamFMax,
    dParamHiStop,
    dParamLoStop,
)
from libgz.physics.check import LARGEST, finite, finite_tuple, joint_value, known_parameter, unit_axis
from libgz.physics.engine import Engine, HasEngine

if TYPE_CHECKING:
    from libgz.geometry import VectorLike
    from libgz.physics.body import Body

__all__ = [
    "BallJoint",
    "FixedJoint",
    "HingeJoint",
    "Joint",
    "JointGroup",
    "SliderJoint",
]


class JointGroup:
    """Kept for old plugins that pass one; joints are freed with their bodies."""

    def __init__(self) -> None:
        self._joints: list[Joint] = []

    def GetGroupId(self) -> JointGroup:
        """The group itself."""
        return self

    def add(self, joint: Joint) -> None:
        """Take a joint into the group."""
        self._joints.append(joint)

    def Empty(self) -> None:
        """Destroy all joints of the group."""
        for joint in self._joints:
            joint.close()
        self._joints.clear()


class Joint:
    """Base of all joints.

    Args:
        world: the World, or an Engine.
        group: an old JointGroup, or None.
        name: for look-up.
    """

    view: Any = None  # the object by which a layer above shows this joint; set by that layer
    kind: ClassVar[JointType]
    ode_name: ClassVar[str]  # as in dJointCreateHinge, dJointSetHingeParam
    motors: ClassVar[tuple[int, ...]] = ()  # parameters that switch its motors off when 0

    def __init__(self, world: HasEngine, group: JointGroup | None = None, *, name: str | None = None) -> None:
        self.engine: Engine = world.engine
        self.name = name
        self.bodies: tuple[Body | None, Body | None] = (None, None)
        self._feedback: JointFeedback | None = None
        self._id: int | None = getattr(ode(), f"dJointCreate{self.ode_name}")(self.engine.world, None)
        self._set_param = getattr(ode(), f"dJointSet{self.ode_name}Param")  # models set some in every step
        self.row = self.engine.add_joint(self, self.kind)
        if group is not None:
            group.add(self)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name or 'unnamed'}>"

    @property
    def closed(self) -> bool:
        """Whether it was destroyed, as joints are with a body that they hold."""
        return self._id is None

    @property
    def id(self) -> int:
        """The ODE handle.

        Raises:
            ClosedError: the joint was closed.
        """
        if self._id is None:
            raise ClosedError(f"{type(self).__name__} {self.name or 'unnamed'!r} was closed")
        return self._id

    def close(self) -> None:
        """Destroy the joint."""
        if self._id is None:
            return
        self._forget_bodies()
        self.engine.remove_joint(self.row)
        ode().dJointDestroy(self._id)
        self._id = None

    def _require_bodies(self, count: int = 1) -> None:
        """Refuse what would make ODE end the process.

        Raises:
            ParameterError: fewer than `count` bodies, dummies not counted, are attached.
        """
        if sum(body is not None and not body.dummy for body in self.bodies) < count:
            bodies = "two bodies" if count == 2 else "a body"
            raise ParameterError(f"{self!r} must be attached to {bodies} first; dummies and the world do not count")

    def _forget_bodies(self) -> None:
        for body in self.bodies:
            if body is not None:
                body.joints.pop(self, None)
                if body.auto_disable:
                    body.Enable(True)
        self.bodies = (None, None)

    def _call(self, verb: str, what: str, *arguments: object) -> float:
        """Call dJoint<verb><kind><what>."""
        return getattr(ode(), f"dJoint{verb}{self.ode_name}{what}")(self.id, *arguments)  # type: ignore[no-any-return]

    def _set_vector(self, what: str, values: VectorLike) -> None:
        numbers = finite_tuple(values, 3, what, LARGEST) if "Anchor" in what else unit_axis(values, what)
        self._call("Set", what, *numbers)
        self.engine.joint_moved(self.row)

    def _get_vector(self, what: str) -> GzVector:
        out = (ctypes.c_double * 4)()
        self._call("Get", what, out)
        return GzVector(*out[:3])

    def _value(self, column: int) -> float:
        """One of angle 1, angle 2, rate 1, rate 2 from the table; 0 for a joint without bodies."""
        engine, row = self.engine, self.row
        if self._id is None:  # its row is soon another one's
            raise ClosedError(f"{type(self).__name__} {self.name or 'unnamed'!r} was closed")
        if not engine.joint_fresh[row]:
            engine.read_joint(row)
        return engine.joint_values[4 * row + column]

    # Bodies ------------------------------------------------------------------------------------------------------

    def Attach(self, one: Body | None, two: Body | None) -> None:
        """Join two bodies; None, or a dummy body, stands for the world. Two of these: nothing happens."""
        ids = tuple(0 if body is None else body.id for body in (one, two))
        if not any(ids):
            return
        if ids[0] == ids[1]:
            raise ParameterError(f"{self!r} cannot join {one!r} with itself")
        self._forget_bodies()
        ode().dJointAttach(self.id, *ids)
        self.bodies = (one, two)
        for body in (one, two):
            if body is not None:
                body.joints[self] = None
        self.engine.join(self.row, self.id)

    def provide_feedback(self, on: bool) -> None:
        """Whether `feedback` is filled in each step; off at first, and then it costs nothing."""
        if on == (self._feedback is not None):
            return
        self._feedback = JointFeedback() if on else None
        ode().dJointSetFeedback(self.id, None if self._feedback is None else ctypes.addressof(self._feedback))

    @property
    def feedback(self) -> tuple[GzVector, GzVector, GzVector, GzVector]:
        """(force 1, torque 1, force 2, torque 2) that the joint put on its first and second body in the last step.

        Forces [N]; torques about the bodies' centres of mass [N m]; global. Zero for the world, for a body that slept,
        and unless `provide_feedback` is on. What motors and stops do is in it, what `add torque` calls do is not.
        """
        told = self._feedback
        if told is None:
            return GzVector(), GzVector(), GzVector(), GzVector()
        first, second = (GzVector(*told.f1[:3]), GzVector(*told.t1[:3])), (GzVector(), GzVector())
        one, two = (body is not None and not body.dummy for body in self.bodies)
        if one and two:
            return *first, GzVector(*told.f2[:3]), GzVector(*told.t2[:3])
        # ODE's first body is never missing.
        return (*first, *second) if one else (*second, *first)

    def Detach(self) -> None:
        """Let both bodies go."""
        self._forget_bodies()
        self.engine.join(self.row, 0)
        ode().dJointAttach(self.id, None, None)

    def GetJointBody(self, index: int) -> Body | None:
        """The first (0) or second (1) body; None for the world."""
        return self.bodies[index]

    @staticmethod
    def AreConnected(one: Body, two: Body) -> bool:
        """Whether a joint holds these two bodies together."""
        return bool(one.id and two.id and ode().dAreConnected(one.id, two.id))

    def GetType(self) -> int:
        """ODE's number of the joint's kind."""
        return int(self.kind)

    def set_spring(self, stiffness: float, damping: float, reference: float = 0.0) -> None:
        """A spring and a damper that push in every step: stiffness (reference - position) - damping rate.

        Hinges and sliders only; [N m/rad, N m s/rad, rad] or [N/m, N s/m, m].

        Raises:
            ParameterError: it is another kind of joint, or a number is not finite.
        """
        if self.kind not in (JointType.HINGE, JointType.SLIDER):
            raise ParameterError(f"{self!r} has no spring; hinges and sliders have")
        self.engine.set_spring(self.row, finite_tuple((stiffness, damping, reference), 3, "spring"))

    # Parameters --------------------------------------------------------------------------------------------------

    def SetAnchor(self, anchor: VectorLike) -> None:
        """Put the joint at a global point [m]."""
        self._set_vector("Anchor", anchor)

    def GetAnchor(self) -> GzVector:
        """The global anchor on the first body [m]."""
        return self._get_vector("Anchor")

    def SetParam(self, parameter: int, value: float) -> None:
        """Set a parameter such as dParamVel [rad/s or m/s], dParamFMax [N m or N], dParamLoStop, dParamHiStop.

        Raises:
            ParameterError: the number names no parameter, or the value is NaN or beyond what it may be: only stops and
                dParamFMax may be infinite, and CFM, ERP and bounce must not be negative.
        """
        number = joint_value(parameter, value)
        self._set_param(self.id, int(parameter), number)

    def GetParam(self, parameter: int) -> float:
        """The value of a parameter."""
        return float(self._call("Get", "Param", known_parameter(parameter)))

    def motors_off(self) -> None:
        """Let the joint's motors go slack."""
        with contextlib.suppress(ClosedError):
            for parameter in self.motors:
                self.SetParam(parameter, 0.0)


class HingeJoint(Joint):
    """One axis of rotation."""

    kind, ode_name, motors = JointType.HINGE, "Hinge", (dParamFMax,)
    _stops: tuple[float, float] = (-math.inf, math.inf)  # as wanted
    _stopped = False  # whether ODE ever had stops to look at

    def SetParam(self, parameter: int, value: float) -> None:
        """As that of all joints.

        ODE looks at a hinge's stops only where they can be met, and else goes on with what it last found, writing into
        memory that is not its own. So a hinge that had stops once keeps one that is never met.
        """
        super().SetParam(parameter, value)
        if parameter not in (dParamLoStop, dParamHiStop):
            return
        low, high = self._stops
        low, high = self._stops = (float(value), high) if parameter == dParamLoStop else (low, float(value))
        met = (low >= -math.pi or high <= math.pi) and low <= high
        if met or self._stopped:
            self._stopped = True
            super().SetParam(dParamLoStop, low if met else -math.pi)
            super().SetParam(dParamHiStop, high if met else math.inf)

    def GetParam(self, parameter: int) -> float:
        """As that of all joints."""
        if parameter in (dParamLoStop, dParamHiStop):
            return self._stops[parameter == dParamHiStop]
        return super().GetParam(parameter)

    def SetAxis(self, axis: VectorLike) -> None:
        """The axis, global."""
        self._set_vector("Axis", axis)

    def GetAxis(self) -> GzVector:
        """The axis, global."""
        return self._get_vector("Axis")

    def GetAngle(self) -> float:
        """Angle [rad]."""
        return self._value(0)

    def GetAngleRate(self) -> float:
        """Angular velocity [rad/s]."""
        return self._value(2)

    def SetTorque(self, torque: float) -> None:
        """Add a torque about the axis for one step [N m]."""
        ode().dJointAddHingeTorque(self.id, finite(torque, "torque [N m]"))


class SliderJoint(Joint):
    """One axis of translation. It has no anchor."""

    kind, ode_name, motors = JointType.SLIDER, "Slider", (dParamFMax,)

    def SetAnchor(self, anchor: VectorLike) -> None:
        """Without effect: a slider has no anchor."""

    def GetAnchor(self) -> GzVector:
        """Zero: a slider has no anchor."""
        return GzVector()

    def SetAxis(self, x: float, y: float, z: float) -> None:
        """The axis, global."""
        self._require_bodies()
        self._set_vector("Axis", (x, y, z))

    def GetAxis(self) -> GzVector:
        """The axis, global."""
        return self._get_vector("Axis")

    def GetPosition(self) -> float:
        """Position along the axis [m]."""
        return self._value(0)

    def GetPositionRate(self) -> float:
        """Velocity along the axis [m/s]: that of one body less that of the other, which is not zero where both turn."""
        return self._value(2)

    def SetSliderForce(self, force: float) -> None:
        """Add a force along the axis for one step [N]."""
        self._require_bodies()
        ode().dJointAddSliderForce(self.id, finite(force, "force [N]"))


class BallJoint(Joint):
    """Three axes of rotation about the anchor."""

    kind, ode_name = JointType.BALL, "Ball"


class FixedJoint(Joint):
    """No freedom at all: the pose of one body in the other at the time of `SetFixed` is kept."""

    kind, ode_name = JointType.FIXED, "Fixed"

    def SetAnchor(self, anchor: VectorLike) -> None:
        """Without effect: a fixed joint has no anchor."""

    def GetAnchor(self) -> GzVector:
        """Zero: a fixed joint has no anchor."""
        return GzVector()

    def SetFixed(self) -> None:
        """Keep the bodies as they stand now."""
        ode().dJointSetFixed(self.id)
