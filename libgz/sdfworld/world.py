"""SdfWorld: what a world of Gazebo classic has beside what all worlds have."""

from __future__ import annotations

import logging
import struct
import zlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from libgz.base.digest import blake2b
from libgz.base.errors import (
    Diagnostics,
    GazeboError,
    NotFoundError,
    ParameterError,
    StateError,
    WorldFileError,
    advise,
    nearest,
)
from libgz.base.files import check_size, is_file, read_limited, save_file
from libgz.base.geometry import GzPose, GzVector
from libgz.ode.types import ContactRule
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import NEWEST, suited, upgraded
from libgz.sdf.value import exact_pose
from libgz.sdf.xacro.recognition import SUFFIX
from libgz.sdf.xml import ROOTS, local_name
from libgz.sdfworld.checks import warn_of_contacts
from libgz.sdfworld.light import SdfLight
from libgz.sdfworld.model import SdfModel, model_pose
from libgz.sdfworld.physics import apply_physics
from libgz.sdfworld.settings import SdfSettings, apply_settings, default_settings
from libgz.sdfworld.standing import set_down
from libgz.sdfworld.world_joints import WorldJoints
from libgz.simulation.entity import Entity
from libgz.simulation.era import Era
from libgz.simulation.journal import Origin, Source
from libgz.simulation.problems import NOTED, Problem
from libgz.simulation.world import World
from libgz.worldfile.search import is_ready_world

if TYPE_CHECKING:
    from libgz.sdfworld.text import SdfText

__all__ = ["BUILT", "WORLD_FILE", "SdfWorld"]

log = logging.getLogger("libgz.simulation")

_AIR = struct.Struct("6d?3d?")

BUILDER = "sdf"  # in the journal
WORLD_FILE = Source(BUILDER, 0, "", b"")
BUILT = ("model", "actor", "light")
POPULATION = (zlib.crc32(b"population"),)  # its random numbers are its own: equal seeds place equal models
MOST_DOCUMENTS = 64  # of entities that are gone, besides as many as there are entities
DIGITS = 9  # decimals of poses that are written
SAME = 1e-9  # [m], and of a quaternion's numbers: two poses that differ by less are one
FAMILY = 1 << 16  # places of a model and those nested in it; more than that a file cannot have


class Document(NamedTuple):
    """What entities are built from.

    Attributes:
        source: in the world's journal.
        elements: its models and lights; a `<world>` among them stands for the joints beside models.
    """

    source: Source
    elements: list[Element]


