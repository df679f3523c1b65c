"""The link between processes: a server is the master at the address in GAZEBO_MASTER_URI, and clients connect to it."""

from __future__ import annotations

import atexit
import errno
import os
import time
from typing import ClassVar

from libgz.base.closing import Closing
from libgz.base.errors import ServerError
from libgz.classic.transport.address import Address, get_master_uri
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.network import Network

__all__ = ["Link", "connect", "serve"]

RETRY = 0.1  # [s] between attempts to connect


class Link(Closing):
    """An open link; a process has at most one. Closed at the end of the process, or of a `with`."""

    current: ClassVar[Link | None] = None

    def __init__(self, network: Network) -> None:
        self.address = network.address
        self._network: Network | None = network
        Link.current = self
        TopicManager.Instance().link(network)
        atexit.register(self.close)

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


def serve(uri: str | None = None, *, watch_only: bool = False) -> Link:
    """Open this process's topics to clients: start the master of Gazebo classic's protocol.

    Args:
        uri: Where to listen, such as `http://localhost:11345`; GAZEBO_MASTER_URI when not given. Port 0 takes a free
            one, which is in the link's `address`.
        watch_only: Whether clients may only receive, and ask for what they show; what else they publish is ignored.

    Raises:
        ServerError: the port is in use, or cannot be opened; or this process has a link.
        ParameterError: the URI is invalid.
    """
    address = _free_process(uri)
    try:
        return Link(Network(address, True, watch_only=watch_only))
    except OSError as error:
        raise _start_error(error) from None


def connect(uri: str | None = None, timeout: float = 30.0) -> Link:
    """Connect this process's topics to those of a server: one of libgz, or of Gazebo classic.

    Args:
        uri: Where the server listens; GAZEBO_MASTER_URI when not given.
        timeout: How long to try [s].

    Raises:
        ServerError: there is no server; or this process has a link.
        ParameterError: the URI is invalid.
    """
    address = _free_process(uri)
    end = time.monotonic() + timeout
    while True:
        try:
            return Link(Network(address, False, max(0.5, min(10.0, end - time.monotonic()))))
        except OSError as error:
            if time.monotonic() + RETRY >= end:
                raise ServerError(_no_master(address, timeout, error)) from None
            time.sleep(RETRY)


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


def _start_error(error: OSError) -> ServerError:
    """Return the error with the original server's text."""
    text = f"Unable to start server[bind: {error.strerror or error}]."
    if error.errno == errno.EADDRINUSE:
        text += " There is probably another Gazebo process running."
        return ServerError(f"{text} GAZEBO_MASTER_URI sets another port; http://localhost:0 takes a free one.")
    uri = os.environ.get("GAZEBO_MASTER_URI")
    return ServerError(f"{text} The address comes from GAZEBO_MASTER_URI, which is {uri!r}." if uri else text)


def _no_master(address: Address, timeout: float, error: OSError) -> str:
    """Return the original client's text, with a possible reason."""
    why = f"there is no server at {address.uri}; GAZEBO_MASTER_URI sets another address"
    if isinstance(error, TimeoutError):
        why = f"the process that listens at {address.uri} does not answer as a master of Gazebo"
    return f"Failed to connect to master in {timeout:g} seconds. ({why})"
