"""Declarations of the structs of interfaces: each field once, with its type, unit, writer and meaning.

::

    @layout
    class PowerData(Data):
        \"\"\"Charge of a robot's batteries.\"\"\"

        time: float = double(SERVER, "s", "sim time of this sample")
        levels: Array[float] = double(SERVER, "V", "charge; only the first is used", 10)

`layout` makes a ctypes structure of it, with C's alignment; `gz_data_t head` is the first field of each `Data`.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, ClassVar, NamedTuple, Protocol, TypeVar

import numpy as np

from libgz.base.errors import GazeboError, ParameterError

__all__ = [
    "ABIS",
    "BOTH",
    "CLIENT",
    "GAZEBO_MAX_MODEL_TYPE",
    "I386",
    "LIBGAZEBO_VERSION",
    "NATIVE",
    "SERVER",
    "VERSIONS",
    "Array",
    "Data",
    "Element",
    "Field",
    "GzData",
    "Part",
    "Struct",
    "abi_of",
    "byte",
    "c_name",
    "c_type",
    "char",
    "commands_of",
    "double",
    "elements",
    "fields_of",
    "float32",
    "for_abi",
    "int32",
    "layout",
    "parts_of",
    "uint16",
    "uint32",
]

LIBGAZEBO_VERSION = 0x060
VERSIONS = (0x050, 0x060)  # that a server can announce: Gazebo 0.5, and Gazebo 0.6 and 0.7
GAZEBO_MAX_MODEL_TYPE = 128
# Of the programs that a server serves: those of this machine, and those of 32-bit PCs, where size_t has 4 bytes and
# doubles are aligned to 4 inside structs.
NATIVE, I386 = ABIS = ("x86_64", "i386")

SERVER, CLIENT, BOTH = "S", "C", "S/C"

T_co = TypeVar("T_co", covariant=True)
S = TypeVar("S", bound="type[Struct]")

C_TYPES: dict[Any, str] = {
    ctypes.c_double: "double",
    ctypes.c_float: "float",
    ctypes.c_int32: "int",
    ctypes.c_uint32: "unsigned int",
    ctypes.c_uint16: "uint16_t",
    ctypes.c_uint8: "uint8_t",
    ctypes.c_char: "char",
    ctypes.c_size_t: "size_t",
}


class Array(Protocol[T_co]):
    """A C array of fixed length."""

    def __getitem__(self, index: Any) -> Any:
        """An element, or a list of them for a slice."""

    def __setitem__(self, index: Any, value: Any) -> None:
        """Write an element or a slice."""

    def __len__(self) -> int:
        """The number of elements."""

    def __iter__(self) -> Iterator[T_co]:
        """The elements in order."""


class Field(NamedTuple):
    """One field of a struct."""

    ctype: Any  # of one element
    writer: str  # SERVER, CLIENT or BOTH
    unit: str
    help: str
    shape: tuple[int, ...] = ()
    used: str = ""  # of an array: the 32-bit field that has the number of elements in use

    @property
    def whole_ctype(self) -> Any:
        """The ctypes type of the whole field, arrays included."""
        whole = self.ctype
        for count in reversed(self.shape):
            whole = whole * count
        return whole


def _scalar(ctype: Any) -> Any:
    def declare(writer: str, unit: str, help: str, *shape: int, used: str = "") -> Any:
        return Field(ctype, writer, unit, help, shape, used)

    return declare


double = _scalar(ctypes.c_double)
float32 = _scalar(ctypes.c_float)
int32 = _scalar(ctypes.c_int32)
uint32 = _scalar(ctypes.c_uint32)
uint16 = _scalar(ctypes.c_uint16)
byte = _scalar(ctypes.c_uint8)
char = _scalar(ctypes.c_char)


def elements(kind: type[Element], writer: str, help: str, most: int, used: str = "") -> Any:
    """An array of `most` structs."""
    return Field(kind, writer, "", help, (most,), used)


class Struct(ctypes.Structure):
    """Base of all declared structs. The docstring of each begins with its name in C."""

    __slots__ = ()  # misspelt fields are errors

    declared: ClassVar[dict[str, Field]] = {}  # by name, in order, without the head


class Element(Struct):
    """Base of the structs that are elements of arrays."""

    __slots__ = ()


class GzData(ctypes.Structure):
    """gz_data_t, the head of every interface."""

    __slots__ = ()

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


class GzData32(ctypes.Structure):
    """gz_data_t of 32-bit programs."""

    __slots__ = ()
    _fields_ = [(name, ctypes.c_uint32 if kind is ctypes.c_size_t else kind) for name, kind, *_ in GzData._fields_]


class Data(Struct):
    """Base of the data structs: a head, then the declared fields."""

    __slots__ = ()

    head: GzData

    _fields_ = [("head", GzData)]


def layout(declaration: S) -> S:
    """Turn the declared fields into fields of a ctypes structure.

    Raises:
        ParameterError: no field is declared.
    """
    declared = {name: value for name, value in vars(declaration).items() if isinstance(value, Field)}
    if not declared:
        raise ParameterError(f"{declaration.__name__} declares no field")
    members = {k: v for k, v in vars(declaration).items() if k not in (*declared, "__dict__", "__weakref__")}
    members |= {
        "__slots__": (),  # which only a new class can have
        "_fields_": [(name, spec.whole_ctype) for name, spec in declared.items()],
        "declared": declared,
    }
    metaclass: Any = type(declaration)
    return metaclass(declaration.__name__, declaration.__bases__, members)  # type: ignore[no-any-return]


@lru_cache
def for_abi(struct: type[Any], abi: str) -> type[Any]:
    """The same declaration as a struct of another ABI.

    Args:
        struct: a struct of this machine's.
        abi: one of `ABIS`.

    Raises:
        ParameterError: there is no such ABI.
    """
    if abi == NATIVE:
        return struct
    if abi != I386:
        raise ParameterError(f"ABI is {abi!r}; allowed are {', '.join(ABIS)}")
    declared = {
        name: field._replace(ctype=for_abi(field.ctype, abi)) if issubclass(field.ctype, Struct) else field
        for name, field in fields_of(struct).items()
    }
    head = [("head", GzData32)] if issubclass(struct, Data) else []
    members = {
        "__doc__": struct.__doc__,
        "__module__": struct.__module__,
        "__slots__": (),
        "_pack_": 4,
        "_layout_": "ms",  # without bit fields that means the same, and later Pythons want it said
        "_fields_": [*head, *((name, spec.whole_ctype) for name, spec in declared.items())],
        "declared": declared,
    }
    return type(struct.__name__, (Struct,), members)


def abi_of(head: bytes) -> str:
    """The ABI of a struct, by the first 8 bytes of its file: in that of this machine, nothing follows the version."""
    return I386 if any(head[4:8]) else NATIVE


def fields_of(struct: type[Struct]) -> dict[str, Field]:
    """Name -> declaration of the fields of a struct, without its head."""
    return struct.declared


@lru_cache
def commands_of(struct: type[Struct]) -> tuple[tuple[slice, bool], ...]:
    """Where clients write in a struct: slices of its memory in order, and whether they are text."""
    return tuple((slice(start, end), text) for start, end, text in _commands(struct, 0))


def _commands(struct: type[Struct], origin: int) -> list[tuple[int, int, bool]]:
    found: list[tuple[int, int, bool]] = []
    for name, field in fields_of(struct).items():
        place = getattr(struct, name)
        start, text = origin + place.offset, field.ctype in (ctypes.c_char, ctypes.c_uint8)
        if issubclass(field.ctype, Struct):
            size = ctypes.sizeof(field.ctype)
            for i in range(place.size // size):
                found += _commands(field.ctype, start + i * size)
        elif field.writer == SERVER:
            continue
        elif found and found[-1][1:] == (start, text):
            found[-1] = (found[-1][0], start + place.size, text)
        else:
            found.append((start, start + place.size, text))
    return found


class Part(NamedTuple):
    """Part of a struct: offset and size [byte]; of an array, size of an element, and offset of how many are in use."""

    offset: int
    size: int
    element: int = 0
    used: int = 0


@lru_cache
def parts_of(struct: type[Struct]) -> tuple[Part, ...]:
    """The whole struct in parts: arrays whose number of elements in use it has, and what is between them."""
    found, end = [], 0
    for name, field in fields_of(struct).items():
        if field.used:
            place, used = getattr(struct, name), getattr(struct, field.used)
            element = place.size // field.shape[0]
            found += [Part(end, place.offset - end), Part(place.offset, place.size, element, used.offset)]
            end = place.offset + place.size
    return (*found, Part(end, ctypes.sizeof(struct) - end))


def numpy_type(field: Field) -> Any:
    """The numpy type of one element of a field."""
    return np.dtype(field.ctype)


def c_name(struct: type[Struct]) -> str:
    """The name of a struct in C, without its ending `_t`.

    Raises:
        GazeboError: the docstring of the declaration does not begin with it.
    """
    name = re.match(r"(\w+)_t\b", struct.__doc__ or "")
    if name is None:
        raise GazeboError(f"the docstring of {struct.__name__} must begin with the struct's name in C")
    return name[1]


def c_type(ctype: Any) -> str:
    """The C name of the type of a scalar or of a declared struct."""
    return f"{c_name(ctype)}_t" if issubclass(ctype, Struct) else C_TYPES[ctype]
