"""LegacyEditor: edits attributes in a worldfile, and builds their models again in the running world."""

from __future__ import annotations

import re
from typing import Any

from libgz.base.errors import NotFoundError, ParameterError, WorldFileError, nearest
from libgz.base.geometry import DTOR, GzPose, GzQuaternFromEuler, GzVector
from libgz.legacy.model import CommonAttributes, Model
from libgz.legacy.origin import to_file, to_world
from libgz.legacy.replacement import Replacement
from libgz.legacy.settings import GlobalAttributes, find_global_nodes, read_global, read_quirks
from libgz.legacy.world import LegacyWorld
from libgz.legacy.world_joints import move_with_world_joints
from libgz.simulation.editor import LONGEST_TEXT, Value, numbers_of
from libgz.simulation.entity import Entity
from libgz.simulation.world import World
from libgz.worldfile.attributes import Attribute, attributes_of, written
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode
from libgz.worldfile.number import atof

__all__ = ["LegacyEditor", "copied_text"]

SETTINGS = b"<param:Global xmlns:param='http://playerstage.sourceforge.net/gazebo/xmlschema/#param'></param:Global>"
PLACE = ("xyz", "rpy")
CODE = "plugin"  # the attribute that names a file to run, which is no value to edit
TYPES = {
    "number": "number",
    "angle": "number",
    "whole number": "integer",
    "bool": "bool",
    "word": "choice",
    "colour": "color",
    "text": "text",
    "file": "text",
}
COUNTS = {"3 numbers": (3, 3), "3 angles": (3, 3), "colour": (3, 4)}


class LegacyEditor:
    """Edits a legacy world; `World.extension(LegacyEditor)` returns it.

    Args:
        world: of Gazebo 0.4 to 0.7.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._era: LegacyWorld = world.extension(LegacyWorld)

    def values(self, entity: Entity | None, part: str = "", kind: str = "") -> list[Value]:
        """The attributes that the class of a model declares, or the settings of the world."""
        if entity is None:
            file = self._file()
            node = next(reversed(find_global_nodes(file)), None)
            return self._values(node or file.GetRootNode(), GlobalAttributes, "world", node is not None)
        model = _model(entity)
        own = attributes_of(model.attributes)
        common = [row for row in self._values(_node(model), CommonAttributes, "model") if row.key not in own]
        rows = [*common, *self._values(_node(model), model.attributes, model.GetName())]
        pose = to_file(model, model.GetPose() if model.parentBody is None else model.relPose)
        for row in rows:
            if row.key == "xyz":
                row.value = list(pose.pos)
            elif row.key == "rpy":
                row.value = [atof(word) for word in written(attributes_of(CommonAttributes)["rpy"], pose).split()]
        return [row for row in rows if row.key != CODE]

    def _values(self, node: WorldFileNode, declaration: type[Any], group: str, given: bool = True) -> list[Value]:
        defaults, found = declaration(), []
        words: dict[str, str] = {}
        for name, attribute in attributes_of(declaration).items():
            text = (node.GetString(name) or "").strip() if given else ""
            default = attribute.cases.get(words.get(attribute.by, "")) if attribute.by else getattr(defaults, name)
            words[name] = text or (default if isinstance(default, str) else "")
            child, limits = node.GetChild(name) if given else None, attribute.limits
            found.append(
                Value(
                    name,
                    name,
                    group,
                    TYPES.get(attribute.type, "vector"),
                    _value(attribute, text or ("" if default is None else written(attribute, default))),
                    text,
                    attribute.unit,
                    limits.least,
                    limits.most,
                    limits.above,
                    list(attribute.words),
                    attribute.help,
                    node.file.label,
                    (child or node).line,
                )
            )
        return found

    def edit(self, entity: Entity | None, part: str, kind: str, key: str, value: Any) -> Entity | None:
        """Change an attribute of a model, which is built again and moves on as it did; or a setting of the world.

        Raises:
            NotFoundError: there is no such attribute.
            GazeboError: the value is not allowed.
        """
        if entity is None:
            self._edit_settings(key, value)
            return None
        model = _model(entity)
        attribute = _declared({**attributes_of(CommonAttributes), **attributes_of(model.attributes)}, key, model)
        text = _text(attribute, value)
        if key in PLACE:
            self._place(model, key, numbers_of(value, 3, 3))
        elif key == "id" and (not text or any(one.GetId() == text for one in self._world.entities if one is not model)):
            raise ParameterError(f"id {text!r} is not allowed; it must be a name that no other model has")
        index, file = _index(model), WorldFile.of(_node(model))
        copy = file.changed()
        copy.models[index].put(key, text)
        self._take(file, copy.changed())
        if key in PLACE:
            return model
        with self._world.hold():
            return Replacement(self._era.loader, model, anew=True).run()

    def embed(self, entity: Entity) -> Entity:
        """Worldfiles include nothing.

        Raises:
            ParameterError: always.
        """
        raise ParameterError(f"{entity.GetId()!r} is in the worldfile; worldfiles include nothing")

    def copy_text(self, entity: Entity) -> str:
        """The text of a model, and of those in it, with ids that no model of the world has."""
        model = _model(entity)
        return copied_text(WorldFile.of(_node(model)), _index(model), {one.GetId() for one in self._world.entities})

    def _file(self) -> WorldFile:
        if self._era.file is None:
            raise WorldFileError("this world was not loaded from a worldfile, so there is nothing to edit")
        return self._era.file

    def _take(self, old: WorldFile, new: WorldFile) -> None:
        self._era.exchange_file(old, new)
        self._world.forget_states()

    def _place(self, model: Model, key: str, numbers: list[float]) -> None:
        """Move a model to the place that its attributes give it."""
        pose = to_file(model, model.GetPose() if model.parentBody is None else model.relPose)
        if key == "xyz":
            pose = GzPose(GzVector(*numbers), pose.rot)
        else:
            pose = GzPose(pose.pos, GzQuaternFromEuler(*map(DTOR, numbers)))
        place = to_world(model, pose)
        if model.parentBody is None:
            move_with_world_joints(model, lambda: self._world.SetModelPose(model, place))
            model.initPose = place
        else:
            self._world.SetModelPose(model, place)

    def _edit_settings(self, key: str, value: Any) -> None:
        attribute = _declared(attributes_of(GlobalAttributes), key, None)
        text, file = _text(attribute, value), self._file()
        copy = file.changed()
        if not find_global_nodes(copy):
            source = copy.text_with(SETTINGS)
            copy = WorldFile()
            copy.LoadString(source, file.label)
            copy.filename = file.filename
        find_global_nodes(copy)[-1].put(key, text)
        new = copy.changed()
        values, fog = read_global(new)
        quirks = read_quirks(new, values.legacyQuirks)
        new.diagnostics.raise_errors()
        self._take(file, new)
        self._world.engine.quirks = quirks
        self._era.apply(values, fog)
        self._world.update_rows_changed()


def _model(entity: Entity) -> Model:
    if not isinstance(entity, Model):
        raise ParameterError(f"{entity.GetId()!r} is no model of a worldfile")
    return entity


def _node(model: Model) -> WorldFileNode:
    if model.node is None:
        raise ParameterError(f"model {model.GetId()!r} was made by code, not from a file; it cannot be edited")
    return model.node


def _index(model: Model) -> int:
    """The number of a model's element among those of its file."""
    node = _node(model)
    return WorldFile.of(node).models.index(node)


