"""Joints that turn about two axes: Hinge2Joint, UniversalJoint."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING

from libgz.errors import ParameterError
from libgz.ode.lib import ode
from libgz.ode.types import JointType, dParamFMax, dParamFMax2
from libgz.physics.check import are_parallel, finite, perpendicular, unit_axis
from libgz.physics.joint import Joint

if TYPE_CHECKING:
    from libgz.geometry import GzVector, VectorLike
    from libgz.physics.body import Body

__all__ = ["Hinge2Joint", "TwoAxisJoint", "UniversalJoint"]


class TwoAxisJoint(Joint):
    """Base of both. ODE ends the process on parallel axes: an axis that nobody set makes way for the other."""

    _set = (False, False)  # which axes were set

    def _lay(self, axis1: VectorLike | None, axis2: VectorLike | None) -> None:
        """Hand unit vectors to ODE; None leaves an axis where it is."""
        raise NotImplementedError

    def SetAxis1(self, axis: VectorLike) -> None:
        """The axis fixed to the first body; global.

        Raises:
            ParameterError: it is parallel to the second one, which was set before.
        """
        axis1 = unit_axis(axis, "axis")
        clash = are_parallel(axis1, self.GetAxis2())
        if clash and self._set[1]:
            self._refuse()
        self._lay(axis1, perpendicular(axis1) if clash else None)
        self._note(True, self._set[1])

    def SetAxis2(self, axis: VectorLike) -> None:
        """The axis fixed to the second body; global.

        Raises:
            ParameterError: it is parallel to the first one, which was set before.
        """
        axis2 = unit_axis(axis, "axis")
        clash = are_parallel(axis2, self.GetAxis1())
        if clash and self._set[0]:
            self._refuse()
        self._lay(perpendicular(axis2) if clash else None, axis2)
        self._note(self._set[0], True)

    def SetAxes(self, axis1: VectorLike, axis2: VectorLike) -> None:
        """Both at once; global.

        Raises:
            ParameterError: they are parallel.
        """
        one, two = unit_axis(axis1, "axis"), unit_axis(axis2, "axis")
        if are_parallel(one, two):
            self._refuse()
        self._lay(one, two)
        self._note(True, True)

    def _note(self, first: bool, second: bool) -> None:
        self._set = (first, second)
        self.engine.joint_moved(self.row)

    def _refuse(self) -> None:
        raise ParameterError(f"the axes of {self!r} must not be parallel; SetAxes sets both at once")

    def GetAxis1(self) -> GzVector:
        """The axis fixed to the first body; global."""
        return self._get_vector("Axis1")

    def GetAxis2(self) -> GzVector:
        """The axis fixed to the second body; global."""
        return self._get_vector("Axis2")


class Hinge2Joint(TwoAxisJoint):
    """Two hinges in series: a steered wheel. Attach(chassis, wheel); axis 1 on the chassis, axis 2 on the wheel."""

    kind, ode_name, motors = JointType.HINGE2, "Hinge2", (dParamFMax, dParamFMax2)

    def Attach(self, one: Body | None, two: Body | None) -> None:
        """Join the chassis, first, and the wheel, second; neither may be the world or a dummy."""
        if one is None or two is None or one.dummy or two.dummy:
            raise ParameterError(f"{self!r} joins two bodies; neither may be the world or a dummy")
        super().Attach(one, two)

    def SetAnchor(self, anchor: VectorLike) -> None:
        """Put the joint at a global point [m]."""
        self._require_bodies(2)
        super().SetAnchor(anchor)

    def _lay(self, axis1: VectorLike | None, axis2: VectorLike | None) -> None:
        addresses = [None if a is None else (ctypes.c_double * 4)(*a) for a in (axis1, axis2)]
        ode().dJointSetHinge2Axes(self.id, *addresses)

    def SetAxis1(self, axis: VectorLike) -> None:
        """The steering axis, fixed to the first body; global."""
        self._require_bodies(2)
        super().SetAxis1(axis)

    def SetAxis2(self, axis: VectorLike) -> None:
        """The rolling axis, fixed to the second body; global."""
        self._require_bodies(2)
        super().SetAxis2(axis)

    def SetAxes(self, axis1: VectorLike, axis2: VectorLike) -> None:
        """Both at once; global."""
        self._require_bodies(2)
        super().SetAxes(axis1, axis2)

    def GetAxis1(self) -> GzVector:
        """The steering axis, global."""
        self._require_bodies(2)
        return super().GetAxis1()

    def GetAxis2(self) -> GzVector:
        """The rolling axis, global."""
        self._require_bodies(2)
        return super().GetAxis2()

    def GetAnchor2(self) -> GzVector:
        """The global anchor on the second body [m]; the suspension sets it apart from the first."""
        return self._get_vector("Anchor2")

    def GetAngle1(self) -> float:
        """Steering angle [rad]."""
        return self._value(0)

    def GetAngle2(self) -> float:
        """Rolling angle [rad]."""
        return self._value(1)

    def GetAngle1Rate(self) -> float:
        """Steering rate [rad/s]."""
        return self._value(2)

    def GetAngle2Rate(self) -> float:
        """Rolling rate [rad/s]."""
        return self._value(3)

    def SetTorque(self, torque1: float, torque2: float) -> None:
        """Add torques about both axes for one step [N m]."""
        self._require_bodies(2)
        ode().dJointAddHinge2Torques(self.id, finite(torque1, "torque [N m]"), finite(torque2, "torque [N m]"))


class UniversalJoint(TwoAxisJoint):
    """Two axes of rotation at right angles through the anchor."""

    kind, ode_name, motors = JointType.UNIVERSAL, "Universal", (dParamFMax, dParamFMax2)

    def _lay(self, axis1: VectorLike | None, axis2: VectorLike | None) -> None:
        for name, axis in (("Axis1", axis1), ("Axis2", axis2)):
            if axis is not None:
                self._call("Set", name, *axis)

    def GetAngle1(self) -> float:
        """Angle about axis 1 [rad]."""
        return self._value(0)

    def GetAngle2(self) -> float:
        """Angle about axis 2 [rad]."""
        return self._value(1)

    def GetAngleRate1(self) -> float:
        """Rate about axis 1 [rad/s]."""
        return self._value(2)

    def GetAngleRate2(self) -> float:
        """Rate about axis 2 [rad/s]."""
        return self._value(3)

    def SetTorque(self, torque1: float, torque2: float) -> None:
        """Add torques about both axes for one step [N m]."""
        ode().dJointAddUniversalTorques(self.id, finite(torque1, "torque [N m]"), finite(torque2, "torque [N m]"))
