"""SdfWorld: what a world of Gazebo classic has beside what all worlds have."""

from __future__ import annotations

import logging
from collections.abc import Iterable

from libgz.errors import Diagnostics, NotFoundError, WorldFileError, nearest
from libgz.geometry import GzPose
from libgz.ode.types import ContactRule
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdfworld.checks import warn_of_contacts
from libgz.sdfworld.light import SdfLight
from libgz.sdfworld.model import SdfModel, model_pose
from libgz.sdfworld.physics import apply_physics
from libgz.sdfworld.settings import SdfSettings, apply_settings, default_settings
from libgz.sdfworld.state import apply_state
from libgz.sdfworld.world_joints import WorldJoints
from libgz.simulation.entity import Entity
from libgz.simulation.era import Era
from libgz.simulation.world import World

__all__ = ["SdfWorld"]

log = logging.getLogger("libgz.simulation")


class SdfWorld(Era):
    """The SDF document and the settings of a world; `World.extension(SdfWorld)` returns it.

    Attributes:
        file: the document, once one is loaded.
        settings: what its `<world>` says beside the entities; SDF's defaults before.
    """

    name = "classic"
    counts_at_start = True

    def __init__(self, world: World) -> None:
        self.world = world
        self.file: SdfFile | None = None
        self.settings: SdfSettings = default_settings()

    @property
    def lights(self) -> list[SdfLight]:
        """The lights that stand in the world, in order of the file."""
        return [entity for entity in self.world.entities if isinstance(entity, SdfLight)]

    # Loading ---------------------------------------------------------------------------------------------------------

    def take_over(self, file: SdfFile) -> None:
        """Make the world one of classic: contact rule, exact rest, time convention, name of the document's world."""
        world = self.world
        world.era = self
        world.engine.contact_rule = ContactRule.CLASSIC
        world.engine.exact_rest = world.engine.record_motion = True
        world.engine.count_turns = world.engine.check_divergence = True
        self.file = file
        named = next(file.root.named("world"), None)
        world.name = named.Get(str, "name") if named is not None else world.name

    def load(self, file: SdfFile) -> None:
        """Build what a document describes: a whole `<world>`, or the models and lights that stand in `<sdf>`.

        Raises:
            WorldFileError: it has errors; the message lists them all. Warnings are logged.
        """
        self.take_over(file)
        root, diagnostics = file.root, file.diagnostics
        if not any(child.name in ("world", "model", "light") for child in root.children):
            diagnostics.raise_errors()
            raise WorldFileError(f"{root.where}: <sdf>: holds no world, model or light")
        element = next(root.named("world"), None) or _world_around(root)
        try:
            self._build(element, diagnostics)
        except Exception as error:  # noqa: BLE001 - an error of the file, whatever it met
            if not diagnostics.errors:  # else it follows from what the reader has found
                diagnostics.failure(element, error)
        for warning in diagnostics.warnings:
            log.warning("%s", warning)
        diagnostics.raise_errors()

    def _build(self, element: Element, diagnostics: Diagnostics) -> None:
        """Settings, models, lights and joints of a `<world>`, placed where its first `<state>` says."""
        world = self.world
        self.settings = apply_settings(world, element, diagnostics)
        self.add_entities(element.children, diagnostics)
        joints = list(element.named("joint"))
        if joints:
            world.adopt(WorldJoints(world, joints, diagnostics))
        state = next(element.named("state"), None)
        if state is not None:
            for insertions in state.named("insertions"):
                self.add_entities(insertions.children, diagnostics)
            apply_state(world, state, diagnostics)
        if not diagnostics.errors:
            warn_of_contacts((model for model in world.entities if isinstance(model, SdfModel)), diagnostics)

    def insert(self, file: SdfFile) -> list[Entity]:
        """Add the models and lights of a document to a running world, between two steps; all of them, or none.

        Raises:
            WorldFileError: it has errors, or holds no model or light.
        """
        world = self.world
        before = len(world.entities)
        root = next(file.root.named("world"), file.root)
        file.diagnostics.raise_errors()
        try:
            added = self.add_entities(root.children, file.diagnostics)
            file.diagnostics.raise_errors()
            if not added:
                raise WorldFileError(f"{root.where}: Unable to find a model or light in it")
            warn_of_contacts((model for model in added if isinstance(model, SdfModel)), file.diagnostics)
        except BaseException:
            world.remove(world.entities[before:])
            raise
        for warning in file.diagnostics.warnings:
            log.warning("%s", warning)
        return added

    def add_entities(self, elements: Iterable[Element], diagnostics: Diagnostics) -> list[Entity]:
        """Build models, then their joints, and lights; what is wrong is added to the diagnostics. What was added."""
        world = self.world
        before = len(world.entities)
        models = []
        for element in elements:
            try:
                if element.name == "model":
                    model = SdfModel(world, element, diagnostics)
                    model.build(model_pose(element))
                    models.append(model)
                    for member in model.nested_family():
                        self._register(member)
                elif element.name == "light":
                    self._register(SdfLight(world, element, diagnostics))
            except Exception as error:  # noqa: BLE001 - an error of the file, whatever it met
                diagnostics.failure(element, error)
        for model in models:
            try:
                model.build_joints()
            except Exception as error:  # noqa: BLE001 - as above
                diagnostics.failure(model.sdf, error)
        return world.entities[before:]

    def _register(self, entity: Entity) -> None:
        entity.initPose = entity.GetPose()
        self.world.adopt(entity)

    # Era -------------------------------------------------------------------------------------------------------------

    def start(self, world: World) -> None:
        """Bring geoms into an order of their own, so that a run after a reset repeats this one."""
        world.engine.sort_geoms()

    def start_view(self, world: World) -> GzPose | None:
        """The pose of `<gui><camera>`."""
        root = self.file.root if self.file is not None else None
        for element in () if root is None else root.named("world"):
            for gui in element.named("gui"):
                for camera in gui.named("camera"):
                    return camera.Get(GzPose, "pose") if camera.HasElement("pose") else None
        return None

    def reset(self, world: World) -> None:
        """Reset the clock, random numbers and poses, then the companions, and signal it."""
        world.engine.seed = world.seed
        world.clock.reset()
        for entity in world.entities:
            if entity.parent is None:
                entity.restore()
        world.engine.sort_geoms()
        world.engine.forget_motion()
        world.engine.wake()
        for companion in world.companions:
            companion.reset()
        world.events["WorldReset"]()

    def press_reset(self, world: World) -> None:
        """Reset the world, as `World.Reset` does."""
        self.reset(world)

    def apply_profile(self, name: str) -> None:
        """Apply another `<physics>` of the file.

        Raises:
            NotFoundError: there is none of this name.
        """
        settings = self.settings
        if name not in settings.profiles:
            known = ", ".join(settings.profiles) or "none"
            hint = nearest(name, settings.profiles)
            raise NotFoundError(f"there is no physics profile {name!r}; there are {known}{hint}")
        settings.physics = settings.profiles[name]
        apply_physics(self.world, settings.physics, Diagnostics())


def _world_around(root: Element) -> Element:
    """A `<world>` with SDF's default settings around what stands in `<sdf>` without one."""
    inside = list(root.children)
    world = root.AddElement("world")
    world.set_attribute("name", "default")
    for child in inside:
        root.RemoveChild(child)
        world.InsertElement(child)
    return world
