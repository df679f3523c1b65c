"""Pages: the browser pages that are connected to a viewer, and the port that serves them, in a thread of its own."""

from __future__ import annotations

import asyncio
import collections
import contextlib
import errno
import logging
import socket
import threading
import time
import weakref
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from libgz.base.backlog import Backlog
from libgz.base.closing import Closing
from libgz.base.errors import GazeboError
from libgz.simulation.repeated import repeated
from libgz.transport.tally import Tally
from libgz.view.gate import Gate
from libgz.view.protocol import (
    LARGEST_MESSAGE,
    LARGEST_OF_WATCHERS,
    MOST_OF_WATCHERS,
    MOST_VALUES,
    held_size,
    read_message,
)
from libgz.view.received import Received, wire_size

__all__ = ["Page", "Pages"]

log = logging.getLogger("libgz.view")
# Browsers open connections in advance, and close them unused: that is no error.
QUIET = logging.getLogger("libgz.view.port")
QUIET.setLevel(logging.CRITICAL)

MOST_CONNECTIONS = 200  # to the port
MOST_TRUSTED = 50  # more of pages with the token: any user of this machine can open the others
MOST_SPARE = 50  # more that have not sent it, of which each serves one request
MOST_DRAWING = 50  # requests for portraits that wait
MOST_TRIES = 200  # ports
MOST_WAITING = 400  # messages to a page that have not been sent
LARGEST_WAITING = 64 << 20  # [byte] of them
LARGEST_UNREAD = 256 << 20  # [byte] that wait for all pages with the token, and as much for all others
LARGEST_RECEIVED, LARGEST_OF_ALL_WATCHERS = 128 << 20, 32 << 20  # [byte] of messages that have not been acted on
MOST_PENDING = 100  # messages of a page that have not been acted on: then no more are read
FASTEST, FASTEST_WATCHER = 500.0, 20.0  # messages of a page per second; without the token
FASTEST_WATCHERS = 300.0  # of all pages without the token together
FASTEST_CONNECTIONS, BURST_OF_CONNECTIONS = 40.0, 100.0  # that are accepted per second, and at once
BACKLOG = 256  # connections that wait for that
AT_ONCE = 1 << 13  # [byte] that are read of a page without the token before others have their turn: frames may be empty
NEVER = 1 << 62  # [byte] after which aiohttp waits itself
PATIENCE = 10.0  # [s] for a page to read a message, or a piece of a file
PIECE = 1 << 16  # [byte] of a file that are sent at once: what is not read is held for each connection
KEPT = 15.0  # [s] that a connection without a page stays open
SILENCE = 20.0  # [s] for a connection to send its first request
BEAT = 20.0  # [s] between two pings
END = 3.0  # [s] for the port to close


class Pace:
    """Says how long to wait before something is done again.

    Args:
        rate: how often it may be done per second, on average.
        burst: how often at once.
    """

    def __init__(self, rate: float, burst: float) -> None:
        self._period, self._span = 1.0 / rate, burst / rate
        self._busy = 0.0  # until when it has been done enough [s]

    def next(self) -> float:
        """It is done now; the time until it may be done again [s]."""
        now = time.monotonic()
        self._busy = max(self._busy, now - self._span) + self._period
        return max(self._busy - now, 0.0)


