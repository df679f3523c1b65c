"""Logs of runs: recording, reading and playback."""

from __future__ import annotations

from libgz.classic.log.control import PlaybackControl, RecordControl
from libgz.classic.log.file import ENCODINGS, LogHeader, LogReader, LogWriter
from libgz.classic.log.play import LogPlay, read_states
from libgz.classic.log.record import LogRecord, NamePattern, default_log_path
from libgz.sdf.state import SdfState as LogState

__all__ = [
    "ENCODINGS",
    "LogHeader",
    "LogPlay",
    "LogReader",
    "LogRecord",
    "LogState",
    "LogWriter",
    "NamePattern",
    "PlaybackControl",
    "RecordControl",
    "default_log_path",
    "read_states",
]
