"""MonoCam: a small fixed camera."""

from __future__ import annotations

import math

from libgz.geometry import GzColor, GzPose, GzQuaternFromAxis, GzVector
from libgz.legacy.model import Model
from libgz.models.camera import CameraServer, RobotCameraAttributes, add_frustum, check_optics
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom, CylinderGeom
from libgz.worldfile.attributes import read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


class MonoCam(Model):
    """A small fixed camera in a box of 5 cm.

    It looks along its x axis; the origin is the centre of its bottom.
    """

    attributes = RobotCameraAttributes
    interfaces = ("camera",)

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(RobotCameraAttributes, node)
        check_optics(node, self.values)
        body = Body(self.world)
        self.AddBody(body, True)
        self.box = BoxGeom(body, self.modelSpaceId, 0.05, 0.05, 0.05)
        self.box.SetRelativePosition((0.0, 0.0, 0.025))
        self.box.SetMass(0.1)
        self.box.SetColor(GzColor(0.3, 0.3, 0.3))
        lens = CylinderGeom(body, self.modelSpaceId, 0.024, 0.01)
        lens.SetRelativePose(GzPose(GzVector(0.03, 0.0, 0.025), GzQuaternFromAxis(0.0, 1.0, 0.0, math.pi / 2.0)))
        lens.SetMass(0.0)
        lens.SetColor(GzColor(1.0, 1.0, 1.0))

        add_frustum(self, body, self.values, self.box.GetRelativePose())
        self.camera = CameraServer(self, self.values)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.camera.init()

    def Update(self, step: float) -> None:  # noqa: D102
        self.camera.update(self.box.GetPose(), self.values.hfov)

    def Fini(self) -> None:  # noqa: D102
        self.camera.fini()
