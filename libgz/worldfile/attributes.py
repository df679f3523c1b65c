"""Attributes of a model, declared once: name, type, default, unit, meaning.

A model lists them as a dataclass and reads them in one line::

    @dataclass(frozen=True)
    class BallAttributes:
        radius: float = length(0.021, help="radius of the ball")
        color: GzColor = color(1.0, 0.4, 0.0, help="its colour")

    values = read(BallAttributes, node)

The declaration is what messages, and whatever describes the models, are made from.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from libgz.errors import nearest
from libgz.geometry import DTOR, GzColor, GzPose, GzVector, VectorLike
from libgz.worldfile.node import WorldFileNode
from libgz.worldfile.number import rubbish

__all__ = [
    "Attribute",
    "angle",
    "attributes_of",
    "boolean",
    "choice",
    "color",
    "file",
    "integer",
    "length",
    "lengths",
    "number",
    "numbers",
    "read",
    "rotation",
    "text",
    "vector",
]

T = TypeVar("T")


@dataclass(frozen=True)
class Attribute:
    """One attribute of a model: how it is read, what is allowed, and what it means."""

    type: str  # what a file holds: "number", "angle", "bool", "3 numbers" ...
    unit: str  # in the file
    help: str
    read: Callable[[WorldFileNode, str, Any], Any]
    allowed: str = ""  # in words
    check: Callable[[Any], bool] | None = None


def _field(default: Any, attribute: Attribute) -> Any:
    metadata = {"attribute": attribute}
    if isinstance(default, GzColor | GzVector | GzPose):
        return dataclasses.field(default_factory=lambda: dataclasses.replace(default), metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def _limits(above: float | None, least: float | None, most: float | None) -> tuple[str, Callable[[float], bool] | None]:
    """Words and test for a range."""
    words = [f"above {above:g}"] if above is not None else []
    words += [f"at least {least:g}"] if least is not None else []
    words += [f"at most {most:g}"] if most is not None else []
    if not words:
        return "", None
    low, high = (-math.inf if least is None else least), (math.inf if most is None else most)
    return " and ".join(words), lambda v: low <= v <= high and (above is None or v > above)


def number(
    default: float,
    *,
    unit: str = "",
    help: str,
    above: float | None = None,
    least: float | None = None,
    most: float | None = None,
) -> float:
    """A number."""
    allowed, check = _limits(above, least, most)
    return _field(default, Attribute("number", unit, help, WorldFileNode.GetDouble, allowed, check))  # type: ignore[no-any-return]


def length(default: float, *, help: str, above: float | None = None, least: float | None = None) -> float:
    """A length [m]."""
    return number(default, unit="m", help=help, above=above, least=least)


def integer(default: int, *, unit: str = "", help: str, least: int | None = None, most: int | None = None) -> int:
    """A whole number."""
    allowed, check = _limits(None, least, most)
    return _field(default, Attribute("whole number", unit, help, WorldFileNode.GetInt, allowed, check))  # type: ignore[no-any-return]


def angle(default_degrees: float, *, help: str, above: float | None = None, most: float | None = None) -> float:
    """An angle: degrees in the file and in this declaration, radians once read."""
    allowed, check = _limits(above, None, most)
    in_degrees = None if check is None else lambda radians: check(math.degrees(radians))
    attribute = Attribute("angle", "deg", help, WorldFileNode.GetAngle, f"{allowed} deg" if allowed else "", in_degrees)
    return _field(DTOR(default_degrees), attribute)  # type: ignore[no-any-return]


def boolean(default: bool, *, help: str) -> bool:
    """True or false."""
    return _field(default, Attribute("bool", "", help, WorldFileNode.GetBool, "true or false"))  # type: ignore[no-any-return]


def text(default: str, *, help: str) -> str:
    """A word."""
    return _field(default, Attribute("text", "", help, _read_text))  # type: ignore[no-any-return]


def _read_text(node: WorldFileNode, key: str, default: str) -> str:
    return (node.GetString(key, default) or "").strip()


def choice(default: str, allowed: tuple[str, ...], *, help: str) -> str:
    """One of several words."""
    words = f"one of {', '.join(allowed)}"
    return _field(default, Attribute("word", "", help, _read_text, words, allowed.__contains__))  # type: ignore[no-any-return]


def color(r: float, g: float, b: float, a: float = 1.0, *, help: str) -> GzColor:
    """Red, green, blue and perhaps alpha."""
    return _field(GzColor(r, g, b, a), Attribute("colour", "", help, WorldFileNode.GetColor))  # type: ignore[no-any-return]


def vector(default: VectorLike, *, unit: str = "m", help: str) -> GzVector:
    """Three numbers."""
    return _field(GzVector(*default), Attribute("3 numbers", unit, help, WorldFileNode.GetPosition))  # type: ignore[no-any-return]


def rotation(*, help: str) -> GzPose:
    """Roll, pitch and yaw in degrees; a pose without a position once read."""
    return _field(GzPose(), Attribute("3 angles", "deg", help, _read_rotation))  # type: ignore[no-any-return]


def _read_rotation(node: WorldFileNode, key: str, default: GzPose) -> GzPose:
    return GzPose(GzVector(), node.GetRotation(key, default.rot))


def numbers(
    *default: float,
    unit: str = "",
    help: str,
    above: float | None = None,
    least: float | None = None,
) -> tuple[float, ...]:
    """Several numbers; those that a file leaves out have their defaults."""
    allowed, check = _limits(above, least, None)
    test = None if check is None else lambda values: all(map(check, values))
    kind = f"{len(default)} numbers"
    return _field(tuple(default), Attribute(kind, unit, help, _read_numbers, allowed and f"{allowed} each", test))  # type: ignore[no-any-return]


def lengths(*default: float, help: str) -> tuple[float, ...]:
    """Several lengths [m], each above zero."""
    return numbers(*default, unit="m", help=help, above=0.0)


def _read_numbers(node: WorldFileNode, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(node.GetTupleDouble(key, i, value) for i, value in enumerate(default))


def file(*, help: str) -> Path | None:
    """A file beside the worldfile, in the current directory, or among the installed worlds."""
    return _field(None, Attribute("file", "", help, _read_file))  # type: ignore[no-any-return]


def _read_file(node: WorldFileNode, key: str, default: None) -> Path | None:
    found = node.SearchFilename(key, str(installed_worlds()))
    return Path(found) if found else default


def installed_worlds() -> Path:
    """Where the ready worlds and their pictures are installed."""
    spec = importlib.util.find_spec("libgz.worlds")
    return Path(spec.origin).parent if spec is not None and spec.origin is not None else Path()


def attributes_of(declaration: type[Any]) -> Mapping[str, Attribute]:
    """Name -> attribute of a declaration, in its order."""
    return {field.name: field.metadata["attribute"] for field in dataclasses.fields(declaration)}


def read(declaration: type[T], node: WorldFileNode) -> T:
    """The attributes of a model's element.

    A value that is not allowed is an error of the worldfile, told with all others after loading; the default stands
    in for it until then.
    """
    defaults = declaration()
    values = {}
    for name, attribute in attributes_of(declaration).items():
        default = getattr(defaults, name)
        value = attribute.read(node, name, default)
        if attribute.check is not None and not attribute.check(value):
            _report(node, name, attribute, value)
            value = default
        values[name] = value
    return declaration(**values)


def _report(node: WorldFileNode, name: str, attribute: Attribute, value: Any) -> None:
    child = node.GetChild(name) or node
    said = child.content.strip() if child is not node else str(value)
    hint = nearest(said, attribute.allowed.removeprefix("one of ").split(", ")) if rubbish(said) else ""
    unit = f" [{attribute.unit}]" if attribute.unit else ""
    child.error(f"{said!r} is not allowed; {name}{unit} must be {attribute.allowed}{hint}")
