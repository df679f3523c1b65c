"""The address of a master, from GAZEBO_MASTER_URI, and where this process listens."""

from __future__ import annotations

import ipaddress
import os
import socket
from typing import NamedTuple
from urllib.parse import urlsplit

from libgz.base.errors import ParameterError
from libgz.classic.names import takes_names
from libgz.classic.transport.topic import log

__all__ = [
    "DEFAULT_PORT",
    "Address",
    "get_master_uri",
    "is_loopback",
    "listening_socket",
    "listening_sockets",
    "publicized_address",
]

DEFAULT_PORT = 11345
DEFAULT_URI = f"http://localhost:{DEFAULT_PORT}"


class Address(NamedTuple):
    """The address of a master. `localhost` is 127.0.0.1, so that both ends use the same one."""

    host: str
    port: int

    @property
    def uri(self) -> str:
        """The address in the form of GAZEBO_MASTER_URI."""
        return f"http://{self._bracketed()}:{self.port}"

    def _bracketed(self) -> str:
        return f"[{self.host}]" if ":" in self.host else self.host


@takes_names
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
    """Return the address at which other processes reach this one: GAZEBO_IP, GAZEBO_HOSTNAME, or 127.0.0.1."""
    return os.environ.get("GAZEBO_IP") or os.environ.get("GAZEBO_HOSTNAME") or "127.0.0.1"


def listening_sockets(address: Address) -> list[socket.socket]:
    """Return sockets that listen for clients of a master: at its address, and at GAZEBO_IP or GAZEBO_HOSTNAME.

    With port 0 they take a free port.

    Raises:
        OSError: the port is in use, or the address is not one of this machine; or it is not of the loopback interface,
            while neither GAZEBO_IP nor GAZEBO_HOSTNAME is set.
    """
    public = publicized_address()
    hosts = [address.host]
    if is_loopback(public):
        if not is_loopback(address.host):
            raise OSError(0, f"{address.host} is reached from other machines, and neither GAZEBO_IP nor "
                             "GAZEBO_HOSTNAME is set to it")  # fmt: skip
    elif public != address.host:
        hosts.append(public)
    found: list[socket.socket] = []
    port = address.port
    try:
        for host in hosts:
            found.append(listening_socket(host, port))
            port = found[0].getsockname()[1]
    except OSError:
        for one in found:
            one.close()
        raise
    return found


def encoded(host: str) -> str | bytes:
    """A name as bytes if it can be: of a text, Python imports the tables of international names first."""
    return host.encode() if host.isascii() else host


def listening_socket(host: str, port: int = 0) -> socket.socket:
    """Return a socket that listens.

    Raises:
        OSError: the port is in use, or the address is not one of this machine.
    """
    family, kind, protocol, _, where = socket.getaddrinfo(encoded(host), port, type=socket.SOCK_STREAM)[0]
    made = socket.socket(family, kind, protocol)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind(where)
        made.listen(128)
    except OSError:
        made.close()
        raise
    return made


def is_loopback(host: str) -> bool:
    """Whether an address, or all those of a name, are of the loopback interface.

    Raises:
        OSError: the name is not known.
    """
    found = socket.getaddrinfo(encoded(host), None, type=socket.SOCK_STREAM)
    return all(ipaddress.ip_address(entry[4][0]).is_loopback for entry in found)
