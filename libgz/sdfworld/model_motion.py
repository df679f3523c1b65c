"""ModelMotion: how an SDF model moves, with those nested in it and their joints, for one built again in its place."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterator

from libgz.base.geometry import GzCoordPoseAdd, GzCoordPoseSub
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.model import SdfModel
from libgz.simulation.motion import Motion, Placed

__all__ = ["ModelMotion"]

TURN = 2.0 * math.pi


class ModelMotion:
    """The pose of a model, the motion of its links, and how often its joints have turned.

    Args:
        model: may be destroyed then.

    Attributes:
        begun: whether it moves, or is not as it was built.
    """

    def __init__(self, model: SdfModel) -> None:
        links = _links(model)
        self._pose, self._motion = model.GetPose(), Motion(links)
        self._positions = {
            (name, axis): joint.position(axis) for name, joint in _joints(model) for axis in range(len(joint.axes))
        }
        self.begun = self._pose != model.start or self._motion.begun(self._pose)

    def carry(self, model: SdfModel) -> None:
        """Let a model move on like this: what it has as the former one had it."""
        model.world.SetModelPose(model, self._pose)
        self._motion.carry(_links(model))
        for name, joint in _joints(model):
            for axis in range(len(joint.axes)):
                before = self._positions.get((name, axis), math.nan)
                if abs(before) > 0.5 * TURN:
                    joint.count_from(before, axis)


def _links(top: SdfModel) -> dict[Hashable, Placed]:
    """All links with their places in the frame of the model at the top, by names from there on."""
    found: dict[Hashable, Placed] = {}
    for model in top.nested_family():
        frame = GzCoordPoseSub(model.start, top.start)
        for name, body in model.links.items():
            found[_path(top, model), name] = Placed(body, GzCoordPoseAdd(model.first_place(body), frame))
    return found


def _joints(top: SdfModel) -> Iterator[tuple[Hashable, SdfJoint]]:
    for model in top.nested_family():
        for name, joint in model.sdf_joints.items():
            yield (_path(top, model), name), joint


def _path(top: SdfModel, model: SdfModel) -> str:
    return model.GetId().removeprefix(top.GetId())
