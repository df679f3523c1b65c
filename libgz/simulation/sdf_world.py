"""Loading SDF documents into a World: settings, models, lights, joints between models, state."""

from __future__ import annotations

import logging
from collections.abc import Iterable

from libgz.errors import GazeboError, WorldFileError
from libgz.fault import Fault, Faults
from libgz.geometry import GzPose
from libgz.physics.body import Body
from libgz.physics.geoms import LightGeom
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.simulation.changes import delete_models
from libgz.simulation.model import Model
from libgz.simulation.sdf_axis import read_joint
from libgz.simulation.sdf_joint import SdfJoint
from libgz.simulation.sdf_model import SdfModel, model_pose
from libgz.simulation.sdf_settings import apply_settings
from libgz.simulation.sdf_state import apply_state
from libgz.simulation.sdf_visual import set_light
from libgz.simulation.world import World

__all__ = ["SdfLight", "WorldJoints", "add_entities", "insert_sdf", "load_sdf"]

log = logging.getLogger("libgz.simulation")


class SdfLight(Model):
    """A `<light>`: a dummy body with a light."""

    def __init__(self, world: World, element: Element, faults: Faults) -> None:
        super().__init__(world)
        self.sdf = element
        self.SetName("light")
        self.SetId(element.Get(str, "name"))
        self.cast_shadows = element.Get(bool, "cast_shadows")
        body = Body(world, dummy=True)
        self.AddBody(body, True)
        body.SetPose(element.Get(GzPose, "pose"))
        self.light = LightGeom(body, None)
        set_light(
            self.light,
            element,
            lambda part, text: faults.add(Fault(part.file, part.line, part.name, text, "warning")),
        )


class WorldJoints(Model):
    """The joints that stand in a `<world>` beside its models; it has a dummy body where the world begins."""

    def __init__(self, world: World) -> None:
        super().__init__(world)
        self.SetName("joints")
        self.SetId("world_joints")
        self.AddBody(Body(world, dummy=True), True)
        self.sdf_joints: dict[str, SdfJoint] = {}

    def Update(self, step: float) -> None:
        """Damping, springs, threads and gears of the joints."""
        if step > 0.0:
            for joint in self.sdf_joints.values():
                if joint.acts:
                    joint.update()

    def find_link(self, name: str) -> Body:
        """A link by `model::link`; a model's name alone is its first link."""
        for model in self.world.models:
            if model.GetId() == name:
                return model.GetBody()
        owner, _, link = name.rpartition("::")
        return self.world.model(owner).GetBody(link)

    def close(self) -> None:
        """Destroy the joints."""
        for joint in self.sdf_joints.values():
            joint.close()
        super().close()


def load_sdf(world: World, file: SdfFile) -> None:
    """Build what an SDF document describes: a whole `<world>`, or the models and lights that stand in `<sdf>`.

    Raises:
        WorldFileError: it has errors; the message lists them all. Warnings are logged.
    """
    root, faults = file.root, file.faults
    if not any(child.name in ("world", "model", "light") for child in root.children):
        faults.raise_errors()
        raise WorldFileError(f"{root.where}: <sdf>: holds no world, model or light")
    try:
        _build(world, next(root.named("world"), None) or _world_around(root), faults)
    except GazeboError as fault:
        if not faults.errors:  # else it follows from what the reader has found
            raise WorldFileError(str(fault)) from fault
    for warning in faults.warnings:
        log.warning("%s", warning)
    faults.raise_errors()


def _build(world: World, element: Element, faults: Faults) -> None:
    """Settings, models, lights and joints of a `<world>`, put where its first `<state>` says."""
    apply_settings(world, element, faults)
    add_entities(world, element.children, faults)
    _add_world_joints(world, element, faults)
    state = next(element.named("state"), None)
    if state is not None:
        for insertions in state.named("insertions"):
            add_entities(world, insertions.children, faults)
        apply_state(world, state, faults)


def _world_around(root: Element) -> Element:
    """Put what stands in `<sdf>` without a `<world>` into one, with the settings that SDF has by default."""
    inside = list(root.children)
    world = root.AddElement("world")
    world.set_attribute("name", "default")
    for child in inside:
        root.RemoveChild(child)
        world.InsertElement(child)
    return world


def insert_sdf(world: World, file: SdfFile) -> list[Model]:
    """Add the models and lights of a document to a running world, between two steps; all of them, or none.

    Raises:
        WorldFileError: it has errors, or holds no model or light.
    """
    before = len(world.models)
    root = next(file.root.named("world"), file.root)
    file.faults.raise_errors()
    try:
        add_entities(world, root.children, file.faults)
        file.faults.raise_errors()
        added = world.models[before:]
        if not added:
            raise WorldFileError(f"{root.where}: Unable to find a model or light in it")
    except BaseException:
        delete_models(world, world.models[before:])
        raise
    for warning in file.faults.warnings:
        log.warning("%s", warning)
    return added


def add_entities(world: World, elements: Iterable[Element], faults: Faults) -> list[Model]:
    """Build models, then their joints, and lights; what is wrong becomes a fault. What was added."""
    before = len(world.models)
    models = []
    for element in elements:
        if element.name == "model":
            model = SdfModel(world, element, faults)
            model.build(model_pose(element))
            models.append(model)
            for member in model.family():
                _register(world, member)
        elif element.name == "light":
            _register(world, SdfLight(world, element, faults))
    for model in models:
        model.build_joints()
    return world.models[before:]


def _register(world: World, model: Model) -> None:
    model.initPose = model.GetPose()
    world.adopt(model)


def _add_world_joints(world: World, holder: Element, faults: Faults) -> None:
    """Joints that stand beside the models."""
    elements = list(holder.named("joint"))
    if not elements:
        return
    joints = WorldJoints(world)
    for element in elements:
        try:
            plan = read_joint(element, joints.find_link, GzPose())
            joints.sdf_joints[plan.name] = SdfJoint(world.engine, plan)
        except GazeboError as fault:
            faults.add(Fault(element.file, element.line, "joint", str(fault), "error"))
    world.adopt(joints)
