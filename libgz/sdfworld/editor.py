"""SdfEditor: edits values in the text of an SDF file, and builds what they belong to again in the running world."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from lxml import etree

from libgz.base.errors import Diagnostics, NotFoundError, ParameterError, WorldFileError, nearest
from libgz.base.geometry import GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector
from libgz.sdf.description import UNITS, UNSET, VERSIONS, Description, describe
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import NEWEST, suited, upgraded
from libgz.sdf.value import check
from libgz.sdf.xml import ROOTS, local_name
from libgz.sdfworld.comments import copy_comments
from libgz.sdfworld.model import SdfModel
from libgz.sdfworld.model_motion import ModelMotion
from libgz.sdfworld.text import SdfText, Step, children
from libgz.sdfworld.world import BUILT, WORLD_FILE, SdfWorld
from libgz.simulation.editor import LONGEST_TEXT, Value, numbers_of
from libgz.simulation.entity import Entity
from libgz.simulation.journal import Source
from libgz.simulation.world import World

__all__ = ["SdfEditor"]

# Types of the description -> those of `Value`, and how many numbers.
TYPES = {
    "double": ("number", 1, 1),
    "int": ("integer", 1, 1),
    "unsigned int": ("integer", 1, 1),
    "bool": ("bool", 1, 1),
    "vector2d": ("vector", 2, 2),
    "vector2i": ("vector", 2, 2),
    "vector3": ("vector", 3, 3),
    "pose": ("vector", 6, 6),
    "color": ("color", 3, 4),
}
# Elements with values of their own, which are parts of a model.
PARTS = ("model", "link", "joint", "sensor", "collision", "visual", "light", "actor", "gripper", "plugin", "projector")
# What is offered although the file does not have it.
OFFERED = (
    *("inertial", "inertia", "material", "limit", "dynamics", "surface", "friction", "ode", "solver", "constraints"),
    *("attenuation", "physics", "scene", "fog", "wind", "atmosphere"),
)
# Of a world: what has editors of its own, or no value.
NOT_OFFERED = ("audio", "gui", "road", "state", "population", "include", "frame", "plugin", "bullet", "simbody", "dart")
INSIDE = {"link": ("collision", "visual")}  # whose values are listed with those of their link
DEEPEST = 8
MOST_VALUES = 2000


class _Include(NamedTuple):
    """An `<include>` by which values come into a document.

    Attributes:
        text: the document.
        element: the include.
        built: what it includes.
        whole: whether the values are those of that as a whole, some of which the include may set.
    """

    text: SdfText
    element: etree._Element
    built: Element
    whole: bool

    def sets(self, key: str) -> bool:
        """Whether it can set a value."""
        return self.whole and (key in ("@name", "pose") or (key == "static" and self.built.name == "model"))

    @property
    def reason(self) -> str:
        """Why it cannot set others."""
        file = self.built.file
        copied = "copy it into the world to edit it here, or " if self.built.name in BUILT else ""
        return f"it is in {file}, which is included: {copied}`libgz edit {file}`"


class _Place(NamedTuple):
    """Where values are: a document, an element of it, and its description.

    Attributes:
        source: in the journal; number 0 is the world's file.
        text: the document; of what is included, as if it was written there.
        element: the element.
        about: its description.
        include: by which the values come into the document of the source; None if they are in it.
    """

    source: Source
    text: SdfText
    element: etree._Element
    about: Description
    include: _Include | None = None


class SdfEditor:
    """Edits a world of Gazebo classic; `World.extension(SdfEditor)` returns it.

    Args:
        world: of classic.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._era: SdfWorld = world.extension(SdfWorld)

    def values(self, entity: Entity | None, part: str = "", kind: str = "") -> list[Value]:
        """The values of a model, light, actor, or a part of one, or of the world, as SDF describes them."""
        if entity is None and local_name(self._era.sdf_text().holder) != "world":
            return []
        place = self._place(entity, part, kind)
        found = list(self._values(place, place.element, place.about, "", "", 0))
        links = list(children(place.element, "link"))
        if local_name(place.element) == "model" and len(links) == 1:
            about = place.about.children["link"]
            name = links[0].get("name", "")
            found += self._values(place, links[0], about, f"link[{name}]/", f"link {name}", 0)
        for value in found:
            if value.key == "pose" and not part and entity is not None and entity.parent is None:
                pose = entity.GetPose()
                value.value = [*pose.pos, *GzQuaternToEuler(pose.rot)]
        return (found if place.include is None else _included(found, place.include))[:MOST_VALUES]

    def _values(
        self, place: _Place, xml: etree._Element | None, about: Description, key: str, group: str, depth: int
    ) -> Iterator[Value]:
        def below(name: str) -> str:
            return f"{group} / {name}".strip(" /")

        for name, attribute in about.all_attributes.items():
            given = None if xml is None else xml.get(name)
            yield self._value(place, xml, attribute, f"{key}@{name}", name, group, given)
        for name, child in about.children.items():
            if name in NOT_OFFERED or depth > DEEPEST:
                continue
            present = [] if xml is None else list(children(xml, name))
            if name in INSIDE.get(about.name, ()):
                for one in present:
                    own = one.get("name", "")
                    yield from self._values(
                        place, one, child, f"{key}{name}[{own}]/", below(f"{name} {own}"), depth + 1
                    )
            elif name in PARTS or len(present) > 1:
                continue
            elif child.type:
                given = (present[0].text or "").strip() if present else None
                yield self._value(place, present[0] if present else xml, child, key + name, name, group, given)
            elif present or child.required or name in OFFERED:
                inner = f"{group} / {name}".strip(" /")
                yield from self._values(
                    place, present[0] if present else None, child, f"{key}{name}/", inner, depth + 1
                )

    @staticmethod
    def _value(
        place: _Place, xml: etree._Element | None, about: Any, key: str, label: str, group: str, text: str | None
    ) -> Value:
        kind = TYPES.get(about.type, ("text", 1, 1))[0]
        default = "" if about.default == UNSET else about.default
        unit = about.note if about.note in UNITS else "m, rad" if about.type == "pose" else ""
        line = xml.sourceline if xml is not None and isinstance(xml.sourceline, int) else 0
        note = "" if about.note in UNITS else about.note
        return Value(
            key, label, group, kind, _shown(kind, default if text is None else text), text or "", unit,
            help=note, file=place.text.label, line=line,
        )  # fmt: skip

    def edit(self, entity: Entity | None, part: str, kind: str, key: str, value: Any) -> Entity | None:
        """Change a value of a model, which is built again and moves on as it did; or of the world.

        Raises:
            NotFoundError: there is no such value.
            GazeboError: the value is not allowed.
        """
        place = self._place(entity, part, kind)
        about = _about(place.about, key)
        text = _text(about, key, value)
        if place.include is not None:
            if not place.include.sets(key):
                owner = part or (entity.GetId() if entity is not None else "")
                raise ParameterError(f"{key} of {owner!r} cannot be edited here: {place.include.reason}")
            place, key = place._replace(text=place.include.text, element=place.include.element), key.removeprefix("@")
        if entity is None:
            self._take(place.source, self._edited(place, key, text))
            self._apply_world()
            return None
        if key == "pose" and not part and entity.parent is None:
            numbers = numbers_of(value, 6, 6)
            pose = GzPose(GzVector(*numbers[:3]), GzQuaternFromEuler(*numbers[3:]))
            self._take(place.source, self._moved(entity, place, text))
            self._world.SetModelPose(entity, pose)
            entity.initPose = pose
            return entity
        if key.removeprefix("@") == "name" and not part:
            self._check_name(entity, text)
        if key == "pose" and place.include is not None:  # in the frame around it, whatever the include's own is
            return self._rebuild(entity, place.source, self._moved(entity, place, text))
        return self._rebuild(entity, place.source, self._edited(place, key, text))

    def embed(self, entity: Entity) -> Entity:
        """Write what an `<include>` includes in its place, so that all of it can be edited; the entity then.

        Raises:
            NotFoundError: it is not in the text.
            ParameterError: it is not included, or it would mean something else in the version of the file.
        """
        place = self._place(entity, "", "")
        if place.include is None:
            raise ParameterError(f"{entity.GetId()!r} is in {place.text.label} already")
        text, element, built, _ = place.include
        version = (text.root.get("version") or "").strip()
        copy = suited(upgraded(built, Path(text.label).parent), version)
        if version < NEWEST and copy.ToString() != upgraded(_read_as(copy, version)).ToString():
            raise ParameterError(
                f"{built.file} is of a later version than SDF {version}, in which it would mean something else; "
                f"convert {text.label} with `libgz upgrade` first"
            )
        copy_comments(copy, element)
        return self._rebuild(entity, place.source, text.changed(text.exchange(element, copy)))

    def copy_text(self, entity: Entity) -> str:
        """The SDF of an entity under a name that no other one has, at its present pose."""
        top = _top(entity)
        element = getattr(top, "sdf", None)
        if not isinstance(element, Element) or element.name not in BUILT:
            raise ParameterError(f"{entity.GetId()!r} has no text to copy")
        copy = upgraded(element)
        stem = re.sub(r"_?\d+$", "", top.GetId()) or "model"
        taken = {one.GetId() for one in self._world.entities}
        copy.set_attribute("name", next(f"{stem}_{n}" for n in range(1, len(taken) + 2) if f"{stem}_{n}" not in taken))
        (next(copy.named("pose"), None) or copy.AddElement("pose")).Set(top.GetPose())
        return f"<sdf version='{NEWEST}'>{copy.ToString()}</sdf>"

    # Places ----------------------------------------------------------------------------------------------------------

    def _file(self) -> SdfFile:
        if self._era.file is None:
            raise WorldFileError("this world was not loaded from an SDF file, so there is nothing to edit")
        return self._era.file

    def _place(self, entity: Entity | None, part: str, kind: str) -> _Place:
        """Where the values of an entity, or of a part of it, are in the text.

        Raises:
            NotFoundError: they are not in it.
        """
        if entity is None:
            text = self._era.sdf_text()
            if local_name(text.holder) != "world":
                raise NotFoundError(f"{text.label} has no <world>, so its settings cannot be edited")
            return _Place(WORLD_FILE, text, text.holder, self._blocks(text)["world"])
        include, source = None, entity.origin.source if entity.origin is not None else None
        if source is None:
            raise NotFoundError(f"{entity.GetId()!r} was made by code, not from a file; it cannot be edited")
        text = self._era.sdf_text() if not source.number else SdfText(source.text, source.label or "<inserted>")
        self._blocks(text)
        element, path = text.holder, self._path(entity)
        for number, built in enumerate(path):
            step = _step(built)
            found = text.find([step], element)
            if found is None:
                found = text.include(built, element)
                if found is None:
                    why = "it is made by another element, or included in a way that is not clear"
                    raise NotFoundError(f"{entity.GetId()!r} has no element of its own in {text.label}: {why}")
                include = _Include(text, found, built, number == len(path) - 1 and not part)
                text = _written(built, built.file)
                found = text.find([step])
            if found is None:
                raise NotFoundError(f"{entity.GetId()!r} has no element in {text.label}")
            element = found
        merged = _merged(path[-1], part) if path else None
        if merged is not None and text.find([_step(merged)], element) is None:
            include = include or _Include(text, element, merged, False)
            text = _written(path[-1], merged.file)
            element = text.root[0]
        about = self._blocks(text)[local_name(element)]
        for step in _parts(element, part, kind):
            below = next((one for one in children(element, step[0]) if one.get("name") == step[1]), None)
            if below is None:
                names = [str(one.get("name")) for one in children(element, step[0])]
                raise NotFoundError(f"{entity.GetId()!r} has no {step[0]} {step[1]!r}{nearest(step[1], names)}")
            element, about = below, about.children[step[0]]
        return _Place(source, text, element, about, include)

    def _path(self, entity: Entity) -> list[Element]:
        """The elements from that of the entity at the top to its own, as the text is now."""
        element = self._era.element_of(entity.origin) if entity.origin is not None else None
        found: list[Element] = []
        while element is not None and element.name in BUILT:
            found.insert(0, element)
            element = element.parent
        return found

    @staticmethod
    def _blocks(text: SdfText) -> Any:
        version = (text.root.get("version") or "").strip()
        if local_name(text.root) not in ROOTS or version not in VERSIONS:
            raise WorldFileError(
                f"{text.label} is not SDF {VERSIONS[0]} to {VERSIONS[-1]}; `libgz upgrade` converts it, for editing"
            )
        return describe(version)

    def _moved(self, entity: Entity, place: _Place, text: str) -> bytes:
        return place.text.changed(*place.text.pose(place.element, text, self._path(entity)[-1].placed))

    @staticmethod
    def _edited(place: _Place, key: str, text: str) -> bytes:
        steps = _steps(key)
        element, left = place.element, []
        for index, (tag, name) in enumerate(steps):
            if not name:
                left = [tag for tag, _ in steps[index:]]
                break
            found = place.text.find([(tag, name)], element)
            if found is None:
                raise NotFoundError(f"there is no {tag} {name!r}")
            element = found
        return place.text.changed(place.text.value(element, left, text))

    def _take(self, source: Source, text: bytes) -> Source:
        """Take an edited text; its source in the journal."""
        self._world.forget_states()
        if not source.number:
            self._era.set_text(text)
            return source
        return self._era.exchange_insertion(source, text)

    # Building again --------------------------------------------------------------------------------------------------

    def _check_name(self, entity: Entity, text: str) -> None:
        taken = any(one is not entity and one.GetId() == text for one in self._world.entities)
        if taken or not text or "::" in text:
            raise ParameterError(f"name {text!r} is not allowed; it must be a name that nothing else in the world has")

    def _apply_world(self) -> None:
        diagnostics = Diagnostics()
        self._era.apply_again(diagnostics)
        diagnostics.raise_errors()

    def _rebuild(self, entity: Entity, source: Source, text: bytes) -> Entity:
        """Take an edited text, and build the entity at the top again."""
        top, world = _top(entity), self._world
        family = [one for one in world.entities if _top(one) is top]
        nested = family.index(entity)
        pose, home, motion = top.GetPose(), top.initPose, ModelMotion(top) if isinstance(top, SdfModel) else None
        source = self._take(source, text)
        with world.hold():
            new = self._era.build_again(top, source)
            if motion is None:  # a light, whose element says where it began
                if pose != home:
                    world.SetModelPose(new, pose)
            elif motion.begun and isinstance(new, SdfModel):
                motion.carry(new)
            new.initPose = home
        again = [one for one in world.entities if _top(one) is new]
        return again[nested] if nested < len(again) else new


