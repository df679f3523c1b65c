"""Control: requests of other processes to a running server, through a socket in its directory.

The socket is a hidden file, which clients of libgazebo do not see. A request is a line, ``VERB ARGUMENT LENGTH``, and
that many bytes; so is the answer, ``ok`` or ``error``, whose bytes are the message.
"""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import threading
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from libgz.base.errors import ServerError
from libgz.base.numbers import whole_number
from libgz.base.waiting import wait_for
from libgz.transport.paths import CONTROL_SOCKET, check_owner, server_directory
from libgz.transport.timed_socket import TimedSocket

__all__ = ["Control", "Request", "ask"]

log = logging.getLogger("libgz.transport")

LONGEST_LINE = 256  # [byte]
MOST = 1 << 28  # [byte] of a request; a state is the longest
MOST_ANSWER = 1 << 31  # [byte]
MOST_REQUESTS = 16  # at a time; others wait for their turn
PAUSE = 0.25  # [s] when no descriptors or threads are left
PATIENCE = 10.0  # [s] for a request to arrive, and for its answer to be taken


@dataclass(eq=False, repr=False)
class Request:
    """What another process asks for.

    Attributes:
        verb, argument: of the line.
        content: the bytes after it.
    """

    verb: str
    argument: str
    content: bytes
    _answer: tuple[str, bytes] | None = None
    _answered: threading.Event = field(default_factory=threading.Event)

    def answer(self, content: bytes = b"", *, error: str | None = None) -> None:
        """Send the result, or one sentence that says why there is none."""
        self._answer = ("ok", content) if error is None else ("error", error.encode())
        self._answered.set()

    def wait(self) -> tuple[str, bytes]:
        """The answer, once there is one."""
        wait_for(self._answered)
        return self._answer or ("error", b"")


class Control:
    """Takes requests in a thread of its own; `waiting` holds them until the run's loop answers them.

    Args:
        directory: the server's.

    Raises:
        ServerError: the socket cannot be created.
    """

    def __init__(self, directory: str) -> None:
        self.waiting: deque[Request] = deque()
        self._path = f"{directory}/{CONTROL_SOCKET}"
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            with _short(directory) as folder:
                self._socket.bind(f"{folder}/{CONTROL_SOCKET}")
            Path(self._path).chmod(0o600)
            self._socket.listen()
        except OSError as error:
            self._socket.close()
            raise ServerError(f"cannot create {self._path}: {error.strerror}") from None
        self._closed = False
        self._free = threading.BoundedSemaphore(MOST_REQUESTS)
        threading.Thread(target=self._accept, name="control", daemon=True).start()

    def _accept(self) -> None:
        while True:
            self._free.acquire()
            try:
                connection, _ = self._socket.accept()
            except OSError:
                self._free.release()
                if self._closed:
                    return
                time.sleep(PAUSE)
                continue
            try:
                threading.Thread(target=self._serve, args=(connection,), name="control", daemon=True).start()
            except RuntimeError:  # the system has no thread left
                connection.close()
                self._free.release()
                time.sleep(PAUSE)

    def _serve(self, connection: socket.socket) -> None:
        try:
            self._answer(connection)
        except MemoryError:
            log.warning("control: no memory is left for a request; it is dropped")
        finally:
            self._free.release()

    def _answer(self, made: socket.socket) -> None:
        with TimedSocket(made.detach(), time.monotonic() + PATIENCE) as connection, contextlib.suppress(OSError):
            words, content = _receive(connection, MOST)
            if len(words) != 2:
                _send(connection, "error", b"the request is not understood")
                return
            request = Request(words[0], words[1], content)
            self.waiting.append(request)
            if self._closed:
                request.answer(error="the server is ending")
            answer = request.wait()
            connection.deadline = time.monotonic() + PATIENCE
            _send(connection, *answer)

    def close(self) -> None:
        """Take no more requests, and remove the socket. Can be called twice."""
        if self._closed:
            return
        self._closed = True
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()
        with contextlib.suppress(OSError):  # somebody has put a folder there
            Path(self._path).unlink(missing_ok=True)
        while self.waiting:
            self.waiting.popleft().answer(error="the server is ending")


def ask(server_id: int, verb: str, argument: str = "-", content: bytes = b"", timeout: float | None = None) -> bytes:
    """Send a request to a running server of this user, and return the result; it is waited for until the timeout [s].

    Raises:
        ServerError: there is no such server, it takes no requests, or it answers with an error.
    """
    directory = server_directory(server_id)
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as connection:
        try:
            check_owner(directory)
            connection.settimeout(timeout)
            with _short(directory) as folder:
                connection.connect(f"{folder}/{CONTROL_SOCKET}")
        except OSError as error:
            socket_path = f"{directory}/{CONTROL_SOCKET}"
            raise ServerError(
                f"no server with id {server_id} takes requests ({socket_path}: {error.strerror or error}); "
                "they are taken by gazebo, and by gzserver --server-id ID"
            ) from None
        try:
            _send(connection, f"{verb} {argument}", content)
            words, result = _receive(connection, MOST_ANSWER)
        except TimeoutError:
            raise ServerError(f"server {server_id} did not answer within {timeout:g} s") from None
        except OSError as error:
            raise ServerError(f"server {server_id} ended before it answered ({error.strerror or error})") from None
    if words == ["error"]:
        raise ServerError(result.decode(errors="replace"))
    return result


@contextlib.contextmanager
def _short(directory: str) -> Iterator[str]:
    """A path of a directory that is short enough for a socket's address."""
    descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        yield f"/proc/self/fd/{descriptor}"
    finally:
        os.close(descriptor)


def _send(connection: socket.socket, line: str, content: bytes) -> None:
    connection.sendall(f"{line} {len(content)}\n".encode() + content)


def _receive(connection: socket.socket, most: int) -> tuple[list[str], bytes]:
    """The words of a line without the length, and the bytes after it, of which there are so many at most.

    Raises:
        OSError: what arrives is not of this form.
    """
    with connection.makefile("rb") as stream:
        words = stream.readline(LONGEST_LINE).decode(errors="replace").split()
        length = whole_number(words[-1], most) if words else None
        if length is None:
            raise OSError("the other process sent something else")
        content = stream.read(length)
        if len(content) < length:
            raise OSError("the other process ended")
        return words[:-1], content
