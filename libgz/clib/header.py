"""Writes `gazebo.h` and the list of interfaces that the C library is made of, both from the declarations.

python -m libgz.clib.header        writes them beside this module
"""

from __future__ import annotations

import ctypes
import re
import sys
from textwrap import wrap
from types import ModuleType
from typing import Any

from libgz.clib import FOLDER
from libgz.errors import GazeboError
from libgz.interfaces.catalog import INTERFACES
from libgz.interfaces.gripper import GripperDataCvs
from libgz.transport import layout, legacy, semaphores
from libgz.transport.interface import Interface
from libgz.transport.layout import Field, GzData, fields_of

__all__ = ["c_name", "header", "interface_list", "macros_of"]

# The old library's own words where its names do not follow from the type: an unused head in two handles.
HEADED_HANDLES = frozenset({"actarray", "ptz"})
LATER_GRIPPER = "GAZEBO_GRIPPER_CVS"

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

PREAMBLE = """\
/*
 * libgazebo: reading and commanding the models of a running server.
 *
 * Made from the declarations in interfaces/ by `python -m libgz.clib.header`; edit those instead.
 *
 * Layouts are those of version 0x060 (Gazebo 0.6 and 0.7), with ir and actarray, which came later. Define
 * GAZEBO_GRIPPER_CVS for the gripper struct of late 2006.
 *
 * Functions return 0, or -1 after printing why; gz_error_str gives the reason. Lengths are metres, angles radians,
 * times seconds. [S] marks what the server writes, [C] what clients write. Copyright: Apache License 2.0.
 */

#ifndef GAZEBO_H
#define GAZEBO_H

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#ifdef __cplusplus
extern "C" {
#endif
"""

CORE = """\
/* Errors: print them or not, and information up to a level (1 sessions, 5 files, 9 all). */
extern void gz_error_init(int print, int level);
extern const char *gz_error_str(void);

/* A server: a directory, and the semaphores that wake clients. */
typedef struct gz_server {
    int server_id;
    char *filename; /* of the directory */
    int sem_key;
    int sem_cid;
} gz_server_t;

extern gz_server_t *gz_server_alloc(void);
extern void gz_server_free(gz_server_t *self);
extern int gz_server_init(gz_server_t *self, int server_id, int force);
extern int gz_server_fini(gz_server_t *self);
extern int gz_server_post(gz_server_t *self); /* wakes all clients */

/* A client. Those that wait need an id of their own, 0 to 7. */
typedef struct gz_client {
    int server_id;
    int client_id;
    char *filename; /* of the server's directory */
    int sem_key;
    int sem_cid;
} gz_client_t;

extern gz_client_t *gz_client_alloc(void);
extern void gz_client_free(gz_client_t *self);
extern int gz_client_query(gz_client_t *self, int server_id); /* 0 there, 1 not there, -1 cannot tell */
extern int gz_client_connect(gz_client_t *self, int server_id);
extern int gz_client_connect_wait(gz_client_t *self, int server_id, int client_id);
extern int gz_client_disconnect(gz_client_t *self);
extern int gz_client_wait(gz_client_t *self); /* sleeps until the server posts, once a step */

/* What all data structs begin with. */
{head}

/* A mapped file, whatever struct it holds. */
typedef struct gz_iface {
    gz_server_t *server;
    gz_client_t *client;
    int mmap_fd;
    void *mmap;
    char *filename;
} gz_iface_t;

extern gz_iface_t *gz_iface_alloc(void);
extern void gz_iface_free(gz_iface_t *self);
extern int gz_iface_create(gz_iface_t *self, gz_server_t *server, const char *type, const char *id, size_t size);
extern int gz_iface_destroy(gz_iface_t *self);
extern int gz_iface_open(gz_iface_t *self, gz_client_t *client, const char *type, const char *id, size_t size);
extern int gz_iface_close(gz_iface_t *self);
extern int gz_iface_lock(gz_iface_t *self, int blocking); /* always waits */
extern void gz_iface_unlock(gz_iface_t *self);
extern int gz_iface_post(gz_iface_t *self);
"""

TRUTH_FUNCTIONS = """
/* Fill e with roll, pitch, yaw of q, and q with u, x, y, z of e. */
extern int gz_truth_euler_from_quatern(gz_truth_t *self, double *e, double *q);
extern int gz_truth_quatern_from_euler(gz_truth_t *self, double *q, double *e);
"""


# The library's own function asks for the size of the release's struct.
LATER_GRIPPER_OPEN = f"""
#ifdef {LATER_GRIPPER}
#define gz_gripper_open(self, client, id) \\
    (gz_iface_open((self)->iface, client, "gripper", id, sizeof(gz_gripper_data_t)) != 0 \\
         ? -1 \\
         : ((self)->data = (gz_gripper_data_t *) (self)->iface->mmap, 0))
#endif
"""


def header() -> str:
    """The text of gazebo.h."""
    parts = [PREAMBLE, _macros(), CORE.replace("{head}", _head())]
    parts += [_interface(kind) for kind in INTERFACES.values()]
    parts.append("#ifdef __cplusplus\n}\n#endif\n\n#endif\n")
    return "\n".join(parts)


def interface_list() -> str:
    """The text of interfaces.def, one line for each interface: whether it posts, or belongs to no model."""
    lines = ["/* Made by `python -m libgz.clib.header`. */", ""]
    for name, kind in INTERFACES.items():
        sort = "OWNERLESS" if name == "sim" else "WAKING" if kind.has_post else "SILENT"
        lines.append(f"INTERFACE_{sort}({name}, {c_name(kind.data_class)}_t)")
    return "\n".join(lines) + "\n"


