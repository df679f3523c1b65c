"""Joints between bodies.

Anchors and axes are global at the moment of the call, and the bodies must be in their places by then: angles and
positions are zero where they were when anchor or axis was set.

All models attach the moving part first, the base second: a positive velocity about +y then rolls a wheel forward.
Only Hinge2Joint (`two_axes`) takes the chassis first, for its first axis belongs to the first body.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
from collections.abc import Callable, Iterable
from typing import Any, ClassVar, NamedTuple

from libgz.base.errors import ClosedError, GazeboError, ParameterError
from libgz.base.geometry import GzVector, VectorLike
from libgz.base.law import constant
from libgz.ode.context import HeldEffort
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.memory import clear_joint
from libgz.ode.types import (
    JointFeedback,
    JointType,
    dParamFMax,
    dParamHiStop,
    dParamLoStop,
)
from libgz.physics.body import Body
from libgz.physics.check import LARGEST, finite, finite_tuple, joint_value, known_parameter, unit_axis, vector_of
from libgz.physics.engine import Engine, HasEngine
from libgz.physics.lock import built, exclusive

__all__ = [
    "AxisJoint",
    "BallJoint",
    "FixedJoint",
    "HingeJoint",
    "Joint",
    "JointFunctions",
    "JointGroup",
    "SliderJoint",
]


class JointFunctions(NamedTuple):
    """ODE's functions for one kind of joint; None for what the kind does not have."""

    create: Callable[..., Any]
    set_param: Callable[..., Any]
    get_param: Callable[..., Any]
    set_anchor: Callable[..., Any] | None = None
    get_anchor: Callable[..., Any] | None = None
    set_axis: Callable[..., Any] | None = None
    get_axis: Callable[..., Any] | None = None


class JointGroup:
    """Kept for old plugins that pass one; joints are freed with their bodies."""

    def __init__(self) -> None:
        self._joints: list[Joint] = []
        self._native: int | None = None

    def GetGroupId(self) -> JointGroup:
        """The group itself."""
        return self

    @property
    def native(self) -> int:
        """ODE's own group, for joints that a plugin makes with functions of ODE."""
        if self._native is None:
            self._native = int(ode().dJointGroupCreate(0))
        return self._native

    def add(self, joint: Joint) -> None:
        """Add a joint to the group."""
        self._joints.append(joint)

    def Empty(self) -> None:
        """Destroy all joints of the group."""
        for joint in self._joints:
            joint.close()
        self._joints.clear()
        if self._native is not None:
            ode().dJointGroupEmpty(self._native)

    def close(self) -> None:
        """Destroy all joints of the group, and ODE's group."""
        self.Empty()
        if self._native is not None:
            ode().dJointGroupDestroy(self._native)
            self._native = None


