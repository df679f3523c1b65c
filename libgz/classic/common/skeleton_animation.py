"""SkeletonAnimation: how the bones of an actor move."""

from __future__ import annotations

from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.names import takes_names
from libgz.physics.skeletons import SkeletonAnimation as Motion

__all__ = ["SkeletonAnimation"]


@takes_names
class SkeletonAnimation:
    """An animation of a skeleton.

    Args:
        name: of it.
        bones: names of the bones, the root first.
        motion: their poses by time.
    """

    def __init__(self, name: str, bones: tuple[str, ...], motion: Motion) -> None:
        self._name, self._bones, self._motion = name, bones, motion

    def GetName(self) -> str:
        """The name."""
        return self._name

    def GetLength(self) -> float:
        """The duration [s]."""
        return self._motion.length

    def GetNodeCount(self) -> int:
        """The number of bones."""
        return len(self._bones)

    def HasNode(self, node: str) -> bool:
        """Whether there is a bone of this name."""
        return node in self._bones

    def GetPoseAt(self, time: float, loop: bool = True) -> dict[str, Pose3d]:
        """The poses of all bones in the frames of their parents, by name, at a time [s]."""
        positions, turns = self._motion.at(time, loop)
        rows = zip(self._bones, positions.tolist(), turns.tolist(), strict=True)
        return {name: Pose3d(Vector3d(*place), Quaterniond(*turn)) for name, place, turn in rows}

    def GetPoseAtX(self, x: float, node: str = "", loop: bool = True) -> dict[str, Pose3d]:
        """The same where the root has come as far along x [m]; `node` is the root in any case."""
        positions, turns = self._motion.at_x(x)
        rows = zip(self._bones, positions.tolist(), turns.tolist(), strict=True)
        return {name: Pose3d(Vector3d(*place), Quaterniond(*turn)) for name, place, turn in rows}

    Name, Length, NodeCount, PoseAt, PoseAtX = GetName, GetLength, GetNodeCount, GetPoseAt, GetPoseAtX
