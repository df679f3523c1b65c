"""Motion: where the bodies of an entity are and how they move, for one that is built again in its place."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import NamedTuple

from libgz.base.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzVector
from libgz.physics.body import Body, point_velocity

__all__ = ["Motion", "Placed"]

SAME = 1e-9  # [m], and of a quaternion's numbers: what differs by less is one


class Placed(NamedTuple):
    """A body, and its pose in the frame of its entity when that was built [m]."""

    body: Body
    place: GzPose


class _Moving(NamedTuple):
    """A body at one moment: pose [m]; centre of mass [m], its velocity [m/s] and angular velocity [rad/s]."""

    place: GzPose
    pose: GzPose
    motion: tuple[float, ...]


class Motion:
    """The motion of the bodies of an entity, which may be destroyed then.

    Args:
        bodies: by names, by which those of another entity are found.
    """

    def __init__(self, bodies: Mapping[Hashable, Placed]) -> None:
        self._bodies = {
            name: _Moving(place, body.GetPose(), (*body.GetCoMPose().pos, *body.GetLinearVel(), *body.GetAngularRate()))
            for name, (body, place) in bodies.items()
        }

    def begun(self, frame: GzPose) -> bool:
        """Whether a body moves, or is not at its place in a frame [m]."""
        for place, pose, motion in self._bodies.values():
            built = GzCoordPoseAdd(place, frame)
            if any(motion[3:]) or not _near((*pose.pos, *pose.rot), (*built.pos, *built.rot)):
                return True
        return False

    def carry(self, bodies: Mapping[Hashable, Placed]) -> None:
        """Give bodies of the same names the poses and velocities that these had.

        A body whose place in its entity is another one now is moved by the difference. Bodies without a counterpart
        stay where they are.
        """
        for name, (body, place) in bodies.items():
            if name in self._bodies:
                _carry(body, place, self._bodies[name])


def _carry(body: Body, place: GzPose, old: _Moving) -> None:
    same = _near((*place.pos, *place.rot), (*old.place.pos, *old.place.rot))
    body.SetPose(old.pose if same else GzCoordPoseAdd(GzCoordPoseSub(place, old.place), old.pose))
    if body.dummy:
        return
    centre, speed = body.GetCoMPose().pos, GzVector(*old.motion[3:6])
    body.SetLinearVel(speed if _near((*centre,), old.motion[:3]) else point_velocity(old.motion, centre))
    body.SetAngularVel(old.motion[6:])


def _near(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return all(abs(a - b) < SAME for a, b in zip(one, other, strict=True))