def _top(entity: Entity) -> Entity:
    while entity.parent is not None:
        entity = entity.parent
    return entity


def _step(element: Element) -> Step:
    return element.name, element.Get(str, "name")


def _written(element: Element, label: str) -> SdfText:
    """An element as a document of its own."""
    return SdfText(f"<sdf version='{NEWEST}'>{upgraded(element).ToString()}</sdf>".encode(), label)


def _merged(model: Element, part: str) -> Element | None:
    """The link or joint that a part of a model is or is in, if the model has it of one that it includes."""
    parts = (one for one in model.children if one.name in ("link", "joint") and one.file != model.file)
    return next((one for one in parts if f"{part}::".startswith(f"{one.Get(str, 'name')}::")), None)


def _included(values: list[Value], include: _Include) -> list[Value]:
    """The values of what is included, and first where that is."""
    file, place = include.built.file, include.text
    for value in values:
        if include.sets(value.key):
            given = next(children(include.element, value.key.removeprefix("@")), None)
            line = (include.element if given is None else given).sourceline
            value.file, value.line = place.label, line if isinstance(line, int) else 0
        else:
            value.file, value.line, value.reason = file, 0, include.reason
    return [Value("include", "file", "Included", "include", file, file, file=file, reason=include.reason), *values]


def _read_as(element: Element, version: str) -> Element:
    """An element as a document of another version has it."""
    return SdfFile.from_string(f"<sdf version='{version}'>{element.ToString()}</sdf>").root.children[0]


