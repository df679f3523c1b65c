"""Settings of an SDF world: physics and its profiles, gravity, scene, magnetic field, place on Earth."""

from __future__ import annotations

import weakref
from dataclasses import dataclass, field

from libgz.errors import Diagnostic, Diagnostics, NotFoundError, ParameterError, nearest
from libgz.geometry import GzVector
from libgz.sdf.description import VERSIONS, describe
from libgz.sdf.element import Element
from libgz.sdfworld.visual import apply_scene
from libgz.simulation.world import World

__all__ = ["SdfSettings", "apply_profile", "apply_settings", "settings_of"]


@dataclass
class SdfSettings:
    """What a `<world>` says besides its entities."""

    element: Element  # the `<world>`
    physics: Element  # the profile in force
    profiles: dict[str, Element] = field(default_factory=dict)
    magnetic_field: GzVector = field(default_factory=lambda: GzVector(5.5645e-6, 22.8758e-6, -42.3884e-6))  # [T], now
    spherical_coordinates: Element | None = None
    scene: Element | None = None


_settings: weakref.WeakKeyDictionary[World, SdfSettings] = weakref.WeakKeyDictionary()


def settings_of(world: World) -> SdfSettings:
    """What the file of a world said, and was set since; SDF's defaults for one that was not loaded from SDF."""
    if world not in _settings:
        element = Element("world", describe(VERSIONS[-1])["world"])
        _settings[world] = SdfSettings(element, element.child("physics"))
    return _settings[world]


def apply_settings(world: World, element: Element, diagnostics: Diagnostics) -> SdfSettings:
    """Read the settings of a `<world>`, and put them into force."""
    found = list(element.named("physics")) or [element.child("physics")]
    profiles = {p.Get(str, "name") or "default_physics": p for p in reversed(found)}
    chosen = next((p for p in found if p.Get(bool, "default")), found[0])
    settings = SdfSettings(element, chosen, dict(reversed(profiles.items())))
    _settings[world] = settings
    # Gravity and magnetic field moved out of <physics> in 1.6.
    outside = element.description is None or "gravity" in element.description.children
    world.engine.gravity = tuple((element if outside else chosen).Get(GzVector, "gravity"))
    for holder in (element, chosen):
        if holder.HasElement("magnetic_field"):
            settings.magnetic_field = holder.Get(GzVector, "magnetic_field")
    if element.HasElement("spherical_coordinates"):
        settings.spherical_coordinates = element.child("spherical_coordinates")
    settings.scene = element.child("scene")
    apply_scene(world, settings.scene)
    try:
        _apply_physics(world, chosen, diagnostics)
    except ParameterError as error:
        diagnostics.add(Diagnostic(chosen.file, chosen.line, chosen.name, str(error), "error"))
    return settings


def apply_profile(world: World, name: str) -> None:
    """Put another `<physics>` of the file into force.

    Raises:
        NotFoundError: there is none of this name.
    """
    settings = settings_of(world)
    if name not in settings.profiles:
        known = ", ".join(settings.profiles) or "none"
        hint = nearest(name, settings.profiles)
        raise NotFoundError(f"there is no physics profile {name!r}; there are {known}{hint}")
    settings.physics = settings.profiles[name]
    _apply_physics(world, settings.physics, Diagnostics())


def _apply_physics(world: World, physics: Element, diagnostics: Diagnostics) -> None:
    """Step, solver, contacts and pacing."""
    engine = world.engine
    engine.step_time = physics.Get(float, "max_step_size")
    engine.max_contacts = physics.Get(int, "max_contacts")
    kind = physics.Get(str, "type")
    if kind != "ode":
        _warn(diagnostics, physics, f"type {kind!r} is not here; ODE is used instead")
    solver = physics.child("ode").child("solver")
    engine.solver = "world" if solver.Get(str, "type") == "world" else "quick"
    engine.set_quick_step(solver.Get(int, "iters"), solver.Get(float, "sor"))
    model = solver.Get(str, "friction_model") or "pyramid_model"
    if model not in ("pyramid_model", "cone_model"):
        _warn(diagnostics, solver, f"friction_model {model!r} is not here; pyramid_model and cone_model are")
    engine.cone = model == "cone_model"
    constraints = physics.child("ode").child("constraints")
    engine.set_constraints(
        constraints.Get(float, "erp"),
        constraints.Get(float, "cfm"),
        constraints.Get(float, "contact_max_correcting_vel"),
    )
    world.simSpeed = physics.Get(float, "real_time_update_rate") * engine.step_time


def _warn(diagnostics: Diagnostics, element: Element, message: str) -> None:
    diagnostics.add(Diagnostic(element.file, element.line, element.name, message, "warning"))
