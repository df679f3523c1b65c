"""Generates docs/interfaces.md from the declarations.

python -m libgz.interfaces.reference > docs/interfaces.md
"""

from __future__ import annotations

import ctypes
import sys
from typing import Any

from libgz.interfaces.catalog import INTERFACES
from libgz.interfaces.gripper import GripperDataCvs
from libgz.transport.interface import Interface
from libgz.transport.layout import Field, GzData, Struct, c_type, fields_of

__all__ = ["reference"]

INTRODUCTION = """\
# Interfaces

<!-- Generated from the declarations in interfaces/ by `python -m libgz.interfaces.reference`; edit those instead. -->

A model publishes its data in interfaces and receives commands through them. Each interface is one file of shared
memory, `$TMP/gazebo-$USER-<server id>/<type>.<id>`, that contains one C struct. The default of `TMP` is `/tmp`, that of
`USER` is `nobody`; both must be the same for the server and its clients. Lengths are in metres, angles in radians,
times in seconds.

**Writer** in the tables: S the server, C clients, S/C both. A command holds until the next one: when a client dies, its
robot continues to drive. The server checks what clients write: it ignores NaN and infinities and clamps large numbers,
with a warning.

## From Python

<!-- run with: gazebo pioneer2at -->
```python
import libgz

with libgz.Client(server_id=0, client_id=0) as client:  # 0 to 7, one for each program
    robot = client.position("robot1")
    robot.command(vx=0.2)
    while client.wait(timeout=1.0):  # until something has new data
        print(robot.pose)
```

Arrays are numpy views of the shared memory, not copies. Read several fields that must be consistent under the lock:
`with robot.locked() as data: ...`.

Programs for the old Python module need one changed line, `import libgz as gazebo` or `from libgz import *`: all
functions `gz_<type>_alloc, open, lock, unlock, close, free ...`, `gz_client_*`, `gz_server_*`, `gz_error_*` and the
constants of the C header are names of `libgz`, and `.data` is the struct.

## From C and C++

    cc old_client.c $(libgz config --cflags --libs)

compiles against the `gazebo.h` of libgz, version 0x060, and links the C library, which `libgz config` compiles from its
sources at the first call. Programs linked with the old library work, too. `-DGAZEBO_GRIPPER_CVS` selects the gripper
struct of late 2006, which a Pioneer2Gripper with `<laterInterface>true</laterInterface>` serves. Servers can be written
in C, too: `gz_server_init`, `gz_<type>_create`.

## From the shell

    libgz interfaces                                  lists the server's interfaces
    libgz echo position.robot1                        prints samples; --json for programs, --once, --count N, --rate HZ
    libgz echo position.robot1 pos --seconds 10 --plot path.png
    libgz set position.robot1 cmd_vel_pos=0.3,0,0
    libgz clean                                       removes stale files and semaphores of dead servers

## Waiting, locks, end of the server

Every post wakes all clients, as in the old server: the server posts at the end of each step, paused steps included, and
cameras, lasers, pan-tilt units, stereo heads, GPS receivers and observers post whenever they have new data. **Waits
therefore do not count steps**: in a world with devices one step may wake a client several times, and several posts
between two waits wake it once, so that 500 waits may take 90 steps or 500. The field `time` of an interface shows
whether its data are new, `sim_time` of the interface `sim` how far the simulation is.

Clients sleep on a set of sixteen System V semaphores, one for each client id. A semaphore is a flag, not a count; the
first wait of a new client may return at once. Locks are `flock` on the interface's file. A server waits 20 ms for a
lock that a client holds, then skips that interface in this step.

When a server ends, waiting clients get an error (`ServerGoneError`, -1 in C); so they do when a new server replaces one
that crashed. They must connect and open their interfaces again.

## Version 0x050

`gazebo --wire-version 0x050` and `World(wire_version=0x050)` serve clients of Gazebo 0.5: files announce that version,
and truth and camera have the structs of that version. libgz's own clients read the version from the file.

Versions before 0x050, those of Gazebo 0.4 and older, are not supported: they had other structs, server ids that were
text, and no semaphores.

## 32-bit programs

In programs of 32-bit PCs (i386) `size_t` has 4 bytes and doubles are aligned to 4 inside structs, so that all structs
differ.

    gazebo --abi i386 WORLD
    cc client.c $(libgz config --m32)

`gazebo --abi i386` and `World(abi="i386")` serve such programs, among them binaries of the time; `libgz config --m32`
compiles the C library for them (`apt-get install gcc-multilib`). A server serves one ABI. A C program of the other one
gets an error that names both; clients in Python open either. The tables below have offsets of 64-bit programs.

## Build systems, Player

    libgz config --install ~/gazebo
    export PKG_CONFIG_PATH=~/gazebo/lib/pkgconfig
    ./configure

writes `include/gazebo.h`, `lib/libgazebo.a`, `lib/libgazebo.so.0` with its link `libgazebo.so`, and
`lib/pkgconfig/gazebo.pc`, version 0.7.0, below a directory, `/usr/local` for example. `pkg-config gazebo` and tests for
`gz_client_wait` in the library `gazebo` then succeed, as in the configure scripts of Player. Programs find the shared
library there without `LD_LIBRARY_PATH` if they are linked with what pkg-config prints.

Player tests the version that a server announces, and refuses to run with another one than that of its header:

| Player | wants | `V` |
|---|---|---|
| 1.6.5 and older | truth as Euler angles, which 0x060 does not have | 0x050 |
| 1.6.5 and older, without truth | either version | 0x050 or 0x060 |
| 2.0, and CVS of 2006 | truth as quaternions | 0x060, the default |

    libgz config --install ~/gazebo --wire-version V
    gazebo --wire-version V WORLD

A Player that was compiled with an old Gazebo needs the version of that Gazebo: 0x050 with 0.5, 0x060 with 0.6 and 0.7.
Player 1.6.5 compiled for 0x060 runs, but takes the first numbers of a quaternion for roll, pitch and yaw.

## Adding and removing models

In a world with a `<model:Factory>`, clients write the XML of one model into its string, and the server adds the model:

<!-- run with: gazebo factory -->
```python
import libgz

with libgz.Client(server_id=0) as client:
    factory = client.factory("factory1")
    factory.create_model("<model:Pioneer2AT><id>robot2</id><xyz>3 0 0</xyz></model:Pioneer2AT>")
    factory.delete_model("robot2")  # writes <delete>robot2</delete>
```

The XML may have a root element that declares its prefixes. The server clears the string when it has read it. For XML
that it cannot use, it logs a warning and adds nothing. `<delete>id</delete>` is an extension of libgz: it removes the
model of that id and the models that are attached to it. Models added in this way are not saved.

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


if __name__ == "__main__":
    sys.stdout.write(reference())
