"""Descriptions of the interfaces and their structs in Markdown, made from the declarations."""

from __future__ import annotations

import ctypes
import sys
from typing import Any

from libgz.interfaces.catalog import INTERFACES
from libgz.interfaces.gripper import GripperDataCvs
from libgz.transport.interface import Interface
from libgz.transport.layout import Field, GzData, Struct, c_type, fields_of

__all__ = ["describe", "reference"]

INTRODUCTION = """\
# Structs of the interfaces

<!-- Made by scripts/make_docs.py from the declarations in interfaces/; do not edit. -->

[Interfaces](interfaces.md) explains how they are used. Offsets are those of 64-bit programs.

## The head

The first field of every struct is `gz_data_t head`, 152 bytes, written by the server.
"""

HEAD_HELP = {
    "version": "0x060 or 0x050",
    "size": "size of the whole struct; a client refuses an interface whose struct is smaller than its own",
    "model_type": "class of the model, such as Pioneer2DX",
    "model_id": "number of the model, from 1",
    "parent_model_id": "number of the model it is attached to, or 0",
}


def reference() -> str:
    """The text of the page."""
    lines = [INTRODUCTION, "| offset | bytes | type | field | meaning |", "|---|---|---|---|---|"]
    for name, ctype, *_ in GzData._fields_:
        field = getattr(GzData, name)
        shown = f"char[{field.size}]" if issubclass(ctype, ctypes.Array) else c_type(ctype)
        lines.append(f"| {field.offset} | {field.size} | {shown} | `{name}` | {HEAD_HELP[name]} |")
    for kind in INTERFACES.values():
        lines += ["", *_section(kind)]
    return "\n".join(lines) + "\n"


def describe(type_: str) -> str:
    """The section of one interface; an empty text if there is no such type."""
    kind = INTERFACES.get(type_)
    return "" if kind is None else "\n".join(_section(kind)) + "\n"


def _section(kind: type[Interface[Any]]) -> list[str]:
    """The section of one interface: its description, functions and structs."""
    module = sys.modules[kind.__module__].__doc__ or ""
    about = module.partition(": ")[2].strip()
    verbs = "alloc, free, create, destroy, open, close, lock, unlock" + (", post" if kind.has_post else "")
    lines = [f"## {kind.type}", "", f"{about[:1].upper()}{about[1:]}", ""]
    call = "sim()" if kind.type == "sim" else f"{kind.type}(id)"
    lines += [f"In Python `libgz.{kind.__name__}`, `client.{call}`.", f"In C `gz_{kind.type}_` {verbs}.", ""]
    for field in fields_of(kind.data_class).values():
        if issubclass(field.ctype, Struct):
            lines += [*_table(field.ctype), ""]
    lines += _table(kind.data_class)
    if kind.type == "gripper":
        lines += ["", *_table(GripperDataCvs)]
    for struct in kind.older.values():
        lines += ["", *_table(struct)]
    return lines


def _table(struct: type[Struct]) -> list[str]:
    """The table of one struct, with a row for each field."""
    words = " ".join((struct.__doc__ or "").split()).rstrip(".")
    name, _, more = words.partition(" ")
    more = f": {more}" if more else ""
    lines = [f"`{name.rstrip(':;')}`, {ctypes.sizeof(struct)} bytes{more}", ""]
    lines += ["| offset | bytes | type | field | writer | meaning | unit |", "|---|---|---|---|---|---|---|"]
    for field_name, field in fields_of(struct).items():
        place = getattr(struct, field_name)
        lines.append(
            f"| {place.offset} | {place.size} | {_type(field)} | `{field_name}` | {field.writer} "
            f"| {field.help} | {field.unit} |"
        )
    return lines


def _type(field: Field) -> str:
    return c_type(field.ctype) + "".join(f"[{count}]" for count in field.shape)
