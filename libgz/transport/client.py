"""Client: a connection to a server, which opens interfaces and waits for the server's posts."""

from __future__ import annotations

import errno
import os
import time
from pathlib import Path
from typing import Any

from libgz.base.errors import InterfaceError, ParameterError, ServerError, nearest
from libgz.transport.interface import Interface
from libgz.transport.paths import LOCK_FILE, check_server_id, server_directory
from libgz.transport.semaphores import CLIENTS, SemaphoreSet

__all__ = ["Client"]

_POLL = 0.02  # [s]


class Client:
    """A connection to a server.

    Client ids: 0 to 7 are for users' programs, 8 for wxgazebo, 9 for Player. If two clients wait under one id, each
    post wakes only one of them.
    """

    def __init__(self) -> None:
        self.server_id = 0
        self.client_id = -1
        self.path = ""
        self.opened: list[Interface[Any]] = []
        self._semaphores: SemaphoreSet | None = None

    def __repr__(self) -> str:
        names = ", ".join(f"{interface.type}.{interface.id}" for interface in self.opened)
        return f"<{type(self).__name__} of server {self.server_id}{': ' if names else ''}{names}>"

    @staticmethod
    def query(server_id: int) -> bool:
        """Whether a server with this id is present.

        Raises:
            InterfaceError: the semaphores belong to another user.
        """
        try:
            SemaphoreSet.attach(server_id)
        except FileNotFoundError:
            return False
        except OSError as error:
            raise InterfaceError(f"failed to query semaphore [{error.strerror}]") from None
        return True

    def connect(self, server_id: int) -> None:
        """Set the server of a client that does not wait. The server need not run yet.

        Raises:
            ParameterError: the server id is invalid, or the path of its directory is too long.
        """
        self.connect_wait(server_id, -1)

    def connect_wait(self, server_id: int, client_id: int) -> None:
        """Connect so that `wait` works.

        Raises:
            ParameterError: the client id is above 15, the server id is invalid, or the path of its directory is too
                long.
            ServerError: there is no such server, or its semaphores belong to another user.
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
        """Sleep until the server serves all its interfaces; it creates `sim` last.

        Args:
            timeout: [s].

        Raises:
            ServerError: the server was not ready before the timeout.
            InterfaceError: the semaphores belong to another user.
        """
        end = time.monotonic() + timeout
        ready = Path(self.path) / "sim.default"
        while not (self.query(self.server_id) and ready.exists()):
            if time.monotonic() >= end:
                raise ServerError(f"server {self.server_id} does not appear to be running ({ready} does not exist)")
            time.sleep(_POLL)

    def wait(self, timeout: float | None = None) -> bool:
        """Sleep until a post, of a step or of a device; the first wait may return at once.

        The server posts at the end of each step, lasers, cameras and other devices whenever they have new data: waits
        do not count steps. The `time` of an interface shows whether its data are new.

        Args:
            timeout: [s]; None waits without a limit.

        Returns:
            Whether the server posted before the timeout. Always True for a client without an id.

        Raises:
            ServerGoneError: the server ended.
            InterfaceError: the wait failed for another reason.
            ParameterError: the timeout is negative or NaN.
        """
        if self._semaphores is None:
            return True
        return self._semaphores.wait(self.client_id, timeout)

    def interfaces(self) -> list[tuple[str, str]]:
        """(type, id) of all interfaces of the server, sorted."""
        try:
            names = sorted(os.listdir(self.path))  # noqa: PTH208
        except OSError:
            return []
        pairs = (name.partition(".") for name in names if name != LOCK_FILE)
        return [(kind, name) for kind, dot, name in pairs if kind and dot]

    def hint(self, kind: str, name: str) -> str:
        """The end of an error message about an interface that is not served: those of its type, and similar ids."""
        served = [other for k, other in self.interfaces() if k == kind]
        if not served:
            return f"; server {self.server_id} serves no {kind} interface"
        return f"; its {kind} interfaces are {', '.join(map(repr, served))}{nearest(name, served)}"

    def disconnect(self) -> None:
        """Close all interfaces opened through this client. Can be called twice."""
        for interface in list(self.opened):
            interface.close()
        self._semaphores = None
