"""Loop: the one thread that reads from and writes to the sockets of ROS, so that no step waits for a peer."""

from __future__ import annotations

import contextlib
import logging
import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Hashable, Sequence
from typing import Any, TypeAlias

from libgz.base.visible import one_line
from libgz.ros.packing import Buffer
from libgz.transport.allowance import Share
from libgz.transport.peers import PeerCheck
from libgz.transport.tally import Tally

__all__ = ["Connection", "Frame", "Listener", "Loop", "kept"]

log = logging.getLogger("libgz.ros")

READ_SIZE = 1 << 15  # bytes at once; more would be thousands of short messages
REST = 0.005  # [s] without reading, at least, once the share of the time is spent
SEND_AT_ONCE = 1 << 18  # bytes of frames in one call, unless the first one has more
MOST_PARTS = 64  # in one call
GATHERING = 0.01  # [s] for which messages of a hurried world wait for others
LONGEST_TEXT = 1000  # characters of what peers call themselves or have sent, in the log
LONGEST_SEND = 0.1  # [s] that one thread waits until another has sent, which never waits for a socket
MOST_CONNECTIONS = 1024
MOST_INCOMPLETE = 1 << 27  # bytes of messages that have not come whole, of all connections together
SHORT = 1 << 16  # bytes of one that is not looked at: that of a header
PERIOD = 1.0  # [s] between two looks for peers that do not greet
PAUSE = 0.25  # [s] without accepting, when no descriptors are left
GREETING_TIME = 5.0  # [s] in which a peer must say what it wants


Frame: TypeAlias = tuple[Buffer, ...]


def kept(parts: Sequence[Buffer]) -> list[Buffer]:
    """Parts whose memory does not change any more: copies, where it may."""
    return [part if isinstance(part, bytes) or isinstance(part.obj, bytes) else bytes(part) for part in parts]


def _after(parts: list[Buffer], size: int) -> list[Buffer]:
    """What is left of parts behind so many bytes."""
    for number, part in enumerate(parts):
        if size < len(part):
            return [memoryview(part)[size:], *parts[number + 1 :]]
        size -= len(part)
    return []


