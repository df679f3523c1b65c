"""Attributes of a model, declared once: name, type, default, unit, meaning.

A model lists them as a dataclass and reads them in one line::

    @dataclass(frozen=True)
    class BallAttributes:
        radius: float = length(0.021, help="radius of the ball")
        color: GzColor = color(1.0, 0.4, 0.0, help="its colour")

    values = read(BallAttributes, node)

Messages, reference pages and the grammar are made from the declaration.
"""

from __future__ import annotations

import copy
import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar, dataclass_transform

from libgz.base.errors import nearest
from libgz.base.files import installed_worlds
from libgz.base.geometry import DTOR, RTOD, GzColor, GzPose, GzQuaternToEuler, GzVector, VectorLike
from libgz.worldfile.node import LARGEST, WorldFileNode
from libgz.worldfile.number import malformed

__all__ = [
    "Attribute",
    "Limits",
    "NoAttributes",
    "angle",
    "attributes_of",
    "boolean",
    "choice",
    "color",
    "declaration",
    "file",
    "integer",
    "length",
    "lengths",
    "lengths_by",
    "number",
    "numbers",
    "read",
    "rotation",
    "text",
    "vector",
    "written",
]

T = TypeVar("T")


class Limits(NamedTuple):
    """The range of a number, in the file's unit; None where there is no limit."""

    above: float | None = None
    least: float | None = None
    most: float | None = None

    def __str__(self) -> str:
        words = [f"above {self.above:g}"] if self.above is not None else []
        words += [f"at least {self.least:g}"] if self.least is not None else []
        words += [f"at most {self.most:g}"] if self.most is not None else []
        return " and ".join(words)

    @property
    def check(self) -> Callable[[float], bool] | None:
        """A test for the range; None if everything is allowed."""
        if self == NO_LIMITS:
            return None
        above, low = self.above, -math.inf if self.least is None else self.least
        high = math.inf if self.most is None else self.most
        return lambda v: low <= v <= high and (above is None or v > above)


NO_LIMITS = Limits()


class Attribute(NamedTuple):
    """One attribute of a model: how it is read, what is allowed, and what it means."""

    type: str  # what a file holds: "number", "angle", "bool", "3 numbers" ...
    unit: str  # in the file
    help: str
    read: Callable[[WorldFileNode, str, Any], Any]
    allowed: str = ""  # in words
    check: Callable[[Any], bool] | None = None
    limits: Limits = NO_LIMITS
    infinite: int = 0  # how many of its numbers, the first ones, may be `inf`
    words: tuple[str, ...] = ()  # the only values allowed
    by: str = ""  # an earlier attribute on which the default depends
    cases: Mapping[str, Any] = MappingProxyType({})  # values of that attribute -> defaults


def _initialize(self: Any, **values: Any) -> None:
    for field in dataclasses.fields(self):
        default = field.default if field.default_factory is MISSING else field.default_factory()
        object.__setattr__(self, field.name, values.pop(field.name, default))
    if values:
        raise TypeError(f"{type(self).__name__} has no attribute {', '.join(values)}")


def _equal(self: Any, other: object) -> bool:
    return vars(self) == vars(other) if type(self) is type(other) else NotImplemented


def _text(self: Any) -> str:
    return f"{type(self).__qualname__}({', '.join(f'{name}={value!r}' for name, value in vars(self).items())})"


@dataclass_transform(frozen_default=True, kw_only_default=True)
def declaration(kind: type[T]) -> type[T]:
    """`dataclass(frozen=True)`, which would compile these methods for each class, at every start."""
    made: Any = dataclass(frozen=True, init=False, repr=False, eq=False)(kind)
    made.__init__, made.__eq__, made.__hash__, made.__repr__ = _initialize, _equal, None, _text
    return kind


@declaration
class NoAttributes:
    """A model without attributes of its own."""


