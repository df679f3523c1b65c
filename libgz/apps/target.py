"""Shared by the commands for interfaces: the server, the interface and its fields on the command line."""

from __future__ import annotations

import argparse
import ctypes
import re
from collections.abc import Iterator
from typing import Any

from libgz.base.errors import ParameterError, nearest
from libgz.interfaces.catalog import new_interface
from libgz.interfaces.client import Client
from libgz.transport.interface import Interface
from libgz.transport.layout import Struct, fields_of

__all__ = ["add_server", "add_target", "connect", "element_values", "find_field", "open_target", "unit_of", "values_of"]

LONGEST = 16  # elements; longer arrays, such as images, are not printed as text
ELEMENT = re.compile(r"(\w+)((?:\[\d+\])*)((?:\.\w+)?)")

# Arrays whose number of valid elements is in another field.
COUNTED = {
    "actuators_data": "actuators_count",
    "fids": "fid_count",
    "intensity": "range_count",
    "ir_pos": "ir_count",
    "ir_ranges": "ir_count",
    "ir_rot": "ir_count",
    "joints": "joint_count",
    "links": "link_count",
    "ranges": "range_count",
    "sonar_pos": "sonar_count",
    "sonar_ranges": "sonar_count",
    "sonar_rot": "sonar_count",
}


def add_server(parser: argparse.ArgumentParser) -> None:
    """Add the option for the server's id."""
    parser.add_argument("-s", dest="server_id", metavar="ID", type=int, default=0, help="server id (default 0)")


def add_target(parser: argparse.ArgumentParser) -> None:
    """Add the arguments for the server and the interface."""
    add_server(parser)
    parser.add_argument("target", metavar="TYPE.ID", help="an interface, such as position.robot1; sim is sim.default")


def connect(options: argparse.Namespace, client_id: int = -1) -> Client:
    """A client of the server given on the command line.

    Raises:
        ServerError: there is no such server.
    """
    return Client(options.server_id, client_id)


def open_target(client: Client, target: str) -> Interface[Any]:
    """The interface given on the command line.

    Raises:
        ParameterError: there is no such type.
        InterfaceError: the server does not serve it.
    """
    kind, dot, name = target.partition(".")
    interface = new_interface(kind)
    if not dot and kind != "sim":
        raise ParameterError(f"{target!r} has no id; write TYPE.ID{client.hint(kind, '')}")
    return client.open(interface, name if dot else "default")


def values_of(interface: Interface[Any], *, everything: bool = False) -> dict[str, Any]:
    """Field -> plain value, read together under the lock. Counted arrays are as long as their count says.

    Without `everything`, long arrays are left out.
    """
    values: dict[str, Any] = {}
    with interface.locked() as data:
        for name, field in fields_of(type(data)).items():
            count = field.shape[0] if field.shape else 0
            if name in COUNTED:
                count = max(0, min(count, getattr(data, COUNTED[name])))
            elif count > LONGEST and field.ctype is ctypes.c_uint8 and not everything:
                continue
            elif count > LONGEST and not everything:
                count = 0
            values[name] = _plain(getattr(data, name), count)
    return values


def _plain(value: Any, count: int | None = None) -> Any:
    """Numbers, text, lists and dictionaries out of C's."""
    if isinstance(value, bytes):
        return value.decode(errors="replace")
    if isinstance(value, Struct):
        return {name: _plain(getattr(value, name)) for name in fields_of(type(value))}
    if isinstance(value, ctypes.Array):
        return [_plain(item) for item in value[: len(value) if count is None else count]]
    return value


def find_field(interface: Interface[Any], text: str) -> tuple[str, tuple[int, ...], str]:
    """A field on the command line, ``pos``, ``pos[0]`` or ``joints[2].angle``: its name, indices, and inner field.

    Raises:
        ParameterError: there is no such field or element.
    """
    fields = fields_of(type(interface.data))
    match = ELEMENT.fullmatch(text)
    name = match[1] if match else text
    if match is None or name not in fields:
        label = f"{interface.type}.{interface.id}"
        raise ParameterError(f"{label} has no field {text!r}; it has {', '.join(fields)}{nearest(name, fields)}")
    field, indices = fields[name], tuple(int(word) for word in re.findall(r"\d+", match[2]))
    if len(indices) > len(field.shape) or any(i >= n for i, n in zip(indices, field.shape, strict=False)):
        extent = "".join(f"[{n}]" for n in field.shape)
        raise ParameterError(f"there is no {text!r}; the field is {name}{extent}")
    inner = match[3].lstrip(".")
    if inner and (not issubclass(field.ctype, ctypes.Structure) or inner not in fields_of(field.ctype)):
        raise ParameterError(f"there is no {text!r}; {name} has no member {inner!r}")
    return name, indices, inner


def element_values(data: Any, place: tuple[str, tuple[int, ...], str]) -> Iterator[float]:
    """The numbers at a place that `find_field` found, all of them where it is an array."""
    name, indices, inner = place
    value = getattr(data, name)
    for index in indices:
        value = value[index]
    yield from _numbers(getattr(value, inner) if inner else value)


def unit_of(data: Any, place: tuple[str, tuple[int, ...], str]) -> str:
    """The unit of the numbers at a place."""
    name, _, inner = place
    field = fields_of(type(data))[name]
    return (fields_of(field.ctype)[inner] if inner else field).unit


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, ctypes.Array):
        for item in value:
            yield from _numbers(item)
    elif isinstance(value, int | float):
        yield float(value)
    else:
        raise ParameterError("the field is not numeric")
