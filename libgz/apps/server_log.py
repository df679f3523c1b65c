"""The log options of gzserver: record a running world, or play a log file."""

from __future__ import annotations

import argparse
import contextlib
import logging
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import libgz.classic.log as logs
from libgz.apps.console import number_from_zero
from libgz.classic.log.control import PlaybackControl, RecordControl
from libgz.classic.log.file import ENCODINGS
from libgz.classic.server import attach
from libgz.front import World

if TYPE_CHECKING:
    from libgz.classic.log import LogPlay, LogRecord

__all__ = ["add_log_options", "keep_log"]

log = logging.getLogger("libgz.classic")


def add_log_options(parser: argparse.ArgumentParser) -> None:
    """Add classic's options."""
    add = parser.add_argument
    add("-p", "--play", metavar="LOG", help="play a log file instead of a world")
    add(
        "-r",
        "--record",
        action="store_true",
        help="record a log file; implied by the next four options. With view=FILE or ID=FILE behind it: a video of the "
        "whole world, or of a legacy camera; may be repeated",
    )
    add("--record_path", metavar="FOLDER", help="directory of state.log (default ~/.gazebo/log/<time>/gzserver)")
    add(
        "--record_period",
        type=number_from_zero("number of seconds"),
        metavar="S",
        help="sim time between two states [s] (default: every step)",
    )
    add("--record_encoding", choices=tuple(ENCODINGS), help="encoding of the states (default zlib)")
    add(
        "--record_filter", metavar="NAMES", help="names of models to record, a pattern with * or a regex (default: all)"
    )


@contextlib.contextmanager
def keep_log(options: argparse.Namespace, core: World, play: LogPlay | None) -> Iterator[PlaybackControl | None]:
    """Record a world, or play a log, as set by options and topics; yields the control of a played log, else None.

    Raises:
        GazeboError: the log cannot be written.
    """
    details = options.record_path, options.record_period, options.record_encoding, options.record_filter
    wanted = options.record or any(detail is not None for detail in details)
    if core.sdf is None:
        if wanted:
            log.error("a legacy world cannot be recorded; convert it to an SDF world with `libgz convert`")
        yield None
    elif play is not None:
        if wanted:
            log.warning("a played log is not recorded")
        with contextlib.closing(PlaybackControl(play)) as control:
            yield control
    else:
        record = _record(options, core) if wanted else None
        with contextlib.closing(RecordControl(attach(core).world, record)):
            yield None


def _record(options: argparse.Namespace, core: World) -> LogRecord:
    record = logs.LogRecord(
        core,
        None if options.record_path is None else Path(options.record_path) / "state.log",
        period=options.record_period or 0.0,
        encoding=options.record_encoding or "zlib",
        filter=options.record_filter or "",
    )
    log.info("recording to [%s]", record.path)
    return record
