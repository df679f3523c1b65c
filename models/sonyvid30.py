"""SonyVID30: Sony's pan-tilt-zoom camera, standing."""

from __future__ import annotations

import math

from libgz.geometry import GzColor, GzPose, GzVector
from libgz.models.pantilt import PanTiltCamera
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom, CylinderGeom

GREY = GzColor(0.3, 0.3, 0.3)


class SonyVID30(PanTiltCamera):
    """Sony's pan-tilt-zoom camera, standing.

    It pans 54 degrees to each side and tilts 90 degrees up and down.
    """

    example = """
        <model:Pioneer2AT>
          <id>robot1</id>
          <model:SonyVID30>
            <id>camera1</id>
            <xyz>0.1 0 0.311</xyz>
          </model:SonyVID30>
        </model:Pioneer2AT>
    """

    panLimits = (-0.3 * math.pi, 0.3 * math.pi)
    tiltLimits = (-0.5 * math.pi, 0.5 * math.pi)

    def build(self) -> tuple[Body, Body, Body]:  # noqa: D102
        base, middle, head = Body(self.world), Body(self.world, "middle"), Body(self.world, "head")
        self.AddBody(base, True)
        self.AddBody(middle)
        self.AddBody(head)
        space = self.modelSpaceId
        self.add_part(base, CylinderGeom(base, space, 0.071, 0.028), GzPose(), 0.2, GREY)
        self.add_part(middle, BoxGeom(middle, space, 0.057, 0.105, 0.025), GzPose(GzVector(0.0, 0.0, 0.028)), 0.1, GREY)
        self.add_part(head, BoxGeom(head, space, 0.12, 0.12, 0.055), GzPose(GzVector(0.0, 0.0, 0.0655)), 0.1, GREY)
        self.add_lens(head, 0.065, 0.0655)
        return base, middle, head
