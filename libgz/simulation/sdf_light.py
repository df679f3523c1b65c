"""Lights of SDF: those of the world, and those of links."""

from __future__ import annotations

from libgz.geometry import GzColor, GzPose, GzVector
from libgz.physics.body import Body
from libgz.physics.geoms import LightGeom
from libgz.sdf.element import Element
from libgz.simulation.model import Model
from libgz.simulation.world import World

__all__ = ["SdfLight", "add_light"]


def add_light(body: Body, element: Element, *, placed: bool = True) -> LightGeom:
    """Give a body the light that a `<light>` describes; `placed` at its pose in the body, else where the body is."""
    light = LightGeom(body, None)
    light.SetDiffuseColor(element.Get(GzColor, "diffuse"))
    light.SetSpecularColor(element.Get(GzColor, "specular"))
    fading = element.child("attenuation")
    light.SetAttenuation([fading.Get(float, key) for key in ("constant", "linear", "quadratic")])
    if placed:
        light.SetRelativePose(element.Get(GzPose, "pose"))
    return light


class SdfLight(Model):
    """A `<light>` of the world: a dummy body with a light."""

    def __init__(self, world: World, element: Element) -> None:
        super().__init__(world)
        self.sdf = element
        self.SetName("light")
        self.SetId(element.Get(str, "name"))
        self.kind = element.Get(str, "type")  # point, directional or spot
        self.direction = element.Get(GzVector, "direction")
        self.cast_shadows = element.Get(bool, "cast_shadows")
        self.range = element.child("attenuation").Get(float, "range")  # [m]
        body = Body(world, dummy=True)
        self.AddBody(body, True)
        body.SetPose(element.Get(GzPose, "pose"))
        self.light = add_light(body, element, placed=False)
