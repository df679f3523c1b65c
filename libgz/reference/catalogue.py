"""The catalogue: a description of each model, made from its declaration and its example world."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from libgz.base.errors import NotFoundError, nearest
from libgz.front import World
from libgz.legacy.factory import ModelFactory
from libgz.legacy.model import CommonAttributes, Model
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CapsuleGeom, CylinderGeom, PlaneGeom, SphereGeom, WheelGeom
from libgz.worldfile.attributes import Attribute, attributes_of, written
from libgz.worldfile.file import WorldFile

__all__ = ["NAMESPACE", "Entry", "Part", "Row", "common_rows", "entries", "entry", "rows_of"]

NAMESPACE = "http://playerstage.sourceforge.net/gazebo/xmlschema/#"
_AROUND = {
    "LightSource": "<model:LightSource>\n  <id>sun</id>\n  <xyz>-5 5 10</xyz>\n</model:LightSource>",
    "GroundPlane": "<model:GroundPlane>\n  <id>ground</id>\n</model:GroundPlane>",
}


@dataclass(frozen=True)
class Row:
    """One attribute, as text."""

    name: str
    type: str
    default: str  # as written in a file; empty for none
    unit: str
    allowed: str
    help: str

    @property
    def meaning(self) -> str:
        """Its meaning and what is allowed."""
        return f"{self.help} ({self.allowed})" if self.allowed and self.type != "bool" else self.help


@dataclass(frozen=True)
class Part:
    """A body or a joint of a model, as text."""

    name: str
    text: str


@dataclass(frozen=True)
class Entry:
    """One model."""

    name: str
    kind: type[Model]

    @property
    def _documentation(self) -> str:
        own = self.kind.__doc__ if "__doc__" in vars(self.kind) else None
        return inspect.cleandoc(own or "A model without a description.")

    @property
    def summary(self) -> str:
        """One line."""
        return self._documentation.partition("\n")[0]

    @property
    def description(self) -> str:
        """The rest of the documentation after the summary; may be empty."""
        return self._documentation.partition("\n")[2].strip()

    @property
    def rows(self) -> list[Row]:
        """Its own attributes."""
        return rows_of(self.kind.attributes)

    @property
    def example(self) -> str:
        """A small world with the model."""
        default = f"<model:{self.name}>\n  <id>{self.name.lower()}1</id>\n</model:{self.name}>"
        own = textwrap.dedent(self.kind.example).strip() or default
        parts = [text for name, text in _AROUND.items() if f"<model:{name}>" not in own]
        body = "\n\n".join(textwrap.indent(text, "  ") for text in [*parts, own])
        return (
            f'<?xml version="1.0"?>\n<gz:world\n  xmlns:gz="{NAMESPACE}gz"\n  xmlns:model="{NAMESPACE}model"\n'
            f'  xmlns:param="{NAMESPACE}param">\n\n{body}\n</gz:world>\n'
        )

    def parts(self) -> tuple[list[Part], list[Part]]:
        """(bodies, joints) of the model in its example world.

        Raises:
            WorldFileError: the example does not load.
        """
        file = WorldFile()
        file.LoadString(self.example, f"example of {self.name}")
        world = World()
        try:
            world.Load(file)
            model = next(m for m in world.models if m.GetName() == self.name)
            bodies = [Part(_name(body), _body_text(body)) for body in model.bodies]
            joints = [
                Part(
                    joint.name or "unnamed",
                    f"{type(joint).__name__} between "
                    + " and ".join("the world" if body is None else _name(body) for body in joint.bodies),
                )
                for joint in model.joints
            ]
            return bodies, joints
        finally:
            world.close()


def entries(factory: ModelFactory | None = None) -> Iterator[Entry]:
    """All models of a factory that are classes, in alphabetical order."""
    factory = factory or ModelFactory()
    for name in factory.names():
        kind = factory.find(name)
        if isinstance(kind, type) and issubclass(kind, Model):
            yield Entry(name, kind)


def entry(name: str) -> Entry:
    """The model of a name, ignoring case.

    Raises:
        NotFoundError: there is none.
    """
    found = {entry.name.lower(): entry for entry in entries()}
    if name.lower() not in found:
        names = [entry.name for entry in found.values()]
        raise NotFoundError(f"there is no model {name!r}; there are {', '.join(names)}{nearest(name, names)}")
    return found[name.lower()]


def rows_of(declaration: type[Any]) -> list[Row]:
    """The attributes of a declaration, as text."""
    defaults = declaration()
    return [
        Row(name, a.type, _default(a, getattr(defaults, name)), a.unit, a.allowed, a.help)
        for name, a in attributes_of(declaration).items()
    ]


def common_rows() -> list[Row]:
    """The attributes of every model."""
    return rows_of(CommonAttributes)


def _default(attribute: Attribute, value: Any) -> str:
    if attribute.by:
        return ", ".join(f"{written(attribute, v)} ({case})" for case, v in attribute.cases.items())
    return written(attribute, value)


def _name(body: Body) -> str:
    return body.bodyName or "unnamed"


def _body_text(body: Body) -> str:
    shapes = [_geom_text(geom) for geom in body.geoms]
    if body.dummy:
        return ", ".join(["only a pose", *shapes])
    return ", ".join([f"{body.mass:.4g} kg", *shapes])


def _geom_text(geom: Geom) -> str:
    """A geom's shape and size."""
    if isinstance(geom, BoxGeom):
        return f"box {' x '.join(f'{v:.4g}' for v in geom.size)} m"
    if isinstance(geom, WheelGeom):
        return f"wheel of radius {geom.radius:.4g} m"
    if isinstance(geom, SphereGeom):
        return f"sphere of radius {geom.radius:.4g} m"
    if isinstance(geom, CylinderGeom | CapsuleGeom):
        shape = "cylinder" if isinstance(geom, CylinderGeom) else "capsule"
        return f"{shape} of radius {geom.radius:.4g} m and length {geom.length:.4g} m"
    if isinstance(geom, PlaneGeom):
        return "infinite plane"
    return type(geom).__name__.removesuffix("Geom").lower()
