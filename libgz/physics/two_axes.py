"""Joints that turn about two axes: Hinge2Joint, UniversalJoint."""

from __future__ import annotations

import ctypes

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzVector, VectorLike
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.types import JointType, dParamFMax, dParamFMax2
from libgz.physics.body import Body
from libgz.physics.check import are_parallel, finite, perpendicular, unit_axis, vector_of
from libgz.physics.joint import Joint, JointFunctions
from libgz.physics.lock import exclusive

__all__ = ["Hinge2Joint", "TwoAxisJoint", "UniversalJoint"]


class TwoAxisJoint(Joint):
    """Base of both. ODE ends the process on parallel axes: an axis that was not set is turned away from the other."""

    SAVED = ("_set",)
    motors = (dParamFMax, dParamFMax2)
    _set = (False, False)  # which axes were set

    def _put_axes(self, axis1: VectorLike | None, axis2: VectorLike | None) -> None:
        """Pass unit vectors to ODE; None leaves an axis as it is."""
        raise NotImplementedError

    @exclusive
    def SetAxis1(self, axis: VectorLike | float, *yz: float) -> None:
        """The axis fixed to the first body; global: a vector, or three numbers.

        Raises:
            ParameterError: it is parallel to the second one, which was set before.
        """
        self._require_bodies()
        axis1 = unit_axis(vector_of(axis, yz), "axis")
        clash = are_parallel(axis1, self.GetAxis2())
        if clash and self._set[1]:
            self._refuse()
        self._put_axes(axis1, perpendicular(axis1) if clash else None)
        self._note(True, self._set[1])

    @exclusive
    def SetAxis2(self, axis: VectorLike | float, *yz: float) -> None:
        """The axis fixed to the second body; global: a vector, or three numbers.

        Raises:
            ParameterError: it is parallel to the first one, which was set before.
        """
        self._require_bodies()
        axis2 = unit_axis(vector_of(axis, yz), "axis")
        clash = are_parallel(axis2, self.GetAxis1())
        if clash and self._set[0]:
            self._refuse()
        self._put_axes(perpendicular(axis2) if clash else None, axis2)
        self._note(self._set[0], True)

    @exclusive
    def SetAxes(self, axis1: VectorLike, axis2: VectorLike) -> None:
        """Both at once; global.

        Raises:
            ParameterError: they are parallel.
        """
        self._require_bodies()
        one, two = unit_axis(axis1, "axis"), unit_axis(axis2, "axis")
        if are_parallel(one, two):
            self._refuse()
        self._put_axes(one, two)
        self._note(True, True)

    def _note(self, first: bool, second: bool) -> None:
        self._set = (first, second)
        self.engine.tables.joint_moved(self.row)

    def _refuse(self) -> None:
        raise ParameterError(f"the axes of {self.label} must not be parallel; SetAxes sets both at once")

    def GetAxis1(self) -> GzVector:
        """The axis fixed to the first body; global: a vector, or three numbers."""
        raise NotImplementedError

    def GetAxis2(self) -> GzVector:
        """The axis fixed to the second body; global: a vector, or three numbers."""
        raise NotImplementedError

    def GetAngle1(self) -> float:
        """Angle about axis 1 [rad]."""
        return self._value(0)

    def GetAngle2(self) -> float:
        """Angle about axis 2 [rad]."""
        return self._value(1)


class Hinge2Joint(TwoAxisJoint):
    """Two hinges in series: a steered wheel.

    Attach(chassis, wheel), neither of which may be the world or a dummy; axis 1, for steering, is fixed to the chassis,
    axis 2, for rolling, to the wheel.
    """

    kind, bodies_needed = JointType.HINGE2, 2

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        return JointFunctions(
            lib.dJointCreateHinge2,
            lib.dJointSetHinge2Param,
            lib.dJointGetHinge2Param,
            lib.dJointSetHinge2Anchor,
            lib.dJointGetHinge2Anchor,
        )

    def check_bodies(self, one: Body | None, two: Body | None) -> None:
        """Check what is to be attached: the chassis, first, and the wheel; neither may be the world or a dummy."""
        super().check_bodies(one, two)
        if one is None or two is None or one.dummy or two.dummy:
            raise ParameterError(f"{self.label} joins two bodies; neither may be the world or a dummy")

    def _put_axes(self, axis1: VectorLike | None, axis2: VectorLike | None) -> None:
        addresses = [None if a is None else (ctypes.c_double * 4)(*a) for a in (axis1, axis2)]
        ode().dJointSetHinge2Axes(self.id, *addresses)

    def GetAxis1(self) -> GzVector:
        """The steering axis, global."""
        self._require_bodies()
        return self._get_vector(ode().dJointGetHinge2Axis1)

    def GetAxis2(self) -> GzVector:
        """The rolling axis, global."""
        self._require_bodies()
        return self._get_vector(ode().dJointGetHinge2Axis2)

    def GetAnchor2(self) -> GzVector:
        """The global anchor on the second body [m]; the suspension moves it away from the first."""
        return self._get_vector(ode().dJointGetHinge2Anchor2)

    def GetAngle1Rate(self) -> float:
        """Steering rate [rad/s]."""
        return self._value(2)

    def GetAngle2Rate(self) -> float:
        """Rolling rate [rad/s]."""
        return self._value(3)

    @exclusive
    def SetTorque(self, torque1: float, torque2: float) -> None:
        """Add torques about both axes for one step [N m]."""
        self._require_bodies()
        ode().dJointAddHinge2Torques(self.id, finite(torque1, "torque [N m]"), finite(torque2, "torque [N m]"))


class UniversalJoint(TwoAxisJoint):
    """Two axes of rotation at right angles through the anchor."""

    kind = JointType.UNIVERSAL

    @staticmethod
    def _ode_functions(lib: OdeLibrary) -> JointFunctions:
        return JointFunctions(
            lib.dJointCreateUniversal,
            lib.dJointSetUniversalParam,
            lib.dJointGetUniversalParam,
            lib.dJointSetUniversalAnchor,
            lib.dJointGetUniversalAnchor,
        )

    def _put_axes(self, axis1: VectorLike | None, axis2: VectorLike | None) -> None:
        if axis1 is not None:
            ode().dJointSetUniversalAxis1(self.id, *axis1)
        if axis2 is not None:
            ode().dJointSetUniversalAxis2(self.id, *axis2)

    def GetAxis1(self) -> GzVector:
        """The axis fixed to the first body; global: a vector, or three numbers."""
        return self._get_vector(ode().dJointGetUniversalAxis1)

    def GetAxis2(self) -> GzVector:
        """The axis fixed to the second body; global: a vector, or three numbers."""
        return self._get_vector(ode().dJointGetUniversalAxis2)

    def GetAngleRate1(self) -> float:
        """Rate about axis 1 [rad/s]."""
        return self._value(2)

    def GetAngleRate2(self) -> float:
        """Rate about axis 2 [rad/s]."""
        return self._value(3)

    @exclusive
    def SetTorque(self, torque1: float, torque2: float) -> None:
        """Add torques about both axes for one step [N m]."""
        ode().dJointAddUniversalTorques(self.id, finite(torque1, "torque [N m]"), finite(torque2, "torque [N m]"))