def _declared(attributes: dict[str, Attribute] | Any, key: str, model: Model | None) -> Attribute:
    if key not in attributes or key == CODE:
        what = f"model {model.GetId()!r} ({model.GetName()})" if model is not None else "the world"
        raise NotFoundError(f"{what} has no attribute {key!r} to edit{nearest(key, attributes)}")
    found: Attribute = attributes[key]
    return found


def _value(attribute: Attribute, text: str) -> Any:
    """The value of a text, for a page."""
    kind = TYPES.get(attribute.type, "vector")
    if kind in ("vector", "color"):
        return [atof(word) for word in text.split()]
    if kind in ("number", "integer"):
        number = atof(text)
        return int(number) if kind == "integer" else number
    return text.strip().lower() in ("true", "1") if kind == "bool" else text


def _text(attribute: Attribute, value: Any) -> str:
    """The text of a value that a page sends.

    Raises:
        ParameterError: it is not of the attribute's type.
    """
    kind = TYPES.get(attribute.type, "vector")
    if kind in ("vector", "color"):
        most = int(attribute.type.removesuffix(" numbers").split()[-1]) if attribute.type not in COUNTS else 0
        return " ".join(map(_short, numbers_of(value, *COUNTS.get(attribute.type, (1, most)))))
    if kind in ("number", "integer"):
        number = numbers_of(value, 1, 1)[0]
        if kind == "integer" and number != round(number):
            raise ParameterError(f"{value!r} is not allowed; it must be a whole number")
        return _short(number)
    if kind == "bool":
        if not isinstance(value, bool):
            raise ParameterError(f"{value!r} is not allowed; it must be true or false")
        return "true" if value else "false"
    if not isinstance(value, str) or len(value) > LONGEST_TEXT or not value.replace("\n", " ").isprintable():
        raise ParameterError(f"the value must be a text of at most {LONGEST_TEXT} printable characters")
    if attribute.words and value not in attribute.words:
        raise ParameterError(
            f"{value!r} is not allowed; it must be {attribute.allowed}{nearest(value, attribute.words)}"
        )
    return value.strip()


def _short(number: float) -> str:
    """A number as short as it can be written without loss."""
    return repr(number + 0.0).removesuffix(".0")


def copied_text(file: WorldFile, index: int, taken: set[str]) -> str:
    """The text of a worldfile's model, and of those in it, with ids that are not taken.

    Args:
        file: is not changed.
        index: of the model among the file's.
        taken: ids that are not free; those of the copy are added.
    """
    copy = file.changed()
    twin = copy.models[index]
    for each in twin.walk():
        if each.prefix == "model":
            name = _free((each.GetString("id", each.GetName()) or "").strip(), taken)
            taken.add(name)
            each.put("id", name)
    return copy.element_text(twin)


def _free(name: str, taken: set[str]) -> str:
    """A name that is not taken: `box2` for `box1`."""
    stem = re.sub(r"\d+$", "", name) or "model"
    return next(f"{stem}{number}" for number in range(1, len(taken) + 2) if f"{stem}{number}" not in taken)
