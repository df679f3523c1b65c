"""The headers of a Parquet file's pages: what its readers believe, and allocate, before they look at a page.

The footer of a file may state smaller sizes than the headers of its pages. These are structures of Thrift's compact
protocol, https://github.com/apache/thrift/blob/master/doc/specs/thrift-compact-protocol.md; their fields are in
https://github.com/apache/parquet-format/blob/master/src/main/thrift/parquet.thrift.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, BinaryIO, NamedTuple

__all__ = ["Page", "read_pages"]

# Types of fields in the compact protocol.
STOP, TRUE, FALSE, BYTE, I16, I32, I64, DOUBLE, BINARY, LIST, SET, MAP, STRUCT = range(13)
SIZE, COMPRESSED, DATA, DICTIONARY, DATA_2 = 2, 3, 5, 7, 8  # fields of a page's header
VALUES = 1  # field of each of the last three
MOST_LEVELS = 8
LONGEST_NUMBER = 10  # bytes


class Page(NamedTuple):
    """What the header of a page states."""

    size: int  # [byte] decompressed
    values: int
    dictionary: bool


def read_pages(file: BinaryIO, start: int, length: int) -> Iterator[Page]:
    """The pages of a column, which is so many bytes of a file from a place on.

    Raises:
        ValueError: they are damaged.
    """
    end = start + length
    while start < end:
        file.seek(start)
        header = _Header(file).struct()
        about: dict[int, Any] = next(
            (header[key] for key in (DATA, DICTIONARY, DATA_2) if isinstance(header.get(key), dict)), {}
        )
        page = Page(_count(header, SIZE), _count(about, VALUES), DICTIONARY in header)
        start = file.tell() + _count(header, COMPRESSED)
        if start > end:
            raise ValueError("a page is longer than its column")
        yield page


def _count(fields: dict[int, Any], key: int) -> int:
    found = fields.get(key, 0)
    if not (isinstance(found, int) and 0 <= found < 1 << 31):
        raise ValueError("the header of a page is damaged")
    return found


class _Header:
    """Reads a structure; of its fields, whole numbers and structures are kept."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def struct(self, level: int = 0) -> dict[int, Any]:
        """The fields of a structure by their numbers."""
        found: dict[int, Any] = {}
        key = 0
        while (head := self._byte()) != STOP:
            kind, step = head & 15, head >> 4
            key = key + step if step else self._number()
            found[key] = kind == TRUE if kind in (TRUE, FALSE) else self._value(kind, level)
        return found

    def _value(self, kind: int, level: int) -> Any:
        if level >= MOST_LEVELS:
            raise ValueError("the header of a page is nested too deeply")
        if kind in (I16, I32, I64):
            return self._number()
        if kind == STRUCT:
            return self.struct(level + 1)
        if kind in (TRUE, FALSE, BYTE):  # a truth value in a list has a byte
            self._byte()
        elif kind == DOUBLE:
            self._skip(8)
        elif kind == BINARY:
            self._skip(self._unsigned())
        elif kind in (LIST, SET):
            head = self._byte()
            self._items(head >> 4 if head >> 4 < 15 else self._unsigned(), (head & 15,), level)
        elif kind == MAP:
            size = self._unsigned()
            kinds = self._byte() if size else 0
            self._items(size, (kinds >> 4, kinds & 15), level)
        else:
            raise ValueError("the header of a page is damaged")
        return None

    def _items(self, count: int, kinds: tuple[int, ...], level: int) -> None:
        for _ in range(count):  # each takes a byte at least
            for kind in kinds:
                self._value(kind, level + 1)

    def _byte(self) -> int:
        return self._bytes(1)[0]

    def _bytes(self, count: int) -> bytes:
        found = self._file.read(count)
        if len(found) < count:
            raise ValueError("the header of a page is cut off")
        return found

    def _skip(self, count: int) -> None:
        if count >= 1 << 31:
            raise ValueError("the header of a page is damaged")
        if count:
            self._file.seek(count - 1, 1)
            self._byte()

    def _unsigned(self) -> int:
        number = 0
        for place in range(LONGEST_NUMBER):
            byte = self._byte()
            number |= (byte & 127) << (7 * place)
            if byte < 128:
                return number
        raise ValueError("the header of a page is damaged")

    def _number(self) -> int:
        number = self._unsigned()
        return (number >> 1) ^ -(number & 1)
