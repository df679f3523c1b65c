"""Ending: ends a process natively (ending.c) where native code keeps Python's interpreter lock, if that was built."""

from __future__ import annotations

import contextlib
import ctypes
import faulthandler
import logging
import os
import signal
import threading
from functools import lru_cache
from pathlib import Path

__all__ = ["Relay", "forget", "note"]

log = logging.getLogger("libgz.transport")

STDERR = 2
REPORT = signal.SIGRTMAX - 3  # no other program sends it; its handler prints the main thread's stack


@lru_cache
def _library() -> ctypes.CDLL | None:
    """The native part, or None where it was not built."""
    path = Path(__file__).with_name("_ending.so")
    if not path.exists():
        return None
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        log.warning("a second signal does not end native code that keeps Python's interpreter lock: %s", error)
        return None
    library.gz_ending_start.argtypes = [*([ctypes.c_int] * 2), ctypes.c_ulong, ctypes.c_int, ctypes.c_void_p * 3]
    library.gz_ending_note.argtypes = [ctypes.c_char_p, ctypes.c_int]
    library.gz_ending_forget.argtypes = [ctypes.c_char_p]
    for function in (library.gz_ending_join, library.gz_ending_note, library.gz_ending_forget):
        function.restype = None
    return library


def _threads() -> ctypes.Array[ctypes.c_void_p]:
    """The process's functions to create a thread, to wait for its end, and to send it a signal."""
    process = ctypes.CDLL(None)
    functions = (process.pthread_create, process.pthread_join, process.pthread_kill)
    return (ctypes.c_void_p * 3)(*(ctypes.cast(function, ctypes.c_void_p).value for function in functions))


def note(path: str, semaphores: int) -> None:
    """Note what a server must not leave behind: its directory, and its set of semaphores."""
    library = _library()
    if library is not None:
        library.gz_ending_note(os.fsencode(path), semaphores)


def forget(path: str) -> None:
    """Forget the server of a directory: it has ended."""
    library = _library()
    if library is not None:
        library.gz_ending_forget(os.fsencode(path))


class Relay:
    """Passes on the numbers of signals from a pipe to the watchdog, in a thread that needs no interpreter lock.

    0.9 s after the second SIGINT, SIGTERM or SIGHUP it ends the process, if the watchdog has not. Only one may run.

    Args:
        source: where they are read; a 0 ends the relay.

    Attributes:
        reader: where the watchdog reads them: `source` itself without the native part.
    """

    def __init__(self, source: int) -> None:
        self.reader = source
        self._writer = -1
        self._beat: ctypes.c_int64 | None = None
        library = _library()
        if library is None:
            return
        number = self._register()
        reader, writer = os.pipe()
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        try:
            error = library.gz_ending_start(source, writer, threading.main_thread().ident, number, _threads())
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
        if error != 0:
            os.close(reader)
            os.close(writer)
            self._unregister()
            return
        self.reader, self._writer = reader, writer
        self._beat = ctypes.c_int64.in_dll(library, "gz_ending_beat")

    @staticmethod
    def _register() -> int:
        """Have a signal print the main thread's stack; its number, 0 if that is impossible."""
        try:
            faulthandler.register(REPORT, file=STDERR, all_threads=False)
        except (OSError, RuntimeError, ValueError):  # there is no such stream, or no such signal
            return 0
        return REPORT

    @staticmethod
    def _unregister() -> None:
        with contextlib.suppress(ValueError):  # there is no such signal
            faulthandler.unregister(REPORT)

    def beat(self) -> None:
        """Python code runs: called again and again, at least every second."""
        if self._beat is not None:
            self._beat.value += 1

    def close(self) -> None:
        """Wait for the end of the thread: a 0 was written."""
        library = _library()
        if self._beat is None or library is None:
            return
        library.gz_ending_join()
        self._beat = None
        for descriptor in (self.reader, self._writer):
            os.close(descriptor)
        self._unregister()
