"""Loading SDF documents into a World: settings, models, lights, joints between models, state."""

from __future__ import annotations

import logging
from collections.abc import Iterable

from libgz.errors import Diagnostic, Diagnostics, GazeboError, WorldFileError
from libgz.geometry import GzPose
from libgz.legacy.model import Model
from libgz.physics.body import Body
from libgz.physics.geoms import LightGeom
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdfworld.axis import read_joint
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.model import SdfModel, model_pose
from libgz.sdfworld.settings import apply_settings
from libgz.sdfworld.state import apply_state
from libgz.sdfworld.visual import set_light
from libgz.simulation.changes import delete_models
from libgz.simulation.world import World

__all__ = ["SdfLight", "WorldJoints", "add_entities", "insert_sdf", "load_sdf"]

log = logging.getLogger("libgz.simulation")


class SdfLight(Model):
    """A `<light>`: a dummy body with a light."""

    def __init__(self, world: World, element: Element, diagnostics: Diagnostics) -> None:
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
            lambda part, text: diagnostics.add(Diagnostic(part.file, part.line, part.name, text, "warning")),
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
    root, diagnostics = file.root, file.diagnostics
    if not any(child.name in ("world", "model", "light") for child in root.children):
        diagnostics.raise_errors()
        raise WorldFileError(f"{root.where}: <sdf>: holds no world, model or light")
    try:
        _build(world, next(root.named("world"), None) or _world_around(root), diagnostics)
    except GazeboError as error:
        if not diagnostics.errors:  # else it follows from what the reader has found
            raise WorldFileError(str(error)) from error
    for warning in diagnostics.warnings:
        log.warning("%s", warning)
    diagnostics.raise_errors()


def _build(world: World, element: Element, diagnostics: Diagnostics) -> None:
    """Settings, models, lights and joints of a `<world>`, put where its first `<state>` says."""
    apply_settings(world, element, diagnostics)
    add_entities(world, element.children, diagnostics)
    _add_world_joints(world, element, diagnostics)
    state = next(element.named("state"), None)
    if state is not None:
        for insertions in state.named("insertions"):
            add_entities(world, insertions.children, diagnostics)
        apply_state(world, state, diagnostics)


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
    file.diagnostics.raise_errors()
    try:
        add_entities(world, root.children, file.diagnostics)
        file.diagnostics.raise_errors()
        added = world.models[before:]
        if not added:
            raise WorldFileError(f"{root.where}: Unable to find a model or light in it")
    except BaseException:
        delete_models(world, world.models[before:])
        raise
    for warning in file.diagnostics.warnings:
        log.warning("%s", warning)
    return added


def add_entities(world: World, elements: Iterable[Element], diagnostics: Diagnostics) -> list[Model]:
    """Build models, then their joints, and lights; what is wrong becomes an error. What was added."""
    before = len(world.models)
    models = []
    for element in elements:
        if element.name == "model":
            model = SdfModel(world, element, diagnostics)
            model.build(model_pose(element))
            models.append(model)
            for member in model.family():
                _register(world, member)
        elif element.name == "light":
            _register(world, SdfLight(world, element, diagnostics))
    for model in models:
        model.build_joints()
    return world.models[before:]


def _register(world: World, model: Model) -> None:
    model.initPose = model.GetPose()
    world.adopt(model)


def _add_world_joints(world: World, holder: Element, diagnostics: Diagnostics) -> None:
    """Joints that stand beside the models."""
    elements = list(holder.named("joint"))
    if not elements:
        return
    joints = WorldJoints(world)
    for element in elements:
        try:
            plan = read_joint(element, joints.find_link, GzPose())
            joints.sdf_joints[plan.name] = SdfJoint(world.engine, plan)
        except GazeboError as error:
            diagnostics.add(Diagnostic(element.file, element.line, "joint", str(error), "error"))
    world.adopt(joints)
