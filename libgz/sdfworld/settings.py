"""Settings of an SDF world: physics and its profiles, gravity, scene, air, magnetic field, place on Earth."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from libgz.base.errors import Diagnostics, ParameterError
from libgz.base.geometry import GzVector
from libgz.sdf.description import NEWEST, describe
from libgz.sdf.element import Element
from libgz.sdfworld.air import Atmosphere, Wind, read_atmosphere, read_wind
from libgz.sdfworld.physics import apply_physics
from libgz.sdfworld.visual import apply_scene
from libgz.simulation.world import World

__all__ = ["SdfSettings", "apply_settings", "default_settings"]


@dataclass(eq=False, repr=False)
class SdfSettings:
    """What a `<world>` says beside its entities."""

    element: Element  # the `<world>`
    physics: Element  # the profile that is applied
    profiles: dict[str, Element] = field(default_factory=dict)
    magnetic_field: GzVector = field(default_factory=lambda: GzVector(5.5645e-6, 22.8758e-6, -42.3884e-6))  # [T], now
    spherical_coordinates: Element | None = None
    scene: Element | None = None
    wind: Wind = field(default_factory=Wind)
    atmosphere: Atmosphere = field(default_factory=Atmosphere)


def default_settings() -> SdfSettings:
    """SDF's defaults, for a world that was not loaded from SDF."""
    element = Element("world", describe(NEWEST)["world"])
    return SdfSettings(element, element.child("physics"))


def apply_settings(world: World, element: Element, diagnostics: Diagnostics) -> SdfSettings:
    """Read the settings of a `<world>`, and apply them."""
    found = list(element.named("physics")) or [element.child("physics")]
    names = [p.Get(str, "name") or "default_physics" for p in found]
    profiles = dict(zip(names, found, strict=True))  # of one name, as in Gazebo, the last
    chosen = profiles[next((name for name, p in zip(names, found, strict=True) if p.Get(bool, "default")), names[0])]
    settings = SdfSettings(element, chosen, profiles)
    # Gravity and magnetic field moved out of <physics> in 1.6.
    outside = element.description is None or "gravity" in element.description.children
    holder = element if outside or element.HasElement("gravity") else chosen
    try:
        world.engine.gravity = tuple(holder.Get(GzVector, "gravity"))
    except ParameterError as error:
        diagnostics.failure(next(holder.named("gravity"), holder), error)
    for holder in (element, chosen):
        if holder.HasElement("magnetic_field"):
            settings.magnetic_field = holder.Get(GzVector, "magnetic_field")
    if element.HasElement("spherical_coordinates"):
        settings.spherical_coordinates = _place_on_earth(element.child("spherical_coordinates"), diagnostics)
    try:
        settings.wind, settings.atmosphere = read_wind(element), read_atmosphere(element, diagnostics)
    except ParameterError as error:
        diagnostics.failure(next((e for e in element.children if e.name in ("wind", "atmosphere")), element), error)
    settings.scene = element.child("scene")
    apply_scene(world, settings.scene)
    apply_physics(world, chosen, diagnostics)
    return settings


def _place_on_earth(element: Element, diagnostics: Diagnostics) -> Element:
    """The `<spherical_coordinates>`, after a check that its numbers are finite."""
    for name in ("latitude_deg", "longitude_deg", "elevation", "heading_deg"):
        value = element.Get(float, name)
        if not math.isfinite(value):
            diagnostics.failure(element, ParameterError(f"<{name}> is {value}; it must be finite"))
    return element
