"""SharedTables: the files in which a server shows the states and the scene of its world to processes that look on.

One file holds a header and the tables of states, another the scene as JSON, and more the data of meshes and rays. The
server writes them, and reads nothing back; docs/observer.md describes them for readers in any language.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.transport.directory import ServerDirectory
from libgz.transport.paths import DATA_FILE, SCENE_FILE, TABLES_FILE
from libgz.transport.truncation import Watch, watch

__all__ = [
    "BODY_COLUMNS",
    "FORMAT",
    "HEADER",
    "JOINT_COLUMNS",
    "MAGIC",
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


class SharedTables:
    """The writer of these files.

    Args:
        directory: of the server, open.
    """

    def __init__(self, directory: ServerDirectory) -> None:
        self._directory = directory
        self.header = np.zeros(1, dtype=HEADER)
        head = self.header[0]
        head["magic"], head["format"], head["status"] = MAGIC, FORMAT, Status.RUNNING
        head["body_columns"], head["joint_columns"] = BODY_COLUMNS, JOINT_COLUMNS
        head["pid"], head["start"] = os.getpid(), start_time(os.getpid())
        self.address = 0  # of the mapped file
        self._memory: Any = None
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
        head = self.header[0]
        joints_offset = HEADER.itemsize + bodies * BODY_COLUMNS * 8
        size = joints_offset + joints * JOINT_COLUMNS * 8
        segment = self._directory.create_file(TABLES_FILE, size)
        self._former_file = self._descriptor, self._watch
        memory: Any = segment.memory
        self._memory, self._descriptor = memory, segment.descriptor
        self._watch = watch(memory, segment.descriptor) if segment.descriptor is not None else None
        self.address = np.frombuffer(memory, dtype=np.uint8).ctypes.data
        head["bodies_offset"], head["bodies"] = HEADER.itemsize, bodies
        head["joints_offset"], head["joints"], head["size"] = joints_offset, joints, size

    def show(self) -> None:
        """Give the new file its name, once it was filled, and point the readers of the former one to it.

        Raises:
            OSError: the hidden file was removed.
        """
        self._directory.show_file(TABLES_FILE)
        descriptor, found = self._former_file
        if descriptor is not None:
            self._end(descriptor, found, Status.REPLACED)

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
        parts, places, offset = [], {}, 0
        for key, array in arrays.items():
            part = np.ascontiguousarray(array)
            places[key] = {"type": str(part.dtype), "shape": list(part.shape), "offset": offset}
            parts.append(part.tobytes())
            offset += part.nbytes
        content = b"".join(parts)
        name = DATA_FILE + hashlib.sha256(content).hexdigest()[:20]
        if name not in self._data:
            self._directory.write_file(name, content)
            self._data.add(name)
        return {"file": name, "arrays": places}

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


def start_time(pid: int) -> int:
    """When a process started, in ticks since the machine did, as field 22 of /proc/PID/stat; 0 if it is not known."""
    try:
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
        return int(text.rpartition(")")[2].split()[19])
    except (OSError, ValueError, IndexError):
        return 0