class SdfWorld(Era):
    """The SDF document and the settings of a world; `World.extension(SdfWorld)` returns it.

    Attributes:
        file: the document, once one is loaded.
        settings: what its `<world>` says beside the entities; SDF's defaults before.
    """

    STATE = ("_air", "profile")

    name = "classic"
    counts_at_start = True

    def __init__(self, world: World) -> None:
        self.world = world
        self.file: SdfFile | None = None
        self._read_text = b""  # of the file, without edits
        self.settings: SdfSettings = default_settings()
        self._documents: dict[Source, Document] = {}
        self._by_tree = world.engine.solver == "tree"  # as who made the world chose
        world.journal.builders[BUILDER] = self

    @property
    def lights(self) -> list[SdfLight]:
        """The lights that stand in the world, in order of the file."""
        return [entity for entity in self.world.entities if isinstance(entity, SdfLight)]

    @property
    def profile(self) -> str:
        """The name of the applied `<physics>`; setting it applies nothing."""
        for name, element in self.settings.profiles.items():
            if element is self.settings.physics:
                return name
        return ""

    @profile.setter
    def profile(self, name: str) -> None:
        self.settings.physics = self.settings.profiles.get(name, self.settings.physics)

    @property
    def _air(self) -> bytes:
        """Magnetic field, wind and atmosphere as they are now, as the bytes of their numbers."""
        field, wind, air = self.settings.magnetic_field, self.settings.wind, self.settings.atmosphere
        blows = wind.velocity
        return _AIR.pack(
            *(field.x, field.y, field.z, blows.x, blows.y, blows.z, wind.enabled),
            *(air.temperature, air.gradient, air.pressure, air.enabled),
        )

    @_air.setter
    def _air(self, packed: bytes) -> None:
        numbers, wind, air = _AIR.unpack(packed), self.settings.wind, self.settings.atmosphere
        self.settings.magnetic_field, wind.velocity = GzVector(*numbers[:3]), GzVector(*numbers[3:6])
        wind.enabled, air.temperature, air.gradient, air.pressure, air.enabled = numbers[6:]

    # Loading ---------------------------------------------------------------------------------------------------------

    def take_over(self, file: SdfFile) -> None:
        """Make the world one of classic: contact rule, exact rest, time convention, name of the document's world."""
        world = self.world
        world.era = self
        world.engine.contact_rule = ContactRule.CLASSIC
        world.engine.exact_rest = world.engine.record_motion = True
        world.engine.count_turns = True
        if self.file is None:
            self._read_text = file.text
            self.digest = blake2b(file.root.ToString().encode(), digest_size=16).digest()
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
        if not any(child.name in ("world", *BUILT) for child in root.children):
            diagnostics.raise_errors()
            raise WorldFileError(f"{root.where}: <sdf>: holds no world, model or light")
        worlds = list(root.named("world"))
        for further in worlds[1:]:
            diagnostics.warn(further, "a file has one world: this one is left out, as in Gazebo classic")
        element = worlds[0] if worlds else _world_around(root)
        try:
            self._build(element, diagnostics)
        except Exception as error:  # noqa: BLE001 - an error of the file, whatever it met
            if not diagnostics.errors:  # else it follows from what the reader has found
                diagnostics.failure(element, error)
        self._report_warnings(diagnostics)
        diagnostics.raise_errors()

    def _build(self, element: Element, diagnostics: Diagnostics) -> None:
        """Settings, models, lights and joints of a `<world>`, placed where its first `<state>` says."""
        world = self.world
        self.settings = apply_settings(world, element, diagnostics)
        self._keep_tree()
        state, document = next(element.named("state"), None), self._document(element, diagnostics)
        built = document.elements[: document.elements.index(element)]
        self._documents[document.source] = document
        self._add(document, range(len(built)), diagnostics)
        if any(True for _ in element.named("joint")):
            self._add(document, [len(built)], diagnostics)
        for road in element.named("road"):
            try:
                from libgz.sdfworld.road import make_road  # few worlds have one

                make_road(world, road, diagnostics.warn)
            except GazeboError as error:
                diagnostics.failure(road, error)
        if state is not None:
            self._add(document, range(len(built) + 1, len(document.elements)), diagnostics)
            try:
                from libgz.sdfworld.state import apply_state  # only saved worlds have one

                apply_state(world, state, diagnostics)
            except ParameterError as error:
                diagnostics.warn(state, f"{error}; but for its insertions, the state has no effect")
        if not diagnostics.errors:
            models = [model for model in world.entities if isinstance(model, SdfModel)]
            if state is None:
                set_down(models)
            advise(warn_of_contacts, None, models, diagnostics)

    def _document(self, element: Element, diagnostics: Diagnostics) -> Document:
        """What entities are built from a `<world>`: its own ones, itself for its joints, those that its state adds."""
        built = [part for part in element.children if part.name in BUILT]
        if next(element.named("population"), None) is not None:
            from libgz.sdfworld.population import populate  # few worlds have one, and the generator is slow to load

            seeds = np.random.SeedSequence(self.world.seed, spawn_key=POPULATION)
            built += populate(element, np.random.default_rng(seeds), diagnostics)
        state = next(element.named("state"), None)
        holders = state.named("insertions") if state is not None else ()
        inserted = [part for insertions in holders for part in insertions.children if part.name in BUILT]
        return Document(WORLD_FILE, [*built, element, *inserted])

    def insert(self, file: SdfFile) -> list[Entity]:
        """Add the models and lights of a document to a running world, between two steps; all of them, or none.

        Raises:
            WorldFileError: it has errors, or holds no model or light.
        """
        world = self.world
        before = len(world.entities)
        root = next(file.root.named("world"), file.root)
        file.diagnostics.raise_errors()
        elements = [part for part in root.children if part.name in BUILT]
        text = "".join(upgraded(part).ToString() for part in elements)
        source = world.journal.insertion(BUILDER, file.label, f"<sdf version='{NEWEST}'>{text}</sdf>".encode())
        self._forget_documents()
        self._documents[source] = document = Document(source, elements)
        try:
            self._add(document, range(len(elements)), file.diagnostics)
            file.diagnostics.raise_errors()
            if len(world.entities) == before:
                raise WorldFileError(f"{root.where}: Unable to find a model or light in it")
            added = [model for model in world.entities[before:] if isinstance(model, SdfModel)]
            set_down(added)
            advise(warn_of_contacts, None, added, file.diagnostics)
        except BaseException:
            world.remove(world.entities[before:])
            del self._documents[source]
            world.journal.inserted -= 1
            raise
        self._report_warnings(file.diagnostics)
        return world.entities[before:]

    def _forget_documents(self) -> None:
        """Forget, now and then, what was inserted and is gone: each insertion of many is to cost the same."""
        entities = self.world.entities
        if len(self._documents) > 2 * len(entities) + MOST_DOCUMENTS:
            present = {entity.origin.source for entity in entities if entity.origin is not None}
            self._documents = {
                source: document
                for source, document in self._documents.items()
                if not source.number or source in present
            }

    def _report_warnings(self, diagnostics: Diagnostics) -> None:
        """Note all warnings in the world, and log a few of each kind."""
        for warning in diagnostics.warnings:
            self.world.problems.add(Problem(log.name, str(warning), "", "warning"))
        for line in diagnostics.summary():
            log.warning("%s", line, extra=NOTED)

    def _add(self, document: Document, tops: Iterable[int], diagnostics: Diagnostics) -> None:
        """Build elements of a document by number: models, then their joints, lights; a `<world>` means its joints.

        What is wrong is added to the diagnostics.
        """
        models = []
        for top in tops:
            element = document.elements[top]
            try:
                if element.name in ("model", "actor"):
                    with self.world.engine.whole():
                        model = _model_class(element)(self.world, element, diagnostics)
                        model.build(model_pose(element))
                    models.append(model)
                    self._register_family(model, document, top)
                elif element.name == "light":
                    with self.world.engine.whole():
                        light = SdfLight(self.world, element, diagnostics)
                    self._register(light, document, top * FAMILY)
                else:
                    joints = WorldJoints(self.world, element, diagnostics)
                    joints.origin = Origin(document.source, top * FAMILY)
                    self.world.adopt(joints)
            except Exception as error:  # noqa: BLE001 - an error of the file, whatever it met
                diagnostics.failure(element, error)
        for model in models:
            try:
                model.build_joints()
            except Exception as error:  # noqa: BLE001 - as above
                diagnostics.failure(model.sdf, error)

    def _register_family(self, model: SdfModel, document: Document, top: int) -> None:
        """Register a model and those nested in it, as far as they are new."""
        numbers = {id(part): number for number, part in enumerate(_family(document.elements[top]))}
        for member in model.nested_family():
            self._register(member, document, top * FAMILY + numbers[id(member.sdf)])

    def _register(self, entity: Entity, document: Document, place: int) -> None:
        entity.origin = Origin(document.source, place)
        entity.initPose = entity.GetPose()
        self.world.adopt(entity)

    # Building again --------------------------------------------------------------------------------------------------

    def _document_of(self, source: Source) -> Document:
        """The document of a source; what was inserted into another world is read again."""
        if source in self._documents:
            return self._documents[source]
        file = SdfFile.from_string(source.text, source.label)
        self._documents[source] = document = Document(
            source, [part for part in file.root.children if part.name in BUILT]
        )
        return document

    def rebuild(self, source: Source, places: Sequence[int]) -> None:
        """Build models, lights and joints of a document again, by their places.

        Raises:
            StateError: one of them cannot be built.
        """
        document, diagnostics = self._document_of(source), Diagnostics()
        nested: dict[int, list[int]] = {}  # to be built into models that are there
        tops: list[int] = []
        for place in places:
            top, member = divmod(place, FAMILY)
            if not member:
                tops.append(top)
            elif top not in tops:
                nested.setdefault(top, []).append(member)
        for top, members in nested.items():
            self._rebuild_nested(document, top, members)
        self._add(document, tops, diagnostics)
        if diagnostics.errors:
            reasons = "; ".join(map(str, diagnostics.errors))
            raise StateError(f"a model of the state cannot be built again: {reasons}")

    def _rebuild_nested(self, document: Document, top: int, members: list[int]) -> None:
        family = _family(document.elements[top])
        built = {e.origin.place: e for e in self.world.entities if e.origin and e.origin.source == document.source}
        for member in members:
            place = top * FAMILY + member
            above = family[member].parent
            owner = next((e for e in built.values() if isinstance(e, SdfModel) and e.sdf is above), None)
            if place in built or owner is None:
                continue
            model = owner.build_nested(family[member])
            numbers = {id(part): number for number, part in enumerate(family)}
            for one in model.nested_family():
                self._register(one, document, top * FAMILY + numbers[id(one.sdf)])
                built[top * FAMILY + numbers[id(one.sdf)]] = one
            model.build_joints()

    def load_into(self, world: World) -> None:
        """Load the document, as it was read, into another world.

        Raises:
            StateError: there is no document.
        """
        if self.file is None:
            super().load_into(world)
            return
        world.extension(SdfWorld).load(self.file.read_again())
        if self.file.busy:
            world.attach_era()

    # Edits -----------------------------------------------------------------------------------------------------------

    @property
    def file_name(self) -> str:
        """The name of the world's file, without its folder."""
        path = Path(self.file.label if self.file is not None else "")
        return path.name if is_file(path) else ""

    @property
    def text(self) -> bytes:
        """The text of the world's file, with what was edited since it was read."""
        return self.file.text if self.file is not None else b""

    def element_of(self, origin: Origin) -> Element:
        """What an entity would be built of, as its document is now."""
        top, member = divmod(origin.place, FAMILY)
        return _family(self._document_of(origin.source).elements[top])[member]

    def sdf_text(self) -> SdfText:
        """The same, and its elements.

        Raises:
            StateError: there is no file.
            WorldFileError: its text cannot be changed.
        """
        if self.file is None:
            raise StateError("this world was not loaded from an SDF file")
        from libgz.sdfworld.text import SdfText  # worlds that are not edited do without it

        return SdfText(self.file.text, self.file.label)

    def set_text(self, text: bytes) -> None:
        """Take another text as that of the world's file; what is in the world stays until it is built again.

        Raises:
            StateError: there is no file.
            WorldFileError: it has errors, or is larger than a file that can be loaded.
        """
        if self.file is None:
            super().set_text(text)
            return
        check_size(text, self.file.label)
        file, diagnostics = self.file.read_again(text), Diagnostics()
        file.diagnostics.raise_errors()
        digest = blake2b(file.root.ToString().encode(), digest_size=16).digest()
        element = next(file.root.named("world"), None) or _world_around(file.root)
        document = self._document(element, diagnostics)
        diagnostics.raise_errors()
        self._documents[document.source] = document
        self.file, self.digest = file, digest

    def exchange_insertion(self, source: Source, text: bytes) -> Source:
        """Take another text for one that was inserted; its source. What was built of it is still of the old one.

        Raises:
            WorldFileError: it has errors.
        """
        file = SdfFile.from_string(text, source.label)
        file.diagnostics.raise_errors()
        new = source._replace(text=text)
        self._documents[new] = Document(new, [part for part in file.root.children if part.name in BUILT])
        return new

    def apply_again(self, diagnostics: Diagnostics) -> None:
        """Apply the settings of the world's file again, after an edit of its text."""
        if self.file is not None:
            element = next(self.file.root.named("world"), None)
            if element is not None:
                self.settings = apply_settings(self.world, element, diagnostics)
                self._keep_tree()

    def _keep_tree(self) -> None:
        """Choose the tree solver again, if who made the world did: files name one of Gazebo's two, or none."""
        if self._by_tree:
            self.world.engine.solver = "tree"

    def build_again(self, entity: Entity, source: Source) -> Entity:
        """Build a model, light or actor again, with all in it, as its document describes it now; the new one.

        Raises:
            WorldFileError: it cannot be built.
        """
        world, origin, diagnostics = self.world, entity.origin, Diagnostics()
        if origin is None:
            raise StateError(f"{entity.GetId()!r} was made by code, not from a file")
        others = [joints for joints in world.entities if isinstance(joints, WorldJoints)]
        world.remove([*others, *entity.with_attached()])
        count = len(world.entities)
        self._add(self._document_of(source), [origin.place // FAMILY], diagnostics)
        for joints in others:
            if joints.origin is not None:
                self._add(self._document_of(joints.origin.source), [joints.origin.place // FAMILY], diagnostics)
        diagnostics.raise_errors()
        world.initialize(world.entities[count:])
        return world.entities[count]

    def saved_text(self, world: World) -> tuple[str | None, bytes, bytes]:
        """What `save` of the whole world would write: the file's name or None, its text now, and its text then."""
        text, read = self.sdf_text(), self._read_text
        path = Path(text.label)
        if not is_file(path):
            return None, read, self._placed(text)
        if path.suffix == SUFFIX or local_name(text.root) not in ROOTS:
            raise WorldFileError(f"{path} is no plain SDF; name a file to write to, or convert it with `libgz upgrade`")
        return str(path), read_limited(path), self._placed(text)

    def _placed(self, text: SdfText) -> bytes:
        """A text of the file with the present poses, without what is deleted, and with what was inserted."""
        world, edits = self.world, []
        document = self._documents[WORLD_FILE]
        tops = [one for one in world.entities if one.parent is None and not isinstance(one, WorldJoints)]
        present = {one.origin.place // FAMILY: one for one in tops if one.origin and not one.origin.source.number}
        for number, element in enumerate(document.elements):
            if element.name not in BUILT:
                break
            name, entity = element.Get(str, "name"), present.get(number)
            found = text.find([(element.name, name)]) if element.file == text.label else None
            found = text.include(element) if found is None else found
            if found is None:
                continue
            if entity is None:
                edits.append(text.removal(found))
            elif not _same_pose(entity.GetPose(), model_pose(element)):
                edits += text.pose(found, _written(entity.GetPose()), element.placed)
        inserted, version = [], self.file.version if self.file is not None else NEWEST
        for one in tops:
            if one.origin is not None and one.origin.source.number:
                part = upgraded(self._document_of(one.origin.source).elements[one.origin.place // FAMILY])
                (next(part.named("pose"), None) or part.AddElement("pose")).value.SetFromString(_written(one.GetPose()))
                inserted.append(suited(part, version).ToString(text.indent_in()))
        return text.changed(*edits, *([text.addition(inserted)] if inserted else []))

    def save(self, world: World, whole: bool = False) -> int:
        """Write the world's file with the present poses, edits, insertions and deletions; 0 or -1.

        Comments and order stay; the file as it was is kept as ``NAME.bak``. Worlds of libgz are not written to.
        """
        if not whole:
            return super().save(world, whole)
        try:
            name, before, text = self.saved_text(world)
            if name is None:
                raise WorldFileError("this world was loaded from text: name a file to save it to")
            if is_ready_world(Path(name)):
                raise WorldFileError(f"{name} belongs to libgz and is not written to; run a copy of it")
            if before != text:
                check_size(text, name)
                save_file(Path(name), text, before)
        except (GazeboError, OSError) as error:
            log.error("%s", error)
            return -1
        return 0

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
        """Return to the state at the end of loading, then reset the companions, and signal it.

        A pause stays, and so do the initial poses that models were given since.
        """
        paused, poses = world.paused, {entity: entity.initPose for entity in world.entities}
        world.return_to_start()
        world.paused = paused
        moved = [entity for entity in world.entities if poses.get(entity, entity.initPose) != entity.initPose]
        for entity in moved:
            entity.initPose = poses[entity]
        for entity in moved:
            if entity.parent is None:
                entity.restore()
        world.events["TimeReset"]()
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
            WorldFileError: a value in it is not allowed.
        """
        settings = self.settings
        if name not in settings.profiles:
            known = ", ".join(settings.profiles) or "none"
            hint = nearest(name, settings.profiles)
            raise NotFoundError(f"there is no physics profile {name!r}; there are {known}{hint}")
        settings.physics, diagnostics = settings.profiles[name], Diagnostics()
        apply_physics(self.world, settings.physics, diagnostics)
        self._keep_tree()
        diagnostics.raise_errors()


def _written(pose: GzPose) -> str:
    """A pose as a file has it, without digits that are rounding."""
    return " ".join(repr(round(float(word), DIGITS) + 0.0).removesuffix(".0") for word in exact_pose(pose).split())


def _same_pose(one: GzPose, other: GzPose) -> bool:
    """Whether two poses differ by no more than rounding."""
    near = max(abs(a - b) for a, b in zip(one.pos, other.pos, strict=True)) < SAME
    signs = (1.0, -1.0)
    return near and min(max(abs(a - s * b) for a, b in zip(one.rot, other.rot, strict=True)) for s in signs) < SAME


def _model_class(element: Element) -> type[SdfModel]:
    """The class of a `<model>` or an `<actor>`."""
    if element.name == "model":
        return SdfModel
    from libgz.sdfworld.actor import SdfActor  # with it come skeletons

    return SdfActor


def _family(element: Element) -> list[Element]:
    """The elements of a model and of those nested in it, parents first."""
    return [element, *(part for nested in element.named("model") for part in _family(nested))]


def _world_around(root: Element) -> Element:
    """A `<world>` with SDF's default settings around what stands in `<sdf>` without one."""
    inside = list(root.children)
    world = root.AddElement("world")
    world.set_attribute("name", "default")
    for child in inside:
        root.RemoveChild(child)
        world.InsertElement(child)
    return world
