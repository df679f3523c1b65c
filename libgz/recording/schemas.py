"""Schemas of what is recorded, so that programs that know nothing of libgz can read the fields.

An interface's bytes are a C struct. They are at the same time a message of ROS 1, whose numbers follow each other
without gaps: the padding of C is declared as bytes. So the exact bytes are recorded once, and are readable.
"""

from __future__ import annotations

import ctypes
from typing import Any

from google.protobuf import descriptor_pb2

from libgz.recording.own_messages import SEPARATOR

__all__ = ["descriptors_of", "struct_schema"]

_ROS = {
    ctypes.c_double: "float64",
    ctypes.c_float: "float32",
    ctypes.c_int32: "int32",
    ctypes.c_int: "int32",
    ctypes.c_uint32: "uint32",
    ctypes.c_uint16: "uint16",
    ctypes.c_uint8: "uint8",
    ctypes.c_char: "uint8",
    ctypes.c_size_t: "uint64",
}


def struct_schema(layout: type[ctypes.Structure]) -> str:
    """The schema of a struct as a message of ROS 1."""
    parts: dict[str, str] = {}
    text = _lines(layout, parts)
    return text + "".join(f"{SEPARATOR}MSG: gz/{name}\n{lines}" for name, lines in parts.items())


def _lines(layout: type[ctypes.Structure], parts: dict[str, str]) -> str:
    """A line for each field, and for each gap before one; `parts` gets the structs inside."""
    lines, end = [], 0
    for base in reversed(layout.__mro__):
        for name, kind, *_ in vars(base).get("_fields_", ()):
            place = getattr(layout, name)
            lines += _gap(end, place.offset)
            counts = []
            while issubclass(kind, ctypes.Array):
                counts.append(kind._length_)
                kind = kind._type_
            total = 1
            for count in counts:
                total *= count
            size = f"[{total}]" if counts else ""
            if issubclass(kind, ctypes.Structure):
                parts.setdefault(kind.__name__, "")
                parts[kind.__name__] = _lines(kind, parts)
                lines.append(f"gz/{kind.__name__}{size} {name}")
            else:
                lines.append(f"{_ROS[kind]}{size} {name}")
            end = place.offset + place.size
    lines += _gap(end, ctypes.sizeof(layout))
    return "\n".join(lines) + "\n"


def _gap(end: int, start: int) -> list[str]:
    return [f"uint8[{start - end}] padding_{end}"] if start > end else []


# Messages of protocol buffers --------------------------------------------------------------------------------------


def descriptors_of(descriptor: Any) -> bytes:
    """The schema of a generated message type: all files that describe it."""
    files = descriptor_pb2.FileDescriptorSet()
    seen: set[str] = set()

    def add(file: Any) -> None:
        if file.name not in seen:
            seen.add(file.name)
            for needed in file.dependencies:
                add(needed)
            file.CopyToProto(files.file.add())

    add(descriptor.file)
    return bytes(files.SerializeToString())
