"""PlayerServer: listens on the ports of a configuration, and serves clients of all versions in one loop."""

from __future__ import annotations

import contextlib
import logging
import queue
import selectors
import socket
import threading
import time
from collections import OrderedDict
from collections.abc import Callable

from libgz.base.closing import Closing
from libgz.base.errors import ServerError, explain
from libgz.player.configuration import Configuration
from libgz.player.connection import Connection, Totals
from libgz.player.conversation import Directory
from libgz.player.device import Device
from libgz.player.drivers import RefusedError
from libgz.player.messages import Message
from libgz.player.records import Values
from libgz.player.simulator import Simulator
from libgz.player.wire import ACK, NACK, Frame
from libgz.transport.peers import PeerCheck
from libgz.transport.tally import Tally

__all__ = ["LOOPBACK", "PlayerServer"]

log = logging.getLogger("libgz.player")

LOOPBACK = "127.0.0.1"
PERIOD = 0.004  # [s] between two looks at the interfaces, while somebody subscribes to them
IDLE = 0.25  # [s] while nobody does
BUDGET = 0.004  # [s] of a turn for what clients send
MOST_CONNECTIONS = 400
KERNEL_BUFFER = 128 << 10  # [byte] that the system holds for a client
BANNER = b"Player v.2.1.3 (libgz)".ljust(32, b"\0")  # clients read 32 bytes before they send the first

_Slow = tuple[Connection, Frame, Device, Message, Values]
_Answer = tuple[Connection, int, Frame, Message, "Values | None"]


