"""XML-RPC as the masters and nodes of ROS 1 speak it, with bounds of time and size on both sides."""

from __future__ import annotations

import contextlib
import http.client
import http.server
import logging
import math
import operator
import reprlib
import socket
import threading
import time
import xmlrpc.client
from collections.abc import Callable, Mapping
from typing import Any
from urllib.parse import urlsplit
from xml.parsers import expat

from libgz.base.errors import GazeboError
from libgz.base.visible import one_line
from libgz.transport.allowance import Share
from libgz.transport.peers import PeerCheck
from libgz.transport.tally import Tally
from libgz.transport.timed_socket import TimedSocket

__all__ = ["MOST_REQUEST", "Server", "XmlRpcError", "call", "shown"]

log = logging.getLogger("libgz.ros")

MOST_ANSWER = 1 << 24  # bytes; a robot description is the longest
MOST_REQUEST = 1 << 20
MOST_THREADS = 32
PATIENCE = 5.0  # [s]
MOST_DEPTH = 300  # elements in elements: three for each list or table in another
LONGEST_SHOWN = 300  # characters of a text of others in a message
QUICK = 0.3  # [s] that a request takes at most; a slower one lets others that wait come first
WAITING = 2.0  # [s] that a request waits for one of the threads
PAUSE = 0.25  # [s] when no descriptors are left

_FAILURES = (OSError, http.client.HTTPException, xmlrpc.client.Error, ValueError, TypeError, LookupError)


class XmlRpcError(GazeboError):
    """A call that failed: nobody there, no answer in time, or an answer that is none."""


def call(uri: str, method: str, *values: Any, patience: float = PATIENCE, most: int | None = None) -> Any:
    """Call a method; what it returns.

    Args:
        uri: the address of the node or master.
        method: its name.
        values: its arguments.
        patience: how long the whole call may take [s].
        most: bytes of the answer; None: those of the longest one that a master gives.

    Raises:
        XmlRpcError: the call failed.
    """
    most = MOST_ANSWER if most is None else most
    try:
        place = urlsplit(uri)
        if place.scheme != "http" or not place.hostname:
            raise XmlRpcError(f"{shown(uri)!r} is no address of XML-RPC; it must begin with http://")
        body = xmlrpc.client.dumps(values, method, allow_none=True).encode()
        connection = _Connection(place.hostname, place.port or 80, timeout=patience)
        try:
            connection.request("POST", place.path or "/RPC2", body, {"Content-Type": "text/xml"})
            answer = connection.getresponse()
            data = answer.read(most + 1)
        finally:
            connection.close()
        if answer.status != http.HTTPStatus.OK:
            raise XmlRpcError(f"{shown(uri)} answered {answer.status} {shown(answer.reason)}")
        return _loads(data, most)[0][0]
    except _FAILURES as error:
        raise XmlRpcError(f"{method} of {shown(uri)}: {shown(str(error)) or type(error).__name__}") from error


def shown(value: Any) -> str:
    """What another node sent as the text of a message: one line, neither long nor deep."""
    return one_line(value[:LONGEST_SHOWN] if isinstance(value, str) else reprlib.repr(value))


class _Connection(http.client.HTTPConnection):
    """A connection whose timeout is that of the whole call."""

    def connect(self) -> None:
        """Connect."""
        deadline = time.monotonic() + (self.timeout or 0.0)
        super().connect()
        self.sock = TimedSocket(self.sock.detach(), deadline)


def _loads(data: bytes, most: int) -> tuple[tuple[Any, ...], str | None]:
    if len(data) > most:
        raise ValueError(f"more than {most} bytes")
    try:
        _probe(data)
        values, method = xmlrpc.client.loads(data)
    except xmlrpc.client.Error:
        raise
    except Exception as error:  # noqa: BLE001 - Python's reader trusts what it reads
        raise ValueError(f"no valid XML-RPC: {type(error).__name__}: {error}") from None
    return values, method


def _probe(data: bytes) -> None:
    """Look through a document for what Python's reader takes, but nobody should.

    Raises:
        ValueError: it has a document type, or too many elements in elements.
    """
    depth = 0

    def refuse(*_: object) -> None:
        raise ValueError("a document type")

    def enter(*_: object) -> None:
        nonlocal depth
        depth += 1
        if depth > MOST_DEPTH:
            raise ValueError(f"more than {MOST_DEPTH} elements in each other")

    def leave(_: str) -> None:
        nonlocal depth
        depth -= 1

    probe = expat.ParserCreate()  # "<!" is other bytes in UTF-16
    probe.StartDoctypeDeclHandler, probe.StartElementHandler, probe.EndElementHandler = refuse, enter, leave
    probe.Parse(data, True)


class Server:
    """Serves functions by XML-RPC, each request in a thread.

    Args:
        address: where it listens.
        functions: by their names.

    Attributes:
        share: what may be spent on requests.
    """

    def __init__(self, address: str, functions: Mapping[str, Callable[..., Any]]) -> None:
        self._server = _HttpServer((address, 0), _Handler)
        self._server.functions = functions
        self.share = self._server.share
        self.port: int = self._server.server_address[1]
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), name="ros-xmlrpc", daemon=True)

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()

    def close(self) -> None:
        """End."""
        self._server.shutdown()
        self._server.server_close()


