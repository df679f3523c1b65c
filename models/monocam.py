"""MonoCam: a small camera that is fixed to its parent."""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.base.geometry import GzColor, GzQuaternFromAxis
from libgz.legacy.model import Model
from libgz.models.camera import CameraServer, RobotCameraAttributes, add_frustum, check_optics
from libgz.models.parts import GREY, add_body, fit
from libgz.physics.geoms import BoxGeom, CylinderGeom
from libgz.simulation.plan import Plan
from libgz.worldfile.attributes import read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

WHITE = GzColor(1.0, 1.0, 1.0)


class MonoCam(Model):
    """A small camera in a box of 5 cm.

    It looks along its x axis; the origin is the centre of its bottom.
    """

    STATE: ClassVar[tuple[str, ...]] = ("camera",)

    attributes = RobotCameraAttributes
    interfaces = ("camera",)
    active_while_paused = True  # the image that is due is taken

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(RobotCameraAttributes, node)
        check_optics(node, self.values)
        body = add_body(self)
        self.box = fit(BoxGeom(body, self.modelSpaceId, 0.05, 0.05, 0.05), (0.0, 0.0, 0.025), 0.1, GREY)
        along_x = GzQuaternFromAxis(0.0, 1.0, 0.0, math.pi / 2.0)
        fit(CylinderGeom(body, self.modelSpaceId, 0.024, 0.01), (0.03, 0.0, 0.025), 0.0, WHITE, along_x)
        add_frustum(self, body, self.values, self.box.GetRelativePose())
        self.camera = CameraServer(self, self.values)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.camera.Init()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        self.camera.plan_update(plan, self._look)

    def _look(self) -> None:
        self.camera.take(self.box.GetPose(), self.values.hfov)

    def Fini(self) -> None:  # noqa: D102
        self.camera.Fini()
