"""CanonVCC4: Canon's pan-tilt-zoom camera, hanging."""

from __future__ import annotations

import math

from libgz.geometry import GzColor, GzPose, GzVector
from libgz.models.pantilt import PanTiltCamera
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom, CylinderGeom

MASS = 0.375  # of all parts [kg]
GREY, RED = GzColor(0.3, 0.3, 0.3), GzColor(1.0, 0.0, 0.0)


class CanonVCC4(PanTiltCamera):
    """Canon's pan-tilt-zoom camera, hanging.

    It pans 90 degrees to each side, and tilts 30 degrees up and 90 down.
    """

    example = """
        <model:Pioneer2AT>
          <id>robot1</id>
          <model:CanonVCC4>
            <id>camera1</id>
            <xyz>0.1 0 0.33</xyz>
          </model:CanonVCC4>
        </model:Pioneer2AT>
    """

    panLimits = (-0.5 * math.pi, 0.5 * math.pi)
    tiltLimits = (-math.pi / 6.0, 0.5 * math.pi)

    def build(self) -> tuple[Body, Body, Body]:  # noqa: D102
        head, middle, base = Body(self.world, "head"), Body(self.world, "middle"), Body(self.world)
        self.AddBody(head)
        self.AddBody(middle)
        self.AddBody(base, True)
        space = self.modelSpaceId
        self.add_part(
            head, BoxGeom(head, space, 0.113, 0.101, 0.09), GzPose(GzVector(0.0, 0.0, 0.045)), 0.25 * MASS, GREY
        )
        self.add_lens(head, 0.0555, 0.045)
        self.add_part(
            middle, BoxGeom(middle, space, 0.057, 0.105, 0.025), GzPose(GzVector(0.0, 0.0, 0.09)), 0.25 * MASS, RED
        )
        self.add_part(
            base, CylinderGeom(base, space, 0.071, 0.028), GzPose(GzVector(0.0, 0.0, 0.1025)), 0.5 * MASS, GREY
        )
        return base, middle, head
