"""What the library shares with Python's side, as C++ made of the declarations there: records, functions of ODE."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Any

from libgz.base.records import ClockRecord, TableRecord
from libgz.ode.context import StepContext
from libgz.ode.lib import declared
from libgz.sdfworld.joint_record import MOST_AXES, PARAMETERS, RANGES, AxisRecord, JointRecord

__all__ = ["FUNCTIONS", "RECORDS", "RowRecord", "shared"]

# Of ODE, that calls of every step use.
FUNCTIONS = (
    "dBodyEnable",
    "dBodyGetAutoDisableFlag",
    "dBodyAddForce",
    "dBodyAddTorque",
    "dBodyAddRelForce",
    "dBodyAddRelTorque",
    "dBodyAddForceAtPos",
    "dBodyAddForceAtRelPos",
    "dJointAddHingeTorque",
    "dJointAddSliderForce",
    "dJointSetHingeParam",
    "dJointSetSliderParam",
    "dJointGetHingeParam",
    "dJointGetSliderParam",
)


class RowRecord(ctypes.Structure):
    """Where the numbers of a view are; addresses are null and rows -1 where there are none."""

    _fields_ = [
        ("tables", ctypes.POINTER(TableRecord)),
        ("clock", ctypes.POINTER(ClockRecord)),
        ("joint", ctypes.POINTER(JointRecord)),
        ("row", ctypes.c_int64),
        ("ends", ctypes.c_int64 * 2),  # of a joint: rows of the bodies that an effort wakes
        ("slides", ctypes.c_int64),  # a joint: it is a slider
        ("framed", ctypes.c_int64),  # a model: its frame is fixed to that body
        ("frame", ctypes.c_double * 7),  # position [m] and rotation there
    ]


RECORDS = (TableRecord, ClockRecord, StepContext, AxisRecord, JointRecord, RowRecord)
_PLAIN = {ctypes.c_double: "double", ctypes.c_int64: "int64_t", ctypes.c_uint64: "uint64_t", ctypes.c_void_p: "void *"}
_OF_ODE = {None: "void", ctypes.c_int: "int", ctypes.c_double: "double", ctypes.c_void_p: "void *"}


def shared() -> str:
    """The C++ of it all."""
    lines = ["#include <cstddef>", "#include <cstdint>", "namespace libgz {"]
    for record in RECORDS:
        lines += _struct(record)
    lines.append("struct Functions {  // of ODE")
    for name in FUNCTIONS:
        result, arguments = declared(name)
        lines.append(f"  {_OF_ODE[result]} (*{name})({', '.join(_OF_ODE[kind] for kind in arguments)});")
    lines += [
        "};",
        "// Parameters of joints that are numbers of ODE: key, number, least and largest value, place in a record.",
    ]
    lines.append("struct Parameter { const char *key; int number; double least, most; int place; };")
    lines.append("static const Parameter PARAMETERS[] = {")
    for place, (key, number) in enumerate(PARAMETERS.items()):
        if key in RANGES:
            least, most = RANGES[key]
            lines.append(f'  {{"{key}", {number}, {least!r}, {most!r}, {MOST_AXES * place}}},')
    lines += ["};", "}"]
    return "\n".join(lines) + "\n"


def _struct(record: type[ctypes.Structure]) -> list[str]:
    """A record; the compiler checks that it is the same."""
    name = record.__name__
    fields: Sequence[tuple[str, Any]] = record._fields_  # type: ignore[assignment]
    lines = [f"struct {name} {{", *(f"  {_member(field, kind)};" for field, kind in fields), "};"]
    checks = [f"offsetof({name}, {field}) == {getattr(record, field).offset}" for field, _ in fields]
    return [*lines, f'static_assert(sizeof({name}) == {ctypes.sizeof(record)} && {" && ".join(checks)}, "layout");']


def _member(name: str, kind: Any) -> str:
    count = ""
    if issubclass(kind, ctypes.Array):
        kind, count = kind._type_, f"[{kind._length_}]"
    text = _PLAIN.get(kind) or f"{kind._type_.__name__} *"
    return f"{text}{'' if text.endswith('*') else ' '}{name}{count}"
