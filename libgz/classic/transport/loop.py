"""SocketLoop: the one thread that handles all sockets of a link, and its connections.

What comes in may be hostile. Handling it takes at most a share of the time, frames have a largest size, queues are
bounded, each and together, and of too many connections those are closed that have sent nothing valid, or take nothing.
"""

from __future__ import annotations

import collections
import contextlib
import selectors
import socket
import threading
import time
from collections.abc import Callable
from typing import Any

from libgz.base.backlog import Backlog
from libgz.base.credit import Credit
from libgz.base.errors import ParameterError
from libgz.classic.transport.framing import Frames
from libgz.classic.transport.topic import log
from libgz.transport.peers import PeerCheck
from libgz.transport.tally import Tally

__all__ = ["Connection", "SocketLoop"]

CONNECTIONS = 500  # that are accepted at the same time
BURST = 0.03  # [s] of handling what comes in at once, before the share counts
DEBT = 0.06  # [s] of it that is counted at most: more is Python's, such as a collection of garbage, not the clients'
CHUNK = 1 << 16  # [bytes] received at once from one connection
ACCEPTS = 16  # connections that are accepted before others have their turn, if there is time for so many
FORGETTING = 10.0  # [s] after which what a connection has cost counts half
EVENTS = 32  # connections that are handled before others have their turn
STALLED = 1.0  # [s] without progress, after which a receiver is sent nothing more until it receives again
QUEUE_BYTES, QUEUE_COUNT = 8 << 20, 1000  # that wait for one receiver; then the oldest are dropped
PARTIAL_BYTES = 128 << 20  # of frames that have come in parts, of all connections together


