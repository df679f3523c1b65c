"""Loading SDF documents into a World: physics settings, models, lights."""

from __future__ import annotations

import logging

from libgz.errors import WorldFileError
from libgz.fault import Fault, Faults
from libgz.geometry import GzCoordPoseAdd, GzPose, GzVector
from libgz.physics.body import Body
from libgz.physics.geoms import LightGeom
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.simulation.model import Model
from libgz.simulation.sdf_model import SdfModel, model_pose
from libgz.simulation.sdf_visual import apply_scene, set_light
from libgz.simulation.world import World

__all__ = ["SdfLight", "load_sdf"]

log = logging.getLogger("libgz.simulation")


class SdfLight(Model):
    """A `<light>`: a dummy body with a light."""

    def __init__(self, world: World, element: Element) -> None:
        super().__init__(world)
        self.sdf = element
        self.SetName("light")
        self.SetId(element.Get(str, "name"))
        body = Body(world, dummy=True)
        self.AddBody(body, True)
        body.SetPose(element.Get(GzPose, "pose"))
        self.light = LightGeom(body, None)
        set_light(self.light, element)


def load_sdf(world: World, file: SdfFile) -> None:
    """Build what an SDF document describes: a whole `<world>`, or the models and lights that stand in `<sdf>`.

    Raises:
        WorldFileError: it has errors; the message lists them all. Warnings are logged.
    """
    root, faults = file.root, file.faults
    element = next(root.named("world"), None)
    if element is not None:
        _apply_physics(world, element, faults)
        apply_scene(world, element.child("scene"))
    for entity in (element or root).children:
        if entity.name == "model":
            _add_model(world, entity, faults, GzPose(), None)
        elif entity.name == "light":
            _register(world, SdfLight(world, entity))
    if element is None and not world.models:
        raise WorldFileError(f"{root.where}: <sdf>: holds no world, model or light")
    for warning in faults.warnings:
        log.warning("%s", warning)
    faults.raise_errors()


def _register(world: World, model: Model) -> None:
    model.initPose = model.GetPose()
    world.adopt(model)


def _add_model(world: World, element: Element, faults: Faults, frame: GzPose, parent: SdfModel | None) -> None:
    """A model, then those nested in it, each at its pose in the one around it."""
    model = SdfModel(world, element, faults, parent)
    pose = GzCoordPoseAdd(model_pose(element), frame)
    model.build(pose)
    if not model.bodies:
        if not any(True for _ in element.named("model")):
            return
    else:
        if parent is not None and parent.bodies:
            model.SetId(f"{parent.GetId()}::{model.GetId()}")
        _register(world, model)
    for nested in element.named("model"):
        _add_model(world, nested, faults, pose, model)


def _apply_physics(world: World, element: Element, faults: Faults) -> None:
    """Step, gravity, solver and pacing."""
    physics = element.child("physics")
    engine = world.engine
    engine.step_time = physics.Get(float, "max_step_size")
    # Gravity moved out of <physics> in 1.6.
    holder = element if element.description is None or "gravity" in element.description.children else physics
    engine.gravity = tuple(holder.Get(GzVector, "gravity"))
    kind = physics.Get(str, "type")
    if kind != "ode":
        where = Fault(
            physics.file, physics.line, "physics", f"type {kind!r} is not here; ODE is used instead", "warning"
        )
        faults.add(where)
    solver = physics.child("ode").child("solver")
    engine.solver = "world" if solver.Get(str, "type") == "world" else "quick"
    engine.set_quick_step(solver.Get(int, "iters"), solver.Get(float, "sor"))
    constraints = physics.child("ode").child("constraints")
    engine.set_constraints(
        constraints.Get(float, "erp"),
        constraints.Get(float, "cfm"),
        constraints.Get(float, "contact_max_correcting_vel"),
    )
    rate = physics.Get(float, "real_time_update_rate")
    world.simSpeed = rate * engine.step_time
