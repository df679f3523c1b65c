"""What gzserver's options for log files do: record a world as it runs, or play one."""

from __future__ import annotations

import argparse
import contextlib
import logging
from collections.abc import Iterator
from pathlib import Path

from libgz.apps.console import number_from_zero
from libgz.classic.log import ENCODINGS, LogPlay, LogRecord, PlaybackControl, RecordControl
from libgz.classic.server import attach
from libgz.front import World

__all__ = ["add_log_options", "keep_log"]

log = logging.getLogger("libgz.classic")


def add_log_options(parser: argparse.ArgumentParser) -> None:
    """Add classic's options."""
    add = parser.add_argument
    add("-p", "--play", metavar="LOG", help="play a log file in place of a world")
    add("-r", "--record", action="store_true", help="record a log file; so do the next four options")
    add("--record_path", metavar="FOLDER", help="where state.log is written (default ~/.gazebo/log/<time>/gzserver)")
    add(
        "--record_period",
        type=number_from_zero("number of seconds"),
        metavar="S",
        help="least sim time between two states (default: each step)",
    )
    add("--record_encoding", choices=tuple(ENCODINGS), help="how states are written (default zlib)")
    add("--record_filter", metavar="NAMES", help="record models of these names: a pattern with * or a regex")


@contextlib.contextmanager
def keep_log(options: argparse.Namespace, core: World, play: LogPlay | None) -> Iterator[PlaybackControl | None]:
    """Record a world, or play it, as options and topics say; what controls the playing, if that is what is done.

    Raises:
        GazeboError: the log cannot be written.
    """
    details = options.record_path, options.record_period, options.record_encoding, options.record_filter
    wanted = options.record or any(detail is not None for detail in details)
    if core.sdf is None:
        if wanted:
            log.error("a legacy world cannot be recorded; `libgz convert` makes an SDF world of it")
        yield None
    elif play is not None:
        if wanted:
            log.warning("what is played is not recorded")
        with contextlib.closing(PlaybackControl(play)) as control:
            yield control
    else:
        record = _record(options, core) if wanted else None
        with contextlib.closing(RecordControl(attach(core).world, record)):
            yield None


def _record(options: argparse.Namespace, core: World) -> LogRecord:
    record = LogRecord(
        core,
        None if options.record_path is None else Path(options.record_path) / "state.log",
        period=options.record_period or 0.0,
        encoding=options.record_encoding or "zlib",
        filter=options.record_filter or "",
    )
    log.info("recording to [%s]", record.path)
    return record
