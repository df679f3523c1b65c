"""Protobuf messages that plugins and their libraries bring: a process can load each of their files once.

protobuf ends a process that registers a second file of one name, and it reads what was registered whenever it likes. So
what has messages stays in memory; and a plugin with the same file as one before it uses that one's, as in Gazebo, whose
plugins share all their symbols.
"""

from __future__ import annotations

import ctypes
import functools
import mmap
import os
import re
from pathlib import Path

from libgz.base.errors import PluginError
from libgz.classic.msgs.declare import declarations
from libgz.classic_cxx.messages import file_of
from libgz.cxx.shared_object import SharedObject

__all__ = ["OwnMessages", "files_in", "mapped"]

REGISTERS = b"AddDescriptors"  # protobuf's function
NAME = re.compile(rb"\n(?P<length>[\x07-\x7f])(?P<name>[\x21-\x7e]{1,122}\.proto)")  # begins a FileDescriptorProto
FIELDS = {10, 18, 26, 34, 42, 50, 58, 66, 74, 80, 88, 98}  # of that: number and kind as encoded
NUMBERS = {80, 88}


def _number(data: bytes | mmap.mmap, at: int) -> tuple[int, int]:
    """A number of protobuf's encoding, and where it ends."""
    value = shift = 0
    while at < len(data) and shift < 35:
        value |= (data[at] & 127) << shift
        at, shift = at + 1, shift + 7
        if data[at - 1] < 128:
            break
    return value, at


def _descriptor(data: bytes | mmap.mmap, start: int) -> bytes:
    """The FileDescriptorProto that begins at a place: up to what cannot be a field of it."""
    end = start
    while end < len(data) and data[end] in FIELDS:
        value, at = _number(data, end + 1)
        at += 0 if data[end] in NUMBERS else value
        if at > len(data):
            break
        end = at
    return data[start:end]


@functools.cache
def _gazebos() -> set[str]:
    """The names of Gazebo's files."""
    return {f"{file_of(name)}.proto" for name in declarations() if "." not in name}


def files_in(data: bytes | mmap.mmap) -> dict[str, bytes]:
    """The files of messages that were compiled into a shared object, by name; without Gazebo's, which libgz has."""
    found: dict[str, bytes] = {}
    if data.find(REGISTERS) >= 0:
        for match in NAME.finditer(data):
            name = match["name"].decode()
            if len(name) == match["length"][0] and name not in _gazebos():
                found.setdefault(name, _descriptor(data, match.start()))
    return found


def mapped() -> set[str]:
    """The paths of the shared objects of this process."""
    lines = Path("/proc/self/maps").read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    return {line[line.index("/") :] for line in lines if "/" in line and ".so" in line}


class OwnMessages:
    """The files of messages that plugins of this process and their libraries have brought."""

    def __init__(self) -> None:
        self._kept: dict[Path, SharedObject] = {}
        self._owners: dict[str, tuple[Path, str, bytes]] = {}  # plugin or library, its name for the loader, descriptor

    def check(self, path: Path, data: bytes) -> None:
        """Let a plugin that is about to be loaded use the messages of those before it, if it has the same ones.

        Args:
            path: the plugin's file.
            data: what it contains.

        Raises:
            PluginError: it was loaded before with messages of its own, or another plugin has others in a file of the
                same name.
        """
        if path in self._kept:
            raise PluginError(
                f"error loading plugin: {path} has protobuf messages of its own, which a process can load only once; "
                "start the server again"
            )
        owners: set[str] = set()
        for name, descriptor in files_in(data).items():
            if name not in self._owners:
                continue
            owner, loaded, known = self._owners[name]
            if descriptor != known:
                raise PluginError(
                    f"error loading plugin: {path} has protobuf messages of a file {name}, and {owner} has others of a "
                    "file of this name; give one of them another name"
                )
            owners.add(loaded)
        for loaded in owners:
            ctypes.CDLL(loaded, mode=os.RTLD_NOLOAD | os.RTLD_NOW | os.RTLD_GLOBAL)

    def keep(self, path: Path, shared: SharedObject, data: bytes, before: set[str]) -> None:
        """Keep a plugin that has been loaded, if it has messages, and the libraries with messages that came with it.

        Args:
            path: the plugin's file.
            shared: it.
            data: what it contains.
            before: what was `mapped` before.
        """
        if files := files_in(data):
            self._kept[path] = shared
            self._own(path, shared.library._name, files)
        for library in mapped() - before:
            if library != shared.library._name and (files := _files_of(library)):
                ctypes.CDLL(library, mode=os.RTLD_NOLOAD | os.RTLD_NOW | os.RTLD_NODELETE)
                self._own(Path(library), library, files)

    def _own(self, path: Path, loaded: str, files: dict[str, bytes]) -> None:
        for name, descriptor in files.items():
            self._owners.setdefault(name, (path, loaded, descriptor))


def _files_of(library: str) -> dict[str, bytes]:
    """The files of messages in a library; none if it cannot be read, as one that is a file no more."""
    try:
        with Path(library).open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            return files_in(data)
    except (OSError, ValueError):
        return {}
