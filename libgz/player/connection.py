"""Connection: a client's socket, with bounded memory for what it sends and for what it does not read."""

from __future__ import annotations

import contextlib
import logging
import socket
from collections import deque
from collections.abc import Callable

from libgz.player.conversation import Conversation, Conversation1, Conversation2, Directory
from libgz.player.device import Device
from libgz.player.messages import Message
from libgz.player.records import MalformedError, Values
from libgz.player.wire import Frame, Wire1, detect

__all__ = ["Connection", "Totals"]

log = logging.getLogger("libgz.player")

CHUNK = 64 << 10  # [byte] that are read at a time
MOST_UNSENT = 2 << 20  # [byte] of a client, above which it is sent no data and nothing of it is read
MOST_UNSENT_IN_ALL = 64 << 20
MOST_IN_TURN = 8  # frames of a client, before it is the turn of others
MOST_UNUSABLE = 1 << 20  # [byte] that a client may send without a frame among them

Defer = Callable[["Connection", Frame, Device, Message, Values], None]


class Totals:
    """What all connections hold together: `unsent` [byte]."""

    def __init__(self) -> None:
        self.unsent = 0


class Connection:
    """A client. Its version is known when it has sent the first bytes.

    Args:
        version: of clients of Player 2 and 3; an empty string: as the client shows.
        defer: answers slow requests.

    Attributes:
        closed: why it has to be closed; an empty string while it is in use.
        busy: whether a slow request is being answered.
        more: whether `handle` may find a frame.
    """

    def __init__(
        self, sock: socket.socket, port: int, directory: Directory, totals: Totals, version: str, defer: Defer
    ) -> None:
        self.socket, self.port = sock, port
        self.conversation: Conversation | None = None
        self.closed = ""
        self.busy = self.more = False
        self._directory, self._totals, self._version, self._defer = directory, totals, version, defer
        self._received = bytearray()
        self._unusable = 0
        self._unsent: deque[memoryview] = deque()
        self._unsent_size = 0

    @property
    def waits_to_send(self) -> bool:
        """Whether the client has to read first."""
        return bool(self._unsent)

    @property
    def listens(self) -> bool:
        """Whether more of the client is read now: not from one that does not read its answers."""
        return self._unsent_size <= MOST_UNSENT and not self.busy and not self.more

    @property
    def crowded(self) -> bool:
        """Whether so much waits already that data are left out."""
        waiting = self._unsent_size
        return waiting > MOST_UNSENT or (waiting > 0 and self._totals.unsent > MOST_UNSENT_IN_ALL)

    def receive(self) -> None:
        """Read what has come, for `handle`."""
        try:
            data = self.socket.recv(CHUNK)
        except BlockingIOError:
            return
        except OSError as error:
            self.closed = error.strerror or "its socket failed"
            return
        if not data:
            self.closed = "it ended"
            return
        self._received += data
        self._unusable += len(data)
        self.more = True

    def handle(self) -> None:
        """Handle complete frames, as many as it is the turn of."""
        self.more = False
        try:
            if self.conversation is None and not self._choose():
                return
            for _ in range(MOST_IN_TURN):
                if self.closed or self.busy or self._unsent_size > MOST_UNSENT:
                    return
                if self.conversation is None or not self.conversation.take(self._received):
                    if self._unusable > MOST_UNUSABLE:
                        self.closed = "it sends nothing usable"
                    return
                self._unusable = len(self._received)
            self.more = True
        except MalformedError as error:
            self.closed = str(error)

    def _choose(self) -> bool:
        wire = detect(self._received)
        if wire is None:
            return False
        if wire is Wire1:
            self.conversation = Conversation1(self._directory, self.port, self)
        else:
            self.conversation = Conversation2(self._directory, self.port, self, self._version)
        return True

    def send(self, data: bytes) -> None:
        """Send bytes, now or when the client reads."""
        if self.closed:
            return
        view = memoryview(data)
        if not self._unsent:
            view = view[self._write(view) :]
        if view:
            self._unsent.append(view)
            self._count(len(view))

    def flush(self) -> None:
        """Send what waits, as far as the client reads."""
        while self._unsent and not self.closed:
            first = self._unsent[0]
            sent = self._write(first)
            self._count(-sent)
            if sent < len(first):
                self._unsent[0] = first[sent:]
                break
            self._unsent.popleft()
        self.more = self.more or (bool(self._received) and self._unsent_size <= MOST_UNSENT)

    def _write(self, view: memoryview) -> int:
        try:
            return self.socket.send(view)
        except BlockingIOError:
            return 0
        except OSError as error:
            self.closed = error.strerror or "its socket failed"
            return 0

    def _count(self, size: int) -> None:
        self._unsent_size += size
        self._totals.unsent += size

    def defer(self, frame: Frame, device: Device, message: Message, values: Values) -> None:
        """See `Channel.defer`."""
        self.busy = True
        self._defer(self, frame, device, message, values)

    def close(self, reason: str) -> None:
        """Close it at the end of this turn."""
        self.closed = self.closed or reason

    def end(self) -> None:
        """Close the socket, and end all subscriptions. Can be called twice."""
        self.closed = self.closed or "the server ends"
        if self.conversation is not None:
            self.conversation.close()
        self._count(-self._unsent_size)
        self._unsent.clear()
        self._received.clear()
        with contextlib.suppress(OSError):
            self.socket.close()
