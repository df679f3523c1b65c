"""What the commands share: one-sentence errors, and messages on the console in the old server's form."""

from __future__ import annotations

import argparse
import contextlib
import errno
import functools
import logging
import math
import os
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn, TextIO, TypeAlias

from libgz.errors import ParameterError

__all__ = [
    "INTERRUPTED",
    "USAGE_ERROR",
    "LogFile",
    "Parser",
    "as_command",
    "number_from_zero",
    "set_up_classic_console",
    "set_up_messages",
    "whole_number",
]

USAGE_ERROR = 2
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)
INTERRUPTED, NO_READER = 128 + signal.SIGINT, 128 + signal.SIGPIPE  # as shells tell of programs that signals ended
PREFIXES = {logging.WARNING: "warning : ", logging.ERROR: "error   : ", logging.CRITICAL: "error   : "}


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one sentence."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and end with exit code 2."""
        self.exit(USAGE_ERROR, f"{self.prog}: {message}; {self.prog} -h lists what is allowed\n")


def whole_number(name: str) -> Callable[[str], int]:
    """What turns an argument into a whole number from 0 on; `name` is what a message calls it."""

    def read(text: str) -> int:
        number = int(text)
        if number < 0:
            raise ValueError
        return number

    read.__name__ = name
    return read


def number_from_zero(name: str) -> Callable[[str], float]:
    """What turns an argument into a finite number that is not negative; `name` is what a message calls it."""

    def read(text: str) -> float:
        number = float(text)
        if not 0.0 <= number < math.inf:
            raise ValueError
        return number

    read.__name__ = name
    return read


_Main: TypeAlias = Callable[[Sequence[str] | None], int]


def as_command(name: str, interrupted: int = INTERRUPTED, failed: int = 1) -> Callable[[_Main], Callable[..., int]]:
    """Make a main function end well whatever becomes of its streams: one sentence, or nothing, and an exit code.

    Args:
        name: of the command.
        interrupted: exit code for a SIGINT that the function does not take itself.
        failed: exit code for a file or stream that cannot be used.
    """

    def decorate(main: _Main) -> Callable[..., int]:
        @functools.wraps(main)
        def command(arguments: Sequence[str] | None = None) -> int:
            _open_streams()
            try:
                try:
                    return main(arguments)
                finally:
                    sys.stdout.flush()
            except KeyboardInterrupt:
                return interrupted
            except BrokenPipeError:  # `| head` has seen enough
                _give_up_output()
                return NO_READER
            except OSError as error:
                _give_up_output()
                with contextlib.suppress(OSError):
                    where = error.filename or ("its output" if error.errno in NO_ROOM else None)
                    print(f"{name}: {where}: {error.strerror}" if where else f"{name}: {error}", file=sys.stderr)
                return failed

        return command

    return decorate


def _open_streams() -> None:
    """Open streams that the command was started without: the next file would get their number, and their text."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w")  # noqa: PTH123, SIM115 - for the rest of the process
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: PTH123, SIM115 - for the rest of the process


def _give_up_output() -> None:
    """What is still to be written, and cannot be, would fail once more when Python ends."""
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, sys.stdout.fileno())
            os.close(nowhere)


class _Console(logging.StreamHandler[TextIO]):
    """Messages to a stream; where it takes no more, there is nobody to tell."""

    def handleError(self, record: logging.LogRecord) -> None:
        if not isinstance(sys.exc_info()[1], OSError):
            super().handleError(record)


class LogFile(logging.FileHandler):
    """Messages to a file; one that cannot be written any more (a full disk) is told once, and left."""

    def handleError(self, record: logging.LogRecord) -> None:
        """End the file, and say so."""
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            super().handleError(record)
            return
        root = logging.getLogger("libgz")
        if self in root.handlers:
            root.removeHandler(self)
            root.error("log file %s ends here: %s", self.baseFilename, error.strerror)


class _ConsoleFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        return PREFIXES.get(record.levelno, "") + super().format(record)


def set_up_messages(level: int, logfile: str | None) -> None:
    """Send errors, warnings, and messages up to `level` (-1 to 9) to stderr; everything to `logfile`, if given.

    Raises:
        ParameterError: the log file cannot be written.
    """
    root = logging.getLogger("libgz")
    root.setLevel(logging.DEBUG)
    root.propagate = False
    console = _Console(sys.stderr)
    console.setFormatter(_ConsoleFormatter("%(message)s"))
    console.setLevel(logging.WARNING if level < 1 else logging.INFO if level == 1 else logging.DEBUG)
    root.handlers[:] = [console]
    if logfile is None:
        return
    try:
        file = LogFile(Path(logfile).expanduser(), mode="w")
    except OSError as error:
        raise ParameterError(f"cannot write log file {logfile!r}: {error.strerror}") from None
    file.setFormatter(_ConsoleFormatter("%(filename)s:%(lineno)d %(message)s"))
    root.addHandler(file)


def set_up_classic_console(*, verbose: bool) -> None:
    """Send errors and warnings to stderr, and with `verbose` messages to stdout, in Gazebo classic's form."""
    from libgz.classic.common import ConsoleHandler

    root = logging.getLogger("libgz")
    root.setLevel(logging.DEBUG)
    root.propagate = False
    root.handlers[:] = [ConsoleHandler(verbose)]
