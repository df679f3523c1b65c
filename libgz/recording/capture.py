"""Capture: takes what a world shows after each step, and sends it to a process of its own that writes the log.

The server only compares and copies bytes: compression, schemas and what other programs read are that process's work. A
log of a server that is killed is finished by that process; if both are killed, at most the last half second is lost.

It takes from the server what changed, and nothing else: memory is compared with what was sent last, in one native call
a step (`changes.c`), and patches go to a pipe. What is in use of an interface is compared when its server has released
its lock since (`LinkRecord.exchanges`), or what clients write in it differs; all of it is in every 128th step. If the
other process is slow, the server waits. Files that a log names are sent once. `Player` numbers scenes anew, so that
observers can follow when it goes back.
"""

from __future__ import annotations

import ctypes
import fcntl
import importlib.util
import json
import logging
import os
import struct
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from libgz._version import __version__
from libgz.base.closing import Closing
from libgz.base.errors import GazeboError, LibraryError, NotFoundError, ParameterError
from libgz.base.extras import install
from libgz.base.files import read_file
from libgz.base.python import start_module
from libgz.base.records import ClockRecord, TableRecord
from libgz.recording.changes import Changes, Moments, Piece
from libgz.recording.frames import Kind, channel_frame, frame
from libgz.recording.own_messages import FILE_SCHEMA, TABLES_SCHEMA, file_message
from libgz.simulation.world import World
from libgz.transport.interface import Interface
from libgz.transport.layout import Data, commands_of, parts_of
from libgz.transport.tables import HEADER

if TYPE_CHECKING:
    from libgz.recording.topics import TopicTap

__all__ = ["FORMAT", "Capture", "check_packages"]

log = logging.getLogger("libgz.recording")

FORMAT = "1"  # of the log
BEGINNING = 40  # [byte] of what follows the head of an interface
LARGEST_FILE = 64 << 20  # [byte] of textures and skins that are kept in the log
PIPE_SIZE = 1 << 20  # [byte]
LATEST = 2**63 - 1  # [ns] of a record
SEND_PERIOD = 0.05  # [s] between two calls of the system, each of which wakes the writer
SEND_SIZE = PIPE_SIZE // 2  # [byte] that are sent at once
PATIENCE = 60.0  # [s] for the writer to finish
TABLES, SCENE, FILES, SERVED = 1, 2, 3, 4  # channels
FIRST_CHANNEL = 10  # of interfaces and topics
_REVISION, _REVISION_AT = struct.Struct("=q"), HEADER.fields["revision"][1]  # type: ignore[index]

_NEEDED = {"mcap": "mcap", "foxglove_schemas_protobuf": "foxglove-schemas-protobuf"}


def check_packages() -> None:
    """Check that logs can be written and read.

    Raises:
        LibraryError: a package is not installed.
    """
    missing = [name for module, name in _NEEDED.items() if importlib.util.find_spec(module) is None]
    if missing:
        raise LibraryError(f"logs need {' and '.join(missing)}, not installed here: {install('log')}")


def keys_of(layout: type[Data]) -> tuple[tuple[int, int], ...]:
    """The parts of a struct that clients write, and its beginning with the time, for writes without the lock."""
    head: Any = layout.head  # a field of ctypes
    beginning = head.size, min(BEGINNING, ctypes.sizeof(layout) - head.size)
    return beginning, *((part.start, part.stop - part.start) for part, _ in commands_of(layout))