class Loop:
    """Waits for sockets in its thread. `call` and `note` may be used from any thread, all else from that one.

    What comes in is read as long as that takes no more than its share of the time; the rest waits in the system.

    Args:
        name: of the thread.

    Attributes:
        share: what may be spent on what comes in.
        hurried: whether the world runs faster than real time: messages may then wait some milliseconds for others.
    """

    def __init__(self, name: str) -> None:
        self._selector = selectors.DefaultSelector()
        self._inside, self._outside = socket.socketpair()
        for end in (self._inside, self._outside):
            end.setblocking(False)
        self._selector.register(self._inside, selectors.EVENT_READ, self._woken_up)
        self._inputs = selectors.EpollSelector()  # what is read, as long as it may be
        self._selector.register(self._inputs.fileno(), selectors.EVENT_READ, self._read_ready)
        self._reading, self.share = True, Share()
        self._ready: deque[Connection | Listener] = deque()  # those whose turn is next
        self._calls: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque()
        self._noted: deque[Connection] = deque()
        self._due = 0.0  # when what is noted is flushed [s]
        self._resting = True  # no flush is due
        self.hurried: Callable[[], bool] = lambda: False
        self._woken = self._ended = False
        self.connections: dict[Connection, None] = {}
        self._paused: dict[Listener, float] = {}  # until when [s]
        self.tally = Tally(100)
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def call(self, function: Callable[..., object], *values: Any) -> None:
        """Have a function called in the loop's thread, soon."""
        self._calls.append((function, values))
        self._wake()

    def note(self, connection: Connection) -> None:
        """Have what waits on a connection sent some milliseconds after what was sent last, together with what follows.

        It is sent by the thread that notes something then, because threads that take turns with Python cost more than
        calls of the system; or by that of the loop if none does.
        """
        if not connection.noted:
            connection.noted = True
            self._noted.append(connection)
        if time.monotonic() >= self._due:
            for one in self._take_noted():
                one.hasten()
        elif self._resting:
            self._wake()

    def _take_noted(self) -> list[Connection]:
        """The connections that were noted; the next ones are due some time later."""
        self._due = time.monotonic() + GATHERING
        found = []
        with contextlib.suppress(IndexError):
            while True:
                connection = self._noted.popleft()
                connection.noted = False  # what is queued from now on is sent at the latest next time
                found.append(connection)
        return found

    def _wake(self) -> None:
        if not self._woken:
            self._woken = True
            with contextlib.suppress(OSError):
                self._outside.send(b"x")

    def close(self) -> None:
        """End the thread, and close all connections."""
        self._ended = True
        self._woken = False
        self._wake()
        self._thread.join(2.0)

    def watch(self, one: Connection | Listener) -> None:
        """Read what comes on a socket."""
        self._inputs.register(one.socket, selectors.EVENT_READ, one)

    def watch_writing(self, connection: Connection, wanted: bool) -> None:
        """Flush a connection when its socket can take more, or no longer."""
        if wanted:
            self._selector.register(
                connection.socket, selectors.EVENT_WRITE, lambda: self._serve(connection, connection.flush)
            )
        else:
            self._selector.unregister(connection.socket)

    def add(self, connection: Connection) -> None:
        """Serve a connection; one too many is closed."""
        if len(self.connections) >= MOST_CONNECTIONS:
            text = "ROS: there are %d connections; that of %s is refused"
            self.warn("many", text, MOST_CONNECTIONS, connection.peer)
            connection.socket.close()
            return
        self.connections[connection] = None
        self.watch(connection)

    def bound_incomplete(self) -> None:
        """Close the connection with the longest incomplete message, if all together are too long."""
        if sum(one.incomplete for one in self.connections) > MOST_INCOMPLETE:
            longest = max(self.connections, key=lambda one: one.incomplete)
            longest.close(f"the messages that have not come whole have more than {MOST_INCOMPLETE} bytes")

    def pause(self, listener: Listener) -> None:
        """Accept nothing for a while: a socket without descriptors for its connections would stay readable."""
        self.remove(listener)
        self._paused[listener] = time.monotonic() + PAUSE

    def warn(self, cause: Hashable, text: str, *values: object) -> None:
        """Log what peers do again and again at growing counts only."""
        if self.tally.due(cause):
            shown = (value if isinstance(value, int) else one_line(str(value)[:LONGEST_TEXT]) for value in values)
            log.warning(f"{text}%s", *shown, self.tally.times(cause))

    def remove(self, one: Connection | Listener) -> None:
        """Serve a socket no longer."""
        for selector in (self._inputs, self._selector):
            with contextlib.suppress(KeyError, ValueError):
                selector.unregister(one.socket)
        if isinstance(one, Connection):
            self.connections.pop(one, None)

    def _run(self) -> None:
        while not self._ended:
            found = self._selector.select(self._patience())
            self._resting = False
            for key, _ in found:
                key.data()
            self._woken = False
            while self._calls:
                function, values = self._calls.popleft()
                try:
                    function(*values)
                except Exception:
                    log.exception("ROS: a call failed")
            self._flush_noted()
            self._expire()
        for connection in list(self.connections):
            connection.flush()
            connection.close()
        self._selector.close()
        self._inputs.close()
        self._inside.close()
        self._outside.close()

    def _patience(self) -> float:
        """How long to wait for sockets [s]; what comes in is read again once there is time for it."""
        until = PERIOD
        if not self._reading:
            until = REST + self.share.wait
            if until == REST:
                self._reading = True
                self._selector.register(self._inputs.fileno(), selectors.EVENT_READ, self._read_ready)
        left = self._due + GATHERING - time.monotonic()
        self._resting = left <= 0.0
        # What is noted is asked for last: `note` reads whether it rests.
        return min(left, until) if left > 0.0 else 0.0 if self._noted else until

    def _woken_up(self) -> None:
        with contextlib.suppress(OSError):
            self._inside.recv(4096)

    def _read_ready(self) -> None:
        """Read, in turn, what has come on sockets, as long as there is time."""
        begin = time.thread_time()
        self._ready = self._ready or deque(key.data for key, _ in self._inputs.select(0.0))
        while self._ready and not self.share.wait:
            one = self._ready.popleft()
            if one.socket.fileno() >= 0:  # else it was closed
                self._serve(one, one.readable)
            now = time.thread_time()
            self.share.spend(now - begin)
            begin = now
        if self.share.wait:
            self._reading = False
            self._selector.unregister(self._inputs.fileno())

    def _flush_noted(self) -> None:
        """Flush what was noted, if it is time."""
        if self._noted and time.monotonic() >= self._due + GATHERING:
            for connection in self._take_noted():
                connection.flush()

    def _serve(self, one: Connection | Listener, handle: Callable[[], object]) -> None:
        try:
            handle()
        except (OSError, ValueError) as error:
            if isinstance(one, Connection):
                one.close(str(error))
        except Exception:
            log.exception("ROS: a connection failed")
            if isinstance(one, Connection):
                one.close("an error")

    def _expire(self) -> None:
        """Close the connections of peers that did not greet in time, and accept again after a pause."""
        now = time.monotonic()
        for listener in [one for one, until in self._paused.items() if now > until]:
            del self._paused[listener]
            self.watch(listener)
        for connection in [one for one in self.connections if one.deadline is not None and now > one.deadline]:
            connection.close("it said nothing")


