"""The link between processes: a server listens where GAZEBO_MASTER_URI says, clients connect to it.

Nothing else is opened on the network, and nothing is searched for.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import os
import socket
import time as clock
from types import TracebackType
from typing import TYPE_CHECKING, ClassVar

from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.master import Address, get_master_uri
from libgz.classic.transport.topic import log
from libgz.errors import LibraryError, ServerError

if TYPE_CHECKING:
    from libgz.classic.transport.network import Network

__all__ = ["Link", "connect", "serve"]

EXTRA = "pip install 'libgz[net]'"
RETRY = 0.1  # [s] between attempts to connect


class Link:
    """An open link; there is one in a process at most. Closed at the end of the process, or of a `with`."""

    current: ClassVar[Link | None] = None

    def __init__(self, address: Address, network: Network | None, claim: socket.socket | None = None) -> None:
        self.address = address
        self._network = network
        self._claim = claim  # without the extra: holds the port, so that a second server notices
        Link.current = self
        if network is not None:
            TopicManager.Instance().link(network)
        atexit.register(self.close)

    @property
    def networked(self) -> bool:
        """Whether other processes can be reached: the extra is installed."""
        return self._network is not None

    def connected(self) -> bool:
        """Whether a client's server is there."""
        return self._network is not None and self._network.connected()

    def close(self) -> None:
        """Close the link; publishers and subscribers go on within the process. Once is enough."""
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

    def __enter__(self) -> Link:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


def serve(uri: str | None = None) -> Link:
    """Be the server that clients find.

    Without the extra `libgz[net]` the port is held all the same, and topics stay within the process.

    Args:
        uri: Where to listen, such as `http://localhost:11345`; GAZEBO_MASTER_URI when not given.

    Raises:
        ServerError: the port is in use, or cannot be opened; or this process has a link.
        ParameterError: the URI cannot be read.
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
    """Reach the topics of a server, and offer ours to it.

    Args:
        uri: Where the server listens; GAZEBO_MASTER_URI when not given.
        timeout: How long to try [s].

    Raises:
        ServerError: there is no server; or this process has a link.
        LibraryError: the extra `libgz[net]` is not installed.
        ParameterError: the URI cannot be read.
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
    """The address, if this process has no link yet."""
    address = get_master_uri(uri)
    if Link.current is not None:
        raise ServerError(f"this process has a link to {Link.current.address.uri} already; close it first")
    return address


def _network() -> type[Network] | None:
    """The way to other processes, or None without the extra."""
    try:
        from libgz.classic.transport.network import Network
    except ImportError as error:
        if (error.name or "").partition(".")[0] != "zenoh":
            raise
        return None
    return Network


def _claim(address: Address) -> socket.socket:
    """A socket bound to the address: asks the system in its own words whether it is free."""
    try:
        family, kind, protocol, _, where = socket.getaddrinfo(*address, type=socket.SOCK_STREAM)[0]
        claim = socket.socket(family, kind, protocol)
    except OSError as error:
        raise _start_error(error.strerror or str(error)) from None
    try:
        claim.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        claim.bind(where)
        claim.listen()  # only then is a port that somebody else listens on refused
    except OSError as error:
        claim.close()
        raise _start_error(error.strerror or str(error), error.errno) from None
    return claim


def _start_error(why: str, number: int | None = None) -> ServerError:
    """The old server's sentence."""
    text = f"Unable to start server[bind: {why}]. There is probably another Gazebo process running."
    if number != errno.EADDRINUSE:
        text += f" The address comes from GAZEBO_MASTER_URI, which is {os.environ.get('GAZEBO_MASTER_URI')!r}."
    return ServerError(text)


def _no_master(address: Address, timeout: float) -> str:
    """The old client's sentence, and what may be the matter."""
    why = f"there is no server at {address.uri}, which GAZEBO_MASTER_URI would change"
    with contextlib.suppress(OSError), socket.create_connection(address, timeout=1.0):
        why = f"what listens at {address.uri} does not answer; if it is a server of libgz, it wants {EXTRA}"
    return f"Failed to connect to master in {timeout:g} seconds. ({why})"
