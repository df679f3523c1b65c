"""Portraits of the models of the catalogue, which a process of its own makes when a page first asks for one."""

from __future__ import annotations

import collections
import json
import logging
import subprocess
import threading
from collections.abc import Callable

from libgz.base.closing import Closing
from libgz.base.errors import GazeboError
from libgz.base.python import start_module
from libgz.view.assets import JPEG, Asset

__all__ = ["Portraits"]

log = logging.getLogger("libgz.view")

PATIENCE = 60.0  # [s] for a portrait
IDLE = 10.0  # [s] after which the process ends
MOST_KEPT = 3000
LARGEST = 1 << 20  # [byte]
MOST_FAILURES = 5  # processes in a row that ended without an answer: then there are no portraits


class Portraits(Closing):
    """Makes portraits, one at a time.

    Args:
        text_of: the text of a model of the catalogue by its name; None if there is none. It may raise GazeboError.
    """

    def __init__(self, text_of: Callable[[str], str | None]) -> None:
        self._text_of = text_of
        self._kept: collections.OrderedDict[str, Asset | None] = collections.OrderedDict()  # by the text
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._idle: threading.Timer | None = None
        self._failures, self._closed = 0, False

    def get(self, name: str) -> Asset | None:
        """The portrait of a model; None if it has none. It may take `PATIENCE`; safe in every thread."""
        try:
            text = self._text_of(name)
        except GazeboError:
            return None
        if text is None:
            return None
        with self._lock:
            if text not in self._kept:
                body = self._made(text)
                if body is None:
                    return None
                self._kept[text] = Asset(body, JPEG) if body else None
                if len(self._kept) > MOST_KEPT:
                    self._kept.popitem(last=False)
            return self._kept[text]

    def _made(self, text: str) -> bytes | None:
        """The portrait of a text; empty if nothing of it is seen, None if its process ended."""
        if self._closed or self._failures >= MOST_FAILURES:
            return None
        process = self._process or self._started()
        late = threading.Timer(PATIENCE, process.kill)
        late.start()
        try:
            body = _asked(process, text)
        except (OSError, ValueError):  # the process has ended
            self._failures += 1
            log.warning("a portrait of a model was not made: its process ended")
            self._end()
            return None
        finally:
            late.cancel()
        self._failures = 0
        self._rest()
        return body

    def _started(self) -> subprocess.Popen[bytes]:
        self._process = start_module(
            "libgz.view.portrait", stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        return self._process

    def _rest(self) -> None:
        """End the process if nothing is asked for some time."""
        if self._idle is not None:
            self._idle.cancel()
        self._idle = threading.Timer(IDLE, self._sleep)
        self._idle.daemon = True
        self._idle.start()

    def _sleep(self) -> None:
        with self._lock:
            if self._idle is threading.current_thread():  # else there was another request
                self._end()

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.communicate()

    def close(self) -> None:
        """Make no more portraits. Can be called twice."""
        self._closed = True
        if self._process is not None:
            self._process.kill()  # one that is being made ends now
        with self._lock:
            if self._idle is not None:
                self._idle.cancel()
            self._end()


def _asked(process: subprocess.Popen[bytes], text: str) -> bytes:
    """What the process answers.

    Raises:
        OSError: it has ended.
        ValueError: it has ended, or its answer is none.
    """
    stdin, stdout = process.stdin, process.stdout
    if stdin is None or stdout is None:
        return b""
    stdin.write(json.dumps({"text": text}).encode() + b"\n")
    stdin.flush()
    length = int(stdout.readline())
    body = stdout.read(length) if 0 <= length <= LARGEST else b""
    if len(body) != length:
        raise ValueError(f"{len(body)} of {length} bytes")
    return body
