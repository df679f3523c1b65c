"""What the Python form of the step does with bodies and joints beside ODE's solver, as step.c does."""

from __future__ import annotations

import ctypes
import math
from ctypes import c_double
from typing import Any

from libgz.ode.lib import OdeLibrary
from libgz.ode.tables import BodyTable, JointTable, unwound
from libgz.ode.types import JointType

__all__ = ["MotionLimits", "apply_spring", "finish_motion", "record_motion"]

# Bodies beyond these have diverged: [m/s], [rad/s]; [N], [N m], before a step; [m/s], [rad/s], after it.
MAX_SPEED, MAX_EFFORT, DIVERGED_SPEED = 1e7, 1e12, 2e9


class MotionLimits:
    """Finds diverged bodies. It reads ODE's memory in place: a call for each number would take as long as the step."""

    def __init__(self, ode_: OdeLibrary) -> None:
        self._ode = ode_
        self._vectors: dict[int, tuple[tuple[Any, float, float], ...]] = {}  # of a body; addresses are used again

    def _find(self, body: int) -> tuple[tuple[Any, float, float], ...]:
        """Vectors of a body, each with the largest numbers before and after a step; the position comes first."""
        ode_ = self._ode
        self._vectors[body] = tuple(
            ((c_double * 3).from_address(ctypes.addressof(get(body).contents)), before, after)
            for get, before, after in (
                (ode_.dBodyGetPosition, math.inf, math.inf),
                (ode_.dBodyGetLinearVel, MAX_SPEED, DIVERGED_SPEED),
                (ode_.dBodyGetAngularVel, MAX_SPEED, DIVERGED_SPEED),
                (ode_.dBodyGetForce, MAX_EFFORT, math.inf),
                (ode_.dBodyGetTorque, MAX_EFFORT, math.inf),
            )
        )
        return self._vectors[body]

    def reset_diverged(self, body: int) -> bool:
        """Reset velocities and efforts of a body that has diverged, and return whether it had."""
        for (x, y, z), most, _ in self._vectors.get(body) or self._find(body):
            if not (-most <= x <= most and -most <= y <= most and -most <= z <= most):
                break
        else:
            return False
        ode_ = self._ode
        for put in (ode_.dBodySetLinearVel, ode_.dBodySetAngularVel, ode_.dBodySetForce, ode_.dBodySetTorque):
            put(body, 0.0, 0.0, 0.0)
        return True

    def has_diverged(self, body: int, max_distance: float) -> bool:
        """Whether a body has diverged in a step; read_bodies in step.c."""
        for (x, y, z), _, most in (self._vectors.get(body) or self._find(body))[:3]:
            limit = min(most, max_distance)
            if not (-limit <= x <= limit and -limit <= y <= limit and -limit <= z <= limit):
                return True
            max_distance = math.inf  # which limits the position only
        return False


def record_motion(ode_: OdeLibrary, table: BodyTable, row: int) -> None:
    """Record velocity and applied efforts of a body as a step begins; record_motion in step.c."""
    body, motion = int(table.ids[row]), table.motion[row]
    motion[0:3] = ode_.dBodyGetLinearVel(body).contents[:3]
    motion[3:6] = ode_.dBodyGetAngularVel(body).contents[:3]
    motion[6:9] = ode_.dBodyGetForce(body).contents[:3]
    motion[9:12] = ode_.dBodyGetTorque(body).contents[:3]
    motion[12] = ode_.dBodyGetGravityMode(body) and not ode_.dBodyIsKinematic(body)


def finish_motion(ode_: OdeLibrary, table: BodyTable, row: int, step: float) -> None:
    """Make accelerations of the velocities that `record_motion` recorded; finish_motion in step.c."""
    body, motion = int(table.ids[row]), table.motion[row]
    after = (*ode_.dBodyGetLinearVel(body).contents[:3], *ode_.dBodyGetAngularVel(body).contents[:3])
    motion[0:6] = [(v - before) / step for v, before in zip(after, motion[0:6].tolist(), strict=True)]


def apply_spring(ode_: OdeLibrary, table: JointTable, row: int, *, unwind: bool) -> None:
    """Apply the spring and damper of a hinge or slider for the coming step; apply_springs in step.c."""
    joint, kind = int(table.ids[row]), int(table.types[row])
    stiffness, damping, reference = table.springs[row].tolist()
    if kind == JointType.HINGE:
        at = ode_.dJointGetHingeAngle(joint)
        if unwind:
            at = unwound(float(table.state[row, 0]), at)
        rate = ode_.dJointGetHingeAngleRate(joint)
        ode_.dJointAddHingeTorque(joint, stiffness * (reference - at) - damping * rate)
    elif kind == JointType.SLIDER:
        at, rate = ode_.dJointGetSliderPosition(joint), ode_.dJointGetSliderPositionRate(joint)
        ode_.dJointAddSliderForce(joint, stiffness * (reference - at) - damping * rate)