def c_name(struct: type[ctypes.Structure]) -> str:
    """The name of a struct in C, which the declaration's docstring begins with."""
    name = re.match(r"(\w+)_t\b", struct.__doc__ or "")
    if name is None:
        raise GazeboError(f"the docstring of {struct.__name__} must begin with the struct's name in C")
    return name[1]


def macros_of(module: ModuleType) -> dict[str, int]:
    """The constants of a module that C programs know, in its order."""
    prefixes = ("GZ_", "GAZEBO_", "LIBGAZEBO_")
    return {n: v for n, v in vars(module).items() if n.startswith(prefixes) and isinstance(v, int)}


def _macros() -> str:
    lines = [
        f"#define LIBGAZEBO_VERSION {layout.LIBGAZEBO_VERSION:#05x}",
        f"#define GZ_SEM_KEY {semaphores.GZ_SEM_KEY:#x} /* plus the server id: the key of its semaphores */",
        f"#define GAZEBO_MAX_MODEL_TYPE {layout.GAZEBO_MAX_MODEL_TYPE}",
    ]
    lines += [f"#define {name} {value}" for name, value in macros_of(legacy).items()]
    return "\n".join(lines) + "\n"


def _head() -> str:
    lines = ["typedef struct gz_data {"]
    for name, ctype, *_ in GzData._fields_:
        if issubclass(ctype, ctypes.Array):
            lines.append(f"    char {name}[GAZEBO_MAX_MODEL_TYPE];")
        else:
            lines.append(f"    {C_TYPES[ctype]} {name};")
    return "\n".join([*lines, "} gz_data_t;"])


def _interface(kind: type[Interface[Any]]) -> str:
    """Macros, structs and functions of one interface."""
    module = sys.modules[kind.__module__]
    name, data = kind.type, kind.data_class
    title = (module.__doc__ or "").partition(". ")[0].strip().rstrip(".")
    lines = [f"/* {title}. */"]
    lines += [f"#define {macro} {value}" for macro, value in macros_of(module).items()]
    for field in fields_of(data).values():
        if issubclass(field.ctype, ctypes.Structure):
            lines += ["", *_struct(field.ctype, headed=False)]
    if name == "gripper":
        lines += ["", f"#ifdef {LATER_GRIPPER}", *_struct(GripperDataCvs, headed=True)]
        lines += ["#else", *_struct(data, headed=True), "#endif"]
    else:
        lines += ["", *_struct(data, headed=True)]
    lines += ["", *_handle(name, c_name(data)), "", *_functions(kind)]
    return "\n".join(lines) + "\n" + {"truth": TRUTH_FUNCTIONS, "gripper": LATER_GRIPPER_OPEN}.get(name, "")


def _struct(struct: type[ctypes.Structure], headed: bool) -> list[str]:
    name = c_name(struct)
    lines = [f"typedef struct {name} {{"]
    if headed:
        lines.append("    gz_data_t head;")
    for field_name, field in fields_of(struct).items():
        lines += _field(field_name, field)
    return [*lines, f"}} {name}_t;"]


def _field(name: str, field: Field) -> list[str]:
    """A field, with its meaning behind it, or above it where that does not fit."""
    struct = issubclass(field.ctype, ctypes.Structure)
    kind = f"{c_name(field.ctype)}_t" if struct else C_TYPES[field.ctype]
    extent = "".join(f"[{count}]" for count in field.shape)
    unit = f" [{field.unit}]" if field.unit else ""
    code, note = f"    {kind} {name}{extent};", f"[{field.writer}] {field.help}{unit}"
    if len(code) + len(note) + 7 <= 116:
        return [f"{code} /* {note} */"]
    above = wrap(f"/* {note} */", 112)
    return [f"    {above[0]}", *(f"       {line}" for line in above[1:]), code]


def _handle(name: str, data: str) -> list[str]:
    lines = [f"typedef struct gz_{name} {{"]
    if name in HEADED_HANDLES:
        lines.append("    gz_data_t head; /* unused */")
    return [*lines, "    gz_iface_t *iface;", f"    {data}_t *data;", f"}} gz_{name}_t;"]


def _functions(kind: type[Interface[Any]]) -> list[str]:
    name = kind.type
    owner = "" if name == "sim" else ", const char *model_type, int model_id, int parent_model_id"
    create = f"extern int gz_{name}_create(gz_{name}_t *self, gz_server_t *server, const char *id"
    lines = [f"extern gz_{name}_t *gz_{name}_alloc(void);", f"extern void gz_{name}_free(gz_{name}_t *self);"]
    if owner:
        lines += [f"{create},", f"    {owner[2:]});"]
    else:
        lines += [f"{create});"]
    lines += [
        f"extern int gz_{name}_destroy(gz_{name}_t *self);",
        f"extern int gz_{name}_open(gz_{name}_t *self, gz_client_t *client, const char *id);",
        f"extern int gz_{name}_close(gz_{name}_t *self);",
        f"extern int gz_{name}_lock(gz_{name}_t *self, int blocking);",
        f"extern void gz_{name}_unlock(gz_{name}_t *self);",
    ]
    if kind.has_post:
        lines.append(f"extern int gz_{name}_post(gz_{name}_t *self);")
    return lines


if __name__ == "__main__":
    (FOLDER / "gazebo.h").write_text(header())
    (FOLDER / "interfaces.def").write_text(interface_list())
