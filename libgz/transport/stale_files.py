"""Stale files: directories and semaphores of servers that died without removing them."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from libgz.transport.paths import LOCK_FILE, server_directory
from libgz.transport.semaphores import CLIENTS, GZ_SEM_KEY, SemaphoreSet
from libgz.transport.server import alive

__all__ = ["StaleItem", "remove_stale"]

_SEMAPHORES = Path("/proc/sysvipc/sem")
_HIGHEST_ID = 1 << 30


@dataclass(frozen=True)
class StaleItem:
    """A file, directory or semaphore set of a dead server that was removed."""

    server_id: int
    name: str


def remove_stale(server_id: int | None = None) -> Iterator[StaleItem]:
    """Remove the stale files and semaphores of this user's dead servers, and yield each item that was removed.

    Those of live servers, of other users, and of servers that may be alive are not touched.

    Args:
        server_id: one server; None for all.

    Raises:
        ParameterError: the path of the server's directory is too long.
    """
    ids = {*_directories(), *_semaphore_ids()} if server_id is None else {server_id}
    for number in sorted(ids):
        yield from _remove_one(number)


def _directories() -> Iterator[int]:
    """Server ids for which there is a directory named for this user."""
    folder, _, stem = server_directory(0).rpartition("/")
    pattern = re.compile(re.escape(stem.removesuffix("0")) + r"(\d{1,9})")
    with contextlib.suppress(OSError):
        for name in os.listdir(folder or "/"):  # noqa: PTH208
            match = pattern.fullmatch(name)
            if match:
                yield int(match[1])


def _semaphore_ids() -> Iterator[int]:
    """Server ids for which there are semaphores of this user."""
    try:
        lines = _SEMAPHORES.read_text().splitlines()[1:]
    except OSError:
        return
    for line in lines:
        key, _, mode, count, owner = map(int, line.split()[:5])
        mine = owner == os.geteuid() and count == CLIENTS and mode == 700
        if mine and 0 <= key - GZ_SEM_KEY < _HIGHEST_ID:
            yield key - GZ_SEM_KEY


def _remove_one(server_id: int) -> Iterator[StaleItem]:
    """Remove the stale items of one server id, under its lock, so that no server starts on the id meanwhile."""
    with contextlib.ExitStack() as stack:
        directory = _open_own(server_directory(server_id), stack)
        if directory is not None and not _hold_lock(directory, stack):
            return
        try:
            semaphores = SemaphoreSet.attach(server_id)
        except OSError:
            semaphores = None
        if semaphores is not None:
            try:
                if alive(semaphores.last_poster()):
                    return
                semaphores.remove()
            except OSError:
                return
            yield StaleItem(server_id, f"semaphores {GZ_SEM_KEY + server_id:#x}")
        if directory is not None:
            yield from _remove_directory(server_id, directory)


def _open_own(path: str, stack: contextlib.ExitStack) -> int | None:
    """A directory of this user, opened without following links; None if there is none."""
    try:
        directory = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return None
    stack.callback(os.close, directory)
    return directory if os.fstat(directory).st_uid == os.geteuid() else None


def _hold_lock(directory: int, stack: contextlib.ExitStack) -> bool:
    """Take a server's lock; False if it is alive. A directory without a lock file belongs to another kind of server."""
    try:
        lock = os.open(LOCK_FILE, os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC, dir_fd=directory)
    except FileNotFoundError:
        return True
    except OSError:
        return False
    stack.callback(os.close, lock)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


def _remove_directory(server_id: int, directory: int) -> Iterator[StaleItem]:
    """Remove interface files, then the directory if it is empty."""
    path = server_directory(server_id)
    for name in sorted(os.listdir(directory), key=lambda name: (name == LOCK_FILE, name)):
        about = os.stat(name, dir_fd=directory, follow_symlinks=False)
        if stat.S_ISREG(about.st_mode) and (name == LOCK_FILE or "." in name):
            os.unlink(name, dir_fd=directory)
            yield StaleItem(server_id, f"{path}/{name}")
    try:
        os.rmdir(path)  # noqa: PTH106
    except OSError:
        return
    yield StaleItem(server_id, path)