class Listener:
    """A socket that accepts connections.

    Args:
        loop: serves it.
        address: where it listens.
        accepted: makes the connection of a new socket.
    """

    def __init__(self, loop: Loop, address: str, accepted: Callable[[socket.socket, str], Connection]) -> None:
        family = socket.AF_INET6 if ":" in address else socket.AF_INET
        self.socket = socket.create_server((address, 0), family=family, backlog=128)
        self.socket.setblocking(False)
        self.port: int = self.socket.getsockname()[1]
        self._loop, self._accepted = loop, accepted
        self._peers = PeerCheck()

    def start(self) -> None:
        """Begin to accept."""
        self._loop.call(self._loop.watch, self)

    def readable(self) -> None:
        """Accept a connection."""
        try:
            accepted, address = self.socket.accept()
        except BlockingIOError:
            return
        except OSError as error:
            self._loop.warn("accept", "ROS: a connection cannot be accepted: %s", error)
            self._loop.pause(self)
            return
        if refused := self._peers.refusal(accepted):
            self._loop.warn("user", "ROS: a connection was refused: %s", refused)
            accepted.close()
            return
        self._loop.add(self._accepted(accepted, f"{address[0]}:{address[1]}"))

    def close(self) -> None:
        """Accept no more."""
        self._loop.call(self._end)

    def _end(self) -> None:
        self._loop.remove(self)
        self.socket.close()