class Page:
    """A page that is connected.

    Args:
        number: of it, never used again.
        may_control: whether its address has the token.
        loop: of the port.
        backlog: that counts what waits for it.
        received: that counts what it has sent.
        connection: to it.

    Attributes:
        number, may_control: as above.
        visible: whether its user can see it.
        wants: names that it wants, by channel.
        unacted: sizes of its messages that have not been acted on [byte].
        received: what they take, and those that have not come whole.
        pace: at which its messages are read.
    """

    def __init__(
        self,
        number: int,
        may_control: bool,
        loop: asyncio.AbstractEventLoop,
        backlog: Backlog,
        received: Received,
        connection: _Connection,
    ) -> None:
        self.number, self.may_control = number, may_control
        self.visible, self.received, self.unacted = True, 0, collections.deque[int]()
        self.wants: dict[str, list[str]] = {}
        self._loop, self._backlog, self._received, self._connection = loop, backlog, received, connection
        self._waiting: dict[str, bytes | str] = {}
        self._size = 0  # of them [byte]
        self._copy: range | None = None  # as long as what the transport has of a message
        self._since = time.monotonic()  # when the last message was sent
        self._filled = asyncio.Event()
        self._ended = False
        self.pace = Pace(FASTEST, FASTEST / 2.0) if may_control else Pace(FASTEST_WATCHER, FASTEST_WATCHER / 2.0)

    @property
    def burden(self) -> float:
        """Bytes that wait for it times how long: one that reads has little, however large its messages are."""
        return (self._size + len(self._copy or ())) * (time.monotonic() - self._since)

    def post(self, key: str, message: bytes | str) -> None:
        """Send a message; one of the same key that has not been sent is dropped for it. Safe in every thread."""
        with contextlib.suppress(RuntimeError):  # the port was closed
            self._loop.call_soon_threadsafe(self.put, key, message)

    def put(self, key: str, message: bytes | str) -> None:
        """As `post`, in the port's thread."""
        with self._backlog.lock:
            if self._ended:
                return
            self._drop(key)  # a state stays behind its scene
            self._waiting[key] = message
            self._size += len(message)
            self._backlog.add(self, message)
            if len(self._waiting) > MOST_WAITING or self._size > LARGEST_WAITING:
                self._end()
                self.abort("one that did not read what waited for it")
        self._filled.set()

    def discard(self) -> bool:
        """Close the page: what waits is the newest of each key, and no page should show an older one."""
        found = bool(self._waiting or self._copy)
        self._end()
        self.abort("the one that read least of what waited for all pages, which was too much together")
        return found

    def acted(self) -> None:
        """The oldest of its messages that had not been acted on has been. Safe in every thread."""
        with contextlib.suppress(RuntimeError):  # the port was closed
            self._loop.call_soon_threadsafe(self._acted)

    def _acted(self) -> None:
        self._received.remove(self, wire_size(self.unacted.popleft()))

    def abort(self, reason: str) -> None:
        """Close the connection at once; the log says which page that is."""
        self._connection.abort(f"a page was closed: {reason}")

    def _drop(self, key: str) -> bool:
        message = self._waiting.pop(key, None)
        if message is None:
            return False
        self._size -= len(message)
        self._backlog.remove(message)
        return True

    def _end(self) -> None:
        self._ended = True
        for key in [*self._waiting]:
            self._drop(key)
        self._hold(0)
        self._filled.set()

    def _hold(self, size: int) -> None:
        """Count what the transport has of a message in place of what it had."""
        if self._copy is not None:
            self._backlog.remove(self._copy)
        self._copy = range(size) if size and not self._ended else None
        if self._copy is not None:
            self._backlog.add(self, self._copy)
        elif not self._waiting:
            self._backlog.forget(self)

    async def send_all(self, channel: web.WebSocketResponse) -> None:
        """Send what is posted, until the page is closed or does not read; then the connection ends."""
        try:
            while not self._ended:
                await self._filled.wait()
                self._filled.clear()
                while self._waiting:
                    await self._send_next(channel)
        except TimeoutError:
            self.abort(f"one that read nothing for {PATIENCE:.0f} s")
        except (ConnectionError, RuntimeError):  # it has left
            self._connection.abort("")
        finally:
            with self._backlog.lock:
                self._end()

    async def _send_next(self, channel: web.WebSocketResponse) -> None:
        with self._backlog.lock:
            key = next(iter(self._waiting))
            message = self._waiting[key]
            self._drop(key)
            self._since = time.monotonic()
        if isinstance(message, bytes):
            await channel.send_frame(message, WSMsgType.BINARY)
        else:
            await channel.send_frame(message.encode(), WSMsgType.TEXT)
        del message  # the transport has a copy of what the system does not take
        with self._backlog.lock:
            self._hold(self._connection.unsent)
        async with asyncio.timeout(PATIENCE):
            await self._connection.writable.wait()
        with self._backlog.lock:
            self._hold(0)


OnMessage = Callable[[Page, dict[str, Any], int], None]


