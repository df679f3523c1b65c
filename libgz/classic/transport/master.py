"""The server's address, from GAZEBO_MASTER_URI, and this machine's address."""

from __future__ import annotations

import os
import socket
from typing import NamedTuple
from urllib.parse import urlsplit

from libgz.classic.transport.topic import log
from libgz.errors import ParameterError

__all__ = ["DEFAULT_PORT", "Address", "get_master_uri", "publicized_address"]

DEFAULT_PORT = 11345
DEFAULT_URI = f"http://localhost:{DEFAULT_PORT}"


class Address(NamedTuple):
    """The address of a server. `localhost` is 127.0.0.1, so that both ends use the same one."""

    host: str
    port: int

    @property
    def uri(self) -> str:
        """The address in the form of GAZEBO_MASTER_URI."""
        return f"http://{self._bracketed()}:{self.port}"

    @property
    def endpoint(self) -> str:
        """The address in the form of the network library."""
        return f"tcp/{self._bracketed()}:{self.port}"

    def _bracketed(self) -> str:
        return f"[{self.host}]" if ":" in self.host else self.host


def get_master_uri(uri: str | None = None) -> Address:
    """Return the address in a URI such as `http://localhost:11345`; without one, in GAZEBO_MASTER_URI.

    Raises:
        ParameterError: the URI is invalid.
    """
    text = uri or os.environ.get("GAZEBO_MASTER_URI") or DEFAULT_URI
    try:
        parts = urlsplit(text if "://" in text else f"http://{text}")
        host, port = parts.hostname, parts.port
    except ValueError as error:
        raise ParameterError(f"master URI {text!r}: {error}; it must be like {DEFAULT_URI}") from None
    if not host:
        raise ParameterError(f"master URI {text!r} names no machine; it must be like {DEFAULT_URI}")
    if port is None:
        log.warning("Port missing in master URI[%s]. Using default value of %d.", text, DEFAULT_PORT)
        port = DEFAULT_PORT
    return Address("127.0.0.1" if host == "localhost" else host, port)


def publicized_address() -> str:
    """Return the address at which other machines reach this one.

    It is GAZEBO_IP, GAZEBO_HOSTNAME, or the source address of the default route; 127.0.0.1 without a network. Nothing
    is sent.
    """
    named = os.environ.get("GAZEBO_IP") or os.environ.get("GAZEBO_HOSTNAME")
    if named:
        return named
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # an address for documentation: the call only looks up the route
            return str(probe.getsockname()[0])
        except OSError:
            return "127.0.0.1"