def _parts(element: etree._Element, part: str, kind: str) -> Iterator[Step]:
    """The path of a part from its model on; a sensor may be named with its link."""
    if not part:
        return
    tag = {"body": "link"}.get(kind, kind) or "link"
    if tag not in ("link", "joint", "sensor", "light", "model"):
        raise ParameterError(f"kind {kind!r} is not allowed; it must be link, joint, sensor or light")
    for holder in ("link", tag):  # names of what was included have `::` in them
        for own in (one.get("name", "") for one in children(element, holder)):
            if "::" in own and f"{part}::".startswith(f"{own}::"):
                yield holder, own
                if part != own:
                    yield tag, part.removeprefix(f"{own}::")
                return
    *above, name = part.split("::")
    if (
        tag == "link"
        and name == "canonical"
        and not any(True for one in children(element, "link") if one.get("name") == name)
    ):
        name = next((str(one.get("name")) for one in children(element, "link")), name)
    if tag in ("sensor", "light") and not above:
        holders = [one for one in children(element, "link") if any(s.get("name") == name for s in children(one, tag))]
        above = [str(holders[0].get("name"))] if holders else []
    for step in above:
        yield ("model", step) if any(one.get("name") == step for one in children(element, "model")) else ("link", step)
    yield tag, name


_STEP = re.compile(r"([^/\[\]]+)(?:\[([^\[\]]*)\])?(?:/|$)")


