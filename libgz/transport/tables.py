"""SharedTables: the files in which a server shows the states and the scene of its world to processes that look on.

One file holds a header and the tables of states, another the scene as JSON, and more the data of meshes and rays. The
server writes them, and reads nothing back; docs/observer.md describes them for readers in any language.
"""

from __future__ import annotations

import contextlib
import logging
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.digest import sha256
from libgz.base.errors import NotFoundError
from libgz.transport.directory import ServerDirectory
from libgz.transport.paths import DATA_FILE, SCENE_FILE, TABLES_FILE
from libgz.transport.truncation import Watch, watch

__all__ = [
    "BODY_COLUMNS",
    "FORMAT",
    "HEADER",
    "JOINT_COLUMNS",
    "MAGIC",
    "LocalTables",
    "SharedTables",
    "Status",
    "start_time",
]

log = logging.getLogger("libgz.transport")

MAGIC, FORMAT = b"GZTABLES", 1
BODY_COLUMNS, JOINT_COLUMNS = 16, 4

# The first bytes of the file of tables. Numbers are those of the machine, at multiples of 8 bytes.
HEADER = np.dtype(
    [
        ("magic", "S8"),  # GZTABLES
        ("format", np.uint64),  # of these files
        ("sequence", np.uint64),  # grows by 2 with each publication; odd while one is being written
        ("status", np.int64),  # see Status
        ("pid", np.int64),  # of the server
        ("start", np.int64),  # when that process started: field 22 of /proc/PID/stat; 0 if it is not known
        ("size", np.int64),  # of the file [byte]
        ("revision", np.int64),  # of the scene that belongs to these tables
        ("steps", np.int64),  # done, pauses excluded
        ("paused", np.int64),  # 1: the last step was a paused one
        ("sim_time", np.float64),  # [s]
        ("pause_time", np.float64),  # [s]
        ("real_time", np.float64),  # since the start [s]
        ("step_time", np.float64),  # length of a step [s]
        ("body_columns", np.int64),  # 16
        ("bodies_offset", np.int64),  # of the table of bodies in the file [byte]
        ("bodies", np.int64),  # its rows
        ("joint_columns", np.int64),  # 4
        ("joints_offset", np.int64),
        ("joints", np.int64),
    ]
)


class Status:
    """What `status` in the header says."""

    RUNNING = 1
    REPLACED = 2  # the tables outgrew this file: open it again by its name
    ENDED = 3


class LocalTables:
    """The writer of tables and scene in the memory of this process, for what looks on from within it.

    Attributes:
        header: one row, which is copied to the front of the tables with each publication.
        address: of the header in the memory of the tables.
        scene: as it was last written, JSON; empty before.
    """

    def __init__(self) -> None:
        self.header = np.zeros(1, dtype=HEADER)
        head = self.header[0]
        head["magic"], head["format"], head["status"] = MAGIC, FORMAT, Status.RUNNING
        head["body_columns"], head["joint_columns"] = BODY_COLUMNS, JOINT_COLUMNS
        head["pid"], head["start"] = os.getpid(), start_time(os.getpid())
        self.address = 0
        self.scene = b""
        self._memory: Any = None
        self._contents: dict[str, bytes] = {}

    @property
    def owned(self) -> bool:
        """Whether this process may write them."""
        return True

    def resize(self, bodies: int, joints: int) -> None:
        """Take memory for so many rows."""
        self._place(bytearray(self._arrange(bodies, joints)))

    def _arrange(self, bodies: int, joints: int) -> int:
        """Write in the header where so many rows are; the size of all [byte]."""
        head = self.header[0]
        joints_offset = HEADER.itemsize + bodies * BODY_COLUMNS * 8
        head["bodies_offset"], head["bodies"] = HEADER.itemsize, bodies
        head["joints_offset"], head["joints"] = joints_offset, joints
        head["size"] = size = joints_offset + joints * JOINT_COLUMNS * 8
        return size

    def _place(self, memory: Any) -> None:
        self._memory = memory
        self.address = np.frombuffer(memory, dtype=np.uint8).ctypes.data

    def show(self) -> None:
        """Nothing to do: there are no other processes."""

    @property
    def must_restore(self) -> bool:
        """Whether `restore_length` must be called before each access."""
        return False

    def restore_length(self) -> None:
        """Nothing to do: nobody else can shorten the memory."""

    def write_scene(self, content: bytes, data: set[str]) -> None:
        """Replace the scene; `data` are the names of the data that it uses."""
        self.scene = content
        self._contents = {name: self._contents[name] for name in data}

    def write_data(self, arrays: dict[str, NDArray[Any]]) -> dict[str, Any]:
        """Keep arrays; returns how a scene names them."""
        name, content, places = _data_file(arrays)
        self._contents[name] = content
        return {"file": name, "arrays": places}

    def content(self, name: str) -> bytes:
        """The bytes of data that the present scene names.

        Raises:
            NotFoundError: there are none of this name.
        """
        if name not in self._contents:
            raise NotFoundError(f"there are no data {name!r}")
        return self._contents[name]

    @property
    def memory(self) -> Any:
        """Header and tables as they are in memory, to be read only; another object after `resize`."""
        return self._memory

    def publish(self, numbers: dict[str, float], bodies: bytes, joints: bytes) -> None:
        """Publish states from tables of bytes; `numbers` are those of the header, from revision to real time.

        A world's step publishes natively; this is for states that come from elsewhere, such as a log.
        """
        head, memory = self.header[0], self._memory
        for name, value in numbers.items():
            head[name] = value
        place = HEADER.fields["sequence"][1]  # type: ignore[index]
        head["sequence"] += 1
        memory[place : place + 8] = head["sequence"].tobytes()
        memory[: HEADER.itemsize] = self.header.tobytes()
        memory[HEADER.itemsize : HEADER.itemsize + len(bodies)] = bodies
        start = int(head["joints_offset"])
        memory[start : start + len(joints)] = joints
        head["sequence"] += 1
        memory[place : place + 8] = head["sequence"].tobytes()

    def close(self) -> None:
        """Nothing to do: the memory goes with this object."""


