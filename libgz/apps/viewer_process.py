"""ViewerProcess: the process of a server's viewer, which is started again if it dies."""

from __future__ import annotations

import logging
import secrets
import subprocess
import threading
import time
from collections.abc import Sequence

from libgz.base.closing import Closing
from libgz.base.python import start_module

__all__ = ["TOKEN", "ViewerProcess"]

log = logging.getLogger("libgz.view")

TOKEN = "LIBGZ_VIEW_TOKEN"  # in the viewer's environment: pages stay connected to one that is started again
PATIENCE = 0.5  # [s] for the viewer of --view to end
WELL = 5.0  # [s] a viewer that ran for so long is started again if it dies


class ViewerProcess(Closing):
    """The process of a viewer, which is started again, with the same address, when it dies.

    Args:
        words: options of `libgz view`.
    """

    def __init__(self, words: Sequence[str]) -> None:
        self._words = words
        self._token = {TOKEN: secrets.token_urlsafe(18)}
        self._ended = threading.Event()
        self._process = self._start()
        self._watch = threading.Thread(target=self._keep, name="viewer", daemon=True)
        self._watch.start()

    def _start(self) -> subprocess.Popen[bytes]:
        words = "view", *self._words
        return start_module("libgz", *words, changes=self._token, stdin=subprocess.DEVNULL, start_new_session=True)

    def _keep(self) -> None:
        """Start the viewer again as often as it dies after a while; one that dies at once would do so again."""
        begin = time.monotonic()
        while self._process.wait() != 0 and not self._ended.is_set():
            if time.monotonic() < begin + WELL:
                return
            log.warning("the viewer ended with code %d and is started again", self._process.returncode)
            begin = time.monotonic()
            self._words = [word for word in self._words if word != "--open"]  # the page is open
            self._process = self._start()

    def close(self) -> None:
        """End the viewer; it may end a little later than this process."""
        self._ended.set()
        self._process.terminate()
        self._watch.join(PATIENCE)