class Joint:
    """Base of all joints.

    Attributes:
        bodies: the first and second body; None for the world.
        facade: the object by which the API of a layer above presents this joint; set by that layer.

    Args:
        world: the World, or an Engine.
        group: an old JointGroup, or None.
        name: for look-up.
    """

    SAVED: ClassVar[tuple[str, ...]] = ("name",)
    kind: ClassVar[JointType]
    motors: ClassVar[tuple[int, ...]] = ()  # parameters that switch its motors off when 0
    bodies_needed: ClassVar[int] = 0  # which must be attached before anchor, axes and efforts, or ODE ends the process

    @built
    def __init__(self, world: HasEngine, group: JointGroup | None = None, *, name: str | None = None) -> None:
        self.engine: Engine = world.engine
        self.name = name
        self.bodies: tuple[Body | None, Body | None] = (None, None)
        self.facade: Any = None
        self._feedback: JointFeedback | None = None
        self._functions = self._ode_functions(ode())
        self._set_param = self._functions.set_param  # models set some in every step
        self._id: int | None = self._functions.create(self.engine.world, None)
        clear_joint(self._id or 0, self.kind)
        self._table = self.engine.tables.joints
        self.row = self.engine.tables.add_joint(self, self.kind)
        if group is not None:
            group.add(self)
        self.engine.note_made(self)

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        """ODE's functions for this kind of joint."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name or 'unnamed'}{_value_of(self)}>"

    @property
    def label(self) -> str:
        """Its kind and name, for messages."""
        return f"{type(self).__name__} {self.name or 'unnamed'!r}"

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
        self._require_open()
        return self._id or 0

    def _require_open(self) -> None:
        """Check that the joint was not closed: its row may belong to another one.

        Raises:
            ClosedError: it was.
        """
        if self._id is None:
            raise ClosedError(f"{self.label} was closed")

    @exclusive
    def close(self) -> None:
        """Destroy the joint."""
        if self._id is None:
            return
        self._forget_bodies()
        self._table.remove(self.row)
        self.engine.drop_held(self._id)
        ode().dJointDestroy(self._id)
        self._id = None

    def _require_bodies(self) -> None:
        """Check that enough bodies are attached; dummies do not count.

        Raises:
            ParameterError: they are not.
        """
        needed = self.bodies_needed
        if needed and sum(body is not None and not body.dummy for body in self.bodies) < needed:
            bodies = "two bodies" if needed == 2 else "a body"
            raise ParameterError(f"{self.label} must be attached to {bodies} first; dummies and the world do not count")

    def _forget_bodies(self) -> None:
        for body in self.bodies:
            if body is not None:
                body.joints.pop(self, None)
                if body.auto_disable:
                    body.Enable(True)
        self.bodies = (None, None)
        self.engine.attached.pop(self, None)

    @exclusive
    def reset_turns(self) -> None:
        """Count turns of all angles from zero again; see `Engine.count_turns`."""
        self._require_open()
        if any(self.bodies):  # ODE crashes on angles of some joints without bodies
            self.engine.tables.attach_joint(self.row, self.id)

    @exclusive
    def count_turns_from(self, index: int, angle: float) -> None:
        """Count turns of the first (0) or second (1) angle from a value [rad] on."""
        self._require_open()
        self._table.state[self.row, index] = angle
        self.engine.tables.joint_moved(self.row)

    @exclusive
    def _set_axis(self, function: Callable[..., Any] | None, axis: Iterable[float]) -> None:
        if function is not None:
            self._require_bodies()
            function(self.id, *unit_axis(axis, "axis"))
            self.engine.tables.joint_moved(self.row)

    @exclusive
    def _get_vector(self, function: Callable[..., Any] | None) -> GzVector:
        """What an ODE function writes; zero without one."""
        if function is None:
            return GzVector()
        out = (ctypes.c_double * 4)()
        function(self.id, out)
        return GzVector(*out[:3])

    def _value(self, column: int) -> float:
        """One of angle 1, angle 2, rate 1, rate 2 from the table; 0 for a joint without bodies."""
        if self._id is None:
            self._require_open()
        table, row = self._table, self.row
        if not table.fresh[row]:
            self._read()
        return table.values[4 * row + column]

    @exclusive
    def _read(self) -> None:
        """Copy angles and rates from ODE: another thread may be stepping it, or have destroyed the joint."""
        self._require_open()
        if not self._table.fresh[self.row]:
            self._table.read(self.row)

    # Bodies ------------------------------------------------------------------------------------------------------

    @exclusive
    def Attach(self, one: Body | None, two: Body | None) -> None:
        """Join two bodies; None, or a dummy body, stands for the world. Two of these: nothing happens.

        Raises:
            ParameterError: one is no body of the joint's world, or both are the same.
        """
        self.check_bodies(one, two)
        if any(body is not None and body.id for body in (one, two)):
            self._join(one, two)

    def check_bodies(self, one: Body | None, two: Body | None) -> None:
        """Check what is to be attached: ODE ends the process if these are not two bodies of the joint's world.

        Raises:
            ClosedError: the joint was closed.
            ParameterError: one is no body of the joint's world, or both are the same.
        """
        self._require_open()
        for body in (one, two):
            if body is not None and not (isinstance(body, Body) and body.engine is self.engine):
                raise ParameterError(f"{self.label} joins bodies of its world; {body!r} is none of them")
        if one is not None and two is not None and one.id and one.id == two.id:
            raise ParameterError(f"{self.label} cannot join body {one.label!r} with itself")

    def _join(self, one: Body | None, two: Body | None) -> None:
        self._forget_bodies()
        ode().dJointAttach(self.id, *(0 if body is None else body.id for body in (one, two)))
        self.bodies = (one, two)
        self.engine.attached[self] = None
        for body in (one, two):
            if body is not None:
                body.joints[self] = None
        self.engine.tables.attach_joint(self.row, self.id)

    @exclusive
    def provide_feedback(self, on: bool) -> None:
        """Whether `feedback` is filled in each step; off by default, and then it costs nothing."""
        if on == (self._feedback is not None):
            return
        self._feedback = JointFeedback() if on else None
        ode().dJointSetFeedback(self.id, None if self._feedback is None else ctypes.addressof(self._feedback))

    @property
    def feedback(self) -> tuple[GzVector, GzVector, GzVector, GzVector]:
        """(force 1, torque 1, force 2, torque 2) of the joint on its first and second body in the last step.

        Forces [N]; torques about the bodies' centres of mass [N m]; global. Zero for the world, for a body that slept,
        and unless `provide_feedback` is on. Includes motors and stops, but not efforts applied by `SetTorque` or
        `SetSliderForce`.
        """
        result = self._feedback
        if result is None:
            return GzVector(), GzVector(), GzVector(), GzVector()
        first, second = (GzVector(*result.f1[:3]), GzVector(*result.t1[:3])), (GzVector(), GzVector())
        one, two = (body is not None and not body.dummy for body in self.bodies)
        if one and two:
            return *first, GzVector(*result.f2[:3]), GzVector(*result.t2[:3])
        # ODE's first body is never missing.
        return (*first, *second) if one else (*second, *first)

    @exclusive
    def Detach(self) -> None:
        """Detach both bodies."""
        self._require_open()
        self._forget_bodies()
        self.engine.tables.attach_joint(self.row, 0)
        ode().dJointAttach(self.id, None, None)

    def GetJointBody(self, index: int) -> Body | None:
        """The first (0) or second (1) body; None for the world.

        Raises:
            ParameterError: the index is neither.
        """
        if index not in (0, 1):
            raise ParameterError(f"{self.label} has the bodies 0 and 1; there is none of index {index!r}")
        return self.bodies[int(index)]

    @staticmethod
    def AreConnected(one: Body, two: Body) -> bool:
        """Whether a joint connects these two bodies.

        Raises:
            ParameterError: one is no body.
        """
        for body in (one, two):
            if not isinstance(body, Body):
                raise ParameterError(f"joints connect bodies; {body!r} is none")
        with one.engine.lock:
            return bool(one.id and two.id and ode().dAreConnected(one.id, two.id))

    @constant
    def GetType(self) -> int:
        """ODE's number of the joint's kind."""
        return int(self.kind)

    @exclusive
    def set_spring(self, stiffness: float, damping: float, reference: float = 0.0) -> None:
        """Apply stiffness (reference - position) - damping rate in every step: a spring and a damper.

        Hinges and sliders only; [N m/rad, N m s/rad, rad] or [N/m, N s/m, m].

        Raises:
            ParameterError: it is another kind of joint, or a number is not finite.
        """
        self._require_open()
        if self.kind not in (JointType.HINGE, JointType.SLIDER):
            raise ParameterError(f"{self.label} has no spring; hinges and sliders have")
        self.engine.tables.set_spring(self.row, finite_tuple((stiffness, damping, reference), 3, "spring"))

    # Parameters --------------------------------------------------------------------------------------------------

    @exclusive
    def SetAnchor(self, anchor: VectorLike | float, *yz: float) -> None:
        """Place the joint at a global point [m], a vector or three numbers; sliders and fixed joints have none."""
        if self._functions.set_anchor is not None:
            self._require_bodies()
            self._functions.set_anchor(self.id, *finite_tuple(vector_of(anchor, yz), 3, "anchor [m]", LARGEST))
            self.engine.tables.joint_moved(self.row)

    @exclusive
    def GetAnchor(self) -> GzVector:
        """The global anchor on the first body [m]; zero for sliders and fixed joints."""
        return self._get_vector(self._functions.get_anchor)

    @exclusive
    def SetParam(self, parameter: int, value: float) -> None:
        """Set a parameter such as dParamVel [rad/s or m/s], dParamFMax [N m or N], dParamLoStop, dParamHiStop.

        Raises:
            ParameterError: the number names no parameter, or the value is NaN or out of range: only stops and
                dParamFMax may be infinite, and CFM, ERP and bounce must not be negative.
        """
        self._put(parameter, value)

    def _put(self, parameter: int, value: float) -> None:
        number = joint_value(parameter, value)
        self._set_param(self.id, int(parameter), number)

    def write_held(self, held: HeldEffort, effort: float) -> bool:
        """Write an effort [N m or N] on this hinge or slider for `Engine.hold`; whether that can hold it."""
        held.joint, held.type, held.effort = self.id, self.kind, finite(effort, "effort [N m or N]")
        return True

    def was_held(self, effort: float, steps: int) -> None:
        """Note an effort that was held for a number of steps; these joints keep none."""

    @property
    def setter(self) -> int:
        """The address of ODE's function that sets a parameter, for native updates."""
        function: Any = self._set_param
        return ctypes.cast(function, ctypes.c_void_p).value or 0

    @exclusive
    def GetParam(self, parameter: int) -> float:
        """The value of a parameter."""
        return float(self._functions.get_param(self.id, known_parameter(parameter)))

    @exclusive
    def motors_off(self) -> None:
        """Switch the joint's motors off."""
        with contextlib.suppress(ClosedError):
            for parameter in self.motors:
                self.SetParam(parameter, 0.0)


