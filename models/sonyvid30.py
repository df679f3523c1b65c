"""SonyVID30: Sony's pan-tilt-zoom camera, mounted upright."""

from __future__ import annotations

import math

from libgz.models.pantilt import PanTiltCamera
from libgz.models.parts import GREY, add_body, fit
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom, CylinderGeom


class SonyVID30(PanTiltCamera):
    """Sony's pan-tilt-zoom camera, mounted upright.

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
        base, middle, head = add_body(self), add_body(self, "middle"), add_body(self, "head")
        space = self.modelSpaceId
        fit(CylinderGeom(base, space, 0.071, 0.028), (0.0, 0.0, 0.0), 0.2, GREY)
        fit(BoxGeom(middle, space, 0.057, 0.105, 0.025), (0.0, 0.0, 0.028), 0.1, GREY)
        fit(BoxGeom(head, space, 0.12, 0.12, 0.055), (0.0, 0.0, 0.0655), 0.1, GREY)
        self.add_lens(head, 0.065, 0.0655)
        return base, middle, head
