"""The functions of the old C library in Python: `gz_server_*`, `gz_client_*`, `gz_error_*`, and those of interfaces.

As in C, they return 0, or -1 after logging an error; `gz_error_str` returns the last error message.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from libgz.base.errors import GazeboError
from libgz.transport.client import Client
from libgz.transport.interface import Interface
from libgz.transport.server import LocalServer, Server

__all__ = [
    "GZ_CLIENT_ID_PLAYER",
    "GZ_CLIENT_ID_USER_FIRST",
    "GZ_CLIENT_ID_USER_LAST",
    "GZ_CLIENT_ID_WXGAZEBO",
    "LegacyFunctions",
    "gz_client_alloc",
    "gz_client_connect",
    "gz_client_connect_wait",
    "gz_client_disconnect",
    "gz_client_free",
    "gz_client_query",
    "gz_client_wait",
    "gz_error_init",
    "gz_error_str",
    "gz_server_alloc",
    "gz_server_fini",
    "gz_server_free",
    "gz_server_init",
    "gz_server_post",
]

log = logging.getLogger("libgz.transport")

GZ_CLIENT_ID_USER_FIRST, GZ_CLIENT_ID_USER_LAST = 0, 7
GZ_CLIENT_ID_WXGAZEBO = 8
GZ_CLIENT_ID_PLAYER = 9

I = TypeVar("I", bound=Interface[Any])  # noqa: E741


class _ErrorState:
    """The last error message, and whether errors are logged: one for the process, as in the C library."""

    def __init__(self) -> None:
        self.last = ""
        self.logged = True

    def report(self, error: GazeboError) -> None:
        self.last = str(error)[:1023]
        if self.logged:
            log.error("%s", error)


_errors = _ErrorState()


def gz_error_init(print: int, level: int) -> None:
    """Switch the logging of errors on or off.

    Args:
        print: 0 switches it off.
        level: from 1, informational messages are logged, too; from 5, also the opening and closing of files.
    """
    _errors.logged = bool(print)
    log.setLevel(logging.DEBUG if level >= 5 else logging.INFO if level >= 1 else logging.WARNING)


def gz_error_str() -> str:
    """The last error message, at most 1023 characters."""
    return _errors.last


def _attempt(action: Callable[[], int | None]) -> int:
    """The result of an action, 0 if that is None, or -1 after it raised an error, which is logged."""
    try:
        return action() or 0
    except GazeboError as error:
        _errors.report(error)
        return -1


# Server ----------------------------------------------------------------------------------------------------------


def gz_server_alloc() -> Server:
    """A server that is not running."""
    return Server()


def gz_server_free(server: Server) -> None:
    """Nothing to do."""


def gz_server_init(server: Server, server_id: int, force: int) -> int:
    """Start a server under an id; `force` takes over an id whose owner may be alive. Returns 0 or -1."""

    def start() -> None:
        server.configure(server_id, bool(force))
        server.start()

    return _attempt(start)


def gz_server_fini(server: Server) -> int:
    """Stop a server; files, directory and semaphores are removed. Returns 0 or -1."""
    return _attempt(server.stop)


def gz_server_post(server: LocalServer) -> int:
    """Wake all clients. Returns 0 or -1."""
    return _attempt(server.post)


# Client ----------------------------------------------------------------------------------------------------------


def gz_client_alloc() -> Client:
    """A client that is not connected."""
    return Client()


def gz_client_free(client: Client) -> None:
    """Nothing to do."""


def gz_client_query(client: Client, server_id: int) -> int:
    """0 if the server is present, 1 if not, -1 if its semaphores belong to another user."""
    return _attempt(lambda: 0 if client.query(server_id) else 1)


def gz_client_connect(client: Client, server_id: int) -> int:
    """Connect without the ability to wait. Returns 0 or -1."""
    return gz_client_connect_wait(client, server_id, -1)


def gz_client_connect_wait(client: Client, server_id: int, client_id: int) -> int:
    """Connect as client number `client_id`, 0 to 15. Returns 0 or -1."""
    return _attempt(lambda: client.connect_wait(server_id, client_id))


def gz_client_disconnect(client: Client) -> int:
    """Close all open interfaces. Returns 0 or -1."""
    return _attempt(client.disconnect)


def gz_client_wait(client: Client, timeout: float | None = None) -> int:
    """Sleep until the server posts: 0, or -1 when the server ended, or 1 after a timeout [s] if one is given."""
    return _attempt(lambda: 0 if client.wait(timeout) else 1)


# Interfaces ------------------------------------------------------------------------------------------------------


class LegacyFunctions(Generic[I]):
    """The functions `gz_<type>_*` of one kind of interface.

    Those with an int as result return 0, or -1 after logging an error.
    """

    def __init__(self, kind: type[I]) -> None:
        self._kind = kind

    def alloc(self) -> I:
        """An interface that is neither created nor open."""
        return self._kind()

    def free(self, interface: I) -> None:
        """Nothing to do."""

    def create(
        self,
        interface: I,
        server: LocalServer,
        id: str | None,
        model_type: str = "",
        model_id: int = 0,
        parent_model_id: int = 0,
    ) -> int:
        """Create the interface on a server."""
        return _attempt(lambda: interface.create(server, id, model_type, model_id, parent_model_id))

    def destroy(self, interface: I) -> int:
        """Remove the interface from its server."""
        return _attempt(interface.destroy)

    def open(self, interface: I, client: Client, id: str | None) -> int:
        """Open an interface that a server serves."""
        return _attempt(lambda: interface.open(client, id))

    def close(self, interface: I) -> int:
        """Close the interface."""
        return _attempt(interface.close)

    def lock(self, interface: I, blocking: int = 1) -> int:
        """Take the lock; `blocking` is ignored. -1 also if a server could not take it within its time limit."""
        return _attempt(lambda: 0 if interface.lock() else -1)

    def unlock(self, interface: I) -> None:
        """Release the lock."""
        interface.unlock()

    def post(self, interface: I) -> int:
        """Wake the server's clients."""
        return _attempt(interface.post)
