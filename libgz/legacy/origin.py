"""Origin: where Gazebo 0.4 had a model's origin, and where it is now."""

from __future__ import annotations

from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzVector
from libgz.legacy.model import Model

__all__ = ["to_file", "to_world"]


def to_world(model: Model, pose: GzPose) -> GzPose:
    """A pose of the model's file, relative to the parent body, with the origin that the model has now."""
    return _convert(model, pose, -1.0)


def to_file(model: Model, pose: GzPose) -> GzPose:
    """The inverse of `to_world`."""
    return _convert(model, pose, +1.0)


def _convert(model: Model, pose: GzPose, sign: float) -> GzPose:
    if model.node is None or not model.node.file.is_old:
        return pose
    file = model.node.file
    own = GzPose(GzVector(0.0, 0.0, sign * file.origin_height(model.node)))
    pose = GzCoordPoseAdd(own, pose)
    if isinstance(model.parent, Model) and model.parent.node is not None:
        pose.pos.z -= sign * file.origin_height(model.parent.node)
    return pose
