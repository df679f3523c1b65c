"""The client's side of the wire: finding a server, and sleeping until it has news."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz.errors import InterfaceError, ParameterError, ServerError, nearest
from libgz.transport.paths import check_server_id, server_directory
from libgz.transport.semaphores import CLIENTS, SemaphoreSet

if TYPE_CHECKING:
    from libgz.transport.interface import Interface

__all__ = ["Client"]

_POLL = 0.02  # [s]


class Client:
    """A connection to a server; it opens interfaces and waits for news.

    Client ids: 0 to 7 are for users' programs, 8 for wxgazebo, 9 for Player. Two clients that wait under one id
    steal each other's news.
    """

    def __init__(self) -> None:
        self.server_id = 0
        self.client_id = -1
        self.path = ""
        self.opened: list[Interface[Any]] = []
        self._semaphores: SemaphoreSet | None = None

    @staticmethod
    def query(server_id: int) -> bool:
        """Whether a server with this id is there.

        Raises:
            InterfaceError: it cannot be told, because the semaphores are another user's.
        """
        try:
            SemaphoreSet.attach(server_id)
        except FileNotFoundError:
            return False
        except OSError as error:
            raise InterfaceError(f"failed to query semaphore [{error.strerror}]") from None
        return True

    def connect(self, server_id: int) -> None:
        """Take note of a server: interfaces can be opened. It cannot be waited for, and need not be there yet."""
        self.connect_wait(server_id, -1)

    def connect_wait(self, server_id: int, client_id: int) -> None:
        """Connect so that `wait` works.

        Raises:
            ParameterError: the client id is above 15.
            ServerError: there is no such server.
        """
        if client_id >= CLIENTS:
            raise ParameterError(f"invalid client ID [{client_id}]: 0 to {CLIENTS - 1} are allowed")
        self.server_id, self.client_id = check_server_id(server_id), client_id
        self.path = server_directory(self.server_id)
        self._semaphores = None
        if client_id < 0:
            return
        try:
            self._semaphores = SemaphoreSet.attach(server_id)
        except OSError as error:
            reason = "there is none" if error.errno == errno.ENOENT else error.strerror
            raise ServerError(
                f"Failed to allocate semaphore [{reason}]: server {server_id} does not appear to be running"
            ) from None

    def wait_for_server(self, timeout: float) -> None:
        """Sleep until the server serves all its interfaces; `sim` is the one it makes last.

        Raises:
            ServerError: it was not there in time.
        """
        end = time.monotonic() + timeout
        ready = Path(self.path) / "sim.default"
        while not (self.query(self.server_id) and ready.exists()):
            if time.monotonic() >= end:
                raise ServerError(f"server {self.server_id} does not appear to be running ({ready} is not there)")
            time.sleep(_POLL)

    def wait(self, timeout: float | None = None) -> bool:
        """Sleep until the server posts, once a simulation step; the first wait may return at once.

        Args:
            timeout: [s]; None waits for ever.

        Returns:
            Whether there is news; False when the time was over. Always True for a client without an id.

        Raises:
            ServerGoneError: the server ended.
        """
        if self._semaphores is None:
            return True
        return self._semaphores.wait(self.client_id, timeout)

    def interfaces(self) -> list[tuple[str, str]]:
        """(type, id) of all interfaces the server serves."""
        try:
            names = sorted(os.listdir(self.path))  # noqa: PTH208
        except OSError:
            return []
        pairs = (name.partition(".") for name in names if name != "gazebo.pid")
        return [(kind, name) for kind, dot, name in pairs if dot]

    def hint(self, kind: str, name: str) -> str:
        """What to say of an interface that is not there."""
        served = [other for k, other in self.interfaces() if k == kind]
        if not served:
            return f"; server {self.server_id} serves no {kind} interface"
        return f"; its {kind} interfaces are {', '.join(map(repr, served))}{nearest(name, served)}"

    def disconnect(self) -> None:
        """Close all interfaces opened through this client. Can be called twice."""
        for interface in list(self.opened):
            interface.close()
        self._semaphores = None
