"""LogReader: reads a log, a finished one by its index, and one whose end is missing as far as it goes."""

from __future__ import annotations

import io
import os
import struct
from bisect import bisect_right
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, Message, Metadata, Schema
from mcap.stream_reader import breakup_chunk

from libgz.base.closing import Closing
from libgz.base.errors import NotFoundError, ParameterError, nearest

__all__ = ["LogChannel", "LogMessage", "LogReader"]

MAGIC = b"\x89MCAP0\r\n"
CHUNK, METADATA = 0x06, 0x0C
LONGEST = 1 << 31  # [byte] of a record
# What the library raises for files that are damaged.
DAMAGE = (
    *(McapError, struct.error, zstandard.ZstdError),
    *(ValueError, KeyError, IndexError, EOFError, MemoryError, OverflowError),
)


@dataclass(frozen=True)
class LogChannel:
    """A channel of a log.

    Attributes:
        id: its number in the file.
        topic: its name.
        kind: interface, topic, own (of libgz), shown (made for other programs), or empty in other programs' files.
        schema, encoding: of its messages.
        about: what else the file says of it.
    """

    id: int
    topic: str
    kind: str
    schema: str
    encoding: str
    about: dict[str, str]


class LogMessage(NamedTuple):
    """A message: its channel, time in the log [ns], sim time [ns] and bytes."""

    channel: LogChannel
    time: int
    sim_time: int
    data: bytes


@dataclass
class _Part:
    """A chunk of the file."""

    offset: int
    begin: int  # [ns]
    end: int  # [ns]
    channels: frozenset[int] = field(default_factory=frozenset)