class Pages(Closing):
    """Serves pages on a port.

    Args:
        gate: what the port answers.
        port: first one that is tried.
        on_open, on_message, on_close: called with a page, in the port's thread; with a message also how many bytes it
            takes; `Page.acted` is to be called once it has been acted on.

    Attributes:
        port: that was free.

    Raises:
        GazeboError: no port is free, or the address cannot be bound.
    """

    def __init__(
        self,
        gate: Gate,
        port: int,
        on_open: Callable[[Page], None],
        on_message: OnMessage,
        on_close: Callable[[Page], None],
    ) -> None:
        self.gate, self.port = gate, port
        self._on_open, self._on_message, self._on_close = on_open, on_message, on_close
        self._pages: dict[int, Page] = {}
        self._sockets: weakref.WeakSet[web.WebSocketResponse] = weakref.WeakSet()
        self._connections: set[Any] = set()
        self._spare: dict[Any, None] = {}  # those of them that came when there were enough, oldest first
        self._silent: set[Any] = set()  # connections without a request
        self._count = 0
        self._readers, self._drawers = ThreadPoolExecutor(2, "assets"), ThreadPoolExecutor(1, "portraits")
        self._drawing = 0  # requests for portraits
        self._loop = asyncio.new_event_loop()
        self._server: web.Server
        self._listener: socket.socket | None = None
        self._accepting: asyncio.Task[None] | None = None
        self._watchers = Pace(FASTEST_WATCHERS, FASTEST_WATCHERS / 2.0)
        # By whether pages have the token: those without it cannot close one that controls.
        self._backlogs = {False: Backlog(LARGEST_UNREAD), True: Backlog(LARGEST_UNREAD)}
        self._received = {False: Received(LARGEST_OF_ALL_WATCHERS), True: Received(LARGEST_RECEIVED)}
        self._tally = Tally()
        self._closed = False
        self._thread = threading.Thread(target=self._loop.run_forever, name="pages", daemon=True)
        self._thread.start()
        try:  # in its own thread: that of the caller may have a loop that runs, such as a notebook's
            asyncio.run_coroutine_threadsafe(self._listen(), self._loop).result()
        except BaseException:
            self.close()
            raise

    def __iter__(self) -> Any:
        return iter(list(self._pages.values()))

    def __len__(self) -> int:
        return len(self._pages)

    def post(self, pages: Iterable[Any], key: str, message: bytes | str) -> None:
        """Send a message to pages, as `Page.post` does."""
        wanted = []
        for page in pages:
            if isinstance(page, Page):
                wanted.append(page)
            else:
                page.post(key, message)
        if wanted:
            with contextlib.suppress(RuntimeError):  # the port was closed
                self._loop.call_soon_threadsafe(_put_all, wanted, key, message)

    def join(self, page: Any) -> None:
        """Count something as a page that is like one."""
        self._pages[page.number] = page

    def part(self, page: Any) -> None:
        """Count it no longer."""
        self._pages.pop(page.number, None)

    async def _listen(self) -> None:
        self._server = web.Server(self._handle)
        wanted = self.port
        for self.port in range(wanted, min(wanted + MOST_TRIES, 65536)) if wanted else (0,):
            try:
                [(family, *_), *_] = await self._loop.getaddrinfo(self.gate.host, self.port, type=socket.SOCK_STREAM)
                self._listener = socket.create_server((self.gate.host, self.port), family=family, backlog=BACKLOG)
                self._listener.setblocking(False)
                self.port = self._listener.getsockname()[1]
                self._accepting = self._loop.create_task(self._accept(self._listener))
                return
            except OSError as error:
                if error.errno != errno.EADDRINUSE:
                    place = f"{self.gate.host}, port {self.port},"
                    raise GazeboError(f"{place} cannot be bound: {error.strerror}") from None
        raise GazeboError(f"no port from {wanted} to {self.port} is free on {self.gate.host}")

    async def _accept(self, listener: socket.socket) -> None:
        """Accept connections, not faster than the pages that are open can bear: the others wait."""
        pace = Pace(FASTEST_CONNECTIONS, BURST_OF_CONNECTIONS)
        while True:
            try:
                connection, _ = await self._loop.sock_accept(listener)
                await self._loop.connect_accepted_socket(self._protocol, connection)
            except OSError as error:  # the other side has left, or there are no more descriptors
                QUIET.debug("a connection was not accepted: %s", error)
            await asyncio.sleep(pace.next())

    def _protocol(self) -> asyncio.BaseProtocol:
        kept = len(self._connections) - len(self._spare)
        if kept >= MOST_CONNECTIONS + MOST_TRUSTED:
            return _Refusal()
        made = _Connection(self._server, loop=self._loop, access_log=QUIET, logger=QUIET, keepalive_timeout=KEPT)
        made.forget, made.note, made.count, made.early = self._forget, self._note, None, 0
        made.writable = asyncio.Event()
        made.writable.set()
        if kept >= MOST_CONNECTIONS:
            if len(self._spare) >= MOST_SPARE:
                oldest = next(iter(self._spare))
                self._forget(oldest)
                oldest.force_close()
            self._spare[made] = None
        self._connections.add(made)
        self._silent.add(made)
        self._loop.call_later(SILENCE, self._close_silent, made)
        return made

    def _note(self, what: str) -> None:
        """Log why a connection is closed, at growing counts."""
        with repeated(self._tally):
            log.warning("%s", what)

    def _forget(self, protocol: Any) -> None:
        self._connections.discard(protocol)
        self._spare.pop(protocol, None)

    def _close_silent(self, protocol: Any) -> None:
        if protocol in self._silent:
            self._silent.discard(protocol)
            protocol.force_close()

    async def _handle(self, request: web.BaseRequest) -> web.StreamResponse:
        self._silent.discard(request.protocol)
        refusal = self.gate.refusal(request)
        if refusal is not None:
            return refusal
        if self.gate.may_control(request):
            self._spare.pop(request.protocol, None)
        spare = request.protocol in self._spare
        if request.headers.get("Upgrade", "").lower() == "websocket":
            return await self._talk(request) if not spare else _busy("too many pages are open")
        if not self.gate.is_slow(request):
            response = await self._loop.run_in_executor(self._readers, self.gate.answer, request)
            if spare:
                response.force_close()
            return await _sent(request, response)
        if self._drawing >= MOST_DRAWING:
            return _busy("too many portraits are asked for")
        self._drawing += 1
        try:
            response = await self._loop.run_in_executor(self._drawers, self.gate.answer, request)
        finally:
            self._drawing -= 1
        return await _sent(request, response)

    async def _talk(self, request: web.BaseRequest) -> web.StreamResponse:
        """Serve the socket of a page until it ends."""
        if self.gate.local_path(request) != "/socket":
            return web.Response(status=404, text="there is nothing here")
        may_control = self.gate.may_control(request)
        largest = LARGEST_MESSAGE if may_control else LARGEST_OF_WATCHERS
        most_values = MOST_VALUES if may_control else MOST_OF_WATCHERS
        # Pings are answered below: they count as messages, and so do pongs.
        channel = web.WebSocketResponse(
            heartbeat=BEAT, max_msg_size=largest, compress=False, autoping=False, writer_limit=NEVER
        )
        await channel.prepare(request)
        transport = request.transport
        if transport is None:
            return channel
        if not may_control:
            transport.max_size = AT_ONCE  # type: ignore[attr-defined]
        self._count += 1
        backlog, received = self._backlogs[may_control], self._received[may_control]
        connection: Any = request.protocol
        page = Page(self._count, may_control, self._loop, backlog, received, connection)
        connection.count = lambda count: received.add(page, count)
        received.add(page, connection.early)
        self._pages[page.number] = page
        self._sockets.add(channel)
        sender = self._loop.create_task(page.send_all(channel))
        try:
            self._on_open(page)
            async for raw in channel:
                if raw.type == WSMsgType.PING:
                    with contextlib.suppress(ConnectionError):
                        await channel.pong(raw.data)
                        await connection.writable.wait()
                text = raw.data if raw.type == WSMsgType.TEXT else ""  # else bytes, or an error
                message = read_message(text, most_values)
                size = _size_of(raw.data)
                if message is not None:
                    page.unacted.append(size)
                    self._on_message(page, message, held_size(text))
                else:
                    received.remove(page, wire_size(size))
                wait = page.pace.next()
                await asyncio.sleep(wait if may_control else max(wait, self._watchers.next()))
                most = MOST_PENDING if len(text) < LARGEST_OF_WATCHERS else 1
                del raw, text, message
                while len(page.unacted) >= most and not self._closed:
                    await asyncio.sleep(0.02)
        finally:
            connection.count = None
            received.forget(page)
            self._pages.pop(page.number, None)
            self._on_close(page)
            sender.cancel()
            await asyncio.gather(sender, return_exceptions=True)
        return channel

    def close(self) -> None:
        """Close the port and all connections. Can be called twice."""
        if self._closed:
            return
        self._closed = True
        with contextlib.suppress(Exception):
            asyncio.run_coroutine_threadsafe(self._end(), self._loop).result(2.0 * END)
        self._loop.call_soon_threadsafe(self._loop.stop)
        for threads in (self._readers, self._drawers):
            threads.shutdown(wait=False, cancel_futures=True)
        self._thread.join(END)
        if not self._thread.is_alive():
            self._loop.close()

    async def _end(self) -> None:
        if self._accepting is not None:
            self._accepting.cancel()
            await asyncio.wait([self._accepting])
        if self._listener is not None:
            self._listener.close()
        closing = [one.close(code=WSCloseCode.GOING_AWAY) for one in list(self._sockets)]
        with contextlib.suppress(Exception):
            await asyncio.wait_for(asyncio.gather(*closing, return_exceptions=True), END / 3.0)
        await self._server.shutdown(END / 3.0)
        rest = asyncio.all_tasks() - {asyncio.current_task()}
        for task in rest:
            task.cancel()
        if rest:
            await asyncio.wait(rest, timeout=END / 3.0)


