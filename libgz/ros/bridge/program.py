"""Nodes of ROS 2 for the topics and services that a server declares over a socket.

It runs with the user's own Python, of any distribution and middleware, and imports nothing of libgz. Frames in both
directions: their length (32 bits), their sort (8), a channel (32), and the rest. Messages are passed on as the bytes
that they are.
"""

from __future__ import annotations

import importlib
import itertools
import json
import os
import socket
import struct
import sys
import threading
import traceback
from typing import Any

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message

DECLARE, DROP, MESSAGE, ANSWER, HELLO, DECLARED, REFUSED, LISTENED, REQUEST = range(1, 10)
HEAD = struct.Struct("<IBI")
NUMBER = struct.Struct("<Q")
COUNT = struct.Struct("<I")
MOST_MESSAGE, MOST_REQUEST = 1 << 22, 1 << 24  # bytes that the server takes
# Most requests of a node that are answered at the same time: who asks for an action's result waits for its end.
THREADS = 128
ANSWER_PATIENCE = 1000.0  # [s]; the server ends all that takes longer than 900
LOOK_PERIOD = 0.1  # [s] between two looks for subscribers
POLICIES = {
    "reliability": ReliabilityPolicy,
    "durability": DurabilityPolicy,
    "history": HistoryPolicy,
    "liveliness": LivelinessPolicy,
}
FIRST = "/", "gazebo"  # namespace and name of a node that is always there
TIMES = ("deadline", "lifespan", "liveliness_lease_duration")
EMPTY = {"structure_needs_at_least_one_member": "uint8"}  # what a type without fields has on the wire


def profile(given: dict[str, Any]) -> QoSProfile:
    """The quality of service that a declaration asks for; times in seconds."""
    values: dict[str, Any] = {"depth": given.get("depth", 10)}
    for name, policy in POLICIES.items():
        if name in given:
            values[name] = policy[given[name].upper()]
    for name in TIMES:
        if name in given:
            values[name] = Duration(nanoseconds=round(given[name] * 1e9))
    return QoSProfile(**values)


def find_type(name: str) -> Any:
    """The class of a type: package/msg/Name, package/srv/Name, package/action/Name.Part."""
    package, sort, path = name.split("/")
    found: Any = importlib.import_module(f"{package}.{sort}")
    for part in path.split("."):
        found = getattr(found, part)
    return found


def describe(kind: Any, name: str, found: dict[str, dict[str, str]]) -> dict[str, dict[str, str]]:
    """The fields of a type and of all in it, by their names."""
    fields = kind.get_fields_and_field_types()
    found[name] = dict(fields) or EMPTY
    for text, slot in zip(fields.values(), kind.SLOT_TYPES):  # noqa: B905 -- older Pythons have no `strict`
        inner = getattr(slot, "value_type", slot)
        spaces, base = getattr(inner, "namespaces", None), getattr(inner, "name", "")
        if spaces is None or "builtin_interfaces" in spaces:
            continue
        plain = text.replace("sequence<", "").split(",")[0].split(">")[0].split("[")[0]
        if plain not in found:
            module = importlib.import_module(".".join(spaces))
            owner, _, part = base.rpartition("_")
            nested = getattr(getattr(module, owner), part) if not hasattr(module, base) else getattr(module, base)
            describe(nested, plain, found)
    return found


class OwnNode:
    """A node, with an executor of its own: one looks at all that its nodes have for each message.

    Attributes:
        place: its namespace and name.
        node: that of rclpy.
    """

    def __init__(self, space: str, name: str) -> None:
        self.place = space, name
        self.node = rclpy.create_node(
            name,
            namespace=space,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
            parameter_overrides=[Parameter("start_type_description_service", value=False)],
        )
        self._executor = MultiThreadedExecutor(num_threads=THREADS)
        self._executor.add_node(self.node)
        self._ended = False
        threading.Thread(target=self._spin, daemon=True).start()

    def end(self) -> None:
        """Destroy it, soon: requests may still wait for their answers."""
        self._ended = True
        self._executor.create_task(lambda: None)  # so that the executor does not wait

    def _spin(self) -> None:
        try:
            while rclpy.ok() and not self._ended:
                self._executor.spin_once()
        except BrokenPipeError:
            pass  # the server is gone
        except Exception:  # noqa: BLE001 -- of any middleware
            traceback.print_exc()
        if not self._ended:
            os._exit(0)  # the server starts another bridge
        self._executor.remove_node(self.node)
        self.node.destroy_node()


class Channel:
    """What was declared: `entity` is the publisher, subscription or service of a node; `destroy` ends it."""

    def __init__(self, node: OwnNode, entity: Any, destroy: Any) -> None:
        self.node, self.entity, self.destroy = node, entity, destroy
        self.listeners = 0


