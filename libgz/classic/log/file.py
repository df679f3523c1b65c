"""LogWriter and LogReader: log files in Gazebo classic's format, XML with a header and chunks of SDF documents.

The first document is the world; each other one has a `<state>` with the changes since the previous one. Chunks are
plain text, or compressed by zlib or bz2 and encoded in base64. A truncated file is read up to its end.
"""

from __future__ import annotations

import base64
import bz2
import os
import re
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from lxml import etree

from libgz._version import __version__
from libgz.base.budget import Budget, BudgetError
from libgz.base.closing import Closing
from libgz.base.errors import ParameterError, WorldFileError, nearest
from libgz.base.files import open_file
from libgz.base.numbers import whole_number

__all__ = ["ENCODINGS", "LogHeader", "LogReader", "LogWriter", "log_folder"]

LARGEST_SEED = (1 << 32) - 1
MOST_IN_HEADER = 20  # elements
LONGEST_PROLOGUE = 1 << 20  # [byte] before the first element, such as document types
BLOCK = 1 << 16  # [byte] that are parsed at a time
CHUNK = 64 * 1024  # characters that are written together
# How chunks are compressed, and how within a budget they are decompressed.
ENCODINGS: dict[str, tuple[Callable[[bytes], bytes], Callable[[Budget, bytes], bytes]]] = {
    "zlib": (zlib.compress, Budget.zlib),
    "bz2": (bz2.compress, Budget.bz2),
    "txt": (bytes, lambda _, data: data),
}
_DECLARATION = re.compile(r"<\?xml[^<>]*\?>")


def log_folder() -> Path:
    """Return the folder of logs: ``<GAZEBO_LOG_PATH or ~/.gazebo>/log``."""
    return Path(os.environ.get("GAZEBO_LOG_PATH") or "~/.gazebo").expanduser() / "log"


class LogHeader(NamedTuple):
    """The header of a log."""

    log_version: str
    gazebo_version: str
    rand_seed: int


class LogWriter(Closing):
    """Writes a log file; a context manager.

    Args:
        path: of the file; its folder is created.
        encoding: zlib, bz2 or txt.
        seed: of the run's random numbers.

    Raises:
        ParameterError: there is no such encoding.
        WorldFileError: the file cannot be written.
    """

    def __init__(self, path: str | os.PathLike[str], encoding: str = "zlib", seed: int = 0) -> None:
        if encoding not in ENCODINGS:
            raise ParameterError(
                f"bad log encoding {encoding!r}{nearest(encoding, ENCODINGS)}; allowed are {', '.join(ENCODINGS)}"
            )
        self.path, self.encoding = Path(path), encoding
        self._waiting: list[str] = []
        self._size = 0
        self._failed = False
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = self.path.open("w", encoding="utf-8")
        except (OSError, ValueError) as error:  # clients name paths that are none
            why = getattr(error, "strerror", None) or error
            raise WorldFileError(f"log {str(self.path)!r} cannot be written: {why}") from None
        self._write(
            "<?xml version='1.0'?>\n<gazebo_log>\n<header>\n<log_version>1.0</log_version>\n"
            f"<gazebo_version>libgz {__version__}</gazebo_version>\n<rand_seed>{seed}</rand_seed>\n</header>\n"
        )

    def add(self, document: str) -> None:
        """Add an SDF document; documents are written in chunks.

        Raises:
            WorldFileError: the file cannot be written.
        """
        self._waiting.append(document)
        self._size += len(document)
        if self._size >= CHUNK:
            self.flush()

    def flush(self) -> None:
        """Write the documents that wait.

        Raises:
            WorldFileError: the file cannot be written.
        """
        text, self._waiting, self._size = "".join(self._waiting), [], 0
        if text:
            if self.encoding != "txt":
                text = base64.b64encode(ENCODINGS[self.encoding][0](text.encode())).decode()
            text = text.replace("]]>", "]]]]><![CDATA[>")
            self._write(f"<chunk encoding='{self.encoding}'>\n<![CDATA[{text}]]>\n</chunk>\n")

    def _write(self, text: str) -> None:
        try:
            self._file.write(text)
            self._file.flush()
        except OSError as error:
            self._failed = True
            raise WorldFileError(f"log {self.path} cannot be written: {error.strerror}") from None

    def close(self) -> None:
        """Write the documents that wait, and the end. Can be called twice.

        Raises:
            WorldFileError: the file cannot be written.
        """
        if self._file.closed:
            return
        try:
            if not self._failed:
                self.flush()
                self._write("</gazebo_log>\n")
        finally:
            self._file.close()


