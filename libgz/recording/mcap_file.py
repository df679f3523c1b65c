"""McapFile: writes an MCAP file.

Records are those of the library mcap. Its own writer takes 20 us for a message, and a server at full speed makes tens
of them a step; so messages and their index are packed here.
"""

from __future__ import annotations

import struct
import zlib
from typing import Any

import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)

__all__ = ["McapFile"]

MAGIC = b"\x89MCAP0\r\n"
CHUNK_SIZE = 4 << 20  # [byte]
LEVEL = 1  # of compression: the quickest

_MESSAGE = struct.Struct("<BQHIQQ")  # kind of record, its length, channel, sequence, time of the log and of publication
_INDEX = struct.Struct("<BQHI")  # kind of record, its length, channel, length of the entries
_BEHIND_LENGTH, _INDEX_BEHIND_LENGTH = _MESSAGE.size - 9, _INDEX.size - 9


def _record(record: McapRecord) -> bytes:
    builder: Any = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())


class McapFile:
    """An MCAP file that is being written. What was flushed can be read, though the end of the file is missing.

    Args:
        stream: open for writing, at its beginning.
        library: who writes it.
    """

    def __init__(self, stream: Any, library: str) -> None:
        self._stream, self._place = stream, 0
        self._compressor = zstandard.ZstdCompressor(level=LEVEL)
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._counts: dict[int, int] = {}
        self._chunks: list[ChunkIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._parts: list[bytes] = []  # of the present chunk
        self._size = 0
        self._index: dict[int, list[int]] = {}  # by channel: time and offset of each message
        self._begin = self._end = 0  # [ns] of the chunk
        self._write(MAGIC + _record(Header(profile="", library=library)))
        stream.flush()

    def _write(self, data: bytes) -> None:
        self._stream.write(data)
        self._place += len(data)

    def _add(self, data: bytes) -> None:
        self._parts.append(data)
        self._size += len(data)

    def add_metadata(self, name: str, values: dict[str, str]) -> None:
        """Write names and values about the whole file."""
        data = _record(Metadata(name=name, metadata=values))
        self._metadata.append(MetadataIndex(offset=self._place, length=len(data), name=name))
        self._write(data)

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """A new schema; its number."""
        schema = Schema(id=len(self._schemas) + 1, data=data, encoding=encoding, name=name)
        self._schemas.append(schema)
        self._add(_record(schema))
        return schema.id

    def add_channel(self, topic: str, encoding: str, schema: int, metadata: dict[str, str]) -> int:
        """A new channel; its number."""
        channel = Channel(
            id=len(self._channels) + 1, topic=topic, message_encoding=encoding, schema_id=schema, metadata=metadata
        )
        self._channels.append(channel)
        self._add(_record(channel))
        return channel.id

    def add_message(self, channel: int, sequence: int, log_time: int, publish_time: int, data: bytes) -> None:
        """A message; times are in nanoseconds."""
        if not self._index:
            self._begin = self._end = log_time
        if channel not in self._index:
            self._index[channel] = []
        self._begin, self._end = min(self._begin, log_time), max(self._end, log_time)
        self._index[channel] += log_time, self._size
        head = _MESSAGE.pack(5, _BEHIND_LENGTH + len(data), channel, sequence & 0xFFFFFFFF, log_time, publish_time)
        self._parts += head, data
        self._size += len(head) + len(data)
        if self._size >= CHUNK_SIZE:
            self._finish_chunk()

    def flush(self) -> None:
        """Write everything to the file."""
        self._finish_chunk()
        self._stream.flush()

    def _finish_chunk(self) -> None:
        if not self._parts:
            return
        content = b"".join(self._parts)
        packed = self._compressor.compress(content)
        start = self._place
        chunk = Chunk(
            compression="zstd",
            data=packed,
            message_start_time=self._begin,
            message_end_time=self._end,
            uncompressed_crc=zlib.crc32(content),
            uncompressed_size=len(content),
        )
        data = _record(chunk)
        offsets, indices = {}, []
        end = start + len(data)
        for channel, entries in self._index.items():
            offsets[channel] = end
            packed_entries = struct.pack(f"<{len(entries)}Q", *entries)
            length = len(packed_entries)
            indices.append(_INDEX.pack(7, _INDEX_BEHIND_LENGTH + length, channel, length) + packed_entries)
            end += len(indices[-1])
            self._counts[channel] = self._counts.get(channel, 0) + len(entries) // 2
        self._write(data + b"".join(indices))
        self._chunks.append(
            ChunkIndex(
                message_start_time=self._begin,
                message_end_time=self._end,
                chunk_start_offset=start,
                chunk_length=len(data),
                message_index_offsets=offsets,
                message_index_length=end - start - len(data),
                compression="zstd",
                compressed_size=len(packed),
                uncompressed_size=len(content),
            )
        )
        self._parts, self._size, self._index = [], 0, {}
        self._begin = self._end = 0

    def finish(self) -> None:
        """Write the last messages, the index and the end of the file."""
        self._finish_chunk()
        self._write(_record(DataEnd(data_section_crc=0)))
        start = self._place
        counted = [chunk for chunk in self._chunks if chunk.message_index_offsets]
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=sum(self._counts.values()),
            message_start_time=min((chunk.message_start_time for chunk in counted), default=0),
            message_end_time=max((chunk.message_end_time for chunk in counted), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        for record in (*self._schemas, *self._channels, statistics, *self._chunks, *self._metadata):
            self._write(_record(record))
        self._write(_record(Footer(summary_start=start, summary_offset_start=0, summary_crc=0)) + MAGIC)
        self._stream.flush()
