"""LegacyWorld: what a world of Gazebo 0.4 to 0.7 has beside what all worlds have."""

from __future__ import annotations

import logging

from libgz.errors import GazeboError, ParameterError, WorldFileError
from libgz.geometry import GzPose, GzVector
from libgz.legacy.checks import warn_of_contacts, warn_of_overlaps
from libgz.legacy.factory import ModelFactory
from libgz.legacy.loader import ModelLoader
from libgz.legacy.model import Model
from libgz.legacy.origin import to_file
from libgz.legacy.settings import GlobalAttributes, find_global_nodes, read_global, read_quirks
from libgz.simulation.era import Era
from libgz.simulation.world import World
from libgz.worldfile.file import WorldFile

__all__ = ["LegacyWorld"]

log = logging.getLogger("libgz.simulation")

PREFIXES = ("gz", "model", "param", "params", "window", "models")  # roots of files declare these


class LegacyWorld(Era):
    """The worldfile, the settings and the model classes of a world; `World.extension(LegacyWorld)` returns it.

    Worlds of classic have one, too: models of worldfiles can be inserted into them.

    Attributes:
        file: the worldfile, once one is loaded.
        settings: those of the worldfile, with the old server's defaults.
        factory: the model classes by their names in worldfiles.
        loader: builds models.
    """

    name = "legacy"

    def __init__(self, world: World) -> None:
        self.world = world
        self.file: WorldFile | None = None
        self.settings = GlobalAttributes()
        self.factory = ModelFactory()
        self.loader = ModelLoader(world, self.factory)

    def load(self, file: WorldFile) -> None:
        """Build all models of a worldfile.

        Errors are collected over the whole file. Warnings are logged; attributes that nothing read are among them.

        Raises:
            WorldFileError: there are errors; the message lists them all, one a line.
        """
        self.file = file
        values, fog = read_global(file)
        self.world.engine.quirks = read_quirks(file, values.legacyQuirks)
        try:
            self.apply(values, fog)
        except ParameterError as error:  # of the engine, which refuses what the declaration does not
            node = next(reversed(find_global_nodes(file)), file.GetRootNode())
            file.diagnostics.failure(node.place, error)
        self.loader.visit(file.GetRootNode())
        models = [model for model in self.world.models if isinstance(model, Model)]
        warn_of_overlaps(models)
        warn_of_contacts(models)
        file.note_foreign(not self.world.models)
        file.GetRootNode().note_unused()
        for warning in file.diagnostics.warnings:
            log.warning("%s", warning)
        file.diagnostics.raise_errors()

    def apply(self, values: GlobalAttributes, fog: bool) -> None:
        """Apply the settings of a worldfile.

        Args:
            values: the settings.
            fog: whether there is fog.
        """
        self.settings = values
        world = self.world
        world.simSpeed = values.speed
        world.starts_paused = values.pause
        world.clock.day_time = values.dayTime
        world.utcOffset = values.utcOffset
        world.utmZone = GzVector(values.utmZone, 0.0, 0.0)
        world.utmOffset = values.utmOffset
        world.skyColor = values.skyColor
        world.fogEnable, world.fogDensity = fog, values.fogDensity
        world.engine.step_time = values.stepTime
        world.engine.gravity = tuple(values.gravity)

    def insert(self, text: str, label: str) -> list[Model]:
        """Build the models of a text and initialize them; all of them, or none.

        Raises:
            WorldFileError: the text is not well-formed, has errors, or holds no model.
            PluginError: an Init failed.
            GazeboError: a step is running; use `World.after_step`.
        """
        if self.world.agenda.stepping:
            raise GazeboError("models cannot be inserted during a step; use World.after_step")
        with self.world.hold():
            return self._insert(text, label)

    def _insert(self, text: str, label: str) -> list[Model]:
        file = WorldFile()
        file.LoadString(_with_root(text), label)
        if self.file is not None:
            file.filename = self.file.filename  # files that the text names lie beside the world
        world = self.world
        count, served = len(world.entities), set(world.gz_server.interfaces)
        try:
            root = file.GetRootNode()
            self.loader.visit(root)
            root.note_unused()
            file.diagnostics.raise_errors()
            added = [entity for entity in world.entities[count:] if isinstance(entity, Model)]
            if not added:
                reasons = "\n".join(map(str, file.diagnostics.warnings))
                raise WorldFileError(reasons or f"{label}: there is no <model:...> element in it")
            warn_of_overlaps(added)
            warn_of_contacts(added)
            world.initialize(added)
        except BaseException:
            world.remove(world.entities[count:])
            for key in set(world.gz_server.interfaces) - served:
                world.gz_server.interfaces[key].destroy()
            raise
        for warning in file.diagnostics.warnings:
            log.warning("%s", warning)
        return added

    def start_view(self, world: World) -> GzPose | None:
        """The place of the first ObserverCam in the file."""
        cameras = [model for model in world.models if model.GetName() == "ObserverCam"]
        return cameras[0].initPose if cameras and cameras[0].parent is None else None

    def save(self, world: World) -> int:
        """Make the present poses of top-level models their initial ones, and write them to the worldfile; 0 or -1."""
        if self.file is None:
            return -1
        for model in world.models:
            if not isinstance(model, Model) or model.parent is not None:
                continue
            if model.node is None or model.node.file is not self.file:
                continue
            pose = to_file(model, model.GetPose())
            model.initPose = model.GetPose()
            model.node.SetPosition("xyz", pose.pos, add=True)
            model.node.SetRotation("rpy", pose.rot, add=True)
        try:
            self.file.Save()
        except WorldFileError as error:
            log.error("%s", error)
            return -1
        return 0


def _with_root(text: str) -> str:
    """A lone model element in a root that declares its prefixes; a text that declares them itself as it is."""
    if "xmlns:" in text:
        return text
    text = text.lstrip()
    if text.startswith("<?xml"):
        text = text.partition("?>")[2]
    declared = " ".join(f"xmlns:{prefix}='{prefix}'" for prefix in PREFIXES)
    return f"<gz:world {declared}>{text}</gz:world>"
