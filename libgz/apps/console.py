"""What the commands share: one-sentence errors, and messages on the console in the old server's form."""

from __future__ import annotations

import argparse
import logging
import sys
from pathlib import Path
from typing import NoReturn

from libgz.errors import ParameterError

__all__ = ["USAGE_ERROR", "Parser", "set_up_classic_console", "set_up_messages"]

USAGE_ERROR = 2
PREFIXES = {logging.WARNING: "warning : ", logging.ERROR: "error   : ", logging.CRITICAL: "error   : "}


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one sentence."""

    def error(self, message: str) -> NoReturn:
        """Say what is wrong and end with exit code 2."""
        self.exit(USAGE_ERROR, f"{self.prog}: {message}; {self.prog} -h lists what is allowed\n")


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
    console = logging.StreamHandler(sys.stderr)
    console.setFormatter(_ConsoleFormatter("%(message)s"))
    console.setLevel(logging.WARNING if level < 1 else logging.INFO if level == 1 else logging.DEBUG)
    root.handlers[:] = [console]
    if logfile is None:
        return
    try:
        file = logging.FileHandler(Path(logfile).expanduser(), mode="w")
    except OSError as fault:
        raise ParameterError(f"cannot write log file {logfile!r}: {fault.strerror}") from None
    file.setFormatter(_ConsoleFormatter("%(filename)s:%(lineno)d %(message)s"))
    root.addHandler(file)


def set_up_classic_console(*, verbose: bool) -> None:
    """Send errors and warnings to stderr, and with `verbose` messages to stdout, in Gazebo classic's form."""
    from libgz.classic.common import ConsoleHandler

    root = logging.getLogger("libgz")
    root.setLevel(logging.DEBUG)
    root.propagate = False
    root.handlers[:] = [ConsoleHandler(verbose)]
