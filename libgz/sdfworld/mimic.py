"""Mimic: a joint that follows another one."""

from __future__ import annotations

import math
from collections.abc import Mapping

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.geometry import GzVectorMag, GzVectorSub
from libgz.base.law import constant, largest, law, least, possible, rarely, unrecorded, where
from libgz.physics.body import Body
from libgz.sdf.element import Element
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.joint_record import RANGES

__all__ = ["Mimic"]

KINDS = ("revolute", "prismatic")  # that have a motor of their own, and may follow
SHARE = 0.2  # of a deviation that is corrected in a step, as ODE's constraints do by default
AT_STOP = 1e-6  # [rad or m]


class Mimic:
    """A joint's motor, which keeps it at ``multiplier * (position of the leader - reference) + offset``.

    It applies what it needs, up to a limit of effort; the leader does not feel it.

    Args:
        leader, follower: names of joints.
        joints: those of the model, by name; read in each step, because joints may be removed and made again.
        multiplier, offset, reference: offset and reference in [rad or m].
        axis: of the leader.
        effort: limit [N m or N]; None: that of the follower's axis.
        tolerance: deviation that is not corrected [rad or m].

    Raises:
        NotFoundError: there is no joint to follow.
        ParameterError: one of them has no axis that can follow or be followed, or a number is not finite.
    """

    def __init__(
        self,
        leader: str,
        follower: str,
        joints: Mapping[str, SdfJoint],
        *,
        multiplier: float = 1.0,
        offset: float = 0.0,
        reference: float = 0.0,
        axis: int = 0,
        effort: float | None = None,
        tolerance: float = 0.0,
    ) -> None:
        self.follower, self.leader = follower, leader
        self._joints, self._index = joints, axis
        self.multiplier, self.offset, self.reference = multiplier, offset, reference
        self.effort, self.tolerance = effort, tolerance
        if not all(map(math.isfinite, (multiplier, offset, reference))):
            raise ParameterError(f"joint {follower!r}: multiplier, offset and reference of <mimic> must be finite")
        if leader not in joints or leader == follower:
            known = nearest(leader, joints)
            raise NotFoundError(f"joint {follower!r}: <mimic> names joint {leader!r}; it must be another{known}")
        if joints[follower].kind not in KINDS:
            allowed = " and ".join(KINDS)
            raise ParameterError(f"joint {follower!r} is {joints[follower].kind}; {allowed} joints can follow others")
        if axis >= len(joints[leader].axes):
            raise ParameterError(f"joint {follower!r}: joint {leader!r} has no such axis to follow")

    @classmethod
    def from_element(cls, element: Element, follower: str, joints: Mapping[str, SdfJoint]) -> Mimic:
        """That of a `<mimic>`, for the joint that it stands in."""
        numbers = {key: element.Get(float, key) for key in ("multiplier", "offset", "reference")}
        axis = int(element.Get(str, "axis") == "axis2")
        return cls(element.Get(str, "joint"), follower, joints, axis=axis, **numbers)

    @constant
    def _pair(self) -> tuple[SdfJoint, SdfJoint] | None:
        """Follower and leader, as long as both hold links together."""
        joint, leader = self._joints.get(self.follower), self._joints.get(self.leader)
        if joint is None or leader is None or not (joint.attached and leader.attached):
            return None
        return joint, leader

    @law
    def update(self, step: float) -> None:
        """Set the motor's velocity and limit of effort for the coming step of a length [s]."""
        pair = self._pair()
        if pair is None or not possible(step > 0.0):
            return
        joint, leader = pair
        axis, place = joint.axes[0], joint.position()
        target = self.multiplier * (leader.position(self._index) - self.reference) + self.offset
        deviation = largest(axis.lower, least(axis.upper, target)) - place
        rate = self.multiplier * leader.velocity(self._index)
        rate = where(abs(deviation) >= self.tolerance, rate + SHARE * deviation / step, rate)
        rate = where(axis.velocity > 0.0, largest(-axis.velocity, least(axis.velocity, rate)), rate)
        given = axis.effort if self.effort is None else self.effort
        effort = least(where(given <= 0.0, math.inf, given), RANGES["fmax"][1])
        low, high = place <= axis.lower + AT_STOP, place >= axis.upper - AT_STOP
        if rarely(low | high | (joint.record.parameter("fmax", 0) != effort)):
            self._limit_effort(joint, rate, effort, step)
        joint.run_motor(rate)

    @unrecorded
    def _limit_effort(self, joint: SdfJoint, rate: float, effort: float, step: float) -> None:
        """Set the motor's limit of effort."""
        axis, place = joint.axes[0], joint.position()
        low, high = place <= axis.lower + AT_STOP, place >= axis.upper - AT_STOP
        if low or high:
            # At a stop ODE applies the whole effort of a motor as a torque, which hurls light links away.
            leaves = (low and rate > 0.0) or (high and rate < 0.0)
            effort = min(effort, _inertia(joint) * abs(rate) / step) if leaves else 0.0
        joint.set_param("fmax", effort)


def _inertia(joint: SdfJoint) -> float:
    """What a follower's motor has to accelerate [kg or kg m^2], at most: the lighter one of its links."""
    links = [link for link in (joint.child, joint.parent) if link is not None and link.mass > 0.0]
    if joint.kind == "prismatic":
        return min((link.mass for link in links), default=0.0)
    return min((_moment(link, joint) for link in links), default=0.0)


def _moment(link: Body, joint: SdfJoint) -> float:
    mass = link.GetMass()
    arm = GzVectorMag(GzVectorSub(link.GetCoMPose().pos, joint.anchor()))
    return float((mass.I[0] + mass.I[5] + mass.I[10]) / 2.0 + mass.mass * arm * arm)