class AxisJoint(Joint):
    """Base of joints that turn about one axis."""

    def SetAxis(self, axis: VectorLike | float, *yz: float) -> None:
        """The axis, global: a vector, or three numbers."""
        self._set_axis(self._functions.set_axis, vector_of(axis, yz))

    def GetAxis(self) -> GzVector:
        """The axis, global."""
        return self._get_vector(self._functions.get_axis)

    def GetAngle(self) -> float:
        """Angle [rad]."""
        return self._value(0)

    def GetAngleRate(self) -> float:
        """Angular velocity [rad/s]."""
        return self._value(2)


class HingeJoint(AxisJoint):
    """One axis of rotation.

    Attributes:
        commanded: the angles between which a controller turns it, where it has no stops [rad]; None if it is not known.
    """

    SAVED = ("_stops", "_stopped")
    kind, motors = JointType.HINGE, (dParamFMax,)
    commanded: tuple[float, float] | None = None
    _stops: tuple[float, float] = (-math.inf, math.inf)  # as set by callers
    _stopped = False  # whether ODE ever had stops

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        return JointFunctions(
            lib.dJointCreateHinge,
            lib.dJointSetHingeParam,
            lib.dJointGetHingeParam,
            lib.dJointSetHingeAnchor,
            lib.dJointGetHingeAnchor,
            lib.dJointSetHingeAxis,
            lib.dJointGetHingeAxis,
        )

    @exclusive
    def SetParam(self, parameter: int, value: float) -> None:
        """As that of all joints.

        ODE evaluates a hinge's stops only if they can be reached, and otherwise continues with its last result, writing
        into memory that is not its own. So a hinge that once had stops keeps one that is never reached.
        """
        self._put(parameter, value)
        if parameter not in (dParamLoStop, dParamHiStop):
            return
        low, high = self._stops
        low, high = self._stops = (float(value), high) if parameter == dParamLoStop else (low, float(value))
        reachable = (low >= -math.pi or high <= math.pi) and low <= high
        if reachable or self._stopped:
            self._stopped = True
            self._put(dParamLoStop, low if reachable else -math.pi)
            self._put(dParamHiStop, high if reachable else math.inf)

    def GetParam(self, parameter: int) -> float:
        """As that of all joints."""
        if parameter in (dParamLoStop, dParamHiStop):
            return self._stops[parameter == dParamHiStop]
        return super().GetParam(parameter)

    @exclusive
    def SetTorque(self, torque: float) -> None:
        """Add a torque about the axis for one step [N m]."""
        ode().dJointAddHingeTorque(self.id, finite(torque, "torque [N m]"))


