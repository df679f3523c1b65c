"""The process that writes a log: it reads what a server sends through a pipe, and writes an MCAP file.

What it has read is in the file after 0.2 s. When the pipe ends, with the server or without it, the file is finished.
"""

from __future__ import annotations

import json
import os
import select
import signal
import sys
import time
from collections.abc import Iterator
from typing import Any

from libgz._version import __version__
from libgz.base.errors import GazeboError
from libgz.interfaces.catalog import new_interface
from libgz.recording.changes import apply_patches
from libgz.recording.foxglove import Converter, Output
from libgz.recording.frames import Frame, Frames, Kind, tick_times
from libgz.recording.mcap_file import McapFile
from libgz.recording.own_messages import read_file, read_tables, tables_message
from libgz.recording.schemas import descriptors_of, struct_schema
from libgz.recording.topics import type_of_topic
from libgz.transport.layout import for_abi

__all__ = ["LogWriter", "main"]

FLUSH_PERIOD = 0.2  # [s]
BLOCK = 1 << 20  # [byte]
OBJECT = json.dumps({"type": "object"}).encode()
ARRAY = json.dumps({"type": "array"}).encode()


class _Channel:
    """A channel of the log, by what the server says about it."""

    def __init__(self, file: McapFile, about: dict[str, Any]) -> None:
        self.kind, self.topic = about["kind"], about["topic"]
        self.layout: Any = None
        self.type: Any = None
        self.name = ("", "")
        self.copy = bytearray()  # of an interface
        if self.kind == "interface":
            interface = new_interface(about["type"])
            self.layout = for_abi(interface.layout_for(about["version"], about["size"]), about["abi"])
            self.name = about["type"], about["id"]
            self.copy = bytearray(about["size"])
            schema = f"gz/{self.layout.__name__}", "ros1msg", struct_schema(self.layout).encode()
            encoding = "ros1"
        elif self.kind == "topic":
            self.type = type_of_topic(about["type"], about["declaration"])
            schema = about["type"], "protobuf", descriptors_of(self.type.DESCRIPTOR)
            encoding = "protobuf"
        elif about["text"]:
            schema, encoding = (about["schema"], "ros1msg", about["text"].encode()), "ros1"
        else:
            schema, encoding = (about["schema"], "jsonschema", ARRAY if "Interf" in about["schema"] else OBJECT), "json"
        metadata = {key: str(value) for key, value in about.items() if key not in ("topic", "text")}
        self.id = file.add_channel(self.topic, encoding, file.add_schema(*schema), metadata)


class LogWriter:
    """Writes a log.

    Args:
        file: open for writing.
    """

    def __init__(self, file: Any) -> None:
        self._file = McapFile(file, f"libgz {__version__}")
        self._channels: dict[int, _Channel] = {}
        self._made: dict[tuple[str, str], int] = {}  # channels of messages for other programs
        self._convert = Converter()
        self._log_time = self._sim_time = 0
        self._sequence = 0
        self._pending = False
        self._flushed = time.monotonic()

    def take(self, frame: Frame) -> None:
        """Write a frame."""
        if frame.kind == Kind.MESSAGE:
            self._message(self._channels[frame.channel], frame.content)
        elif frame.kind == Kind.PATCH:
            channel = self._channels[frame.channel]
            apply_patches(channel.copy, frame.content)
            self._message(channel, bytes(channel.copy), patched=True)
        elif frame.kind == Kind.TICK:
            self._log_time, self._sim_time = tick_times(frame.content)
            self._sequence += 1
        elif frame.kind == Kind.END:
            self._show(self._convert.end(self._log_time))
        elif frame.kind == Kind.CHANNEL:
            self._channels[frame.channel] = _Channel(self._file, json.loads(frame.content))
        elif frame.kind == Kind.METADATA:
            self._file.add_metadata("libgz", json.loads(frame.content))
        self._pending = True

    def _message(self, channel: _Channel, content: bytes, patched: bool = False) -> None:
        if channel.topic == "/gz/tables":
            if not patched:
                channel.copy = bytearray(content)
            content = tables_message(content)
        self._write(channel.id, content)
        convert, now = self._convert, self._log_time
        if channel.topic == "/gz/tables":
            convert.states(read_tables(content))
        elif channel.topic == "/gz/scene":
            self._show(convert.scene(content, now))
        elif channel.topic == "/gz/files":
            convert.file(*read_file(content))
        elif channel.kind == "interface":
            self._show(convert.interface(*channel.name, channel.layout.from_buffer_copy(content), now))
        elif channel.kind == "topic":
            self._show(convert.topic(channel.topic, channel.type.FromString(content), now))

    def _show(self, messages: Iterator[Output]) -> None:
        """Write messages for other programs."""
        for topic, message in messages:
            name = message.DESCRIPTOR.full_name
            if (topic, name) not in self._made:
                schema = self._file.add_schema(name, "protobuf", descriptors_of(message.DESCRIPTOR))
                self._made[topic, name] = self._file.add_channel(topic, "protobuf", schema, {"kind": "shown"})
            self._write(self._made[topic, name], message.SerializeToString())

    def _write(self, channel: int, content: bytes) -> None:
        self._file.add_message(channel, self._sequence, self._log_time, self._sim_time, content)

    def flush(self, now: float) -> None:
        """Write everything to the file, if that is due at a time [s]."""
        if now - self._flushed >= FLUSH_PERIOD:
            self._flushed = now
            if self._pending:
                self._pending = False
                self._file.flush()

    def finish(self) -> None:
        """Write index and end of the file."""
        self._file.finish()


def main(file: int, path: str, source: int = 0) -> int:
    """Write the log until the pipe ends; 0, or 1 if it cannot be written."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # the server gets them, too; its end is the end of the pipe
    os.nice(5)  # the server comes first
    try:
        with os.fdopen(file, "wb") as stream:
            _run(LogWriter(stream), source)
    except (OSError, GazeboError) as error:
        reason = getattr(error, "strerror", None) or error
        sys.stderr.write(f"error   : log {path} cannot be written: {reason}\n")
        return 1
    return 0


def _run(log: LogWriter, source: int) -> None:
    frames = Frames()
    while True:
        ready, _, _ = select.select([source], [], [], FLUSH_PERIOD)
        data = os.read(source, BLOCK) if ready else None
        if data == b"":
            break
        for frame in frames.feed(data or b""):
            log.take(frame)
        log.flush(time.monotonic())
    log.finish()


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), sys.argv[2]))