class _HttpServer(http.server.ThreadingHTTPServer):
    daemon_threads = True
    block_on_close = False
    request_queue_size = 128  # a node that subscribes to all topics asks for all of them at the same time
    functions: Mapping[str, Callable[..., Any]]

    def __init__(self, *values: Any) -> None:
        self._free = threading.BoundedSemaphore(MOST_THREADS)
        self.turn = threading.Lock()  # of the request that is handled: many at a time would leave a step no Python
        self.share, self._spent = Share(), 0.0
        self._since: dict[Any, float] = {}  # requests under way -> when they began [s]
        self._peers, self._tally = PeerCheck(), Tally(100)
        super().__init__(*values)

    def warn(self, cause: str, text: str, *values: object) -> None:
        """Log what peers do again and again at growing counts only."""
        if self._tally.due(cause):
            shown_values = (one_line(value) if isinstance(value, str) else value for value in values)
            log.warning(f"{text}%s", *shown_values, self._tally.times(cause))

    def get_request(self) -> Any:
        """A connection, which ends after a time; without descriptors for it, some time later."""
        try:
            made, address = super().get_request()
        except OSError:
            time.sleep(PAUSE)  # else the socket, which stays readable, would be asked again at once
            raise
        return TimedSocket(made.detach(), time.monotonic() + PATIENCE), address

    def service_actions(self) -> None:
        """Count what accepting took, in its thread, and accept nothing more until there is time for it."""
        before, self._spent = self._spent, time.thread_time()
        self.share.spend(self._spent - before)
        time.sleep(self.share.wait)

    def verify_request(self, request: Any, client_address: Any) -> bool:
        """Whether the peer may connect."""
        refused = self._peers.refusal(request)
        if refused:
            self.warn("user", "ROS: a request of %s was refused: %s", client_address[0], refused)
        return not refused

    def process_request(self, request: Any, client_address: Any) -> None:
        """Serve a connection as soon as one of the threads is free."""
        if not self._free.acquire(blocking=False) and not self._free_one():
            text = "ROS: %d requests are under way; one of %s is refused"
            self.warn("many", text, MOST_THREADS, client_address[0])
            self.shutdown_request(request)
            return
        self._since[request] = time.monotonic()
        try:
            super().process_request(request, client_address)
        except RuntimeError:  # the system has no thread left
            self._end(request)
            raise

    def _free_one(self) -> bool:
        """Wait for a thread, whether there is one in time; requests that take long are closed for it."""
        end = time.monotonic() + WAITING
        while not self._free.acquire(timeout=self._close_slowest()):
            if time.monotonic() > end:
                return False
        return True

    def _close_slowest(self) -> float:
        """Close the request that has taken longest, such as one that comes byte by byte: others wait.

        Returns:
            How long to wait until that has an effect, or until it has taken long [s].
        """
        request, since = min(list(self._since.items()), key=operator.itemgetter(1), default=(None, math.inf))
        left = since + QUICK - time.monotonic()
        if request is None or left > 0.0:
            return min(left, QUICK)
        self._since.pop(request, None)
        with contextlib.suppress(OSError):
            request.shutdown(socket.SHUT_RDWR)
        return QUICK

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Serve a connection in its thread."""
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._end(request)

    def _end(self, request: Any) -> None:
        self._since.pop(request, None)
        self._free.release()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A peer that goes away, or sends anything but HTTP, is no event."""
        log.debug("ROS: a request of %s failed", client_address, exc_info=True)


class _Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    wbufsize = -1
    server: _HttpServer
    _spent = 0.0  # of the thread's time, that was counted [s]

    def finish(self) -> None:
        """Count what the request took."""
        super().finish()
        self._count()

    def _count(self) -> None:
        before, self._spent = self._spent, time.thread_time()
        self.server.share.spend(self._spent - before)

    def log_message(self, *_values: object) -> None:
        """Requests are not logged."""

    def do_POST(self) -> None:
        """Answer a call."""
        try:
            size = int(self.headers.get("Content-Length") or -1)
        except ValueError:
            size = -1
        if not 0 <= size <= MOST_REQUEST:
            self.server.warn("size", "ROS: %s sent a request of %d bytes; it is refused", self.client_address[0], size)
            self.close_connection = True
            self.send_error(http.HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
            return
        data = self.rfile.read(size)
        with self.server.turn:
            time.sleep(self.server.share.wait)
            answer = self._answer(data)
            self._count()
        self.send_response(http.HTTPStatus.OK)
        self.send_header("Content-Type", "text/xml")
        self.send_header("Content-Length", str(len(answer)))
        self.send_header("Connection", "close")  # a kept connection would keep its thread
        self.end_headers()
        self.wfile.write(answer)
        self.wfile.flush()

    def _answer(self, data: bytes) -> bytes:
        try:
            values, method = _loads(data, MOST_REQUEST)
            function = self.server.functions.get(method or "")
            if function is None:
                raise ValueError(f"there is no method {method!r}")
            result = function(*values)
            return xmlrpc.client.dumps((result,), methodresponse=True, allow_none=True).encode()
        except Exception as error:  # noqa: BLE001 - whatever a peer sent
            text = "ROS: a request of %s is invalid: %s"
            self.server.warn("invalid", text, self.client_address[0], str(error)[:1000])
            return xmlrpc.client.dumps(xmlrpc.client.Fault(1, str(error)[:1000])).encode()
