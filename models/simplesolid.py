"""SimpleSolid: a movable box, cylinder or sphere."""

from __future__ import annotations

from pathlib import Path

from libgz.base.geometry import GzColor, GzPose, GzVector
from libgz.legacy.model import Model
from libgz.models.parts import add_body
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CylinderGeom, SphereGeom
from libgz.worldfile.attributes import (
    boolean,
    choice,
    color,
    declaration,
    file,
    integer,
    lengths_by,
    number,
    numbers,
    read,
    rotation,
    text,
    vector,
)
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

DEFAULT_SIZES = {"box": (0.5, 0.5, 0.5), "cylinder": (0.1, 0.5), "sphere": (0.5,)}


@declaration
class SimpleSolidAttributes:
    """Attributes of `<model:SimpleSolid>`."""

    shape: str = choice("box", tuple(DEFAULT_SIZES), help="its shape")
    size: tuple[float, ...] = lengths_by(
        "shape", DEFAULT_SIZES, help="x y z of a box; diameter and height of a cylinder; diameter of a sphere"
    )
    mass: float = number(1.0, unit="kg", above=0.0, help="mass")
    color: GzColor = color(1.0, 1.0, 1.0, help="colour; alpha is used only if transparent is true")
    transparent: bool = boolean(False, help="whether alpha is used")
    surfaceHardness: tuple[float, ...] = numbers(
        1e6, 0.0, unit="N/m, N s/m", least=0.0, infinite=1, help="spring and damper"
    )
    surfaceFriction: tuple[float, ...] = numbers(1.0, 1.0, least=0.0, infinite=2, help="Coulomb coefficients")
    textureFile: Path | None = file(help="image file of the texture")
    skinFile: Path | None = file(help="mesh that is rendered instead of the shape")
    skinXyz: GzVector = vector((0.0, 0.0, 0.0), help="position of the mesh, relative to the solid's centre")
    skinRpy: GzPose = rotation(help="rotation of the mesh")
    skinScale: GzVector = vector((1.0, 1.0, 1.0), unit="", help="scale of the mesh")
    retro: float = number(
        0.0, help="retro-reflectivity; from 0.5 on a laser reports intensity 1 (from 1 on with the quirk wholeRetro)"
    )
    fiducial: int = integer(-1, help="number that fiducial finders report; -1: none")
    shadeModel: str = text("flat", help="without effect")
    polygonMode: str = text("fill", help="without effect")


class SimpleSolid(Model):
    """A movable box, cylinder or sphere, with colour, texture, skin, and marks for lasers and fiducial finders.

    The origin is the centre of its bottom; a cylinder stands upright.
    """

    attributes = SimpleSolidAttributes
    example = """
        <model:SimpleSolid>
          <id>can</id>
          <xyz>1 0 0</xyz>
          <shape>cylinder</shape>
          <size>0.2 0.4</size>
          <mass>0.5</mass>
          <color>0.8 0.8 0.2</color>
        </model:SimpleSolid>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(SimpleSolidAttributes, node)
        body = add_body(self)
        geom = self._shape(body, values.shape, values.size)
        geom.SetRelativePosition((0.0, 0.0, self.height / 2.0))
        geom.SetMass(values.mass)
        geom.SetHardness(*values.surfaceHardness)
        geom.SetFriction(*values.surfaceFriction)
        geom.SetColor(values.color)
        geom.SetTransparency(values.transparent)
        geom.SetTexture2DFile(values.textureFile)
        geom.SetSkinFile(values.skinFile)
        geom.SetSkinPose(GzPose(values.skinXyz, values.skinRpy.rot))
        geom.SetSkinScale(values.skinScale)
        geom.SetRetro(values.retro)
        geom.SetFiducial(values.fiducial)
        self.geom = geom

    def _shape(self, body: Body, shape: str, size: tuple[float, ...]) -> Geom:
        """Create the geom of a shape, and set `height` [m]."""
        self.height = size[{"box": 2, "cylinder": 1, "sphere": 0}[shape]]
        if shape == "box":
            return BoxGeom(body, self.modelSpaceId, *size)
        if shape == "cylinder":
            return CylinderGeom(body, self.modelSpaceId, size[0] / 2.0, size[1])
        return SphereGeom(body, self.modelSpaceId, size[0] / 2.0)