class PlayerServer(Closing):
    """Serves the devices of a configuration::

        with PlayerServer(read_configuration("robot.cfg"), Simulator(0)) as server:
            server.run()

    Args:
        configuration: which devices there are, on which ports.
        simulator: whose interfaces they are.
        host: address to listen on.
        key: that clients must send first; an empty string for none.
        version: of clients of Player 2 and 3; an empty string: 2.0 or 2.1, as the client shows.

    Attributes:
        ports: on which it listens.

    Raises:
        ServerError: a port cannot be used.
    """

    def __init__(
        self,
        configuration: Configuration,
        simulator: Simulator,
        *,
        host: str = LOOPBACK,
        key: str = "",
        version: str = "",
    ) -> None:
        self._simulator = simulator
        self._devices = [Device(declared, simulator) for declared in configuration.devices]
        by_address = {(d.declared.port, d.declared.driver.kind, d.declared.index): d for d in self._devices}
        self._directory = Directory(simulator, by_address, key)
        self._version, self._totals, self._peers = version, Totals(), PeerCheck()
        self._tally = Tally(100)
        self._selector = selectors.DefaultSelector()
        self._connections: OrderedDict[int, Connection] = OrderedDict()  # by descriptor, the oldest first
        self._listeners: dict[socket.socket, int] = {}
        self._slow: queue.SimpleQueue[_Slow | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[_Answer] = queue.SimpleQueue()
        self._worker: threading.Thread | None = None
        self._next_poll = self._next_round = self._accepts_from = 0.0
        self._ended = False
        self._reader, self._writer = socket.socketpair()
        self._writer.setblocking(False)
        self._reader.setblocking(False)
        self._selector.register(self._reader, selectors.EVENT_READ)
        self.ports = configuration.ports
        try:
            for port in self.ports:
                self._listen(host, port)
        except OSError as error:
            self.close()
            raise ServerError(f"cannot listen on {host}:{port}: {error.strerror or error}") from None
        simulator.check(time.monotonic())

    def _listen(self, host: str, port: int) -> None:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        listener = socket.create_server((host, port), family=family, backlog=128)
        listener.setblocking(False)
        self._listeners[listener] = port
        self._selector.register(listener, selectors.EVENT_READ)

    @property
    def connections(self) -> int:
        """The number of connected clients."""
        return len(self._connections)

    @property
    def unsent(self) -> int:
        """What waits for clients to read it [byte]."""
        return self._totals.unsent

    def run(self) -> None:
        """Serve until `end` is called."""
        while not self._ended:
            self.turn(IDLE)

    def end(self) -> None:
        """Let `run` return; may be called by another thread and by a signal handler."""
        self._ended = True
        self._wake()

    def _wake(self) -> None:
        with contextlib.suppress(OSError):
            self._writer.send(b"\0")

    def turn(self, timeout: float = 0.0) -> None:
        """Handle what has come, and send what is due; wait for it at most until the timeout [s]."""
        now = time.monotonic()
        if any(connection.more for connection in self._connections.values()):
            timeout = 0.0
        elif any(device.subscribers for device in self._devices):
            timeout = max(0.0, min(timeout, self._next_poll - now))
        for key, events in self._selector.select(timeout):
            if key.fileobj not in self._listeners or not self._accepts_from:
                self._handle(key, events)
        self._answer()
        self._handle_frames()
        now = time.monotonic()
        if now >= self._next_poll:
            self._next_poll = now + PERIOD
            self._poll(now)
        self._remove_closed()
        if 0.0 < self._accepts_from <= now:
            self._accepts_from = 0.0
            for listener in self._listeners:
                self._selector.register(listener, selectors.EVENT_READ)

    def _handle_frames(self) -> None:
        """Handle frames of all clients in turn, for a while."""
        end = time.monotonic() + BUDGET
        for descriptor, connection in [item for item in self._connections.items() if item[1].more]:
            if not connection.closed:
                self._guard(connection, connection.handle)
                self._update(connection)
            self._connections.move_to_end(descriptor)  # the others come first next time
            if time.monotonic() > end:
                return

    def _handle(self, key: selectors.SelectorKey, events: int) -> None:
        if key.fileobj is self._reader:
            with contextlib.suppress(BlockingIOError):
                self._reader.recv(4096)
        elif key.fileobj in self._listeners:
            self._accept(key.fileobj)
        else:
            connection = self._connections.get(key.fd)
            if connection is None:
                return
            if events & selectors.EVENT_WRITE:
                connection.flush()
                if connection.conversation is not None and not connection.crowded:
                    self._guard(connection, connection.conversation.deliver)
            if events & selectors.EVENT_READ and connection.listens:
                connection.receive()
            self._update(connection)

    # Connections -----------------------------------------------------------------------------------------------------

    def _accept(self, listener: socket.socket) -> None:
        try:
            sock, _ = listener.accept()
        except BlockingIOError:
            return
        except OSError as error:  # no descriptors are left
            self._warn(f"cannot accept a client: {error.strerror}")
            self._make_room()
            self._accepts_from = time.monotonic() + IDLE
            for one in self._listeners:  # they stay readable
                self._selector.unregister(one)
            return
        if len(self._connections) >= MOST_CONNECTIONS and not self._make_room():
            self._warn(f"refused a client: there are {MOST_CONNECTIONS} already")
            sock.close()
            return
        refused = self._peers.refusal(sock)
        if refused:
            self._warn(f"refused a client: {refused}")
            sock.close()
            return
        sock.setblocking(False)
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, KERNEL_BUFFER)
        port = self._listeners[listener]
        connection = Connection(sock, port, self._directory, self._totals, self._version, self._defer)
        self._connections[sock.fileno()] = connection
        self._selector.register(sock, selectors.EVENT_READ)
        connection.send(BANNER)
        self._update(connection)

    def _guard(self, connection: Connection, action: Callable[..., None], *arguments: object) -> None:
        """Do what a client asked for; one for which that fails loses its connection, and the others nothing."""
        try:
            action(*arguments)
        except Exception as error:
            self._warn(f"disconnected a client: {explain(error)}")
            log.debug("a client could not be served", exc_info=error)
            connection.close("it could not be served")

    def _warn(self, message: str) -> None:
        """Log what a client did, the first time, then at growing counts."""
        if self._tally.due(message):
            log.warning("%s%s", message, self._tally.times(message))

    def _make_room(self) -> bool:
        """Close the oldest connection that has said nothing usable; whether there was one."""
        for connection in self._connections.values():
            if connection.conversation is None and not connection.closed:
                connection.close("others wait, and it has said nothing")
                self._remove(connection)
                return True
        return False

    def _update(self, connection: Connection) -> None:
        """Wait for what the connection can do next."""
        if connection.closed:
            return
        events = selectors.EVENT_READ if connection.listens else 0
        events |= selectors.EVENT_WRITE if connection.waits_to_send else 0
        descriptor = connection.socket.fileno()
        known = self._selector.get_map().get(descriptor)
        if events == 0:
            if known is not None:
                self._selector.unregister(connection.socket)
        elif known is None:
            self._selector.register(connection.socket, events)
        elif known.events != events:
            self._selector.modify(connection.socket, events)

    def _remove_closed(self) -> None:
        for connection in [c for c in self._connections.values() if c.closed]:
            self._remove(connection)

    def _remove(self, connection: Connection) -> None:
        log.debug("a client of port %d is disconnected: %s", connection.port, connection.closed)
        descriptor = connection.socket.fileno()
        if descriptor in self._selector.get_map():
            self._selector.unregister(connection.socket)
        self._connections.pop(descriptor, None)
        connection.end()

    # Data ------------------------------------------------------------------------------------------------------------

    def _poll(self, now: float) -> None:
        """Look for new data, and let conversations send what is due."""
        self._simulator.check(now)
        for device in self._devices:
            if device.subscribers:
                device.poll()
        everyone = now >= self._next_round
        if everyone:
            self._next_round = now + IDLE
        for connection in self._connections.values():
            conversation = connection.conversation
            if conversation is not None and (everyone or conversation.subscriptions) and not connection.closed:
                self._guard(connection, conversation.deliver)
                if connection.waits_to_send:
                    self._update(connection)

    # Slow requests ---------------------------------------------------------------------------------------------------

    def _defer(self, *request: *_Slow) -> None:
        if self._worker is None:
            self._worker = threading.Thread(target=self._work, name="player requests", daemon=True)
            self._worker.start()
        self._slow.put(request)

    def _work(self) -> None:
        while (request := self._slow.get()) is not None:
            connection, frame, _, message, values = request
            kind, reply = NACK, None
            if not connection.closed:
                try:
                    reply = self._simulator.answer(message.name, values)
                    kind = ACK
                except RefusedError as error:
                    log.debug("refused %s: %s", message.name, error)
                except Exception as error:  # else no further request would be answered
                    self._warn(f"{message.name} failed: {explain(error)}")
                    log.debug("%s failed", message.name, exc_info=error)
            self._answers.put((connection, kind, frame, message, reply))
            self._wake()

    def _answer(self) -> None:
        while not self._answers.empty():
            connection, kind, frame, message, reply = self._answers.get()
            connection.busy = False
            if connection.closed or connection.conversation is None:
                continue
            self._guard(connection, connection.conversation.answer, kind, frame, message, reply)
            connection.more = True

    def close(self) -> None:
        """Disconnect all clients, and stop listening. Can be called twice."""
        for connection in list(self._connections.values()):
            connection.close("the server ends")
            self._remove(connection)
        for listener in self._listeners:
            listener.close()
        self._listeners.clear()
        if self._worker is not None:
            self._slow.put(None)
            self._worker = None
        self._selector.close()
        self._reader.close()
        self._writer.close()
        self._simulator.close()
