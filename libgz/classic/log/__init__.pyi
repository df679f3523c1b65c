"""The public names of libgz.classic.log, and the one module that each comes from."""

from libgz.classic.log.control import PlaybackControl as PlaybackControl, RecordControl as RecordControl
from libgz.classic.log.file import (
    ENCODINGS as ENCODINGS,
    LogHeader as LogHeader,
    LogReader as LogReader,
    LogWriter as LogWriter,
)
from libgz.classic.log.play import LogPlay as LogPlay, LogState as LogState, read_states as read_states
from libgz.classic.log.record import (
    LogRecord as LogRecord,
    NamePattern as NamePattern,
    default_log_path as default_log_path,
)
