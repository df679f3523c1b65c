"""The old C library's functions in Python: `gz_server_*`, `gz_client_*`, `gz_error_*`, and a set per interface.

They return 0, or -1 after logging what went wrong, as their originals did; `gz_error_str` gives the last message.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from libgz.errors import GazeboError
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


class _Errors:
    """The last message, and whether messages are logged."""

    last = ""
    logged = True


def gz_error_init(print: int, level: int) -> None:
    """Switch the logging of errors on or off; level 5 and up logs files being opened and closed, too."""
    _Errors.logged = bool(print)
    log.setLevel(logging.DEBUG if level >= 5 else logging.INFO if level >= 1 else logging.WARNING)


def gz_error_str() -> str:
    """The last error message."""
    return _Errors.last


def _attempt(action: Callable[[], object]) -> int:
    """0, or -1 and a logged message."""
    try:
        action()
    except GazeboError as error:
        _Errors.last = str(error)[:1023]
        if _Errors.logged:
            log.error("%s", error)
        return -1
    return 0


# Server ----------------------------------------------------------------------------------------------------------


def gz_server_alloc() -> Server:
    """A server that was not started."""
    return Server()


def gz_server_free(server: Server) -> None:
    """Nothing to do."""


def gz_server_init(server: Server, server_id: int, force: int) -> int:
    """Start serving under an id."""

    def start() -> None:
        server.__init__(server_id, bool(force))  # type: ignore[misc]
        server.start()

    return _attempt(start)


def gz_server_fini(server: Server) -> int:
    """Stop serving; files, directory and semaphores are removed."""
    return _attempt(server.stop)


def gz_server_post(server: LocalServer) -> int:
    """Wake all clients."""
    return _attempt(server.post)


# Client ----------------------------------------------------------------------------------------------------------


def gz_client_alloc() -> Client:
    """A client that is not connected."""
    return Client()


def gz_client_free(client: Client) -> None:
    """Nothing to do."""


def gz_client_query(client: Client, server_id: int) -> int:
    """0 if the server is there, 1 if not, -1 if that cannot be told."""
    present: list[bool] = []
    if _attempt(lambda: present.append(client.query(server_id))) != 0:
        return -1
    return 0 if present[0] else 1


def gz_client_connect(client: Client, server_id: int) -> int:
    """Connect without the ability to wait."""
    return gz_client_connect_wait(client, server_id, -1)


def gz_client_connect_wait(client: Client, server_id: int, client_id: int) -> int:
    """Connect as client number `client_id`."""
    return _attempt(lambda: client.connect_wait(server_id, client_id))


def gz_client_disconnect(client: Client) -> int:
    """Close what is open."""
    return _attempt(client.disconnect)


def gz_client_wait(client: Client, timeout: float | None = None) -> int:
    """Sleep until the server posts; 0, or -1 when the server ended. 1 if a timeout [s] was given and is over."""
    news: list[bool] = []
    if _attempt(lambda: news.append(client.wait(timeout))) != 0:
        return -1
    return 0 if news[0] else 1


# Interfaces ------------------------------------------------------------------------------------------------------


class LegacyFunctions(Generic[I]):
    """The functions `gz_<type>_*` of one kind of interface."""

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
        """Make the interface on a server."""
        return _attempt(lambda: interface.create(server, id, model_type, model_id, parent_model_id))

    def destroy(self, interface: I) -> int:
        """Take the interface off its server."""
        return _attempt(interface.destroy)

    def open(self, interface: I, client: Client, id: str | None) -> int:
        """Open an interface that a server serves."""
        return _attempt(lambda: interface.open(client, id))

    def close(self, interface: I) -> int:
        """Close the interface."""
        return _attempt(interface.close)

    def lock(self, interface: I, blocking: int = 1) -> int:
        """Take the lock; `blocking` never had an effect. -1 if the server could not have it in time."""
        taken: list[bool] = []
        return -1 if _attempt(lambda: taken.append(interface.lock())) or not taken[0] else 0

    def unlock(self, interface: I) -> None:
        """Give the lock back."""
        interface.unlock()

    def post(self, interface: I) -> int:
        """Wake the server's clients."""
        return _attempt(interface.post)
