"""Writes docs/interfaces.md from the declarations.

python -m libgz.interfaces.reference > docs/interfaces.md
"""

from __future__ import annotations

import ctypes
import sys
from typing import Any

from libgz.interfaces.catalog import INTERFACES
from libgz.interfaces.gripper import GripperDataCvs
from libgz.transport.interface import Interface
from libgz.transport.layout import Field, GzData, fields_of

__all__ = ["reference"]

INTRODUCTION = """\
# Interfaces

<!-- Made from the declarations in interfaces/ by `python -m libgz.interfaces.reference`; edit those instead. -->

A model offers its data in interfaces, and takes commands through them. Each is one file of shared memory,
`$TMP/gazebo-$USER-<server id>/<type>.<id>`, that holds one C struct. `TMP` unset stands for `/tmp`, `USER` unset for
`nobody`; server and clients must agree on both. Lengths are metres, angles radians, times seconds.

**Writer** in the tables: S the server, C clients, S/C both. Commands hold until the next one: a client that dies leaves
its robot driving. What clients write is not trusted: numbers that are none are ignored with a warning, large ones
clamped.

## From Python

```python
import libgz

with libgz.Client(server_id=0, client_id=0) as client:  # 0 to 7, another one for each program that waits
    robot = client.position("robot1")
    robot.command(vx=0.2)
    while client.wait(timeout=1.0):  # once a simulation step
        print(robot.pose)
```

Arrays are numpy views of the shared memory, not copies. Fields that must belong together are read under the lock:
`with robot.locked() as data: ...`.

Programs for the old Python module change one line, `import libgz as gazebo` or `from libgz import *`: all functions
`gz_<type>_alloc, open, lock, unlock, close, free ...`, `gz_client_*`, `gz_server_*`, `gz_error_*` and the constants of
the C header are names of `libgz`, and structs are at `.data`.

## From C and C++

    cc old_client.c $(libgz config --cflags --libs)

compiles against the `gazebo.h` that libgz ships, version 0x060, and links a library made from its sources when it is
first asked for. Programs linked with the old library work, too. `-DGAZEBO_GRIPPER_CVS` picks the gripper struct of
late 2006, which a Pioneer2Gripper with `<laterInterface>true</laterInterface>` serves. Servers can be written as well:
`gz_server_init`, `gz_<type>_create`.

## From the shell

    libgz interfaces                                  what the server offers
    libgz echo position.robot1                        live; --json for programs, --once, --count N, --rate HZ
    libgz echo position.robot1 pos --seconds 10 --plot path.png
    libgz set position.robot1 cmd_vel_pos=0.3,0,0
    libgz clean                                       removes what dead servers left

## Waiting, locks, ends

The server wakes its clients once a step, paused steps included, by a set of sixteen System V semaphores, one for each
client id. A wake-up is a flag, not a count; the first wait of a new client may return at once. Locks are `flock` on the
interface's file. A server waits 20 ms for a lock that a client holds, then goes on without that interface.

When a server ends, waiting clients get an error (`ServerGoneError`, -1 in C); so they do when a server takes the place
of one that crashed. They connect and open again.

## Version 0x050

`gazebo --wire-version 0x050` and `World(wire_version=0x050)` serve clients of Gazebo 0.5: files announce that version,
and truth and camera have the structs that they had then. libgz's own clients see the version in the file.

## Adding and removing models

Where a world has a `<model:Factory>`, clients write the XML of one model into its string, and the model joins the
world:

```python
client.factory("factory1").create_model("<model:Pioneer2AT><id>robot2</id><xyz>3 0 0</xyz></model:Pioneer2AT>")
client.factory("factory1").delete_model("robot2")  # writes <delete>robot2</delete>
```

A text with a root that declares its prefixes is taken, too. The server empties the string when it has taken it. What
it cannot use is a warning on its console, and leaves nothing in the world. `<delete>id</delete>` is libgz's own: it
removes the model of that id and all that is attached to it. Models that came this way are not saved.

## The head

Every struct begins with `gz_data_t head`, 152 bytes, written by the server.
"""

C_NAMES: dict[Any, str] = {
    ctypes.c_double: "double",
    ctypes.c_float: "float",
    ctypes.c_int: "int",
    ctypes.c_uint32: "unsigned int",
    ctypes.c_uint16: "uint16_t",
    ctypes.c_uint8: "uint8_t",
    ctypes.c_char: "char",
    ctypes.c_size_t: "size_t",
}
HEAD_HELP = {
    "version": "0x060 or 0x050",
    "size": "of the whole struct; a client refuses a smaller one than its own",
    "model_type": "class of the model, such as Pioneer2DX",
    "model_id": "number of the model, from 1",
    "parent_model_id": "number of the model it is attached to, or 0",
}


def reference() -> str:
    """The whole page."""
    lines = [INTRODUCTION, "| offset | bytes | type | field | meaning |", "|---|---|---|---|---|"]
    for name, ctype, *_ in GzData._fields_:
        field = getattr(GzData, name)
        c_type = f"char[{field.size}]" if issubclass(ctype, ctypes.Array) else C_NAMES[ctype]
        lines.append(f"| {field.offset} | {field.size} | {c_type} | `{name}` | {HEAD_HELP[name]} |")
    for kind in INTERFACES.values():
        lines += ["", *_section(kind)]
    return "\n".join(lines) + "\n"


def _section(kind: type[Interface[Any]]) -> list[str]:
    """One interface: what it is, its structs, its functions."""
    module = sys.modules[kind.__module__].__doc__ or ""
    about = module.partition(": ")[2].strip()
    verbs = "alloc, free, create, destroy, open, close, lock, unlock" + (", post" if kind.has_post else "")
    lines = [f"## {kind.type}", "", f"{about[:1].upper()}{about[1:]}", ""]
    call = "sim()" if kind.type == "sim" else f"{kind.type}(id)"
    lines += [f"In Python `libgz.{kind.__name__}`, `client.{call}`.", f"In C `gz_{kind.type}_` {verbs}.", ""]
    for field in fields_of(kind.data_class).values():
        if issubclass(field.ctype, ctypes.Structure):
            lines += [*_table(field.ctype), ""]
    lines += _table(kind.data_class)
    if kind.type == "gripper":
        lines += ["", *_table(GripperDataCvs)]
    for struct in kind.older.values():
        lines += ["", *_table(struct)]
    return lines


def _table(struct: type[ctypes.Structure]) -> list[str]:
    """One struct, a row for each field."""
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
    record = issubclass(field.ctype, ctypes.Structure)
    kind = (field.ctype.__doc__ or "").partition(":")[0] if record else C_NAMES[field.ctype]
    return kind + "".join(f"[{count}]" for count in field.shape)


if __name__ == "__main__":
    sys.stdout.write(reference())