class SocketLoop:
    """Handles connections in a thread.

    Args:
        share: Of the processor's time, for what comes in; None for no limit.
    """

    def __init__(self, share: float | None = None) -> None:
        self._credit = Credit(share, BURST, DEBT) if share is not None else None
        self._counted = time.monotonic()
        self._costs: dict[int, float] = {}  # of handling what a descriptor has sent [s]; halved from time to time
        self._unread: set[int] = set()  # descriptors of accepted connections of which nothing was handled
        self._forgotten = self._counted
        self._begun = 0.0  # when handling of what comes in has begun, in time of the thread [s]
        self._main = selectors.DefaultSelector()  # what is always handled: calls, sending, and all that comes in
        self._inputs = selectors.EpollSelector()
        self._reading = True
        self._main.register(self._inputs.fileno(), selectors.EVENT_READ, self._handle_inputs)
        self._wake_end, self._wake = socket.socketpair()
        self._wake_end.setblocking(False)
        self._wake.setblocking(False)
        self._main.register(self._wake_end, selectors.EVENT_READ, self._woken)
        self._calls: collections.deque[Callable[[], None]] = collections.deque()
        self._awake = False
        self.accepted: dict[Connection, None] = {}  # oldest first
        self.backlog = Backlog()
        self._partial = 0  # bytes of incomplete frames
        self._listeners: list[socket.socket] = []
        self._peers: PeerCheck | None = None
        self._connections: set[Connection] = set()
        self._writing: set[Connection] = set()  # whose sockets are full
        self._ending = False
        self._warned = False
        self._failures = Tally(100)
        self._thread = threading.Thread(target=self._run, name="topics", daemon=True)
        self._thread.start()

    # Other threads -----------------------------------------------------------------------------------------------

    def call(self, function: Callable[[], None]) -> None:
        """Call a function in the loop's thread."""
        self._calls.append(function)
        if not self._awake:
            self._awake = True
            with contextlib.suppress(OSError):  # full, so that it wakes anyway; or closed
                self._wake.send(b"\0")

    def inside(self) -> bool:
        """Whether the caller is the loop's thread."""
        return threading.current_thread() is self._thread

    def close(self, patience: float) -> None:
        """Send what waits, for at most so long [s], and close all connections."""
        end = time.monotonic() + patience
        while self._thread.is_alive() and (self._calls or any(one.waits for one in list(self._connections))):
            if time.monotonic() > end:
                break
            time.sleep(0.002)
        self._ending = True
        self._awake = False
        self.call(lambda: None)
        self._thread.join(5.0)
        for opened in (*self._listeners, *(one.socket for one in self._connections), self._wake, self._wake_end):
            with contextlib.suppress(OSError):
                opened.close()
        self._main.close()
        self._inputs.close()

    # The thread --------------------------------------------------------------------------------------------------

    def listen(self, listener: socket.socket, accept: Callable[[Connection], None], largest: int) -> None:
        """Accept connections; `accept` sets what they are for. Any thread may call this."""
        listener.setblocking(False)
        self._listeners.append(listener)
        self._peers = self._peers or PeerCheck()
        self.call(lambda: self._register_listener(listener, accept, largest))

    def _register_listener(self, listener: socket.socket, accept: Callable[[Connection], None], largest: int) -> None:
        def on_ready(_mask: int) -> None:
            for _ in range(ACCEPTS):
                try:
                    made, _address = listener.accept()
                except OSError:
                    return
                self._greet(made, accept, largest)
                if self.exhausted():
                    return

        self._inputs.register(listener, selectors.EVENT_READ, on_ready)

    def _greet(self, made: socket.socket, accept: Callable[[Connection], None], largest: int) -> None:
        """Serve a new connection, if its peer may connect."""
        refused = self._peers.refusal(made) if self._peers is not None else ""
        if refused:
            made.close()
            self.warn("a connection was refused: %s", refused)
            return
        connection = Connection(self, made, largest)
        self.accepted[connection] = None
        if len(self.accepted) > CONNECTIONS:
            self._make_room(connection)
        if connection.open:
            accept(connection)
        if connection.open:
            # Its first frame is handled at once, the rest after those of others: a client may connect again and again.
            self._costs[made.fileno()] = max(self._costs.values(), default=0.0)
            self._unread.add(made.fileno())
            self.read_from(connection)

    def _make_room(self, new: Connection) -> None:
        """Close the oldest connection that has sent nothing valid, or else takes nothing, or else the new one."""
        self.warn("more than %d clients are connected; those that send or take nothing are disconnected", CONNECTIONS)
        others = [one for one in self.accepted if one is not new]
        idle = next((one for one in others if not one.valid), None)
        (idle or next((one for one in others if one.stalled), new)).drop()

    def warn(self, text: str, *values: object) -> None:
        """Log a warning of a client, once: there may be many."""
        if not self._warned:
            self._warned = True
            log.warning(f"{text} (reported once)", *values)
        else:
            log.debug(text, *values)

    def _run(self) -> None:
        while not self._ending:
            for key, mask in self._main.select(self._pause()):
                self._guarded(key.data, mask)
            self._awake = False
            while self._calls:
                call = self._calls.popleft()
                self._guarded(call)

    def _guarded(self, handler: Callable[..., None], *arguments: int) -> None:
        try:
            handler(*arguments)
        except Exception as error:  # noqa: BLE001 - the thread must not end
            kind = type(error).__name__
            if self._failures.due(kind):  # a client may cause it again and again
                times = self._failures.times(kind)
                log.exception("topics between processes: an event could not be handled%s", times)

    def _pause(self) -> float | None:
        """Return how long to wait for events [s], and read again once there is time for it."""
        if self._reading or self._credit is None:
            return None
        self._count(0.0)
        if self._credit.left > 0.0:
            self._reading = True
            self._main.register(self._inputs.fileno(), selectors.EVENT_READ, self._handle_inputs)
            return 0.0
        return 0.005 + self._credit.wait

    def _count(self, spent: float) -> None:
        now = time.monotonic()
        if self._credit is not None:
            self._credit.earn(now - self._counted)
            self._credit.spend(spent)
        if now > self._forgotten + FORGETTING:
            self._forgotten = now
            self._costs = {fd: cost / 2.0 for fd, cost in self._costs.items()}
        self._counted = now

    def _handle_inputs(self, _mask: int) -> None:
        self._begun = time.thread_time()
        ready = self._inputs.select(0)
        if listeners := [entry for entry in ready if entry[0].fileobj in self._listeners]:
            self._handle_ready(listeners)
            ready = [entry for entry in self._inputs.select(0) if entry[0].fileobj not in self._listeners]
        # Who subscribes to answers, and then asks, must be sent the answer: what is on new connections may have come
        # before the rest. Then those that cost least: who sends without an end must not keep others waiting.
        new = [entry for entry in ready if entry[0].fd in self._unread]
        others = [entry for entry in ready if entry[0].fd not in self._unread]
        others.sort(key=lambda entry: self._costs.get(entry[0].fd, 0.0))
        if not (listeners and self.exhausted()):
            self._handle_ready(new + others[:EVENTS])
        self._count(time.thread_time() - self._begun)
        if self._credit is not None and self._credit.left <= 0.0:
            self._reading = False
            self._main.unregister(self._inputs.fileno())

    def _handle_ready(self, ready: list[tuple[selectors.SelectorKey, int]]) -> None:
        """Handle what has come in on some sockets, as long as there is time: the rest is ready the next time, too."""
        last = time.thread_time()
        for key, mask in ready:
            self._costs[key.fd] = self._costs.get(key.fd, 0.0)
            self._unread.discard(key.fd)
            self._guarded(key.data, mask)
            now = time.thread_time()
            if key.fd in self._costs:  # else it was closed
                self._costs[key.fd] += now - last
            last = now
            if self.exhausted():
                break

    def exhausted(self) -> bool:
        """Whether what comes in has been handled for as long as it may be at once: the rest is handled next time."""
        return self._credit is not None and time.thread_time() - self._begun > BURST

    def count_partial(self, change: int) -> None:
        """Count bytes of incomplete frames; above the limit the connection with the longest one is closed."""
        self._partial += change
        while change > 0 and self._partial > PARTIAL_BYTES:
            longest = max(self._connections, key=lambda one: one.partial)
            if not longest.partial:
                return
            self.warn("clients have sent %d bytes of incomplete messages; the longest is dropped", self._partial)
            longest.drop()

    def _woken(self, _mask: int) -> None:
        with contextlib.suppress(OSError):
            self._wake_end.recv(4096)

    def read_from(self, connection: Connection) -> None:
        """Begin to handle a connection's socket."""
        self._connections.add(connection)
        self._inputs.register(connection.socket, selectors.EVENT_READ, connection.on_input)

    def write_to(self, connection: Connection, wanted: bool) -> None:
        """Call a connection when its socket can take more, or no longer."""
        if wanted == (connection in self._writing):
            return
        if wanted:
            self._writing.add(connection)
            self._main.register(connection.socket, selectors.EVENT_WRITE, connection.on_output)
        else:
            self._writing.remove(connection)
            with contextlib.suppress(KeyError, ValueError):
                self._main.unregister(connection.socket)

    def forget(self, connection: Connection) -> None:
        """Stop handling a connection's socket."""
        self.accepted.pop(connection, None)
        self._connections.discard(connection)
        self._costs.pop(connection.socket.fileno(), None)
        self._unread.discard(connection.socket.fileno())
        with contextlib.suppress(KeyError, ValueError):
            self._inputs.unregister(connection.socket)
        self.write_to(connection, False)


