"""Poses: moving the models of a world, putting them back, and keeping their places in the worldfile."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from libgz.errors import WorldFileError
from libgz.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose
from libgz.legacy.origin import to_file

if TYPE_CHECKING:
    from libgz.legacy.model import Model
    from libgz.worldfile.file import WorldFile

__all__ = ["Poses"]

log = logging.getLogger("libgz.simulation")


class Poses:
    """Base of World: places of models."""

    models: list[Model]
    file: WorldFile | None

    def SetModelPose(self, model: Model, pose: GzPose) -> None:
        """Move a model, and all that is attached to it, to a pose relative to its parent body, or global [m].

        All velocities become zero.
        """
        parent = model.parentBody
        target = GzCoordPoseAdd(pose, parent.GetPose()) if parent is not None else pose
        self._move(model, target)
        if parent is not None:
            model.relPose = pose
            model.weld()

    def _move(self, model: Model, target: GzPose) -> None:
        """Move a model to a global pose; its children go rigidly with the bodies they are attached to."""
        places = [
            (child, GzCoordPoseSub(child.GetPose(), child.parentBody.GetPose()))
            for child in model.children
            if child.parentBody is not None
        ]
        model.SetPose(target)
        for child, relative in places:
            if child.parentBody is not None:
                self._move(child, GzCoordPoseAdd(relative, child.parentBody.GetPose()))

    def ResetModelPoses(self) -> None:
        """Put all models back to their initial poses, at rest. The clock and the models' own memory stay."""
        for model in self.models:
            self.SetModelPose(model, model.initPose)

    def Save(self) -> int:
        """Make the present poses of top-level models their initial ones, and write them to the worldfile; 0 or -1."""
        if self.file is None:
            return -1
        for model in self.models:
            if model.parent is not None or model.node is None or model.node.file is not self.file:
                continue
            pose = to_file(model, model.GetPose())
            model.initPose = model.GetPose()
            model.node.SetPosition("xyz", pose.pos, add=True)
            model.node.SetRotation("rpy", pose.rot, add=True)
        try:
            self.file.Save()
        except WorldFileError as error:
            log.error("%s", error)
            return -1
        return 0