def _field(default: T, attribute: Attribute) -> T:
    metadata = {"attribute": attribute}
    if isinstance(default, GzColor | GzVector | GzPose):  # mutable: each object has its own
        return dataclasses.field(default_factory=lambda: copy.copy(default), metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


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
    limits = Limits(above, least, most)
    attribute = Attribute("number", unit, help, WorldFileNode.GetDouble, str(limits), limits.check, limits)
    return _field(default, attribute)


def length(default: float, *, help: str, above: float | None = None, least: float | None = None) -> float:
    """A length [m]."""
    return number(default, unit="m", help=help, above=above, least=least)


def integer(default: int, *, unit: str = "", help: str, least: int | None = None, most: int | None = None) -> int:
    """A whole number."""
    limits = Limits(None, least, most)
    attribute = Attribute("whole number", unit, help, WorldFileNode.GetInt, str(limits), limits.check, limits)
    return _field(default, attribute)


def angle(default_degrees: float, *, help: str, above: float | None = None, most: float | None = None) -> float:
    """An angle: degrees in the file and in this declaration, radians once read."""
    limits = Limits(above, None, most)
    allowed, check = str(limits), limits.check
    in_degrees = None if check is None else lambda radians: check(math.degrees(radians))
    words = f"{allowed} deg" if allowed else ""
    attribute = Attribute("angle", "deg", help, WorldFileNode.GetAngle, words, in_degrees, limits)
    return _field(DTOR(default_degrees), attribute)


def boolean(default: bool, *, help: str) -> bool:
    """True or false."""
    return _field(default, Attribute("bool", "", help, WorldFileNode.GetBool, "true or false"))


def text(default: str, *, help: str) -> str:
    """A word."""
    return _field(default, Attribute("text", "", help, _read_text))


def _read_text(node: WorldFileNode, key: str, default: str) -> str:
    return (node.GetString(key, default) or "").strip()


def choice(default: str, allowed: tuple[str, ...], *, help: str) -> str:
    """One of several words."""
    words = f"one of {', '.join(allowed)}"
    attribute = Attribute("word", "", help, _read_text, words, allowed.__contains__, words=allowed)
    return _field(default, attribute)


def color(r: float, g: float, b: float, a: float = 1.0, *, help: str) -> GzColor:
    """Red, green, blue and optionally alpha."""
    return _field(GzColor(r, g, b, a), Attribute("colour", "", help, WorldFileNode.GetColor))


def vector(default: VectorLike, *, unit: str = "m", help: str) -> GzVector:
    """Three numbers."""
    return _field(GzVector(*default), Attribute("3 numbers", unit, help, WorldFileNode.GetPosition))


def rotation(*, help: str) -> GzPose:
    """Roll, pitch and yaw in degrees; a pose without a position once read."""
    return _field(GzPose(), Attribute("3 angles", "deg", help, _read_rotation))


def _read_rotation(node: WorldFileNode, key: str, default: GzPose) -> GzPose:
    return GzPose(GzVector(), node.GetRotation(key, default.rot))


def numbers(
    *default: float,
    unit: str = "",
    help: str,
    above: float | None = None,
    least: float | None = None,
    infinite: int = 0,
) -> tuple[float, ...]:
    """Several numbers; a file may omit the last ones, which keep their defaults. `infinite` of them may be `inf`."""
    limits = Limits(above, least, None)
    allowed, test = _each(limits)
    attribute = Attribute(f"{len(default)} numbers", unit, help, _read_numbers, allowed, test, limits, infinite)
    return _field(tuple(default), attribute)


def _each(limits: Limits) -> tuple[str, Callable[[Any], bool] | None]:
    """Description and test for several numbers, each within the limits."""
    check = limits.check
    return ("", None) if check is None else (f"{limits} each", lambda values: all(map(check, values)))


def lengths(*default: float, help: str) -> tuple[float, ...]:
    """Several lengths [m], each above zero."""
    return numbers(*default, unit="m", help=help, above=0.0)


def lengths_by(by: str, cases: Mapping[str, tuple[float, ...]], *, help: str) -> tuple[float, ...]:
    """Several lengths [m], each above zero; their count and defaults depend on another attribute.

    Args:
        by: name of an attribute declared before this one, whose value is a word.
        cases: that word -> defaults.
        help: their meaning.
    """
    counts = sorted({len(default) for default in cases.values()})
    kind = f"{counts[0]} to {counts[-1]} numbers" if len(counts) > 1 else f"{counts[0]} numbers"
    limits = Limits(above=0.0)
    attribute = Attribute(kind, "m", help, _read_numbers, *_each(limits), limits, by=by, cases=cases)
    return _field((), attribute)


def _read_numbers(node: WorldFileNode, key: str, default: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(node.GetTupleDouble(key, i, value) for i, value in enumerate(default))


def file(*, help: str) -> Path | None:
    """A file beside the worldfile, in the current directory, or among the installed worlds."""
    return _field(None, Attribute("file", "", help, _read_file))


def _read_file(node: WorldFileNode, key: str, default: None) -> Path | None:
    installed = installed_worlds()
    found = node.SearchFilename(key, str(installed))
    if found is None:
        return default
    name = (node.GetString(key) or "").strip()
    wanted = Path(node.ResolveFilename(name))
    # Text that is not from a file, and the worlds of libgz, mean its files.
    if node.file.filename and Path(found) == installed / name and wanted.resolve() != Path(found).resolve():
        place = node.GetChild(key) or node
        place.warn(f"file {str(wanted)!r} does not exist; {found!r} is used instead")
    return Path(found)


def attributes_of(declaration: type[Any]) -> Mapping[str, Attribute]:
    """Name -> attribute of a declaration, in its order."""
    return {field.name: field.metadata["attribute"] for field in dataclasses.fields(declaration)}


def read(declaration: type[T], node: WorldFileNode) -> T:
    """The attributes of a model's element.

    A value that is not allowed is an error of the worldfile, reported with all others after loading; until then the
    default replaces it.
    """
    defaults = declaration()
    values: dict[str, Any] = {}
    for name, attribute in attributes_of(declaration).items():
        default = attribute.cases[values[attribute.by]] if attribute.by else getattr(defaults, name)
        value = attribute.read(node, name, default)
        if attribute.check is not None and not attribute.check(value):
            _report(node, name, attribute, value)
            value = default
        elif _unusable(value[attribute.infinite :] if attribute.infinite else value):
            (node.GetChild(name) or node).error(f"{name} must be finite, and at most {LARGEST:g}")
            value = default
        values[name] = value
    return declaration(**values)


def _unusable(value: Any) -> bool:
    """Whether a number, or one of several, is infinite or overflows in arithmetic."""
    values = value if isinstance(value, tuple) else (value,)
    return any(isinstance(v, float) and abs(v) > LARGEST for v in values)


def written(attribute: Attribute, value: Any) -> str:
    """A value as a worldfile has it: angles in degrees."""
    if attribute.type == "angle":
        return f"{RTOD(value):.12g}"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, GzPose):
        return " ".join(f"{RTOD(angle) + 0.0:.12g}" for angle in GzQuaternToEuler(value.rot))
    if isinstance(value, GzColor):
        return " ".join(f"{v:g}" for v in (value if value.a != 1.0 else list(value)[:3]))
    if isinstance(value, GzVector | tuple):
        return " ".join(f"{v:.6g}" for v in value)
    if isinstance(value, int | float):
        return f"{value:.12g}"
    return "" if value is None else str(value)


def _report(node: WorldFileNode, name: str, attribute: Attribute, value: Any) -> None:
    child = node.GetChild(name) or node
    text = child.content.strip() if child is not node else str(value)
    hint = nearest(text, attribute.allowed.removeprefix("one of ").split(", ")) if malformed(text) else ""
    unit = f" [{attribute.unit}]" if attribute.unit else ""
    child.error(f"{text!r} is not allowed; {name}{unit} must be {attribute.allowed}{hint}")
