"""Mimic: a joint that follows another one."""

from __future__ import annotations

import math
from collections.abc import Mapping

from libgz.errors import NotFoundError, ParameterError, nearest
from libgz.sdf.element import Element
from libgz.sdfworld.joint import SdfJoint

__all__ = ["Mimic"]

KINDS = ("revolute", "prismatic")  # that have a motor of their own, and may follow
SHARE = 0.2  # of a deviation that is corrected in a step, as ODE's constraints do by default


class Mimic:
    """A joint's motor, which keeps it at ``multiplier * (position of the leader - reference) + offset``.

    It applies what it needs, up to the joint's limit of effort; the leader does not feel it.

    Args:
        element: the `<mimic>` of an axis.
        follower: the name of the joint that it stands in.
        joints: those of the model, by name; read in each step, because joints may be removed and made again.

    Raises:
        NotFoundError: there is no joint to follow.
        ParameterError: one of them has no axis that can follow or be followed, or a number is not finite.
    """

    def __init__(self, element: Element, follower: str, joints: Mapping[str, SdfJoint]) -> None:
        self.follower, self.leader = follower, element.Get(str, "joint")
        self._joints = joints
        self._index = int(element.Get(str, "axis") == "axis2")
        keys = ("multiplier", "offset", "reference")
        self.multiplier, self.offset, self.reference = (element.Get(float, key) for key in keys)
        if not all(map(math.isfinite, (self.multiplier, self.offset, self.reference))):
            raise ParameterError(f"joint {follower!r}: multiplier, offset and reference of <mimic> must be finite")
        if self.leader not in joints or self.leader == follower:
            known = nearest(self.leader, joints)
            raise NotFoundError(f"joint {follower!r}: <mimic> names joint {self.leader!r}; it must be another{known}")
        if joints[follower].kind not in KINDS:
            allowed = " and ".join(KINDS)
            raise ParameterError(f"joint {follower!r} is {joints[follower].kind}; {allowed} joints can follow others")
        if self._index >= len(joints[self.leader].axes):
            raise ParameterError(f"joint {follower!r}: joint {self.leader!r} has no such axis to follow")

    def target(self) -> float:
        """Where the follower should be now [rad or m]."""
        return self.multiplier * (self._joints[self.leader].position(self._index) - self.reference) + self.offset

    def update(self) -> None:
        """Set the motor's velocity and limit of effort for the coming step."""
        joint, leader = self._joints.get(self.follower), self._joints.get(self.leader)
        if joint is None or leader is None or not (joint.attached and leader.attached):
            return
        axis = joint.axes[0]
        target = max(axis.lower, min(axis.upper, self.target()))
        rate = self.multiplier * leader.velocity(self._index)
        rate += SHARE * (target - joint.position()) / joint.engine.step_time
        if axis.velocity > 0.0:
            rate = max(-axis.velocity, min(axis.velocity, rate))
        joint.set_param("vel", rate)
        joint.set_param("fmax", axis.effort if axis.effort > 0.0 else math.inf)
