"""LogReader: reads a log, a finished one by its index, and one whose end is missing as far as it goes.

Records are those of the library mcap; its readers decompress without a limit, so files are taken apart here. Of a file
only one chunk is decompressed at a time, within a budget.
"""

from __future__ import annotations

import io
import os
import struct
import zlib
from bisect import bisect_right
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Channel, ChunkIndex, Footer, McapRecord, Metadata, MetadataIndex, Schema

from libgz.base.budget import ELEMENT, Budget, BudgetError, budget_limit
from libgz.base.closing import Closing
from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.files import open_file

__all__ = ["LogChannel", "LogMessage", "LogReader"]

MAGIC = b"\x89MCAP0\r\n"
# Kinds of records.
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, CHUNK_INDEX, METADATA, METADATA_INDEX = 2, 3, 4, 5, 6, 8, 12, 13
_HEAD = struct.Struct("<BQ")  # of a record: kind, length
_CHUNK = struct.Struct("<QQQI")  # of a chunk: begin, end, size, checksum; the compression and the data follow
_MESSAGE = struct.Struct("<HIQQ")  # of a message: channel, sequence, times of the log and of publication
ABOUT = "libgz"  # name of the metadata of the whole log
FOOTER_SIZE = _HEAD.size + 20
LONGEST = 64 << 20  # [byte] of a message, as on the wire of topics
# What the records' readers raise for files that are damaged.
DAMAGE = (McapError, struct.error, ValueError, KeyError, IndexError, EOFError, MemoryError, OverflowError)

_Record = TypeVar("_Record", bound=McapRecord)


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
        ParameterError: it cannot be read, or is no MCAP file; or the limit of a budget is invalid.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        budget_limit()  # an invalid one is no damage of the file
        try:
            self._file = open_file(self.path)
        except OSError as error:
            raise ParameterError(f"log {str(path)!r} cannot be read: {error.strerror}") from None
        try:
            self._read_contents()
        except BaseException:
            self._file.close()
            raise

    def _forget(self) -> None:
        """Begin with the contents; what is kept of them has one budget: the chunks of a small file may have much."""
        self.about: dict[str, str] = {}
        self.channels: dict[int, LogChannel] = {}
        self._schemas: dict[int, str] = {}  # their names
        self._parts: list[_Part] = []
        self._sets: dict[frozenset[int], frozenset[int]] = {}  # of channels: most chunks have the same
        self._kept = Budget()

    def _read_contents(self) -> None:
        if self._file.read(len(MAGIC)) != MAGIC:
            raise ParameterError(f"{str(self.path)!r} is no log: it does not begin as an MCAP file does")
        self._forget()
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
            end = os.fstat(self._file.fileno()).st_size - FOOTER_SIZE - len(MAGIC)
            kind, content = self._record_at(end)
            start = _parsed(Footer, content).summary_start if kind == FOOTER else 0
            if not 0 < start <= end:
                return False
            about = 0
            while start < end:
                kind, content = self._record_at(start)
                start += _HEAD.size + len(content)
                if kind == SCHEMA:
                    self._add_schema(_parsed(Schema, content))
                elif kind == CHANNEL:
                    self._add_channel(_parsed(Channel, content))
                elif kind == CHUNK_INDEX:
                    self._add_part(_parsed(ChunkIndex, content))
                elif kind == METADATA_INDEX:
                    note = _parsed(MetadataIndex, content)
                    about = note.offset if note.name == ABOUT else about
            if about:
                kind, content = self._record_at(about)
                if kind == METADATA:
                    self._add_metadata(content)
            self._check_parts()
        except (*DAMAGE, OSError):
            self._forget()
            return False
        return True

    def _head_at(self, place: int) -> tuple[int, int]:
        """The kind and length of a record, of which the file has all bytes.

        Raises:
            ValueError, struct.error, OSError: the file ends before.
        """
        self._file.seek(place)
        kind, length = _HEAD.unpack(self._file.read(_HEAD.size))
        if length > os.fstat(self._file.fileno()).st_size - self._file.tell():
            raise ValueError(f"a record of {length} bytes is truncated")
        if kind == 0:
            raise ValueError("there is no record")
        return kind, length

    def _record_at(self, place: int) -> tuple[int, bytes]:
        """The kind and bytes of a record.

        Raises:
            BudgetError: it has more than a reader may hold.
            ValueError, struct.error, OSError: the file ends before.
        """
        kind, length = self._head_at(place)
        Budget().take(length)
        return kind, self._file.read(length)

    def _check_parts(self) -> None:
        """Check that the index names chunks, and each once: a small file could else be read without an end."""
        end = 0
        for part in sorted(self._parts, key=lambda part: part.offset):
            kind, length = self._head_at(part.offset)
            if kind != CHUNK or part.offset < end:
                raise ValueError("the index names no chunk, or one twice")
            end = part.offset + _HEAD.size + length

    def _add_part(self, chunk: ChunkIndex) -> None:
        channels = frozenset(chunk.message_index_offsets)
        if channels:
            self._keep_part(chunk.chunk_start_offset, chunk.message_start_time, chunk.message_end_time, channels)

    def _keep_part(self, offset: int, begin: int, end: int, channels: frozenset[int]) -> None:
        known = self._sets.get(channels)
        self._kept.take(ELEMENT if known is not None else ELEMENT * (1 + len(channels)))
        self._parts.append(_Part(offset, begin, end, self._sets.setdefault(channels, channels)))

    def _add_metadata(self, content: bytes) -> None:
        metadata = _parsed(Metadata, content)
        if metadata.name == ABOUT:
            self.about = dict(metadata.metadata)

    def _add_schema(self, schema: Schema) -> None:
        if self._schemas.get(schema.id) != schema.name:  # the chunks of some programs say it again
            self._kept.take(ELEMENT + len(schema.name))
            self._schemas[schema.id] = schema.name

    def _add_channel(self, channel: Channel) -> None:
        about = dict(channel.metadata)
        texts = (channel.topic, channel.message_encoding, *about, *about.values())
        kind, schema = about.pop("kind", ""), self._schemas.get(channel.schema_id, "")
        found = LogChannel(channel.id, channel.topic, kind, schema, channel.message_encoding, about)
        if self.channels.get(channel.id) != found:
            self._kept.take(sum(ELEMENT + len(text) for text in texts))
            self.channels[channel.id] = found

    def _scan(self) -> None:
        """Find the chunks of a file without an index, up to the first one that is not whole."""
        place = len(MAGIC)
        while True:
            try:
                kind, length = self._head_at(place)
                if kind == CHUNK:
                    self._scan_chunk(place, self._record_at(place)[1])
                elif kind == METADATA:
                    self._add_metadata(self._record_at(place)[1])
            except BudgetError as error:
                raise self._damaged(place, error) from None
            except DAMAGE:
                return
            place += _HEAD.size + length

    def _scan_chunk(self, place: int, content: bytes) -> None:
        found: set[int] = set()
        begin = end = None
        for kind, record in _records(content):
            if kind == SCHEMA:
                self._add_schema(_parsed(Schema, record))
            elif kind == CHANNEL:
                self._add_channel(_parsed(Channel, record))
            elif kind == MESSAGE:
                channel, _, time, _ = _MESSAGE.unpack_from(record)
                found.add(channel)
                begin = time if begin is None else min(begin, time)
                end = time if end is None else max(end, time)
        if begin is not None and end is not None:
            self._keep_part(place, begin, end, frozenset(found))

    def _damaged(self, place: int, error: Exception) -> ParameterError:
        reason = str(error) if isinstance(error, BudgetError) else f"it is damaged: {error}"
        return ParameterError(f"log {self.path} cannot be read at byte {place}: {reason}")

    # Messages --------------------------------------------------------------------------------------------------------

    def topic(self, name: str) -> LogChannel:
        """The channel of a topic.

        Raises:
            NotFoundError: there is none.
        """
        if name not in self._topics:
            raise NotFoundError(f"{self.path} has no {name}{nearest(name, self._topics)}")
        return self._topics[name]

    @cached_property
    def _topics(self) -> dict[str, LogChannel]:
        """The first channel of each topic."""
        found: dict[str, LogChannel] = {}
        for channel in self.channels.values():
            found.setdefault(channel.topic, channel)
        return found

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
        place = part.offset
        try:
            kind, content = self._record_at(place)
            if kind != CHUNK:
                raise ValueError("there is no chunk")
            for kind, record in _records(content):
                if kind != MESSAGE:
                    continue
                channel, _, time, sim_time = _MESSAGE.unpack_from(record)
                if channel in wanted and time > since:
                    if len(record) > LONGEST:
                        raise ValueError(f"a message is longer than {LONGEST >> 20} MiB")
                    yield LogMessage(self.channels[channel], time, sim_time, bytes(record[_MESSAGE.size :]))
        except DAMAGE as error:
            raise self._damaged(place, error) from None

    def last(self, time: float, kinds: Collection[str] = ()) -> dict[str, LogMessage]:
        """Topic -> the last message until a time in the log [s].

        Raises:
            ParameterError: the file is damaged, or these are more than a reader may hold.
        """
        limit = round(time * 1e9)
        missing = {channel.id for channel in self.channels.values() if not kinds or channel.kind in kinds}
        found: dict[str, LogMessage] = {}
        budget = Budget()
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
                budget.take(len(message.data))
                known = found.get(message.channel.topic)  # of an interface that changed its size
                if known is None or known.time < message.time:
                    found[message.channel.topic] = message
                missing.discard(number)
        return found