def _steps(key: str) -> list[Step]:
    """The steps of a key: ``link[base]/inertial/mass``."""
    return [(match[1], match[2] or "") for match in _STEP.finditer(key)]


def _about(about: Description, key: str) -> Any:
    """The description of the value of a key.

    Raises:
        NotFoundError: SDF has none.
    """
    for tag, _ in _steps(key)[: DEEPEST + 3]:
        known: Any = about.all_attributes if tag.startswith("@") else about.children
        found = known.get(tag.removeprefix("@"))
        if found is None or tag in NOT_OFFERED:
            raise NotFoundError(f"<{about.name}> has no {tag!r} to edit{nearest(tag, known)}")
        about = found
    if not about.type or _steps(key) == []:
        raise NotFoundError(f"{key!r} is no value; it holds others")
    return about


def _shown(kind: str, text: str) -> Any:
    words = text.split()
    try:
        if kind in ("vector", "color"):
            return [float(word) for word in words]
        if kind in ("number", "integer"):
            return (int if kind == "integer" else float)(words[0]) if words else 0
    except ValueError:
        return text
    return text.strip().lower() in ("true", "1") if kind == "bool" else text


def _text(about: Any, key: str, value: Any) -> str:
    """The text of a value that a page sends.

    Raises:
        ParameterError: it is not of the type that SDF describes.
    """
    kind, least, most = TYPES.get(about.type, ("text", 1, 1))
    if kind == "bool":
        if not isinstance(value, bool):
            raise ParameterError(f"{value!r} is not allowed; it must be true or false")
        return "true" if value else "false"
    if kind == "text":
        if not isinstance(value, str) or len(value) > LONGEST_TEXT or not value.replace("\n", " ").isprintable():
            raise ParameterError(f"the value must be a text of at most {LONGEST_TEXT} printable characters")
        return value.strip()
    text = " ".join(repr(v + 0.0).removesuffix(".0") for v in numbers_of(value, least, most))
    allowed = check(about.type, text)
    if allowed:
        raise ParameterError(f"{text!r} is not allowed; {key} must be {allowed}")
    return text
