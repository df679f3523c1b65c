"""Declaring what an interface carries: each field once, with its type, unit, writer and meaning.

::

    @layout
    class PowerData(Data):
        \"\"\"Charge of a robot's batteries.\"\"\"

        time: float = double(SERVER, "s", "sim time of this sample")
        levels: Array[float] = double(SERVER, "V", "charge; only the first is used", 10)

`layout` makes the ctypes structure of it, with C's own alignment; `gz_data_t head` comes first in every one.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

import numpy as np

from libgz.errors import ParameterError

__all__ = [
    "BOTH",
    "CLIENT",
    "GAZEBO_MAX_MODEL_TYPE",
    "LIBGAZEBO_VERSION",
    "SERVER",
    "VERSIONS",
    "Array",
    "Data",
    "Element",
    "Field",
    "GzData",
    "byte",
    "char",
    "double",
    "elements",
    "fields_of",
    "float32",
    "int32",
    "layout",
    "uint16",
    "uint32",
]

LIBGAZEBO_VERSION = 0x060
VERSIONS = (0x050, 0x060)  # that a server can announce: those of Gazebo 0.5, and of 0.6 and 0.7
GAZEBO_MAX_MODEL_TYPE = 128

SERVER, CLIENT, BOTH = "S", "C", "S/C"

T_co = TypeVar("T_co", covariant=True)
S = TypeVar("S", bound=type)


_DECLARED: dict[type, dict[str, Field]] = {}


class Array(Protocol[T_co]):
    """A C array: indexed and sliced, of fixed length."""

    def __getitem__(self, index: Any) -> Any:
        """An element, or a list of them for a slice."""

    def __setitem__(self, index: Any, value: Any) -> None:
        """Write an element or a slice."""

    def __len__(self) -> int:
        """How many elements."""

    def __iter__(self) -> Iterator[T_co]:
        """The elements in order."""


@dataclass(frozen=True)
class Field:
    """One field of a struct."""

    ctype: Any  # of one element
    writer: str  # SERVER, CLIENT or BOTH
    unit: str
    help: str
    shape: tuple[int, ...] = ()

    @property
    def whole_ctype(self) -> Any:
        """The ctypes type of the whole field, arrays included."""
        whole = self.ctype
        for count in reversed(self.shape):
            whole = whole * count
        return whole


def _scalar(ctype: Any) -> Any:
    def declare(writer: str, unit: str, help: str, *shape: int) -> Any:
        return Field(ctype, writer, unit, help, shape)

    return declare


double = _scalar(ctypes.c_double)
float32 = _scalar(ctypes.c_float)
int32 = _scalar(ctypes.c_int32)
uint32 = _scalar(ctypes.c_uint32)
uint16 = _scalar(ctypes.c_uint16)
byte = _scalar(ctypes.c_uint8)
char = _scalar(ctypes.c_char)


def elements(kind: type[Element], writer: str, help: str, count: int) -> Any:
    """An array of structs."""
    return Field(kind, writer, "", help, (count,))


class Element(ctypes.Structure):
    """Base of the small structs that stand in arrays."""


class GzData(ctypes.Structure):
    """gz_data_t, the head of every interface."""

    version: int
    size: int
    model_type: bytes
    model_id: int
    parent_model_id: int

    _fields_ = [
        ("version", ctypes.c_int),
        ("size", ctypes.c_size_t),
        ("model_type", ctypes.c_char * GAZEBO_MAX_MODEL_TYPE),
        ("model_id", ctypes.c_int),
        ("parent_model_id", ctypes.c_int),
    ]


class Data(ctypes.Structure):
    """Base of the data structs: a head, then the declared fields."""

    head: GzData

    _fields_ = [("head", GzData)]


def layout(declaration: S) -> S:
    """Turn declared fields into those of a ctypes structure."""
    declared = {name: value for name, value in vars(declaration).items() if isinstance(value, Field)}
    if not declared:
        raise ParameterError(f"{declaration.__name__} declares no field")
    for name in declared:
        delattr(declaration, name)
    setattr(declaration, "_fields_", [(name, spec.whole_ctype) for name, spec in declared.items()])  # noqa: B010
    _DECLARED[declaration] = declared
    return declaration


def fields_of(data: type[ctypes.Structure]) -> dict[str, Field]:
    """Name -> declaration of the fields of a struct, without its head."""
    return _DECLARED[data]


def numpy_type(field: Field) -> Any:
    """The numpy type of one element of a field."""
    return np.dtype(field.ctype)
