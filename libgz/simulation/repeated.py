"""Repeated: what clients cause in the log: short lines, and the same one at growing counts only."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator
from contextvars import ContextVar

from libgz.base.visible import one_line, visible
from libgz.simulation.problems import note_record
from libgz.transport.tally import Tally

__all__ = ["MOST_LINES", "repeated", "running_tally"]

MOST_LINES = 1000  # for a tally: different lines, after which the others count as one
LONGEST_TEXT = 2000  # characters
# Loggers of libgz; what plugins themselves log is theirs.
PARTS = (
    "classic",
    "ode",
    "physics",
    "recording",
    "rendering",
    "ros",
    "sdf",
    "simulation",
    "transport",
    "view",
    "worldfile",
)


def running_tally() -> Tally | None:
    """That of the `repeated` which is in effect: also for what the running code defers."""
    return _tally.get()


@contextlib.contextmanager
def repeated(tally: Tally | None) -> Iterator[None]:
    """For a `with` block that handles what clients have sent: what it logs in this thread is counted.

    What is not logged is a problem of the world all the same.

    Args:
        tally: counts the lines; None: all are logged, also within the block of another one.
    """
    before = _tally.set(tally)
    try:
        yield
    finally:
        _tally.reset(before)


_tally: ContextVar[Tally | None] = ContextVar("tally", default=None)


def _is_logged(record: logging.LogRecord) -> bool:
    """Whether to log a record, which says how often it came."""
    tally = _tally.get()
    if tally is None:
        return True
    text = record.getMessage()
    rest = f"... ({len(text)} characters)" if len(text) > LONGEST_TEXT else ""
    shown = visible if getattr(record, "noted", False) else one_line  # the former have tracebacks of plugins
    text = shown(text[:LONGEST_TEXT]) + rest
    if not tally.due(text):
        note_record(record)
        return False
    record.msg, record.args = "%s%s", (text, tally.times(text))
    return True


for _name in PARTS:
    logging.getLogger(f"libgz.{_name}").addFilter(_is_logged)