class SharedTables(LocalTables):
    """The writer of these files.

    Args:
        directory: of the server, open.
    """

    def __init__(self, directory: ServerDirectory) -> None:
        self._directory = directory
        super().__init__()
        self._descriptor: int | None = None
        self._watch: Watch | None = None
        self._former_file: tuple[int | None, Watch | None] = None, None
        self._data: set[str] = set()  # names of data files
        self._former: set[str] = set()  # data of the scene before the present one, which readers may still open

    # Tables --------------------------------------------------------------------------------------------------------

    def resize(self, bodies: int, joints: int) -> None:
        """Create a file for so many rows, hidden until `show`: fill it in between.

        Raises:
            OSError: it cannot be created.
            ServerError: the directory was removed and cannot be created again.
        """
        segment = self._directory.create_file(TABLES_FILE, self._arrange(bodies, joints))
        self._former_file = self._descriptor, self._watch
        memory: Any = segment.memory
        self._descriptor = segment.descriptor
        self._watch = watch(memory, segment.descriptor) if segment.descriptor is not None else None
        self._place(memory)

    def show(self) -> None:
        """Give the new file its name, once it was filled, and point the readers of the former one to it.

        Raises:
            OSError: the hidden file was removed.
        """
        self._directory.show_file(TABLES_FILE)
        descriptor, found = self._former_file
        if descriptor is not None:
            self._end(descriptor, found, Status.REPLACED)

    @property
    def must_restore(self) -> bool:
        """Whether truncation of the file is not survived natively."""
        return self._watch is None

    def restore_length(self) -> None:
        """Extend the file if somebody truncated it; needed where truncation is not survived natively."""
        if self._watch is None and self._descriptor is not None:
            with contextlib.suppress(OSError):
                if os.fstat(self._descriptor).st_size < int(self.header[0]["size"]):
                    os.ftruncate(self._descriptor, int(self.header[0]["size"]))

    def _end(self, descriptor: int, found: Watch | None, status: int) -> None:
        """Say in a file what became of it, and close it."""
        if self.owned:
            with contextlib.suppress(OSError):
                os.pwrite(descriptor, np.int64(status).tobytes(), HEADER.fields["status"][1])  # type: ignore[index]
        if found is not None:
            found.release()
        os.close(descriptor)

    # Scene ---------------------------------------------------------------------------------------------------------

    def write_scene(self, content: bytes, data: set[str]) -> None:
        """Replace the scene; `data` are the names of the data files that it uses. The header has its revision.

        Raises:
            OSError: it cannot be written.
            ServerError: the directory was removed and cannot be created again.
        """
        self._directory.write_file(SCENE_FILE, content)
        self.scene = content
        for name in self._data - data - self._former:
            self._directory.remove_file(name)
        self._data &= data | self._former
        self._former = set(data)

    def write_data(self, arrays: dict[str, NDArray[Any]]) -> dict[str, Any]:
        """Write arrays to a file of their own, unless they are in one; returns how a scene names them.

        Raises:
            OSError: it cannot be written.
            ServerError: the directory was removed and cannot be created again.
        """
        name, content, places = _data_file(arrays)
        self.keep_content(name, content)
        return {"file": name, "arrays": places}

    def keep_content(self, name: str, content: bytes) -> None:
        """Write data to a file of their own, unless they are in one; `name` is the one that scenes use.

        Raises:
            OSError: it cannot be written.
            ServerError: the directory was removed and cannot be created again.
        """
        if name not in self._data:
            self._directory.write_file(name, content)
            self._data.add(name)

    def content(self, name: str) -> bytes:
        """The bytes of data that the present scene names.

        Raises:
            NotFoundError: there are none of this name.
        """
        try:
            return Path(self._directory.path, name).read_bytes() if name in self._data else super().content(name)
        except OSError:
            raise NotFoundError(f"the data {name!r} were removed") from None

    # End -----------------------------------------------------------------------------------------------------------

    @property
    def owned(self) -> bool:
        """Whether this process made the files; a forked child must not write to them."""
        return self._directory.owned

    def close(self) -> None:
        """Remove the files. Can be called twice. The tables stay mapped, for a thread that may still write them."""
        if self._descriptor is None:
            return
        for name in (TABLES_FILE, SCENE_FILE, *self._data):
            with contextlib.suppress(OSError):
                self._directory.remove_file(name)
        self._data.clear()
        self._end(self._descriptor, self._watch, Status.ENDED)
        self._descriptor = self._watch = None


def _data_file(arrays: dict[str, NDArray[Any]]) -> tuple[str, bytes, dict[str, Any]]:
    """Name and content of a file for arrays, and where each is in it."""
    parts, places, offset = [], {}, 0
    for key, array in arrays.items():
        part = np.ascontiguousarray(array)
        places[key] = {"type": str(part.dtype), "shape": list(part.shape), "offset": offset}
        parts.append(part.tobytes())
        offset += part.nbytes
    content = b"".join(parts)
    return DATA_FILE + sha256(content).hexdigest()[:20], content, places


def start_time(pid: int) -> int:
    """When a process started, in ticks since the machine did, as field 22 of /proc/PID/stat; 0 if it is not known."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
        return int(text.rpartition(")")[2].split()[19])
    except (OSError, ValueError, IndexError):
        return 0