class Connection:
    """A socket that carries frames: their length as 32 bits, little endian, then their bytes.

    The loop's thread reads and writes. `send_at_once` may be used from any thread, and sends what the socket takes
    without waiting, so that neither threads nor copies lie between a message and its socket. What is left waits in
    `queue`, for the loop's thread; so does what may wait some milliseconds, see `Loop.note`.

    Attributes:
        peer: the other end, for messages.
        queue: frames that wait, in parts; any thread may add some.
        noted: whether the loop will flush it soon.
        slow: whether its socket took less than there was.
        using: held by the thread that writes to the socket.
        deadline: when it is closed unless it has greeted [s]; None once it has.
        longest: most bytes of a frame that is accepted now.
    """

    longest = 1 << 16

    def __init__(self, loop: Loop, sock: socket.socket, peer: str) -> None:
        sock.setblocking(False)
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.loop, self.socket, self.peer = loop, sock, peer
        self.deadline: float | None = time.monotonic() + GREETING_TIME
        self.closed = False
        self._received = bytearray()
        self.queue: deque[Frame] = deque()
        self.noted = self.slow = False
        self.using = threading.Lock()
        self._rest: list[Buffer] = []  # of what was taken from the queue
        self._closing = False

    # Reading -----------------------------------------------------------------------------------------------------

    def readable(self) -> None:
        """Read what came, and pass on whole frames."""
        try:
            data = self.socket.recv(READ_SIZE)
        except BlockingIOError:
            return
        if not data:
            self.close()
            return
        if self._closing:
            return  # the last answer is on its way, and nothing is heard any more
        received = self._received
        received += data
        while not self.closed and not self._closing:
            size = self.frame_size(received)
            if size is None:
                break
            if size > self.longest:
                self.close(f"it announced {size} bytes; at most {self.longest} are accepted")
                return
            if len(received) < self.prefix + size:
                break
            body = bytes(received[self.prefix : self.prefix + size])
            del received[: self.prefix + size]
            self.frame(body)
        if len(received) > SHORT:
            self.loop.bound_incomplete()

    prefix = 4

    @property
    def incomplete(self) -> int:
        """How many bytes of a message have come that is not whole."""
        return len(self._received)

    def frame_size(self, received: bytearray) -> int | None:
        """The size of the next frame; None if that is not known yet."""
        return int.from_bytes(received[:4], "little") if len(received) >= 4 else None

    def frame(self, body: bytes) -> None:
        """A frame came."""
        raise NotImplementedError

    # Writing -----------------------------------------------------------------------------------------------------

    def send(self, data: bytes) -> None:
        """Send bytes; from the loop's thread."""
        self.queue.append((data,))
        self.flush()

    def flush(self) -> None:
        """Send as much of what waits as the socket takes now; from the loop's thread."""
        if self.closed:
            return
        try:
            with self.using:
                self._drain()
        except BlockingIOError:
            self._watch(writing=True)
            return
        except OSError as error:
            self.close(str(error))
            return
        self._watch(writing=False)
        if self.unsent:  # what came meanwhile
            self.loop.call(self.flush)
        elif self._closing:
            self.close()

    def send_soon(self, hurried: bool) -> None:
        """Have what was queued sent, from any thread.

        Args:
            hurried: whether it may wait some milliseconds for others.
        """
        if self.slow:
            return  # the loop's thread waits for the socket, and then sends all
        if hurried:
            self.loop.note(self)
        else:
            self.loop.call(self.flush)

    def hasten(self) -> None:
        """Send as much of what waits as the socket takes now; from any thread."""
        if not self.using.acquire(timeout=LONGEST_SEND):
            self.loop.call(self.flush)  # who sends now may have looked at the queue before
            return
        try:
            if not self.closed:
                self._drain()
        except OSError:  # the loop's thread waits for the socket, or closes it
            self.loop.call(self.flush)
        finally:
            self.using.release()

    def _drain(self) -> None:
        while self._rest or (parts := self.next_parts()):
            self._rest = self._rest or parts
            self._rest = _after(self._rest, self.socket.sendmsg(self._rest[:MOST_PARTS]))

    def _watch(self, writing: bool) -> None:
        if writing != self.slow:
            self.slow = writing
            self.loop.watch_writing(self, writing)

    def next_parts(self) -> list[Buffer]:
        """The parts of frames that wait, for one call; they wait no more."""
        parts: list[Buffer] = []
        size = 0
        while size < SEND_AT_ONCE:
            try:
                frame = self.queue.popleft()
            except IndexError:
                break
            parts += frame
            size += sum(map(len, frame))
        return parts

    def send_at_once(self, parts: Sequence[Buffer], size: int) -> bool:
        """Send the parts of a frame, if nothing waits before it; whether that was done.

        What the socket does not take now is copied, and sent later by the loop's thread.

        Args:
            parts: of the frame; their memory may change afterwards.
            size: of all together [byte].
        """
        if self.unsent or not self.using.acquire(blocking=False):
            return False
        try:
            if self.unsent or self.closed:
                return self.closed
            sent = self.socket.sendmsg(parts)
            if sent < size:
                self._rest = _after(kept(parts), sent)
                self.loop.call(self.flush)
        except BlockingIOError:
            return False
        except OSError as error:
            self.loop.call(self.close, str(error))
        finally:
            self.using.release()
        return True

    @property
    def unsent(self) -> bool:
        """Whether something waits."""
        return bool(self.queue or self._rest)

    def finish(self) -> None:
        """Close once all is sent."""
        self._closing = True
        self.flush()

    def close(self, reason: str = "") -> None:
        """Close; the reason is logged."""
        if self.closed:
            return
        self.closed = True
        if reason:
            self.loop.warn(reason, "ROS: the connection of %s is closed: %s", self.peer, reason)
        self.loop.remove(self)
        with self.using:
            self.socket.close()
        self.ended()

    def ended(self) -> None:
        """The connection was closed."""
