"""What a program needs of ROS 1 that only asks: parameters, and calls of services."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from typing import Any
from urllib.parse import urlsplit

from libgz.base.errors import GazeboError
from libgz.ros.names import NodeNames
from libgz.ros.packing import codec
from libgz.ros.tcpros import MOST_HEADER, U32, encode_header, parse_header
from libgz.ros.types import service_type
from libgz.ros.xmlrpc import XmlRpcError, call, shown

__all__ = ["RosCallError", "RosClient"]

MOST_ANSWER = 1 << 24  # bytes
RETRY = 0.25  # [s]


class RosCallError(GazeboError):
    """A service that is not there, or that refused."""


class RosClient:
    """Asks the master, and calls services.

    Args:
        names: of the program.
    """

    def __init__(self, names: NodeNames) -> None:
        self.names = names

    def parameter(self, name: str) -> Any:
        """A parameter; None if it is not set.

        Raises:
            XmlRpcError: there is no master.
        """
        code, _, value = self._ask("getParam", self.names.resolve(name))
        return value if code == 1 else None

    def _ask(self, method: str, name: str) -> tuple[Any, Any, Any]:
        answer = call(self.names.master, method, self.names.name, name)
        if not isinstance(answer, list) or len(answer) != 3:
            raise XmlRpcError(f"{method} of {self.names.master}: {shown(answer)} is no answer of a master")
        return answer[0], answer[1], answer[2]

    def call(
        self,
        name: str,
        kind: str,
        /,
        patience: float = 60.0,
        waiting: Callable[[str], object] | None = None,
        **values: Any,
    ) -> Any:
        """Call a service, once it is there; its response.

        Args:
            name: of the service.
            kind: of its type.
            patience: how long the answer may take [s].
            waiting: called once with a text if the service is not there yet; None: it must be.
            values: fields of the request.

        Raises:
            RosCallError: it is not there, or it refused.
        """
        service, full = service_type(kind), self.names.resolve(name)
        uri = self._look_up(full, waiting)
        header = {"callerid": self.names.name, "md5sum": service.md5, "service": full, "type": service.name}
        try:
            place = urlsplit(uri)
            with socket.create_connection((place.hostname or "", place.port or 0), 5.0) as sock:
                sock.settimeout(patience)
                sock.sendall(encode_header(header))
                answer = parse_header(_read_block(sock, MOST_HEADER))
                if "error" in answer:
                    raise RosCallError(f"service {full}: {answer['error']}")
                body = codec(service.request).pack(service.request(**values))
                sock.sendall(U32.pack(len(body)) + body)
                good = _read(sock, 1)
                data = _read_block(sock, MOST_ANSWER)
        except (OSError, ValueError) as error:
            raise RosCallError(f"service {full} at {shown(uri)}: {error or type(error).__name__}") from error
        if good != b"\1":
            raise RosCallError(f"service {full}: {data.decode('utf-8', 'replace')}")
        return codec(service.response).unpack(data)

    def _look_up(self, full: str, waiting: Callable[[str], object] | None) -> str:
        while True:
            try:
                code, text, uri = self._ask("lookupService", full)
            except XmlRpcError as error:
                if waiting is None:
                    raise
                code, text, uri = -1, str(error), ""
            if code == 1:
                return str(uri)
            if waiting is None:
                raise RosCallError(f"there is no service {full}: {shown(text)}")
            waiting(f"Waiting for service {full}")
            waiting = _silent
            time.sleep(RETRY)


def _silent(_text: str) -> None:
    """The text was reported already."""


def _read(sock: socket.socket, size: int) -> bytes:
    data = bytearray()
    while len(data) < size:
        piece = sock.recv(min(size - len(data), 1 << 16))
        if not piece:
            raise ValueError("the connection was closed")
        data += piece
    return bytes(data)


def _read_block(sock: socket.socket, most: int) -> bytes:
    (size,) = U32.unpack(_read(sock, 4))
    if size > most:
        raise ValueError(f"an answer of {size} bytes")
    return _read(sock, size)
