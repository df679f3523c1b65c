"""Budget: what the readers of compressed files may hold decompressed, so that no small file fills the memory.

A reader makes a budget for what it holds at a time: a chunk of a log, a state, a document. It decompresses by the
budget, which stops at the limit, whatever sizes the file states.
"""

from __future__ import annotations

import bz2
import os
import zlib
from typing import Any

from libgz.base.errors import ParameterError
from libgz.base.numbers import whole_number

__all__ = ["DECOMPRESSED", "ELEMENT", "VARIABLE", "Budget", "BudgetError", "budget_limit"]

DECOMPRESSED = 256 << 20  # [byte]
WINDOW = 1 << 27  # [byte] of zstd's memory for a frame, the most that zstd itself makes
VARIABLE = "LIBGZ_DECOMPRESSED"  # an environment variable with another limit [MiB]
ELEMENT = 150  # [byte] that a parser takes for an element or attribute of XML, or a value of JSON


class BudgetError(ParameterError):
    """A file holds more than its reader may decompress."""


def budget_limit() -> int:
    """How many bytes a reader may hold: 256 MiB, or what the environment variable says.

    Raises:
        ParameterError: the variable is no number of MiB.
    """
    given = os.environ.get(VARIABLE, "")
    if not given:
        return DECOMPRESSED
    limit = whole_number(given, 1 << 24)
    if not limit:
        raise ParameterError(f"the environment variable {VARIABLE} is {given!r}; a number of MiB from 1 on is allowed")
    return limit << 20


class Budget:
    """Bytes that a reader may hold decompressed.

    Args:
        limit: of them; None for the common one.

    Attributes:
        limit: of them.
        used: that were taken.

    Raises:
        ParameterError: the environment variable with the limit is invalid.
    """

    def __init__(self, limit: int | None = None) -> None:
        self.limit = budget_limit() if limit is None else limit
        self.used = 0

    @property
    def left(self) -> int:
        """How many bytes may still be taken."""
        return self.limit - self.used

    def take(self, size: int) -> None:
        """Count bytes that are held from now on.

        Raises:
            BudgetError: that is more than there is left.
        """
        if size > self.left:
            raise BudgetError(
                f"it takes more than {self.limit >> 20} MiB decompressed; the environment variable {VARIABLE} [MiB] "
                "allows more"
            )
        self.used += size

    def take_xml(self, text: str) -> None:
        """Count what a parser makes of XML: elements and attributes take far more than their letters.

        Raises:
            BudgetError: that is more than there is left.
        """
        self.take(ELEMENT * (text.count("<") + text.count("=")))

    def take_json(self, data: bytes) -> None:
        """Count what a parser makes of JSON.

        Raises:
            BudgetError: that is more than there is left.
        """
        self.take(ELEMENT * _count(data, b",[{"))

    # Decompression: each takes what it returns.

    def zlib(self, data: bytes) -> bytes:
        """Decompress.

        Raises:
            BudgetError: it is more than there is left.
            ValueError: it is damaged or truncated.
        """
        tool = zlib.decompressobj()
        try:
            return self._whole(tool.decompress(data, self.left + 1), tool)
        except zlib.error as error:
            raise ValueError(str(error)) from None

    def bz2(self, data: bytes) -> bytes:
        """Decompress.

        Raises:
            BudgetError: it is more than there is left.
            ValueError: it is damaged or truncated.
        """
        tool = bz2.BZ2Decompressor()
        try:
            return self._whole(tool.decompress(data, self.left + 1), tool)
        except OSError as error:
            raise ValueError(str(error)) from None

    def zstd(self, data: bytes, size: int) -> bytes:
        """Decompress what the file states to have so many bytes.

        Raises:
            BudgetError: it is more than there is left.
            ValueError: it is damaged, or has another size.
        """
        import zstandard  # of the extra `log`

        self.take(size)
        try:
            with zstandard.ZstdDecompressor(max_window_size=WINDOW).stream_reader(data) as stream:
                return _of_size(stream.read(size + 1), size)
        except zstandard.ZstdError as error:
            raise ValueError(str(error)) from None

    def lz4(self, data: bytes, size: int) -> bytes:
        """Decompress what the file states to have so many bytes.

        Raises:
            BudgetError: it is more than there is left.
            ValueError: it is damaged, or has another size.
        """
        import lz4.frame  # type: ignore[import-not-found, import-untyped, unused-ignore]  # of the extra `log`

        self.take(size)
        try:
            return _of_size(lz4.frame.LZ4FrameDecompressor().decompress(data, size + 1), size)
        except RuntimeError as error:
            raise ValueError(str(error)) from None

    def _whole(self, found: bytes, tool: Any) -> bytes:
        self.take(len(found))
        if not tool.eof:
            raise ValueError("it is truncated")
        return found


def _of_size(found: bytes, size: int) -> bytes:
    if len(found) != size:
        raise ValueError(f"it has not the {size} bytes that it states")
    return found


def _count(data: bytes, letters: bytes) -> int:
    return sum(data.count(bytes((letter,))) for letter in letters)
