"""The table of functions that the methods of C++ objects call: each converts its arguments, and calls Python."""

from __future__ import annotations

import ctypes
import logging
from ctypes import CFUNCTYPE, c_char_p, c_double, c_int, c_long, c_uint, c_void_p
from functools import cache
from typing import Any

from libgz.base.errors import ClosedError
from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.cxx import forwards
from libgz.cxx.headers import PARTS, Function, Parameter, functions
from libgz.cxx.host import ended_address, fail, frames_address, offer
from libgz.cxx.objects import OBJECTS, current, known, running

__all__ = ["table"]

log = logging.getLogger("libgz.plugin")

CTYPES: dict[str, Any] = {
    "int": c_int,
    "bool": c_int,
    "uint": c_uint,
    "GLuint": c_uint,
    "double": c_double,
    "float": c_double,
    "long": c_long,
    "object": c_long,
    "text": c_char_p,
    "address": c_void_p,
}
RESULTS: dict[str, Any] = {**CTYPES, "object": c_void_p, "text": c_void_p, "void": None}
# Arguments as Python has them; {0} and so on are the numbers of a struct.
VALUES = {
    "bool": "{name} != 0",
    "object": "known({name})",
    "text": "None if {name} is None else {name}.decode('utf-8', 'surrogateescape')",
    "GzVector": "GzVector({0}, {1}, {2})",
    "GzQuatern": "GzQuatern({0}, {1}, {2}, {3})",
    "GzColor": "GzColor({0}, {1}, {2}, {3})",
    "GzPose": "GzPose(GzVector({0}, {1}, {2}), GzQuatern({3}, {4}, {5}, {6}))",
}
# Results as C has them.
RETURNS = {
    "object": "pointer({call})",
    "text": "text({call})",
    "bool": "1 if {call} else 0",
    "GzPose": "pose = {call}; NUMBERS7(out)[:] = (*pose.pos, *pose.rot)",
    "GzVector": "NUMBERS3(out)[:] = tuple({call})",
    "GzQuatern": "NUMBERS4(out)[:] = tuple({call})",
    "GzColor": "NUMBERS4(out)[:] = tuple({call})",
    "GzTwoVectors": "NUMBERS6(out)[:] = {call}",
}
MADE_ANYWHERE = ("WorldFile_new", "JointGroup_new")  # also at file scope, before there is a model
SOURCE = """
def call({parameters}):
    try:
        {statement}
    except BaseException as error:
        failed(error)
        return {default}
"""


def _text(value: str | None) -> int | None:
    return current().session.text(value)


def _pointer(thing: Any) -> int | None:
    if thing is None:
        return None
    model = current()
    return model.session.pointer(thing, model)


def _failed(error: BaseException) -> None:
    """Keep what was raised for the end of the plugin's method, which ends now."""
    running.failure = ClosedError("this object was deleted") if isinstance(error, KeyError) else error
    if running.model is None:
        log.error("a call of a plugin's own thread failed: %s", running.failure)
    fail()


_NAMES: dict[str, Any] = {
    "current": current,
    "GzColor": GzColor,
    "GzPose": GzPose,
    "GzQuatern": GzQuatern,
    "GzVector": GzVector,
    "NUMBERS3": (c_double * 3).from_address,
    "NUMBERS4": (c_double * 4).from_address,
    "NUMBERS6": (c_double * 6).from_address,
    "NUMBERS7": (c_double * 7).from_address,
    "OBJECTS": OBJECTS,
    "failed": _failed,
    "known": known,
    "pointer": _pointer,
    "text": _text,
}


def _value(parameter: Parameter) -> str:
    """An argument as Python has it."""
    kind, name = parameter.kind, _name(parameter)
    if kind in PARTS:
        return VALUES[kind].format(*(f"{name}_{i}" for i in range(len(PARTS[kind]))))
    return VALUES.get(kind, "{name}").format(name=name)


def _name(parameter: Parameter) -> str:
    """Its name in Python, where `def` is a keyword."""
    return parameter.name if parameter.name == "self" else f"its_{parameter.name}"


def _thunk(function: Function) -> Any:
    """A C function that calls Python."""
    names: list[str] = []
    types: list[Any] = []
    values: list[str] = []
    for parameter in function.parameters:
        if parameter.kind in PARTS:
            names += [f"{_name(parameter)}_{i}" for i in range(len(PARTS[parameter.kind]))]
            types += [c_double] * len(PARTS[parameter.kind])
        else:
            names.append(_name(parameter))
            types.append(CTYPES[parameter.kind])
        values.append(_value(parameter))
    struct = function.result in PARTS
    if struct:
        names.append("out")
        types.append(c_void_p)
    own = dict(_NAMES)
    forward = getattr(forwards, function.name, None)
    if forward is None:
        method = function.name.partition("_")[2]
        call = f"OBJECTS[self].{method}({', '.join(values[1:])})"
    elif function.name == "Object_destroyed":  # its handle is forgotten
        own["forward"] = forward
        call = f"forward(self, {', '.join(values[1:])})"
    else:
        own["forward"] = forward
        values = [
            "OBJECTS[self]" if name == "self" else value for name, value in zip(_own(function), values, strict=True)
        ]
        call = f"forward({', '.join(values)})"
    if function.name.endswith("_new") and function.name not in MADE_ANYWHERE:
        call = f"current() and {call}"  # before it waits for the world, which another thread may hold
    statement = RETURNS.get(function.result, "{call}").format(call=call)
    if not struct and function.result != "void":
        statement = f"return {statement}"
    default = "None" if struct or function.result in ("void", "object", "text", "address") else "0"
    source = SOURCE.format(parameters=", ".join(names), statement=statement, default=default)
    exec(compile(source, f"<{function.name}>", "exec"), own)
    return CFUNCTYPE(None if struct else RESULTS[function.result], *types)(own["call"])


def _own(function: Function) -> list[str]:
    return [parameter.name for parameter in function.parameters]


@cache
def table() -> Any:
    """The table, one for the process; plugins that are loaded later find it."""
    thunks = [_thunk(function) for function in functions()]
    addresses = [ctypes.cast(thunk, c_void_p).value for thunk in thunks]
    first = (frames_address(), ended_address())
    count = 1 + len(first) + len(addresses)
    result: Any = (c_void_p * count)(8 * count, *first, *addresses)
    result.thunks = thunks  # which live as long
    offer(result)
    return result
