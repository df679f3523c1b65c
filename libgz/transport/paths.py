"""Paths and names of servers' directories and interface files."""

from __future__ import annotations

import errno
import os
import pwd
import re
import stat

from libgz.base.errors import InterfaceError, ParameterError

__all__ = [
    "CONTROL_SOCKET",
    "DATA_FILE",
    "LOCK_FILE",
    "LONGEST_PATH",
    "SCENE_FILE",
    "TABLES_FILE",
    "check_id",
    "check_owner",
    "check_server_id",
    "file_name",
    "is_data_file",
    "server_directory",
]

# Holds the server's pid. The server keeps a flock on it while it runs, which distinguishes its directory from a stale
# one. Old clients ignore files they do not know.
LOCK_FILE = "gazebo.pid"
# What an observer reads; names with a dot in front are no interfaces'.
TABLES_FILE = ".observer.tables"
SCENE_FILE = ".observer.scene"
CONTROL_SOCKET = ".control"  # for requests of commands
DATA_FILE = ".observer.data."  # and a digest of what is in it
_DATA_NAME = re.compile(re.escape(DATA_FILE) + r"[0-9a-f]{20}")
ROOT = 0
LONGEST_PATH = 127  # the old library's buffers held 128 characters


def server_directory(server_id: int) -> str:
    """``$TMP/gazebo-$USER-<server id>``; servers and clients compute it in the same way.

    It is TMP, not TMPDIR, and an empty variable is used as it is; the defaults of unset ones are /tmp and nobody.

    Raises:
        ParameterError: the path has more than 127 bytes, the limit of old clients.
    """
    path = f"{os.environ.get('TMP', '/tmp')}/gazebo-{os.environ.get('USER', 'nobody')}-{server_id}"
    if len(os.fsencode(path)) > LONGEST_PATH:
        raise ParameterError(f"the server's directory {path!r} is longer than {LONGEST_PATH} bytes; set TMP shorter")
    return path


def is_data_file(name: object) -> bool:
    """Whether a scene may name data so: it names a file of the server's directory, and no other one."""
    return isinstance(name, str) and _DATA_NAME.fullmatch(name) is not None


def check_owner(path: str) -> None:
    """Check whose a server's directory is, before a client opens something in it.

    In a directory like /tmp anybody can make one with the name of another user's server, and with links to files that
    the user's programs would then write into.

    Raises:
        OSError: there is none, it is a link, or it belongs neither to this process's user, nor to root, nor, if this
            is root, to USER.
    """
    about = os.lstat(path)
    if not stat.S_ISDIR(about.st_mode):
        raise NotADirectoryError(errno.ENOTDIR, os.strerror(errno.ENOTDIR), path)
    if about.st_uid not in (os.geteuid(), ROOT) and (os.geteuid() != ROOT or about.st_uid != _named_user()):
        raise PermissionError(errno.EACCES, f"{path} belongs to another user (uid {about.st_uid})", path)


def _named_user() -> int | None:
    """The uid of USER, which root's programs may have from the user who started them."""
    try:
        return pwd.getpwnam(os.environ["USER"]).pw_uid
    except KeyError:
        return None


def check_server_id(server_id: int) -> int:
    """The server id as an int.

    Raises:
        ParameterError: it is negative or too large for a semaphore key.
    """
    if not 0 <= int(server_id) < 1 << 30:
        raise ParameterError(f"server id is {server_id}; it must be from 0 to {(1 << 30) - 1}")
    return int(server_id)


def check_id(kind: str, name: str | None) -> str:
    """The interface id `name`, checked.

    Raises:
        InterfaceError: it is None or no string, or has a character that is not allowed in a file name.
    """
    if name is None:
        raise InterfaceError(f"interface [{kind}] id is NULL")
    if not isinstance(name, str):
        raise InterfaceError(f"interface [{kind}] id is {name!r}; it must be a string, such as {str(name)!r}")
    if "." in name:
        raise InterfaceError(f"invalid id [{name}] (must not contain '.')")
    if "/" in name or "\0" in name:
        raise InterfaceError(f"invalid id [{name}] (must not contain '/')")
    return name


def file_name(kind: str, name: str | None) -> str:
    """``<type>.<id>``.

    Raises:
        InterfaceError: the id is None, or has a character that is not allowed in a file name.
    """
    return f"{kind}.{check_id(kind, name)}"