class SliderJoint(Joint):
    """One axis of translation. It has no anchor."""

    kind, motors, bodies_needed = JointType.SLIDER, (dParamFMax,), 1

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        return JointFunctions(
            lib.dJointCreateSlider,
            lib.dJointSetSliderParam,
            lib.dJointGetSliderParam,
            set_axis=lib.dJointSetSliderAxis,
            get_axis=lib.dJointGetSliderAxis,
        )

    def SetAxis(self, axis: VectorLike | float, *yz: float) -> None:
        """The axis, global: a vector, or three numbers."""
        self._set_axis(self._functions.set_axis, vector_of(axis, yz))

    def GetAxis(self) -> GzVector:
        """The axis, global."""
        return self._get_vector(self._functions.get_axis)

    def GetPosition(self) -> float:
        """Position along the axis [m]."""
        return self._value(0)

    def GetPositionRate(self) -> float:
        """Velocity along the axis [m/s]: that of one body less that of the other, which is not zero if both turn."""
        return self._value(2)

    @exclusive
    def SetSliderForce(self, force: float) -> None:
        """Add a force along the axis for one step [N]."""
        self._require_bodies()
        ode().dJointAddSliderForce(self.id, finite(force, "force [N]"))


class BallJoint(Joint):
    """Three axes of rotation about the anchor."""

    kind = JointType.BALL

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        return JointFunctions(
            lib.dJointCreateBall,
            lib.dJointSetBallParam,
            lib.dJointGetBallParam,
            lib.dJointSetBallAnchor,
            lib.dJointGetBallAnchor,
        )


class FixedJoint(Joint):
    """No freedom at all: the pose of one body in the other at the time of `SetFixed` is kept."""

    kind = JointType.FIXED

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        return JointFunctions(lib.dJointCreateFixed, lib.dJointSetFixedParam, lib.dJointGetFixedParam)

    @exclusive
    def SetFixed(self) -> None:
        """Keep the bodies at their current relative pose."""
        ode().dJointSetFixed(self.id)


def _value_of(joint: Any) -> str:
    """Angle or position of a joint, for `repr`; empty where there is none."""
    for name, unit in (("GetAngle", "rad"), ("GetPosition", "m"), ("GetAngle1", "rad")):
        read = getattr(joint, name, None)
        if read is not None and not joint.closed:
            with contextlib.suppress(GazeboError):
                return f" at {read():.4g} {unit}"
    return ""
