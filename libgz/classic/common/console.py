"""The console of plugins: gzmsg, gzdbg, gzwarn, gzerr, gzlog.

Messages are records of `logging`, with the caller's file and line. The commands install `ConsoleHandler`, which prints
them in Gazebo's form; other programs may handle them like any log record.
"""

from __future__ import annotations

import logging
import sys
from types import FrameType
from typing import NoReturn, TextIO

from libgz.base.errors import GazeboError
from libgz.base.visible import visible

__all__ = [
    "Console",
    "ConsoleFormatter",
    "ConsoleHandler",
    "LogFormatter",
    "endl",
    "gzdbg",
    "gzerr",
    "gzlog",
    "gzmsg",
    "gzthrow",
    "gzwarn",
]

endl = "\n"

_NAME = "libgz.classic.console"
_FILE_ONLY = f"{_NAME}.log"


class _Line:
    """The text after `gzmsg <<` in one statement; it is logged where a piece ends a line, and at the end."""

    __slots__ = ("_console", "_frame", "_text")

    def __init__(self, console: Console, frame: FrameType) -> None:
        self._console = console
        self._frame = (frame.f_code.co_filename, frame.f_lineno, frame.f_code.co_name)
        self._text = ""

    def __lshift__(self, piece: object) -> _Line:
        self._text += str(piece)
        if self._text.endswith("\n"):
            text, self._text = self._text[:-1], ""
            self._console.emit(text, *self._frame)
        return self

    def __del__(self) -> None:
        if self._text:
            self._console.emit(self._text, *self._frame)


class Console:
    """A kind of message. `gzmsg("text")` and `gzmsg << "x is " << 3 << "\\n"` do the same."""

    def __init__(self, logger: str, level: int) -> None:
        self._logger = logging.getLogger(logger)
        self._level = level

    def __call__(self, *pieces: object) -> None:
        """Log a message: the pieces joined by spaces, as `print` does."""
        if self._logger.isEnabledFor(self._level):
            frame = sys._getframe(1)
            text = " ".join(map(str, pieces)).removesuffix("\n")
            self.emit(text, frame.f_code.co_filename, frame.f_lineno, frame.f_code.co_name)

    def __lshift__(self, piece: object) -> _Line:
        return _Line(self, sys._getframe(1)) << piece

    def emit(self, text: str, file: str, line: int, function: str) -> None:
        """Log a message with a given file, line and function."""
        if self._logger.isEnabledFor(self._level):
            logger = self._logger
            logger.handle(logger.makeRecord(logger.name, self._level, file, line, text, (), None, function))


gzmsg = Console(_NAME, logging.INFO)
gzdbg = Console(_NAME, logging.DEBUG)
gzwarn = Console(_NAME, logging.WARNING)
gzerr = Console(_NAME, logging.ERROR)
gzlog = Console(_FILE_ONLY, logging.INFO)


def gzthrow(text: object) -> NoReturn:
    """Log an error message and raise it.

    Raises:
        GazeboError: always, with this text.
    """
    frame = sys._getframe(1)
    gzerr.emit(str(text), frame.f_code.co_filename, frame.f_lineno, frame.f_code.co_name)
    raise GazeboError(str(text))


def _shown(record: logging.LogRecord, text: str) -> str:
    """The text of a record: plugins may colour theirs, and files and peers may not command a terminal."""
    return text if record.name in (_NAME, _FILE_ONLY) else visible(text)


class ConsoleFormatter(logging.Formatter):
    """Formats records as `[Msg] text` and `[Err] [file.py:12] text`, optionally in classic's colours."""

    KINDS = ((logging.ERROR, "Err", 31), (logging.WARNING, "Wrn", 33), (logging.INFO, "Msg", 32), (0, "Dbg", 36))

    def __init__(self, color: bool = False) -> None:
        super().__init__("%(message)s")
        self.color = color

    def format(self, record: logging.LogRecord) -> str:
        """Format a record, without a newline."""
        kind, number = next((name, number) for level, name, number in self.KINDS if record.levelno >= level)
        where = "" if kind == "Msg" else f" [{record.filename}:{record.lineno}]"
        text = f"[{kind}]{where} {_shown(record, super().format(record))}"
        return f"\x1b[1;{number}m{text}\x1b[0m" if self.color else text


class LogFormatter(logging.Formatter):
    """Formats records for a log file: `(sec nsec) text`, in wall time; all but messages with file and line."""

    def format(self, record: logging.LogRecord) -> str:
        """Format a record, without a newline."""
        where = "" if record.levelno == logging.INFO else f"[{record.filename}:{record.lineno}] "
        sec = int(record.created)
        return f"({sec} {int((record.created - sec) * 1e9)}) {where}{_shown(record, super().format(record))}"


class ConsoleHandler(logging.Handler):
    """Prints records as gzserver does: errors and warnings on stderr, always; the rest on stdout, if `verbose`.

    Colours are used on terminals only. `gzlog` writes to log files only.
    """

    def __init__(self, verbose: bool = False) -> None:
        super().__init__(logging.DEBUG if verbose else logging.WARNING)
        self._plain, self._colored = ConsoleFormatter(False), ConsoleFormatter(True)

    def emit(self, record: logging.LogRecord) -> None:
        """Print a record."""
        if record.name == _FILE_ONLY:
            return
        stream: TextIO = sys.stderr if record.levelno >= logging.WARNING else sys.stdout
        try:
            formatter = self._colored if stream.isatty() else self._plain
            stream.write(formatter.format(record) + "\n")
            stream.flush()
        except (OSError, ValueError):
            pass  # a broken pipe, a full disk or a closed stream: there is no other place to report it