def _size_of(data: object) -> int:
    """The bytes of a message's text or bytes."""
    if isinstance(data, str):
        return len(data) if data.isascii() else len(data.encode("utf-8", "replace"))
    return len(data) if isinstance(data, bytes | bytearray) else 0


def _put_all(pages: list[Page], key: str, message: bytes | str) -> None:
    for page in pages:
        page.put(key, message)


async def _sent(request: web.BaseRequest, answer: web.Response) -> web.StreamResponse:
    """Send an answer in pieces; a client that does not read it is disconnected, and holds no copy of it."""
    connection: Any = request.protocol
    response = web.StreamResponse(status=answer.status, headers=answer.headers)
    body = answer.body if isinstance(answer.body, bytes) else b""
    response.content_length = len(body)
    if answer.keep_alive is False:
        response.force_close()
    pieces = range(0, len(body), PIECE) if request.method != "HEAD" else ()
    try:
        await response.prepare(request)
        for start in pieces:
            async with asyncio.timeout(PATIENCE):
                await response.write(memoryview(body)[start : start + PIECE])
        async with asyncio.timeout(PATIENCE):
            await response.write_eof()
    except TimeoutError:
        connection.abort(f"a connection was closed: of a file it read nothing for {PATIENCE:.0f} s")
    return response