def _parsed(kind: type[_Record], content: bytes | memoryview) -> _Record:
    """A record of the library; the bytes are all it may read."""
    record: _Record = kind.read(ReadDataStream(io.BytesIO(content)))  # type: ignore[attr-defined]
    return record


def _records(chunk: bytes) -> Iterator[tuple[int, memoryview]]:
    """Yield the kind and bytes of each record in a chunk.

    Raises:
        BudgetError: the chunk has more than may be decompressed.
        ValueError, struct.error: it is damaged.
    """
    content = memoryview(_decompressed(chunk))
    place = 0
    while place < len(content):
        kind, length = _HEAD.unpack_from(content, place)
        place += _HEAD.size
        if length > len(content) - place:
            raise ValueError(f"a record of {length} bytes is truncated")
        yield kind, content[place : place + length]
        place += length


def _decompressed(chunk: bytes) -> bytes:
    _, _, size, checksum = _CHUNK.unpack_from(chunk)
    stream = ReadDataStream(io.BytesIO(chunk))
    stream.read(_CHUNK.size)
    compression = stream.read_prefixed_string()
    data = stream.read(min(stream.read8(), len(chunk)))
    budget = Budget()
    if compression == "zstd":
        data = budget.zstd(data, size)
    elif compression == "lz4":
        data = budget.lz4(data, size)
    elif compression:
        raise ValueError(f"bad compression {compression!r}; allowed are zstd, lz4 and none")
    if checksum and zlib.crc32(data) != checksum:
        raise ValueError("the checksum of a chunk is wrong")
    return data
