"""LightSource: a point light."""

from __future__ import annotations

from libgz.base.geometry import GzColor
from libgz.legacy.model import Model
from libgz.models.parts import add_body
from libgz.physics.geoms import LightGeom
from libgz.worldfile.attributes import color, declaration, numbers, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

MOST = 8  # lights of a scene, OpenGL's limit


@declaration
class LightSourceAttributes:
    """Attributes of `<model:LightSource>`."""

    ambientColor: GzColor = color(0.2, 0.2, 0.2, help="ambient light")
    diffuseColor: GzColor = color(0.8, 0.8, 0.8, help="diffuse light")
    specularColor: GzColor = color(0.2, 0.2, 0.2, help="specular light")
    attenuation: tuple[float, ...] = numbers(
        1.0, 0.0, 0.0, least=0.0, help="constant, linear and quadratic attenuation"
    )


class LightSource(Model):
    """A point light at the model's position; it moves with its parent. A world renders its first eight lights only."""

    attributes = LightSourceAttributes

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(LightSourceAttributes, node)
        if sum(isinstance(model, LightSource) for model in self.world.models) >= MOST:
            node.warn(f"is not rendered: only the first {MOST} lights of a world are")
        body = add_body(self, dummy=True)
        self.light = LightGeom(body, self.modelSpaceId)
        self.light.SetAmbientColor(values.ambientColor)
        self.light.SetDiffuseColor(values.diffuseColor)
        self.light.SetSpecularColor(values.specularColor)
        self.light.SetAttenuation(values.attenuation)