class Capture(Closing):
    """A recording of a world.

    Call `take` after each step. If the log cannot be written any more, that is logged, and the world runs on.

    Args:
        world: it is initialized.
        path: of the log, `.mcap`; an existing file is replaced.
        period: sim time between two states of bodies and joints [s]; 0 for those of every step.

    Raises:
        LibraryError: a package of the extra [log] is not installed.
        ParameterError: the file cannot be written.
        GazeboError: the writing process cannot be started.
    """

    def __init__(self, world: World, path: str | os.PathLike[str], period: float = 0.0) -> None:
        check_packages()
        self.world, self.path = world, Path(path)
        self._tables = world.publish()
        self._moments = Moments(0.0, 0.0, period, 0.0, SEND_PERIOD, SEND_SIZE, revision_seen=-1)
        self._moments.step = ctypes.addressof(world.engine.tables.record) + TableRecord.step.offset
        clock: Any = ClockRecord  # whose fields are floats to mypy
        self._moments.sim_time = ctypes.addressof(world.clock) + clock.sim_time.offset
        self._known: list[Interface[Any]] = []
        self._memory: Any = None  # of the tables
        self._changes = Changes([])  # of the tables, if there are any yet, and of interfaces
        self._channels: dict[str, int] = {}
        self._files: set[str] = set()  # that the log has
        self._topics: TopicTap | None = None
        self._pipe: int | None = None
        self._writer = self._start()
        if world.facade is not None:
            from libgz.recording.topics import TopicTap  # legacy worlds have no topics

            self._topics = TopicTap(world)
        self._frames: list[bytes] = []  # that come before those of the next step's changes
        about = {
            "format": FORMAT,
            "libgz": __version__,
            "world": world.name,
            "era": world.era.name,
            "wire_version": str(world.gz_server.version),
            "abi": world.gz_server.abi,
            "step_time": repr(world.engine.step_time),
        }
        self._frames.append(frame(Kind.METADATA, 0, json.dumps(about).encode()))
        for number, topic, schema, text in (
            (TABLES, "/gz/tables", "gz/Tables", TABLES_SCHEMA),
            (SCENE, "/gz/scene", "gz.Scene", ""),
            (FILES, "/gz/files", "gz/File", FILE_SCHEMA),
            (SERVED, "/gz/interfaces", "gz.Interfaces", ""),
        ):
            self._frames.append(channel_frame(number, kind="own", topic=topic, schema=schema, text=text))
        self.take(advance=False)

    def _start(self) -> subprocess.Popen[bytes]:
        """Open the file and start the process that writes it."""
        try:
            file = os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise ParameterError(f"log {str(self.path)!r} cannot be written: {error.strerror}") from None
        source, self._pipe = os.pipe2(os.O_CLOEXEC)
        try:
            fcntl.fcntl(self._pipe, fcntl.F_SETPIPE_SZ, PIPE_SIZE)
        except OSError:
            log.debug("the pipe to the log stays small")  # the limit of this user
        try:
            words = str(file), str(self.path)
            return start_module(
                "libgz.recording.writer", *words, stdin=source, pass_fds=[file], stdout=subprocess.DEVNULL
            )
        except OSError as error:
            os.close(self._pipe)
            self._pipe = None
            raise GazeboError(f"the process that writes {self.path} cannot be started: {error.strerror}") from None
        finally:
            os.close(source)
            os.close(file)

    # A step ----------------------------------------------------------------------------------------------------------

    def take(self, advance: bool = True) -> None:
        """Record what the last step changed; waits if the writing process is far behind.

        Args:
            advance: whether there was a step.
        """
        if self._pipe is None:
            return
        world = self.world
        with world.lock:
            if not world.running:
                return
            served, memory = list(world.gz_server.interfaces.values()), self._tables.memory
            same = served == self._known and memory is self._memory
            plain = advance and same and not self._frames and self._topics is None
            due = self._changes.record_step(self._moments) if plain else -1
            if due < 0:
                due = self._take(served, memory, world.engine.step_time if advance else 0.0)
        if due:
            self._moments.sent = time.monotonic()
            self._send()

    def _take(self, served: list[Interface[Any]], memory: Any, step: float) -> bool:
        """`take` of more than numbers that have changed; whether it is time to send it."""
        world, moments, first, after, before = self.world, self._moments, 0, b"", b""
        moments.time += step
        revision = _REVISION.unpack_from(memory, _REVISION_AT)[0]
        if revision != moments.revision_seen:
            moments.revision_seen = revision
            self._take_scene()
        elif moments.time < moments.due - 1e-9:
            first = 1  # states are the first piece
        if not first:
            moments.due = moments.time + moments.period
        if served != self._known or memory is not self._memory:
            self._notice(served, memory)
        if self._topics is not None:
            after = self._take_topics(self._topics)
        if self._frames:
            before, self._frames = b"".join(self._frames), []
        log_time, sim_time = (min(round(time * 1e9), LATEST) for time in (moments.time, world.clock.sim_time))
        waiting = self._changes.record(log_time, max(sim_time, 0), first, before, after)
        return time.monotonic() - moments.sent >= SEND_PERIOD or waiting > SEND_SIZE

    def _take_scene(self) -> None:
        scene = json.loads(self._tables.scene)
        for name in sorted(_named(scene, "file") | ({scene["sky"]["texture"]} if scene.get("sky") else set())):
            if name in self._files:
                continue
            self._files.add(name)
            try:
                content = read_file(name) if name.startswith("/") else self._tables.content(name)
            except (OSError, NotFoundError):
                continue  # it is not there for the renderer, either
            if len(content) <= LARGEST_FILE:
                self._frames.append(frame(Kind.MESSAGE, FILES, file_message(name, content)))
        self._frames.append(frame(Kind.MESSAGE, SCENE, self._tables.scene))

    def _notice(self, served: list[Interface[Any]], memory: Any) -> None:
        """Interfaces came or went, or the tables have another size."""
        self._send()
        pieces = [Piece(memory, TABLES, seen=memory is not self._memory)]
        if memory is not self._memory:
            self._memory = memory
            self._moments.revision = np.frombuffer(memory, np.uint8).ctypes.data + _REVISION_AT
            self._frames.append(frame(Kind.MESSAGE, TABLES, bytes(memory)))
        if served != self._known:
            self._known = served
            names = [[interface.type, interface.id] for interface in served]
            self._frames.append(frame(Kind.MESSAGE, SERVED, json.dumps(names).encode()))
        for one in served:
            channel, parts = self._interface_channel(one), parts_of(one.layout)
            pieces.append(Piece(one.memory, channel, keys_of(one.layout), one.link, parts=parts))
        self._changes = Changes(pieces, self._changes)

    def _interface_channel(self, interface: Interface[Any]) -> int:
        kind, name, size = interface.type, interface.id, interface.size
        version, abi = self.world.gz_server.version, self.world.gz_server.abi
        return self._channel(
            f"/{kind}/{name}", kind="interface", type=kind, id=name, version=version, abi=abi, size=size
        )

    def _take_topics(self, tap: TopicTap) -> bytes:
        found = []
        for topic, type_name, declaration, content in tap.take():
            channel = self._channel(topic, kind="topic", type=type_name, declaration=declaration)
            found.append(frame(Kind.MESSAGE, channel, content))
        return b"".join(found)

    def _channel(self, topic: str, **about: Any) -> int:
        """The number of a channel; a new one the first time."""
        key = f"{topic} {about.get('type')} {about.get('size')}"
        if key not in self._channels:
            self._channels[key] = number = FIRST_CHANNEL + len(self._channels)
            self._frames.append(channel_frame(number, topic=topic, **about))
        return self._channels[key]

    # The pipe --------------------------------------------------------------------------------------------------------

    def _send(self) -> None:
        data = memoryview(self._changes.send())
        try:
            while data and self._pipe is not None:
                data = data[os.write(self._pipe, data) :]
        except BrokenPipeError:
            self._end("cannot be written any more; its reason is above")

    def _end(self, what: str) -> None:
        """Stop recording."""
        if self._pipe is not None:
            os.close(self._pipe)
            self._pipe = None
        if self._topics is not None:
            self._topics.close()
        log.error("log %s %s", self.path, what)

    def close(self) -> None:
        """Finish the log; waits for it. Can be called twice."""
        if self._topics is not None:
            self._topics.close()
        if self._pipe is not None:
            self._send()
        if self._pipe is not None:
            os.close(self._pipe)
            self._pipe = None
            try:
                if self._writer.wait(PATIENCE):
                    log.error("log %s is not complete", self.path)
            except subprocess.TimeoutExpired:
                log.error("log %s is still being written after %g s", self.path, PATIENCE)
        elif self._writer.poll() is None:
            self._writer.wait(PATIENCE)


def _named(value: Any, key: str) -> set[str]:
    """All texts under a key, however deep."""
    found: set[str] = set()
    todo: list[Any] = [value]
    search: Callable[[Any], None] = todo.append
    while todo:
        part = todo.pop()
        if isinstance(part, dict):
            text = part.get(key)
            if isinstance(text, str):
                found.add(text)
            for inner in part.values():
                search(inner)
        elif isinstance(part, list):
            todo.extend(part)
    return found
