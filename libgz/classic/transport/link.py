"""The link between processes: a server listens at the address in GAZEBO_MASTER_URI, and clients connect to it.

No other port is opened, and there is no discovery.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import os
import socket
import time as clock
from typing import TYPE_CHECKING, ClassVar

from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.master import Address, get_master_uri
from libgz.classic.transport.topic import log
from libgz.closing import Closing
from libgz.errors import LibraryError, ServerError

if TYPE_CHECKING:
    from libgz.classic.transport.network import Network

__all__ = ["Link", "connect", "serve"]

EXTRA = "pip install 'libgz[net]'"
RETRY = 0.1  # [s] between attempts to connect


class Link(Closing):
    """An open link; a process has at most one. Closed at the end of the process, or of a `with`."""

    current: ClassVar[Link | None] = None

    def __init__(self, address: Address, network: Network | None, claim: socket.socket | None = None) -> None:
        self.address = address
        self._network = network
        self._claim = claim  # without the extra: occupies the port, so that a second server fails to start
        Link.current = self
        if network is not None:
            TopicManager.Instance().link(network)
        atexit.register(self.close)

    @property
    def networked(self) -> bool:
        """Whether other processes can be reached: the extra is installed."""
        return self._network is not None

    def connected(self) -> bool:
        """Whether a client is connected to its server."""
        return self._network is not None and self._network.connected()

    def close(self) -> None:
        """Close the link; publishers and subscribers continue within the process. Can be called twice."""
        atexit.unregister(self.close)
        if Link.current is self:
            Link.current = None
        if self._network is not None:
            network, self._network = self._network, None
            TopicManager.Instance().unlink(network)
            network.close()
        if self._claim is not None:
            self._claim.close()
            self._claim = None


def serve(uri: str | None = None) -> Link:
    """Open this process's topics to clients.

    Without the extra `libgz[net]` the port is occupied as well, and topics stay within the process.

    Args:
        uri: Where to listen, such as `http://localhost:11345`; GAZEBO_MASTER_URI when not given.

    Raises:
        ServerError: the port is in use, or cannot be opened; or this process has a link.
        ParameterError: the URI is invalid.
    """
    address = _free_process(uri)
    claim = _claim(address)
    network_type = _network()
    if network_type is None:
        log.info("topics stay within this process; to reach them from others: %s", EXTRA)
        return Link(address, None, claim)
    claim.close()
    try:
        return Link(address, network_type(address.endpoint, True))
    except OSError as error:
        taken = "already in use" in str(error)
        why = os.strerror(errno.EADDRINUSE) if taken else str(error)
        raise _start_error(why, errno.EADDRINUSE if taken else None) from None


def connect(uri: str | None = None, timeout: float = 30.0) -> Link:
    """Connect this process's topics to those of a server.

    Args:
        uri: Where the server listens; GAZEBO_MASTER_URI when not given.
        timeout: How long to try [s].

    Raises:
        ServerError: there is no server; or this process has a link.
        LibraryError: the extra `libgz[net]` is not installed.
        ParameterError: the URI is invalid.
    """
    address = _free_process(uri)
    network_type = _network()
    if network_type is None:
        raise LibraryError(f"topics of other processes need eclipse-zenoh, which is not installed: {EXTRA}")
    end = clock.monotonic() + timeout
    while True:
        try:
            return Link(address, network_type(address.endpoint, False, max(0.5, min(10.0, end - clock.monotonic()))))
        except OSError:
            if clock.monotonic() + RETRY >= end:
                raise ServerError(_no_master(address, timeout)) from None
            clock.sleep(RETRY)


def _free_process(uri: str | None) -> Address:
    """Return the address to use.

    Raises:
        ServerError: this process has a link.
        ParameterError: the URI is invalid.
    """
    address = get_master_uri(uri)
    if Link.current is not None:
        raise ServerError(f"this process has a link to {Link.current.address.uri} already; close it first")
    return address


def _network() -> type[Network] | None:
    """Return the class that connects to other processes, or None without the extra."""
    try:
        from libgz.classic.transport.network import Network
    except ImportError as error:
        if (error.name or "").partition(".")[0] != "zenoh":
            raise
        return None
    return Network


def _claim(address: Address) -> socket.socket:
    """Return a socket bound to the address, which shows that the address is free."""
    try:
        family, kind, protocol, _, where = socket.getaddrinfo(*address, type=socket.SOCK_STREAM)[0]
        claim = socket.socket(family, kind, protocol)
    except OSError as error:
        raise _start_error(error.strerror or str(error)) from None
    try:
        claim.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        claim.bind(where)
        claim.listen()  # bind alone succeeds on a port that another process listens on
    except OSError as error:
        claim.close()
        raise _start_error(error.strerror or str(error), error.errno) from None
    return claim


def _start_error(why: str, number: int | None = None) -> ServerError:
    """Return the error with the original server's text."""
    text = f"Unable to start server[bind: {why}]. There is probably another Gazebo process running."
    if number != errno.EADDRINUSE:
        text += f" The address comes from GAZEBO_MASTER_URI, which is {os.environ.get('GAZEBO_MASTER_URI')!r}."
    return ServerError(text)


def _no_master(address: Address, timeout: float) -> str:
    """Return the original client's text, with a possible reason."""
    why = f"there is no server at {address.uri}; GAZEBO_MASTER_URI sets another address"
    with contextlib.suppress(OSError), socket.create_connection(address, timeout=1.0):
        why = f"the process that listens at {address.uri} does not answer; a server of libgz needs {EXTRA}"
    return f"Failed to connect to master in {timeout:g} seconds. ({why})"