class Connection:
    """A connection, whose data are frames. Its methods are called in the loop's thread, but for `send` and `wait_room`.

    Args:
        loop: The loop.
        socket: Connected, or connecting.
        largest: The largest content of a frame [bytes].

    Attributes:
        on_frame: Called with each received content; raises ParameterError if it is invalid.
        on_close: Called by `drop`, and when the other end closes the connection.
        on_room: Called after something was sent.
        open: Whether it is not closed.
        valid: Whether a valid frame was received.
        lossless: Whether no message may be lost: it ends where others lose the oldest ones.
        size: Bytes that wait to be sent.
        partial: Bytes of a frame that is not complete yet.
    """

    def __init__(self, loop: SocketLoop, socket_: socket.socket, largest: int) -> None:
        self._loop, self.socket = loop, socket_
        self.on_frame: Callable[[bytes], None] = lambda _data: None
        self.on_close: Callable[[], None] = lambda: None
        self.on_room: Callable[[], None] = lambda: None
        self.open, self.valid, self.lossless = True, False, False
        self.size = self.partial = 0
        self.tag: Any = None
        self._frames = Frames(largest)
        # Few short frames at once: those for which there is no time are received again.
        self._chunk = min(CHUNK, max(largest // 16, 1 << 12))
        self._queue: collections.deque[bytes] = collections.deque()
        self._sent = 0  # bytes of the first in the queue
        self._lock = loop.backlog.lock
        self._room = threading.Event()
        self._posted = False
        self._ends = False
        self._ended = False  # nothing more is sent
        self._taken = False  # whether the first in the queue is being sent
        self._dropped = False
        self._moved = time.monotonic()  # when something was sent, or began to wait
        socket_.setblocking(False)
        with contextlib.suppress(OSError):
            socket_.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    @property
    def burden(self) -> float:
        """What of all connections the one with the most has to discard something: bytes that wait."""
        return self.size

    @property
    def waits(self) -> bool:
        """Whether there is something to send."""
        return bool(self._queue) and self.open

    @property
    def stalled(self) -> bool:
        """Whether the other end has taken nothing for a second, though something waits."""
        return bool(self._queue) and time.monotonic() - self._moved > STALLED

    def start(self) -> None:
        """Begin to receive."""
        if self.open:
            self._loop.read_from(self)
            self.on_input(0)

    # Sending -----------------------------------------------------------------------------------------------------

    def send(self, data: bytes) -> None:
        """Queue a frame; any thread may call this.

        Above the limits of this queue its oldest frames are dropped, above that of all those of the longest queues.
        """
        with self._lock:
            if not self.open or self._ended:
                return
            if not self._queue:
                self._moved = time.monotonic()
            self._queue.append(data)
            self.size += len(data)
            self._loop.backlog.add(self, data)
            while len(self._queue) > 2 and (self.size > QUEUE_BYTES or len(self._queue) > QUEUE_COUNT):
                self.discard()
            if self._posted:
                return
            self._posted = True
        if self._loop.inside():  # at once, as a part of what it answers
            self.on_output(0)
        else:
            self._loop.call(self._flush)

    def discard(self) -> bool:
        """Discard the oldest frame that is not half sent; if none must be lost, or there is none, the connection ends.

        The lock is held. Returns whether there was anything.
        """
        at = 1 if self._sent or self._taken else 0
        if self.lossless or at >= len(self._queue):
            found = bool(self._queue)
            self._discard_all()
            self._loop.call(self.drop)
            return found
        frame = self._queue[at]
        del self._queue[at]
        self.size -= len(frame)
        self._loop.backlog.remove(frame)
        self._dropped = True
        return True

    def _discard_all(self) -> None:
        self._ended = True
        for frame in self._queue:
            self._loop.backlog.remove(frame)
        self._queue.clear()
        self.size = self._sent = 0
        self._loop.backlog.forget(self)

    def wait_room(self, timeout: float) -> None:
        """Wait until the queue is at most half full, or so long [s]; not in the loop's thread."""
        end = time.monotonic() + timeout
        while self.open and (self.size > QUEUE_BYTES // 2 or len(self._queue) > QUEUE_COUNT // 2):
            self._room.clear()
            if not self._room.wait(min(0.05, max(0.0, end - time.monotonic()))) and time.monotonic() > end:
                return

    def _flush(self) -> None:
        self.on_output(0)

    def on_output(self, _mask: int) -> None:
        """Send what the socket takes."""
        if not self.open:
            return
        done = False
        for _ in range(64):
            first = self._first()
            if first is None:
                done = True
                break
            try:
                count = self.socket.send(memoryview(first)[self._sent :] if self._sent else first)
            except (BlockingIOError, InterruptedError):
                break
            except OSError:
                self.drop()
                return
            if self._took(first, count):
                done = True
                break
        if not self._room.is_set():
            self._room.set()
        self.on_room()
        if self._dropped:
            self._dropped = False
            self._loop.warn("a client receives more slowly than it is sent; the oldest messages are dropped")
        if done and self._ends:
            self.drop()
        else:
            self._loop.write_to(self, not done)

    def _first(self) -> bytes | None:
        """The frame to send next; None if there is none: then the next one in the queue has to be posted."""
        with self._lock:
            if self._queue:
                self._taken = True
                return self._queue[0]
            self._posted = False
            return None

    def _took(self, first: bytes, count: int) -> bool:
        """Count bytes of a frame that the socket has taken; whether that was all that waits."""
        with self._lock:
            self._moved = time.monotonic()
            self._taken = False
            if self._ended:
                return True
            self._sent += count
            if self._sent == len(first):
                self._queue.popleft()
                self.size -= len(first)
                self._sent = 0
                self._loop.backlog.remove(first)
                if not self._queue:
                    self._posted = False
                    self._loop.backlog.forget(self)
                    return True
            return False

    # Receiving ---------------------------------------------------------------------------------------------------

    def on_input(self, _mask: int) -> None:
        """Receive what is there."""
        if not self.open:
            return
        try:
            data = self.socket.recv(self._chunk, socket.MSG_PEEK)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            self.drop()
            return
        if not data:
            self.drop()
            return
        left = 0
        try:
            left = self._handle(data)
        except ParameterError as error:
            self._loop.warn("a client was disconnected: %s", error)
            self.drop()
        finally:
            if self.open:
                with contextlib.suppress(OSError):  # the next time finds that it is closed
                    self.socket.recv(len(data) - left)

    def _handle(self, data: bytes) -> int:
        """Handle the frames that are complete with new bytes, as long as there is time; how many bytes are left.

        Those stay in the socket, which remains ready: a short frame may cost as much as sending to hundreds of clients.

        Raises:
            ParameterError: they are damaged.
        """
        self._frames.add(data)
        left = 0
        while (content := self._frames.take()) is not None:
            self.on_frame(content)
            if not self.open:
                return 0
            new, self.valid = not self.valid and self in self._loop.accepted, True
            if new or self._loop.exhausted():
                left = self._frames.give_back(len(data))
                break
        waiting, self.partial = self.partial, self._frames.waiting
        self._loop.count_partial(self.partial - waiting)
        return left

    def drop(self) -> None:
        """Close the connection, and report it by `on_close`."""
        if self.open:
            self.close()
            self.on_close()

    def end(self) -> None:
        """Close the connection once all is sent."""
        self._ends = True
        if self.open:
            self.on_output(0)

    def close(self) -> None:
        """Close the connection. Can be called twice."""
        if self.open:
            with self._lock:
                self.open = False
                self._discard_all()
            self._room.set()
            self._loop.count_partial(-self.partial)
            self.partial = 0
            self._loop.forget(self)
            with contextlib.suppress(OSError):
                self.socket.close()
