"""Where a server keeps its interface files."""

from __future__ import annotations

import os

from libgz.errors import InterfaceError, ParameterError

__all__ = ["LOCK_FILE", "LONGEST_PATH", "check_id", "check_server_id", "file_name", "server_directory"]

# Holds the server's pid, and a flock for as long as it lives: that tells a dead server's directory from a live one's.
# Clients of the time never look at files they do not know.
LOCK_FILE = "gazebo.pid"
LONGEST_PATH = 127  # the old library's buffers held 128 characters


def server_directory(server_id: int) -> str:
    """``$TMP/gazebo-$USER-<server id>``, as clients compute it too.

    It is TMP, not TMPDIR, and an empty variable is used as it is; unset ones stand for /tmp and nobody.

    Raises:
        ParameterError: the path is longer than old clients can hold.
    """
    path = f"{os.environ.get('TMP', '/tmp')}/gazebo-{os.environ.get('USER', 'nobody')}-{server_id}"
    if len(os.fsencode(path)) > LONGEST_PATH:
        raise ParameterError(f"the server's directory {path!r} is longer than {LONGEST_PATH} bytes; set TMP shorter")
    return path


def check_server_id(server_id: int) -> int:
    """The server id as an int.

    Raises:
        ParameterError: it is negative or too large for a semaphore key.
    """
    if not 0 <= int(server_id) < 1 << 30:
        raise ParameterError(f"server id is {server_id}; it must be from 0 to {(1 << 30) - 1}")
    return int(server_id)


def check_id(kind: str, name: str | None) -> str:
    """An interface's id.

    Raises:
        InterfaceError: it is absent, or has a character that cannot stand in a file name.
    """
    if name is None:
        raise InterfaceError(f"interface [{kind}] id is NULL")
    if "." in name:
        raise InterfaceError(f"invalid id [{name}] (must not contain '.')")
    if "/" in name or "\0" in name:
        raise InterfaceError(f"invalid id [{name}] (must not contain '/')")
    return name


def file_name(kind: str, name: str | None) -> str:
    """``<type>.<id>``."""
    return f"{kind}.{check_id(kind, name)}"
