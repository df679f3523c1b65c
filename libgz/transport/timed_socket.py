"""Timed socket: a connection with one timeout for all together: who sends byte by byte is never late with a byte."""

from __future__ import annotations

import socket
import time
from typing import Any

__all__ = ["TimedSocket"]


class TimedSocket(socket.socket):
    """A connected socket that is used until a time [s], as `time.monotonic` counts; later, TimeoutError is raised.

    Args:
        descriptor: of the socket, which this one owns then.
        deadline: the time, which can be set anew.
    """

    def __init__(self, descriptor: int, deadline: float) -> None:
        super().__init__(fileno=descriptor)
        self.deadline = deadline

    def _wait(self) -> None:
        left = self.deadline - time.monotonic()
        if left <= 0.0:
            raise TimeoutError("timed out")
        self.settimeout(left)

    def sendall(self, *values: Any) -> None:
        """Send all."""
        self._wait()
        super().sendall(*values)

    def send(self, *values: Any) -> int:
        """Send what is taken at once."""
        self._wait()
        return super().send(*values)

    def recv_into(self, *values: Any) -> int:
        """Receive what comes next."""
        self._wait()
        return super().recv_into(*values)
