"""Settings of an SDF world: physics and its profiles, gravity, scene, magnetic field, place on Earth."""

from __future__ import annotations

from dataclasses import dataclass, field

from libgz.errors import Diagnostics, ParameterError
from libgz.geometry import GzVector
from libgz.sdf.description import VERSIONS, describe
from libgz.sdf.element import Element
from libgz.sdfworld.visual import apply_scene
from libgz.simulation.world import World

__all__ = ["SdfSettings", "apply_physics", "apply_settings", "default_settings"]


@dataclass
class SdfSettings:
    """What a `<world>` says beside its entities."""

    STATE = ("magnetic_field",)

    element: Element  # the `<world>`
    physics: Element  # the profile that is applied
    profiles: dict[str, Element] = field(default_factory=dict)
    magnetic_field: GzVector = field(default_factory=lambda: GzVector(5.5645e-6, 22.8758e-6, -42.3884e-6))  # [T], now
    spherical_coordinates: Element | None = None
    scene: Element | None = None


def default_settings() -> SdfSettings:
    """SDF's defaults, for a world that was not loaded from SDF."""
    element = Element("world", describe(VERSIONS[-1])["world"])
    return SdfSettings(element, element.child("physics"))


def apply_settings(world: World, element: Element, diagnostics: Diagnostics) -> SdfSettings:
    """Read the settings of a `<world>`, and apply them."""
    found = list(element.named("physics")) or [element.child("physics")]
    profiles = {p.Get(str, "name") or "default_physics": p for p in reversed(found)}
    chosen = next((p for p in found if p.Get(bool, "default")), found[0])
    settings = SdfSettings(element, chosen, dict(reversed(profiles.items())))
    # Gravity and magnetic field moved out of <physics> in 1.6.
    outside = element.description is None or "gravity" in element.description.children
    holder = element if outside else chosen
    try:
        world.engine.gravity = tuple(holder.Get(GzVector, "gravity"))
    except ParameterError as error:
        diagnostics.failure(next(holder.named("gravity"), holder), error)
    for holder in (element, chosen):
        if holder.HasElement("magnetic_field"):
            settings.magnetic_field = holder.Get(GzVector, "magnetic_field")
    if element.HasElement("spherical_coordinates"):
        settings.spherical_coordinates = element.child("spherical_coordinates")
    settings.scene = element.child("scene")
    apply_scene(world, settings.scene)
    try:
        apply_physics(world, chosen, diagnostics)
    except ParameterError as error:
        diagnostics.failure(chosen, error)
    return settings


def apply_physics(world: World, physics: Element, diagnostics: Diagnostics) -> None:
    """Step, solver, contacts and pacing."""
    engine = world.engine
    engine.step_time = physics.Get(float, "max_step_size")
    engine.max_contacts = physics.Get(int, "max_contacts")
    kind = physics.Get(str, "type")
    if kind != "ode":
        diagnostics.warn(physics, f"type {kind!r} is not supported; ODE is used instead")
    solver = physics.child("ode").child("solver")
    engine.solver = "world" if solver.Get(str, "type") == "world" else "quick"
    engine.set_quick_step(solver.Get(int, "iters"), solver.Get(float, "sor"))
    model = solver.Get(str, "friction_model") or "pyramid_model"
    if model not in ("pyramid_model", "cone_model"):
        diagnostics.warn(solver, f"friction_model {model!r} is not supported; pyramid_model and cone_model are")
    engine.cone = model == "cone_model"
    constraints = physics.child("ode").child("constraints")
    engine.set_constraints(
        constraints.Get(float, "erp"),
        constraints.Get(float, "cfm"),
        constraints.Get(float, "contact_max_correcting_vel"),
    )
    world.simSpeed = physics.Get(float, "real_time_update_rate") * engine.step_time