def _busy(text: str) -> web.Response:
    response = web.Response(status=503, text=text)
    response.force_close()
    return response


class _Connection(web.RequestHandler):
    """A connection, which is counted as long as it lives, and what is received by it.

    Attributes:
        early: bytes that came before it was a page's.
        count: called with how many come later.
        forget, note: called with it when it is lost, and with what the log is to say.
        writable: set unless much is unsent.
    """

    __slots__ = ("count", "early", "forget", "note", "writable")
    early: int
    count: Callable[[int], None] | None
    forget: Callable[[Any], None]
    note: Callable[[str], None]
    writable: asyncio.Event

    @property
    def unsent(self) -> int:
        """Bytes that are held of what it did not take: its buffer takes an eighth more."""
        size = self.transport.get_write_buffer_size() if self.transport is not None else 0
        return size + size // 8

    def abort(self, reason: str) -> None:
        """Close it at once; the log has the reason, unless it is empty."""
        if self.transport is not None and not self.transport.is_closing():
            if reason:
                self.note(reason)
            self.transport.abort()

    def pause_writing(self) -> None:
        """Much is unsent."""
        self.writable.clear()
        super().pause_writing()

    def resume_writing(self) -> None:
        """Little is unsent."""
        self.writable.set()
        super().resume_writing()

    def data_received(self, data: bytes) -> None:
        """Count what is received."""
        if self.count is None:
            self.early += len(data)
        else:
            self.count(len(data))
        super().data_received(data)

    def connection_lost(self, exc: BaseException | None) -> None:
        """Count it no longer."""
        self.writable.set()
        self.forget(self)
        super().connection_lost(exc)


class _Refusal(asyncio.Protocol):
    """A connection beyond the largest number, which is closed."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        transport.close()
