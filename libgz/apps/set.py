"""libgz set: write fields of an interface, under its lock: libgz set position.robot1 cmd_vel_pos=0.3,0,0."""

from __future__ import annotations

import argparse
import ctypes
import math
from typing import Any

from libgz.apps.target import add_target, connect, find_field, open_target
from libgz.base.errors import ParameterError
from libgz.transport.interface import Interface
from libgz.transport.layout import SERVER, fields_of

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_target(parser)
    help_ = "such as cmd_vel_pos=0.3,0,0 or cmd_vel_rot[2]=0.5; fewer values than the array has set its first elements"
    parser.add_argument("assignments", nargs="+", metavar="FIELD=VALUE", help=help_)
    parser.add_argument("--force", action="store_true", help="also write fields that belong to the server")


def run(options: argparse.Namespace) -> int:
    """Write all fields, or none if one of them is invalid.

    Raises:
        ParameterError: a field or value is not allowed.
        InterfaceError: the server does not serve the interface.
    """
    with connect(options) as client:
        interface = open_target(client, options.target)
        changes = [_change(interface, text, options.force) for text in options.assignments]
        with interface.locked():
            for target, key, values in changes:
                if isinstance(key, int):
                    for i, value in enumerate(values):
                        target[key + i] = value
                else:
                    setattr(target, key, values[0])
    return 0


def _change(interface: Interface[Any], text: str, force: bool) -> tuple[Any, int | str, list[Any]]:
    """The target of an assignment (object, index or attribute), and its values."""
    left, equals, right = text.partition("=")
    if not equals:
        raise ParameterError(f"{text!r} is not an assignment; write FIELD=VALUE")
    name, indices, inner = find_field(interface, left.strip())
    fields = fields_of(type(interface.data))
    field = fields[name]
    if issubclass(field.ctype, ctypes.Structure):
        parts = fields_of(field.ctype)
        if not inner or len(indices) != len(field.shape):
            numbers = ", ".join(f"{name}[0].{part}" for part in parts)
            raise ParameterError(f"{name} holds records; name one of their numbers: {numbers}")
        field = parts[inner]
    if field.writer == SERVER and not force:
        own = [other for other, known in fields.items() if known.writer != SERVER]
        raise ParameterError(
            f"{left} is written by the server; clients write {', '.join(own) or 'nothing here'}"
            " (--force writes it nevertheless)"
        )
    target, key = _place(interface.data, name, indices, inner)
    capacity = 1
    value = getattr(target, key) if isinstance(key, str) else None
    if isinstance(value, ctypes.Array):
        target, key, capacity = value, 0, len(value)
    if field.ctype is ctypes.c_uint8 and capacity > 1:
        return target, 0, list(_text_bytes(right, capacity, left))
    values = [_number(word, field.ctype, left) for word in right.split(",")]
    if not force and not all(map(math.isfinite, values)):
        raise ParameterError(f"{text}: {left} takes finite numbers (--force writes others nevertheless)")
    if len(values) > capacity:
        raise ParameterError(f"{left} takes {capacity} number{'s' if capacity > 1 else ''}; {len(values)} are given")
    return target, key, values


def _place(data: Any, name: str, indices: tuple[int, ...], inner: str) -> tuple[Any, int | str]:
    """The object that holds the value, and its index or attribute."""
    if not indices:
        return data, name
    holder = getattr(data, name)
    for index in indices[:-1]:
        holder = holder[index]
    if inner:
        return holder[indices[-1]], inner
    if isinstance(holder[indices[-1]], ctypes.Array | ctypes.Structure):
        raise ParameterError(f"{name} holds more than a number there; name one of its elements")
    return holder, indices[-1]


def _text_bytes(text: str, capacity: int, name: str) -> bytes:
    content = text.encode() + b"\0"
    if len(content) > capacity:
        raise ParameterError(f"the text for {name} has {len(content) - 1} bytes; {capacity - 1} are allowed")
    return content


def _number(word: str, ctype: Any, name: str) -> float | int:
    """A number that fits the field."""
    whole = ctype not in (ctypes.c_double, ctypes.c_float)
    try:
        value = int(word, 0) if whole else float(word)
    except ValueError:
        raise ParameterError(f"{word!r} is not a {'whole ' if whole else ''}number; {name} takes one") from None
    if whole and ctype(value).value != value:
        raise ParameterError(f"{word} does not fit in {name}, which has {8 * ctypes.sizeof(ctype)} bits")
    return value
