"""CanonVCC4: Canon's pan-tilt-zoom camera, mounted upside down."""

from __future__ import annotations

import math

from libgz.models.pantilt import PanTiltCamera
from libgz.models.parts import GREY, RED, add_body, fit
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom, CylinderGeom

MASS = 0.375  # of all parts [kg]


class CanonVCC4(PanTiltCamera):
    """Canon's pan-tilt-zoom camera, mounted upside down.

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
        head, middle, base = add_body(self, "head"), add_body(self, "middle"), add_body(self)
        space = self.modelSpaceId
        fit(BoxGeom(head, space, 0.113, 0.101, 0.09), (0.0, 0.0, 0.045), 0.25 * MASS, GREY)
        self.add_lens(head, 0.0555, 0.045)
        fit(BoxGeom(middle, space, 0.057, 0.105, 0.025), (0.0, 0.0, 0.09), 0.25 * MASS, RED)
        fit(CylinderGeom(base, space, 0.071, 0.028), (0.0, 0.0, 0.1025), 0.5 * MASS, GREY)
        return base, middle, head
