"""LightSource: a point light."""

from __future__ import annotations

from dataclasses import dataclass

from libgz.geometry import GzColor
from libgz.legacy.model import Model
from libgz.physics.body import Body
from libgz.physics.geoms import LightGeom
from libgz.worldfile.attributes import color, numbers, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

MOST = 8  # that OpenGL shines at a time


@dataclass(frozen=True)
class LightSourceAttributes:
    """What `<model:LightSource>` may hold."""

    ambientColor: GzColor = color(0.2, 0.2, 0.2, help="light that comes from everywhere")
    diffuseColor: GzColor = color(0.8, 0.8, 0.8, help="light that comes from the source")
    specularColor: GzColor = color(0.2, 0.2, 0.2, help="light that makes highlights")
    attenuation: tuple[float, ...] = numbers(1.0, 0.0, 0.0, least=0.0, help="constant, linear, quadratic fading")


class LightSource(Model):
    """A point light at the model's position; it moves with its parent. Only the first eight of a world shine."""

    attributes = LightSourceAttributes

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(LightSourceAttributes, node)
        if sum(isinstance(model, LightSource) for model in self.world.models) >= MOST:
            node.warn(f"stays dark: a world shines with its first {MOST} lights")
        body = Body(self.world, dummy=True)
        self.AddBody(body, True)
        self.light = LightGeom(body, self.modelSpaceId)
        self.light.SetAmbientColor(values.ambientColor)
        self.light.SetDiffuseColor(values.diffuseColor)
        self.light.SetSpecularColor(values.specularColor)
        self.light.SetAttenuation(values.attenuation)
