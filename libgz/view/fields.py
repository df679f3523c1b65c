"""Fields: the numbers that interfaces hold, which pages show and plot."""

from __future__ import annotations

import ctypes
import functools
import itertools
import math
import re
from collections.abc import Iterator
from typing import Any

from libgz.transport.layout import Field, Struct, fields_of
from libgz.view.protocol import LONGEST_NAME

__all__ = ["KEY", "fields_of_interface", "value_of"]

_STEP = r"\w+(?:\[\d{1,5}\]){0,2}"
KEY = re.compile(rf"(?P<type>\w+)\.(?P<id>.+)\.(?P<path>{_STEP}(?:/{_STEP})?)")
LONGEST_PLACE = 12  # characters of a place in an array, in a key
FEW = 4  # numbers of an inner array, which are fields of their own; larger ones are left out
# Arrays of interfaces, and the fields that say how many of their elements are used.
COUNTS = {
    **{"sonar_ranges": "sonar_count", "sonar_pos": "sonar_count", "sonar_rot": "sonar_count"},
    **{"ir_ranges": "ir_count", "ir_pos": "ir_count", "ir_rot": "ir_count"},
    **{"ranges": "range_count", "intensity": "range_count"},
    **{"joints": "joint_count", "fids": "fid_count", "actuators_data": "actuators_count"},
}


def value_of(interface: Any, path: str) -> float | None:
    """A number that an interface holds; None if there is no such field, or it is not finite.

    Args:
        path: a field, such as ``stall``, ``pos[0]``, or ``joints[2]/angle``.
    """
    value, layout = interface.data, interface.layout
    for step in path.split("/"):
        name, *places = re.findall(r"\w+", step)
        field = _fields(layout).get(name) if issubclass(layout, Struct) else None
        if field is None or len(places) != len(field.shape):
            return None
        value, layout = getattr(value, name), field.ctype
        for place, size in zip(map(int, places), field.shape, strict=True):
            if place >= size:
                return None
            value = value[place]
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def fields_of_interface(interface: Any) -> Iterator[dict[str, Any]]:
    """The numbers that an interface holds: of, key, label, unit; whole for integers.

    Those of an array are one: with its count, and `#` for the place in key and label.
    """
    owner = f"{interface.type}.{interface.id}"
    for name, field in _fields(interface.layout).items():
        count, outer = None, ""
        if field.shape:
            used = getattr(interface.data, COUNTS[name], field.shape[0]) if name in COUNTS else field.shape[0]
            count, outer = min(int(used), field.shape[0]) if used > 0 else field.shape[0], "[#]"
        for inner, leaf in _leaves(field, field.shape[1:]):
            label = f"{name}{outer}{inner}"
            found: dict[str, Any] = {"of": owner, "key": f"{owner}.{label}", "label": label, "unit": leaf.unit}
            if leaf.ctype._type_ not in "fd":
                found["whole"] = True
            if count is not None:
                found["count"] = count
            if len(found["key"]) + LONGEST_PLACE <= LONGEST_NAME:
                yield found


def _leaves(field: Field, shape: tuple[int, ...]) -> Iterator[tuple[str, Field]]:
    """The numbers in an element of a field: the path behind it, and their field."""
    if any(size > FEW for size in shape):
        return
    for places in itertools.product(*map(range, shape)):
        path = "".join(f"[{place}]" for place in places)
        if not issubclass(field.ctype, ctypes.Structure):
            yield path, field
            continue
        for name, inner in _fields(field.ctype).items():
            yield from ((f"{path}/{name}{rest}", leaf) for rest, leaf in _leaves(inner, inner.shape))


@functools.lru_cache
def _fields(layout: Any) -> dict[str, Field]:
    """The fields of a struct that are numbers, or structs with numbers; arrays of them have up to two dimensions."""
    return {
        name: field
        for name, field in fields_of(layout).items()
        if len(field.shape) <= 2 and name != "time" and (_is_number(field) or issubclass(field.ctype, ctypes.Structure))
    }


def _is_number(field: Field) -> bool:
    kind = getattr(field.ctype, "_type_", None)
    return isinstance(kind, str) and kind != "c" and field.unit != "byte"
