"""Repeated: what nodes cause in the log: short lines, and the same one at growing counts only."""

from __future__ import annotations

import logging
import threading

from libgz.base.visible import one_line
from libgz.transport.tally import Tally

__all__ = ["Repeated"]

LONGEST_TEXT = 2000  # characters


class Repeated(logging.Filter):
    """A filter of a logger: in effect for the thread that is within its `with`, until it is closed.

    Args:
        log: the logger.
    """

    def __init__(self, log: logging.Logger) -> None:
        super().__init__()
        self._log, self._tally = log, Tally(100)
        self._threads: list[int] = []  # within `with`
        log.addFilter(self)

    def close(self) -> None:
        """Let the logger go."""
        self._log.removeFilter(self)

    def __enter__(self) -> None:
        self._threads.append(threading.get_ident())

    def __exit__(self, *_: object) -> None:
        self._threads.remove(threading.get_ident())

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether to log a record, which says how often it came."""
        if record.thread not in self._threads:
            return True
        text = one_line(record.getMessage()[:LONGEST_TEXT])
        if not self._tally.due(text):
            return False
        record.msg, record.args = "%s%s", (text, self._tally.times(text))
        return True
