"""AvatarHeli: the University of Southern California's helicopter AVATAR.

The original source is lost, and its commands are unknown: here it is a rigid body that falls and lands on its skids.
Dimensions were chosen for libgz to match the mesh of its original world.
"""

from __future__ import annotations

from libgz.base.geometry import GzColor
from libgz.legacy.model import Model
from libgz.models.parts import DARK, GREY, add_body, fit
from libgz.models.skin import SkinAttributes, add_skin
from libgz.physics.geoms import BoxGeom, CylinderGeom
from libgz.worldfile.attributes import read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

ORANGE = GzColor(0.9, 0.4, 0.1)


class AvatarHeli(Model):
    """Fuselage, tail, skids and a rotor that does not turn; the origin is 49 cm above the ground.

    It has no interface. Dimensions and layout chosen for libgz.
    """

    example = """
    <model:AvatarHeli>
      <id>robot1</id>
      <xyz>0 0 1</xyz>
    </model:AvatarHeli>
    """

    attributes = SkinAttributes

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(SkinAttributes, node)
        hull = add_body(self)
        space = self.modelSpaceId
        fuselage = fit(BoxGeom(hull, space, 0.60, 0.25, 0.35), (0.0, 0.0, -0.15), 8.0, ORANGE)
        fit(BoxGeom(hull, space, 0.90, 0.05, 0.05), (-0.75, 0.0, -0.05), 0.5, GREY)
        for y in (0.18, -0.18):
            fit(BoxGeom(hull, space, 0.60, 0.03, 0.03), (0.0, y, -0.475), 0.5, DARK)
        rotor = fit(CylinderGeom(hull, space, 0.90, 0.02), (0.0, 0.0, 0.18), 0.0, GzColor(0.1, 0.1, 0.1, 0.3))
        rotor.SetTransparency(True)
        add_skin(self, fuselage, values)
