"""Generates `gazebo.h` and the list of interfaces in the C library from the declarations.

python -m libgz.clib.header        writes them to this folder
"""

from __future__ import annotations

import ctypes
import sys
from textwrap import wrap
from types import ModuleType
from typing import Any

from libgz.clib import FOLDER
from libgz.interfaces.catalog import INTERFACES
from libgz.interfaces.gripper import GripperDataCvs
from libgz.transport import layout, legacy, semaphores
from libgz.transport.interface import Interface
from libgz.transport.layout import Field, GzData, Struct, c_name, c_type, fields_of

__all__ = ["header", "interface_list", "macros_of", "version_macro"]

# Handles that have an unused head in the old library.
HEADED_HANDLES = frozenset({"actarray", "ptz"})
LATER_GRIPPER = "GAZEBO_GRIPPER_CVS"
OLDER_MACROS = {"GAZEBO_CAMERA_MAX_IMAGE_SIZE": 320 * 240 * 3}  # in version 0x050

PREAMBLE = """\
/*
 * libgazebo: reading and commanding the models of a running server.
 *
 * Generated from the declarations in interfaces/ by `python -m libgz.clib.header`; edit those instead.
 *
 * Structs are those of version 0x060 (Gazebo 0.6 and 0.7), with the later ir and actarray. Define
 * GAZEBO_GRIPPER_CVS for the gripper struct of late 2006. With LIBGAZEBO_VERSION defined as 0x050, truth and camera are
 * those of Gazebo 0.5; the library must have been compiled with the same definition.
 *
 * Functions return 0, or -1 after printing an error, which gz_error_str returns. Lengths are in metres, angles in
 * radians, times in seconds. The server writes fields marked [S], clients write those marked [C].
 * License: Apache License 2.0.
 */

#ifndef GAZEBO_H
#define GAZEBO_H

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h> /* programs rely on it: atof without a declaration returns garbage */
#include <sys/types.h>

#ifdef __cplusplus
extern "C" {
#endif
"""

CORE = """\
/* Whether errors are printed, and the level up to which messages are: 1 connections, 5 files, 9 all. */
extern void gz_error_init(int print, int level);
extern const char *gz_error_str(void);

/* A server: a directory and the semaphores that wake clients. */
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

/* A client. Each client that waits needs its own id, 0 to 7. */
typedef struct gz_client {
    int server_id;
    int client_id;
    char *filename; /* of the server's directory */
    int sem_key;
    int sem_cid;
} gz_client_t;

extern gz_client_t *gz_client_alloc(void);
extern void gz_client_free(gz_client_t *self);
extern int gz_client_query(gz_client_t *self, int server_id); /* 0 present, 1 absent, -1 error */
extern int gz_client_connect(gz_client_t *self, int server_id);
extern int gz_client_connect_wait(gz_client_t *self, int server_id, int client_id);
extern int gz_client_disconnect(gz_client_t *self);
extern int gz_client_wait(gz_client_t *self); /* sleeps until a post: of a step, or of any device */

/* The first field of every data struct. */
{head}

/* A mapped file of any struct. */
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
extern int gz_iface_lock(gz_iface_t *self, int blocking); /* always blocks */
extern void gz_iface_unlock(gz_iface_t *self);
extern int gz_iface_post(gz_iface_t *self);
"""

TRUTH_FUNCTIONS = """
/* Write roll, pitch, yaw [rad] of q into e, and u, x, y, z of e into q. */
extern void gz_truth_euler_from_quatern(gz_truth_t *self, double *e, double *q);
extern void gz_truth_quatern_from_euler(gz_truth_t *self, double *q, double *e);
"""


# The function in the library requires the size of the release's struct.
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
    """The text of interfaces.def: for each interface a macro that defines its functions."""
    lines = ["/* Generated by `python -m libgz.clib.header`. */", ""]
    for name, kind in INTERFACES.items():
        variant = "WITHOUT_MODEL" if name == "sim" else "WITH_POST" if kind.has_post else "WITHOUT_POST"
        lines.append(f"INTERFACE_{variant}({name}, {c_name(kind.data_class)}_t)")
    return "\n".join(lines) + "\n"


def macros_of(module: ModuleType) -> dict[str, int]:
    """The constants of a module that are macros in C, in the order of the module."""
    prefixes = ("GZ_", "GAZEBO_", "LIBGAZEBO_")
    return {n: v for n, v in vars(module).items() if n.startswith(prefixes) and isinstance(v, int)}


def version_macro(version: int) -> str:
    """The line of gazebo.h that defines the version of the structs."""
    return f"#define LIBGAZEBO_VERSION {version:#05x}"


def _macros() -> str:
    lines = [
        "#ifndef LIBGAZEBO_VERSION",
        version_macro(layout.LIBGAZEBO_VERSION),
        "#endif",
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
            lines.append(f"    {c_type(ctype)} {name};")
    return "\n".join([*lines, "} gz_data_t;"])


def _interface(kind: type[Interface[Any]]) -> str:
    """Macros, structs and functions of one interface."""
    module = sys.modules[kind.__module__]
    name, data = kind.type, kind.data_class
    title = (module.__doc__ or "").partition(". ")[0].strip().rstrip(".")
    lines = [f"/* {title}. */"]
    macros = macros_of(module)
    lines += [f"#define {macro} {value}" for macro, value in macros.items() if macro not in OLDER_MACROS]
    for field in fields_of(data).values():
        if issubclass(field.ctype, Struct):
            lines += ["", *_struct(field.ctype, headed=False)]
    if name == "gripper":
        lines += ["", f"#ifdef {LATER_GRIPPER}", *_struct(GripperDataCvs, headed=True)]
        lines += ["#else", *_struct(data, headed=True), "#endif"]
    else:
        for version, older in kind.older.items():
            older_macros = {macro: value for macro, value in OLDER_MACROS.items() if macro in macros}
            lines += ["", f"#if LIBGAZEBO_VERSION == {version:#05x}"]
            lines += [f"#define {macro} {value}" for macro, value in older_macros.items()]
            lines += [*_struct(older, headed=True), "#else"]
            lines += [f"#define {macro} {macros[macro]}" for macro in older_macros]
        lines += [*([] if kind.older else [""]), *_struct(data, headed=True), *(["#endif"] if kind.older else [])]
    lines += ["", *_handle(name, c_name(data)), "", *_functions(kind)]
    return "\n".join(lines) + "\n" + {"truth": TRUTH_FUNCTIONS, "gripper": LATER_GRIPPER_OPEN}.get(name, "")


def _struct(struct: type[Struct], headed: bool) -> list[str]:
    name = c_name(struct)
    lines = [f"typedef struct {name} {{"]
    if headed:
        lines.append("    gz_data_t head;")
    for field_name, field in fields_of(struct).items():
        lines += _field(field_name, field)
    return [*lines, f"}} {name}_t;"]


def _field(name: str, field: Field) -> list[str]:
    """The declaration of a field, with a comment behind it, or above it if the line would be too long."""
    extent = "".join(f"[{count}]" for count in field.shape)
    unit = f" [{field.unit}]" if field.unit else ""
    code, note = f"    {c_type(field.ctype)} {name}{extent};", f"[{field.writer}] {field.help}{unit}"
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