class LogReader(Closing):
    """A log, by libgz or another program.

    Args:
        path: of the file. It may still be written; what is in it now is read.

    Attributes:
        complete: whether the file was finished; if not, what was written until its end is read all the same.
        about: what libgz wrote about the whole log; empty in other programs' files.
        channels: by number.
        begin, end: times of the first and last message [s].

    Raises:
        ParameterError: it cannot be read, or is no MCAP file.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        try:
            self._file = self.path.open("rb")
        except OSError as error:
            raise ParameterError(f"log {str(path)!r} cannot be read: {error.strerror}") from None
        if self._file.read(len(MAGIC)) != MAGIC:
            self._file.close()
            raise ParameterError(f"{str(path)!r} is no log: it does not begin as an MCAP file does")
        self.about: dict[str, str] = {}
        self.channels: dict[int, LogChannel] = {}
        self._schemas: dict[int, Schema] = {}
        self._parts: list[_Part] = []
        self.complete = self._read_index()
        if not self.complete:
            self._scan()
        self._parts.sort(key=lambda part: (part.begin, part.offset))
        self.begin = min((part.begin for part in self._parts), default=0) * 1e-9
        self.end = max((part.end for part in self._parts), default=0) * 1e-9

    def __repr__(self) -> str:
        state = "" if self.complete else ", without an end"
        return f"<LogReader {self.path} {self.end - self.begin:.3f} s, {len(self.channels)} channels{state}>"

    def close(self) -> None:
        """Close the file. Can be called twice."""
        self._file.close()

    # Index -----------------------------------------------------------------------------------------------------------

    def _read_index(self) -> bool:
        """Read the index at the end of the file; whether there is one."""
        try:
            self._file.seek(0)
            reader = SeekingReader(self._file)
            summary = reader.get_summary()
            if summary is None:
                return False
            for schema in summary.schemas.values():
                self._schemas[schema.id] = schema
            for channel in summary.channels.values():
                self._add_channel(channel)
            for chunk in summary.chunk_indexes:
                channels = frozenset(chunk.message_index_offsets)
                if channels:
                    self._parts.append(
                        _Part(chunk.chunk_start_offset, chunk.message_start_time, chunk.message_end_time, channels)
                    )
            for metadata in reader.iter_metadata():
                if metadata.name == "libgz":
                    self.about = dict(metadata.metadata)
        except (*DAMAGE, OSError):
            self._schemas, self._parts, self.channels, self.about = {}, [], {}, {}
            return False
        return True

    def _add_channel(self, channel: Channel) -> None:
        schema = self._schemas.get(channel.schema_id)
        about = dict(channel.metadata)
        self.channels[channel.id] = LogChannel(
            channel.id,
            channel.topic,
            about.pop("kind", ""),
            schema.name if schema is not None else "",
            channel.message_encoding,
            about,
        )

    def _scan(self) -> None:
        """Find the chunks of a file without an index, up to the first one that is not whole."""
        file, size = self._file, os.fstat(self._file.fileno()).st_size
        place = len(MAGIC)
        while place + 9 <= size:
            file.seek(place)
            kind, length = struct.unpack("<BQ", file.read(9))
            end = place + 9 + length
            if end > size or length > LONGEST:
                return
            try:
                if kind == CHUNK:
                    self._scan_chunk(place)
                elif kind == METADATA:
                    metadata = Metadata.read(ReadDataStream(io.BytesIO(file.read(length))))
                    if metadata.name == "libgz":
                        self.about = dict(metadata.metadata)
            except DAMAGE:
                return
            place = end

    def _scan_chunk(self, place: int) -> None:
        found: set[int] = set()
        begin = end = None
        for record in self._records(place):
            if isinstance(record, Schema):
                self._schemas[record.id] = record
            elif isinstance(record, Channel):
                self._add_channel(record)
            elif isinstance(record, Message):
                found.add(record.channel_id)
                begin = record.log_time if begin is None else min(begin, record.log_time)
                end = record.log_time if end is None else max(end, record.log_time)
        if begin is not None and end is not None:
            self._parts.append(_Part(place, begin, end, frozenset(found)))

    def _records(self, place: int) -> list[Any]:
        """The records in a chunk.

        Raises:
            ValueError: the chunk is damaged.
        """
        self._file.seek(place + 9)
        chunk = Chunk.read(ReadDataStream(self._file))
        return breakup_chunk(chunk, validate_crc=True)

    # Messages --------------------------------------------------------------------------------------------------------

    def topic(self, name: str) -> LogChannel:
        """The channel of a topic.

        Raises:
            NotFoundError: there is none.
        """
        for channel in self.channels.values():
            if channel.topic == name:
                return channel
        names = [channel.topic for channel in self.channels.values()]
        raise NotFoundError(f"{self.path} has no {name}{nearest(name, names)}")

    def messages(
        self, kinds: Collection[str] = (), topics: Collection[str] = (), after: float | None = None
    ) -> Iterator[LogMessage]:
        """Messages in the order in which they were written.

        Args:
            kinds: of channels; empty for all.
            topics: their names; empty for all.
            after: a time in the log [s]; only later messages.

        Raises:
            ParameterError: the file is damaged.
        """
        wanted = {
            channel.id
            for channel in self.channels.values()
            if (not kinds or channel.kind in kinds) and (not topics or channel.topic in topics)
        }
        since = -1 if after is None else round(after * 1e9)
        for part in self._parts:
            if part.end > since and part.channels & wanted:
                yield from self._messages_of(part, wanted, since)

    def _messages_of(self, part: _Part, wanted: Collection[int], since: int) -> Iterator[LogMessage]:
        try:
            records = self._records(part.offset)
        except DAMAGE as error:
            raise ParameterError(f"log {self.path} is damaged at byte {part.offset}: {error}") from None
        for record in records:
            if isinstance(record, Message) and record.channel_id in wanted and record.log_time > since:
                yield LogMessage(
                    self.channels[record.channel_id], record.log_time, record.publish_time, bytes(record.data)
                )

    def last(self, time: float, kinds: Collection[str] = ()) -> dict[str, LogMessage]:
        """Topic -> the last message until a time in the log [s].

        Raises:
            ParameterError: the file is damaged.
        """
        limit = round(time * 1e9)
        missing = {channel.id for channel in self.channels.values() if not kinds or channel.kind in kinds}
        found: dict[str, LogMessage] = {}
        ends = bisect_right([part.begin for part in self._parts], limit)
        for part in reversed(self._parts[:ends]):
            here = part.channels & missing
            if not here:
                continue
            latest: dict[int, LogMessage] = {}
            for message in self._messages_of(part, here, -1):
                if message.time <= limit:
                    latest[message.channel.id] = message
            for number, message in latest.items():
                known = found.get(message.channel.topic)  # of an interface that changed its size
                if known is None or known.time < message.time:
                    found[message.channel.topic] = message
                missing.discard(number)
        return found