class LogReader:
    """Reads a log file.

    Attributes:
        path: of the file.
        header: of the file.

    Raises:
        WorldFileError: the file cannot be read, or is no log.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.header = self._read_header()

    def _elements(self, name: str) -> Iterator[etree._Element]:
        """Yield the elements of a name, each until the next one is read: of a log no more is held than that."""
        try:
            with open_file(self.path) as file:
                parser = etree.XMLPullParser(
                    ("start", "end"),
                    recover=True,  # the end may be missing
                    huge_tree=True,
                    remove_comments=True,
                    remove_pis=True,
                    resolve_entities=False,
                    no_network=True,
                    load_dtd=False,
                )
                begun, kept = False, 0
                while block := file.read(BLOCK):
                    parser.feed(block)
                    events: Iterator[Any] = parser.read_events()  # its stubs have those of namespaces, too
                    for event, element in events:
                        begun = True
                        if event == "start":
                            continue
                        if element.tag == name:
                            yield element
                        parent = element.getparent()
                        if parent is not None and parent.tag == "header" and kept < MOST_IN_HEADER:
                            kept += 1
                        elif parent is not None:
                            parent.remove(element)
                    if not begun and file.tell() > LONGEST_PROLOGUE:
                        raise WorldFileError(f"{self.path}:1: is not a log file: it begins with no element")
        except OSError as error:
            raise WorldFileError(f"log {self.path} cannot be read: {error.strerror}") from None
        except etree.XMLSyntaxError as error:
            raise WorldFileError(f"{self.path}:{error.lineno or 1}: is not a log file: {error.msg}") from None

    def _read_header(self) -> LogHeader:
        header = next(self._elements("header"), None)
        parent = header.getparent() if header is not None else None
        if header is None or parent is None or parent.tag != "gazebo_log":
            raise WorldFileError(f"{self.path} is not a log file: it has no <gazebo_log> with a <header>")
        seed = header.findtext("rand_seed", "0").strip()
        return LogHeader(
            header.findtext("log_version", "").strip(),
            header.findtext("gazebo_version", "").strip(),
            whole_number(seed, LARGEST_SEED) or 0,
        )

    def chunks(self) -> Iterator[tuple[str, str]]:
        """Yield the encoding and text of each chunk.

        Raises:
            WorldFileError: a chunk is damaged.
        """
        for element in self._elements("chunk"):
            encoding, line = element.get("encoding", "txt"), element.sourceline
            if encoding not in ENCODINGS:
                raise WorldFileError(
                    f"{self.path}:{line}: <chunk>: bad encoding {encoding!r}; allowed are {', '.join(ENCODINGS)}"
                )
            text = element.text or ""
            try:
                Budget().take(len(text))
                if encoding != "txt":
                    text = ENCODINGS[encoding][1](Budget(), base64.b64decode(text)).decode()
                Budget().take_xml(text)  # what readers make of it
            except BudgetError as error:
                raise WorldFileError(f"{self.path}:{line}: <chunk>: {error}") from None
            except ValueError as error:
                raise WorldFileError(f"{self.path}:{line}: <chunk>: is damaged: {error}") from None
            yield encoding, text

    def documents(self) -> Iterator[etree._Element]:
        """Yield the `<sdf>` elements, in order: the world's, then those with states.

        Raises:
            WorldFileError: a chunk is damaged.
        """
        parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=True)
        for _, text in self.chunks():
            try:
                holder = etree.fromstring(f"<chunk>{_DECLARATION.sub('', text)}</chunk>", parser)
            except etree.XMLSyntaxError as error:
                raise WorldFileError(f"{self.path}: a chunk is not well-formed: {error.msg}") from None
            yield from holder.iterchildren("sdf")