class Bridge:
    """Passes messages between the server's socket and the graph of ROS."""

    def __init__(self, sock: socket.socket) -> None:
        self._socket = sock
        self._lock = threading.Lock()  # of the socket for writing
        self._ending = threading.Lock()  # held while a channel ends, or while all are asked
        self._group = ReentrantCallbackGroup()  # requests wait for their answers
        self._nodes: dict[tuple[str, str], OwnNode] = {}
        self._channels: dict[int, Channel] = {}
        self._waiting: dict[int, list[Any]] = {}  # numbers of requests -> event, answer
        self._numbers = itertools.count(1)
        self._large: set[str] = set()

    def run(self) -> None:
        """Serve until the server closes the socket."""
        self.node(*FIRST).node.create_timer(LOOK_PERIOD, self._look)
        about = {
            "distribution": os.environ.get("ROS_DISTRO", ""),
            "middleware": rclpy.get_rmw_implementation_identifier(),
        }
        self._send(HELLO, 0, json.dumps(about).encode())
        self._read_all()

    def node(self, space: str, name: str) -> OwnNode:
        """The node of a name, made when it is first asked for."""
        if (space, name) not in self._nodes:
            self._nodes[space, name] = OwnNode(space, name)
        return self._nodes[space, name]

    def _drop(self, number: int) -> None:
        """End a channel, and with the last one its node, unless that is the first, which looks for subscribers."""
        with self._ending:
            channel = self._channels.pop(number)
            channel.destroy()
        node = channel.node
        if node.place != FIRST and all(one.node is not node for one in self._channels.values()):
            del self._nodes[node.place]
            node.end()

    # The server's side -------------------------------------------------------------------------------------------

    def _send(self, sort: int, channel: int, body: bytes) -> None:
        with self._lock:
            self._socket.sendall(HEAD.pack(len(body) + HEAD.size - 4, sort, channel) + body)

    def _read(self, size: int) -> bytes:
        """Some bytes from the server: those of a message in one piece, for its publisher takes nothing else."""
        data = self._socket.recv(size, socket.MSG_WAITALL) if size else b""
        while len(data) < size:  # a signal came
            more = self._socket.recv(size - len(data), socket.MSG_WAITALL)
            if not more:
                raise EOFError
            data += more
        return data

    def _read_all(self) -> None:
        try:
            while True:
                size, sort, channel = HEAD.unpack(self._read(HEAD.size))
                body = self._read(size - HEAD.size + 4)
                if sort == MESSAGE:
                    self._publish(channel, body)
                elif sort == ANSWER:
                    self._answer(body)
                else:
                    self._act(sort, channel, body)
        except (OSError, EOFError):
            os._exit(0)  # the server is gone; the middleware's threads would wait

    def _publish(self, channel: int, body: bytes) -> None:
        found = self._channels.get(channel)
        if found is not None:
            try:
                found.entity.publish(body)
            except Exception as error:  # noqa: BLE001 -- of any middleware; the server logs it
                self._refuse(channel, error)

    def _answer(self, body: bytes) -> None:
        (number,) = NUMBER.unpack_from(body)
        waiting = self._waiting.pop(number, None)
        if waiting is not None:
            waiting[1] = body[NUMBER.size :]
            waiting[0].set()

    def _act(self, sort: int, channel: int, body: bytes) -> None:
        """Declare or drop."""
        try:
            if sort == DECLARE:
                self._declare(channel, json.loads(body))
            elif channel in self._channels:
                self._drop(channel)
        except Exception as error:  # noqa: BLE001 -- of any middleware; the server logs it
            self._refuse(channel, error)

    def _refuse(self, channel: int, error: Exception) -> None:
        text = f"{type(error).__name__}: {error}"
        self._send(REFUSED, channel, text[:1000].encode())

    def _declare(self, channel: int, given: dict[str, Any]) -> None:
        kind, name, quality = find_type(given["type"]), given["name"], profile(given["qos"])
        verb, own = given["verb"], self.node(*given["node"])
        node = own.node
        kinds = (kind.Request, kind.Response) if verb == "serve" else (kind,)
        fields = [describe(one, "", {}) for one in kinds]
        self._send(DECLARED, channel, json.dumps(fields).encode())  # before all that the server needs the fields for
        if verb == "serve":

            def call(request: Any, response: Any) -> Any:
                return self._call(channel, name, kind, request) or response

            service = node.create_service(kind, name, call, callback_group=self._group)
            self._channels[channel] = Channel(own, service, lambda: node.destroy_service(service))
        elif verb == "publish":
            publisher = node.create_publisher(kind, name, quality)
            self._channels[channel] = Channel(own, publisher, lambda: node.destroy_publisher(publisher))
        else:
            subscription = node.create_subscription(
                kind, name, lambda body: self._received(channel, name, body), quality, raw=True
            )
            self._channels[channel] = Channel(own, subscription, lambda: node.destroy_subscription(subscription))

    # The graph's side --------------------------------------------------------------------------------------------

    def _received(self, channel: int, name: str, body: bytes) -> None:
        if len(body) <= MOST_MESSAGE:
            self._send(MESSAGE, channel, body)
        elif name not in self._large:
            self._large.add(name)
            sys.stderr.write(f"{name}: messages of {len(body)} bytes are left out; at most {MOST_MESSAGE} are taken\n")

    def _call(self, channel: int, name: str, kind: Any, request: Any) -> Any:
        body = serialize_message(request)
        if len(body) > MOST_REQUEST:
            sys.stderr.write(f"{name}: a request of {len(body)} bytes is left out; at most {MOST_REQUEST} are taken\n")
            return None
        number = next(self._numbers)
        waiting = self._waiting[number] = [threading.Event(), b""]
        self._send(REQUEST, channel, NUMBER.pack(number) + body)
        waiting[0].wait(ANSWER_PATIENCE)
        self._waiting.pop(number, None)
        answer = waiting[1]
        return deserialize_message(answer[1:], kind.Response) if answer[:1] == b"\1" else None

    def _look(self) -> None:
        with self._ending:
            for number, channel in list(self._channels.items()):
                if hasattr(channel.entity, "get_subscription_count"):
                    count = channel.entity.get_subscription_count()
                    if count != channel.listeners:
                        channel.listeners = count
                        self._send(LISTENED, number, COUNT.pack(count))


if __name__ == "__main__":
    rclpy.init()
    try:
        Bridge(socket.socket(fileno=int(sys.argv[1]))).run()
    except (KeyboardInterrupt, BrokenPipeError):
        os._exit(0)
