"""LegacyWorld: what a world of Gazebo 0.4 to 0.7 has beside what all worlds have."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from pathlib import Path
from weakref import WeakKeyDictionary

from libgz.base.digest import blake2b
from libgz.base.entities import encoded
from libgz.base.errors import GazeboError, ParameterError, StateError, WorldFileError, advise
from libgz.base.files import check_size, read_limited
from libgz.base.geometry import GzPose, GzVector
from libgz.legacy.factory import ModelFactory
from libgz.legacy.loader import ModelLoader
from libgz.legacy.model import Model
from libgz.legacy.origin import to_file
from libgz.legacy.plugin_search import load_edited
from libgz.legacy.settings import GlobalAttributes, find_global_nodes, read_global, read_quirks
from libgz.simulation.era import Era
from libgz.simulation.journal import Origin, Source
from libgz.simulation.plugins import called
from libgz.simulation.problems import note_threads_of
from libgz.simulation.world import World
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode
from libgz.worldfile.search import is_ready_world

__all__ = ["LegacyWorld"]

log = logging.getLogger("libgz.simulation")

BUILDER = "legacy"  # in the journal
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
        self._text = self._read_text = b""  # of the file: with edits, and as it was read
        self.file: WorldFile | None = None
        self.settings = GlobalAttributes()
        self.factory = ModelFactory()
        self.loader = ModelLoader(world, self.factory, self._origin_of)
        self._sources: WeakKeyDictionary[WorldFile, Source] = WeakKeyDictionary()  # of the models that were built
        world.journal.builders[BUILDER] = self
        world.reloaders.append(self)

    @property
    def models(self) -> list[Model]:
        """The models of the world that worldfiles describe."""
        return [model for model in self.world.models if isinstance(model, Model)]

    def _source_of(self, file: WorldFile) -> Source:
        """The source that a worldfile is; one that is not known yet was inserted by code of users."""
        if file not in self._sources:
            self._sources[file] = self.world.journal.insertion(BUILDER, file.label, file.source)
        return self._sources[file]

    def _origin_of(self, node: WorldFileNode) -> Origin:
        return Origin(self._source_of(WorldFile.of(node)), node.number)

    def _file_of(self, source: Source) -> WorldFile:
        """The worldfile of a source; what was inserted into another world or has no models left is parsed again."""
        for file, known in self._sources.items():
            if known == source:
                return file
        file = self._parse(source.text, source.label)
        self._sources[file] = source
        return file

    def _parse(self, text: bytes, label: str) -> WorldFile:
        """The worldfile of a text that is inserted."""
        file = WorldFile()
        file.LoadString(text, label)
        if self.file is not None:
            file.filename = self.file.filename  # files that the text names lie beside the world
        return file

    def rebuild(self, source: Source, places: Sequence[int]) -> None:
        """Build models of a worldfile again, by the numbers of their elements.

        Raises:
            StateError: one of them cannot be built.
        """
        file = self._file_of(source)
        nodes = {node.number: node for node in file.GetRootNode().walk()}
        built = {e.origin.place: e for e in self.world.entities if e.origin is not None and e.origin.source == source}
        for place in places:
            node = nodes[place]
            above = node.parent
            while above is not None and above.prefix != "model":
                above = above.parent
            parent = built.get(above.number) if above is not None else None
            model = self.loader.load_one(node, parent if isinstance(parent, Model) else None)
            if model is None:
                reasons = "; ".join(map(str, file.diagnostics.errors)) or node.place
                raise StateError(f"a model of the state cannot be built again: {reasons}")
            built[place] = model

    # Reload ----------------------------------------------------------------------------------------------------------

    def _from_plugins(self) -> list[tuple[Model, Path]]:
        """The models whose classes come from plugin files, and these."""
        found = [(model, self.factory.file_of(model.GetName())) for model in self.models]
        return [(model, path) for model, path in found if path is not None]

    def plugin_names(self) -> list[str]:
        """The ids of models whose classes come from plugin files."""
        return [model.GetId() for model, _ in self._from_plugins()]

    def _files_called(self, name: str) -> list[Path]:
        """The files that a name means: of a model by its id, of a class, or by their own names."""
        found = self._from_plugins()
        meant = [path for one, path in found if name in (one.GetId(), one.GetName()) or called(path, name)]
        return list(dict.fromkeys(meant))

    def has_plugin(self, name: str) -> bool:
        """Whether a model, its class or its plugin file is called this."""
        return bool(self._files_called(name))

    def reload_plugin(self, name: str) -> list[str]:
        """Load plugin files again, and build all models of their classes again in their places.

        Raises:
            PluginError: a file fails, or a model; that one and those after it run on as they were.
        """
        from libgz.legacy.replacement import Replacement  # most worlds do without it

        replaced: list[str] = []
        for path in self._files_called(name):
            models = [model for model, file in self._from_plugins() if file == path]
            note_threads_of(path)
            before = self.factory.replace_plugin(load_edited(path))
            done = 0
            try:
                for model in models:
                    Replacement(self.loader, model).run()
                    done += 1
                    replaced.append(f"model {model.GetId()} ({model.GetName()})")
            except BaseException:
                if not done:
                    self.factory.return_classes(before)
                raise
            finally:
                if done:
                    self.world.forget_states()
        return replaced

    def load_into(self, world: World) -> None:
        """Load the worldfile, as it was read, into another world.

        Raises:
            StateError: there is no file.
        """
        if self.file is None:
            super().load_into(world)
            return
        file = self._parse(self._text, self.file.label)
        file.filename = self.file.filename
        world.extension(LegacyWorld).load(file)

    def load(self, file: WorldFile) -> None:
        """Build all models of a worldfile.

        Errors are collected over the whole file. Warnings are logged; attributes that nothing read are among them.

        Raises:
            WorldFileError: there are errors; the message lists them all, one a line.
        """
        if self.file is None:
            self._text = self._read_text = file.source
            self.digest = blake2b(file.source, digest_size=16).digest()
            self._sources[file] = Source(BUILDER, 0, file.label, b"")
        self.file = file
        values, fog = read_global(file)
        self.world.engine.quirks = read_quirks(file, values.legacyQuirks)
        try:
            self.apply(values, fog)
        except ParameterError as error:  # of the engine, which refuses what the declaration does not
            node = next(reversed(find_global_nodes(file)), file.GetRootNode())
            file.diagnostics.failure(node.place, error)
        self.loader.visit(file.GetRootNode())
        _warn_of_models(self.models)
        file.note_foreign()
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
        file = self._parse(encoded(_with_root(text)), label)
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
            _warn_of_models(added)
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

    def save(self, world: World, whole: bool = False) -> int:
        """Write the worldfile, as `World.Save` describes; 0 or -1.

        Worlds of libgz that were found by name are not written to. The file as it was is kept as ``NAME.bak``.
        """
        if self.file is None:
            return -1
        if self.file.filename is not None and is_ready_world(Path(self.file.filename)):
            log.error("%s belongs to libgz and is not written to; run a copy of it", self.file.filename)
            return -1
        for model in self.models:
            if model.parent is None and model.node is not None:
                model.initPose = model.GetPose()
        file, removed, added = self._whole(whole)
        try:
            file.Save(removed=removed, added=added, backup=True)
        except WorldFileError as error:
            log.error("%s", error)
            return -1
        return 0

    def _whole(self, whole: bool) -> tuple[WorldFile, list[WorldFileNode], list[WorldFileNode]]:
        """A copy of the file with the present poses, the elements that are not in the world, and those from elsewhere.

        Raises:
            StateError: there is no file.
        """
        if self.file is None:
            raise StateError("this world was not loaded from a worldfile")
        copy = self.file.changed()
        twins = dict(zip(self.file.models, copy.models, strict=True))
        present = {model.node: model for model in self.models if model.node is not None}
        added = []
        for node, model in present.items():
            if model.parent is None:
                pose = to_file(model, model.GetPose())
                twins.get(node, node).put_pose(pose.pos, pose.rot)
                if whole and node not in twins:
                    added.append(node)
        removed = [twins.get(node, node) for node in self.loader.built - present.keys()] if whole else []
        return copy, removed, added

    # Edits -----------------------------------------------------------------------------------------------------------

    @property
    def file_name(self) -> str:
        """The name of the worldfile, without its folder."""
        name = self.file.filename if self.file is not None else None
        return Path(name or "").name

    @property
    def text(self) -> bytes:
        """The text of the worldfile, with what was edited since it was read."""
        return self._text

    def set_text(self, text: bytes) -> None:
        """Take another text as that of the worldfile; what is in the world stays until a state is restored.

        Raises:
            StateError: there is no file.
            WorldFileError: it is not well-formed, or larger than a file that can be loaded.
        """
        if self.file is None:
            super().set_text(text)
            return
        check_size(text, self.file.label)
        self.exchange_file(self.file, self._parse(text, self.file.label))

    def exchange_file(self, old: WorldFile, new: WorldFile) -> None:
        """Let an edited worldfile take the place of one with the same models, which are those of the new one then."""
        twins, source = dict(zip(old.models, new.models, strict=True)), self._source_of(old)
        del self._sources[old]
        if old is self.file:
            self.file, self._text = new, new.source
            self.digest = blake2b(new.source, digest_size=16).digest()
        else:
            source = source._replace(text=new.source)
        self._sources[new] = source
        for model in self.models:
            if model.node is not None and model.node in twins:
                model.node = twins[model.node]
                model.origin = Origin(source, model.node.number)
        for node, twin in twins.items():
            if node in self.loader.built:
                self.loader.built.add(twin)
                self.loader.built.discard(node)

    def saved_text(self, world: World) -> tuple[str | None, bytes, bytes]:
        """What `save` of the whole world would write: the file's name or None, its text now, and its text then."""
        file, removed, added = self._whole(True)
        return file.filename, self._on_disk(), file.text(removed=removed, added=added)

    def _on_disk(self) -> bytes:
        """The text of the file at present; that which was read, if it has no name or is gone."""
        name = self.file.filename if self.file is not None else None
        try:
            return read_limited(Path(name)) if name is not None else self._read_text
        except OSError:
            return self._read_text


def _with_root(text: str) -> str:
    """A lone model element in a root that declares its prefixes; a text that declares them itself as it is."""
    if "xmlns:" in text:
        return text
    text = text.lstrip()
    if text.startswith("<?xml"):
        text = text.partition("?>")[2]
    declared = " ".join(f"xmlns:{prefix}='{prefix}'" for prefix in PREFIXES)
    return f"<gz:world {declared}>{text}</gz:world>"


def _warn_of_models(models: Sequence[Model]) -> None:
    """Warn of models of this world that cannot rest or move as they are placed."""
    from libgz.legacy.checks import warn_of_contacts, warn_of_overlaps  # SDF worlds have checks of their own
    from libgz.legacy.sweeps import warn_of_sweeps

    overlapping: set[frozenset[Model]] = set()
    overlapping = advise(warn_of_overlaps, overlapping, models)
    advise(warn_of_sweeps, None, models, overlapping)
    advise(warn_of_contacts, None, models)
