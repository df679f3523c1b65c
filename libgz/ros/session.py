"""Session: ROS of one server: what its plugins publish, subscribe to and serve, by whatever wires it has."""

from __future__ import annotations

import logging
import math
import time
from collections import deque
from collections.abc import Callable, Iterable, Sized
from functools import partial
from itertools import chain, repeat
from typing import Any
from weakref import WeakKeyDictionary, WeakSet

import numpy as np

from libgz.base.closing import Closing
from libgz.base.errors import GazeboError, StateError
from libgz.base.law import Number, constant
from libgz.ros.bridged import BridgedNode, Channel
from libgz.ros.names import NodeNames, frame_with_prefix
from libgz.ros.node import Node, Publisher
from libgz.ros.own_node import OwnNode
from libgz.ros.packed import LATEST, MOST_NUMBER, Outbox, PackedMessage
from libgz.ros.packing import Codec
from libgz.ros.types import NUMBERS, Message, MessageType, ServiceType, Stamp, message_type, service_type
from libgz.simulation.event import AtEnd, Callback, unowned
from libgz.simulation.repeated import MOST_LINES, repeated
from libgz.transport.allowance import Allowance
from libgz.transport.tally import Tally

__all__ = [
    "Later",
    "NodeSession",
    "Publication",
    "Service",
    "Session",
    "Subscription",
    "finite",
    "session",
    "set_stamp",
]

log = logging.getLogger("libgz.ros")

MOST_REQUESTS, MOST_REQUEST_BYTES = 256, 1 << 26  # that may wait for the step; as many may wait for their answers

_sessions: list[Session] = []


def session() -> Session:
    """The session of this process.

    Raises:
        StateError: there is none.
    """
    if not _sessions:
        raise StateError("there is no ROS in this process; start the server with --ros1 or --ros2")
    return _sessions[-1]


class Later:
    """The answer of a service that takes more than a step.

    Args:
        poll: called after each step; the answer, or None as long as there is none.
        patience: how long it may take [s], of real time.
        overdue: the answer if it takes longer.
        most: how many of them may wait at one service; with one more, the first one is overdue.
    """

    def __init__(
        self, poll: Callable[[], Message | None], patience: float, overdue: Message, most: int = MOST_REQUESTS
    ) -> None:
        self.poll, self.deadline, self.overdue = poll, time.monotonic() + patience, overdue
        self.most = most


class Publication:
    """A topic that is published, as long as this is kept, or until its plugin ends.

    Attributes:
        topic: its full name.
        kind: the type of its messages.
        stamped: whether these have a header.
        number: of the next message, in the header.
        gatherer: the session, and where native code may put messages; None: nowhere.
    """

    number = Number()

    def __init__(
        self,
        owner: Session,
        topic: str,
        kind: MessageType,
        queue: int,
        latch: bool,
        changed: Callable[[], object] | None = None,
        **more: Any,
    ) -> None:
        self.topic, self.kind = topic, kind
        node: Any = owner.node
        publisher = self._publisher = node.advertise(topic, kind, queue, latch, **more)
        if changed is not None:
            self.changed = Callback(f"the update of what topic {topic} needs", changed)
            owner.watchers.setdefault(publisher, WeakSet()).add(self)
        self.stamped = any(field.kind == "std_msgs/Header" and field.name == "header" for field in kind.fields)
        outbox = publisher.outbox if isinstance(publisher, Publisher) else None
        self.gatherer: tuple[Session, Outbox | None] = owner, outbox
        self._end = AtEnd(lambda: node.withdraw(publisher))

    def end(self) -> None:
        """Publish it no longer; can be called twice."""
        self._end.disconnect()

    @property
    def codec(self) -> Codec:
        """The codec of its messages."""
        found: Codec = self._publisher.codec
        return found

    @property
    @constant
    def listened(self) -> bool:
        """Whether there are subscribers: without any, no message needs to be made."""
        return bool(self._publisher.listened)

    @property
    def subscribed(self) -> bool:
        """Whether there are subscribers now; a topic that keeps its last message is `listened` to without any."""
        return bool(self._publisher.subscribed)

    def publish(self, message: Any) -> None:
        """Send a message: it is packed now, so it may be filled again afterwards.

        Its bytes leave now, or in another thread where a subscriber is slow.
        """
        if self.stamped:
            message.header.seq = int(self.number)
        self.number = self.number + 1.0 if self.number < MOST_NUMBER else 0.0
        if self._publisher.listened:
            self._publisher.publish(self._publisher.codec.pack_parts(message))

    def send_body(self, body: bytes) -> None:
        """Send the bytes of a message."""
        if self._publisher.listened:
            self._publisher.publish([body])


class Subscription:
    """A topic that is subscribed to until this, or its plugin, ends.

    Messages are delivered between steps, in the thread of the world; of those that come faster, the oldest are dropped.
    """

    def __init__(
        self, owner: Session, topic: str, kind: MessageType, callback: Callable[[Any], object], queue: int, **more: Any
    ) -> None:
        self.topic, self.kind, self._session = topic, kind, owner
        self._call = Callback(f"the callback of topic {topic}", callback)
        self._waiting: deque[Any] = deque(maxlen=max(queue, 1))
        self._listed = False  # among those for which messages wait
        node: Any = owner.node
        received = self._received
        depth = {"queue": queue} if owner.version == 2 else {}
        subscriber = self._subscriber = node.subscribe(topic, kind, received, **depth, **more)
        self._end = AtEnd(lambda: node.unsubscribe(subscriber, received))

    @property
    def publishers(self) -> int:
        """How many nodes of ROS 1 publish the topic."""
        return len(self._subscriber.publishers)

    def end(self) -> None:
        """Unsubscribe; can be called twice."""
        self._end.disconnect()

    def _received(self, body: bytes) -> None:
        self._waiting.append(self._subscriber.codec.unpack(body))
        if not self._listed:
            self._listed = True
            self._session.waiting.append(self)
            self._session.interrupt()

    def deliver(self) -> None:
        """Call the callback for all that waits."""
        self._listed = False  # first, so that what comes now is delivered at the latest next time
        for _ in range(len(self._waiting)):
            self._call(self._waiting.popleft())


class Service:
    """A service that is served until this, or its plugin, ends.

    Requests are answered between steps, in the thread of the world.
    """

    def __init__(
        self, owner: Session, name: str, kind: ServiceType, handler: Callable[[Any], Message | Later], **more: Any
    ) -> None:
        self.name, self.kind = name, kind
        self._session, self._handler = owner, handler
        node: Any = owner.node
        server = self._server = node.serve(name, kind, self._received, **more)
        self._end = AtEnd(lambda: node.stop_serving(server))

    def end(self) -> None:
        """Serve it no longer; can be called twice."""
        self._end.disconnect()

    def _received(self, body: bytes, answer: Callable[[bool, bytes], None]) -> bool:
        waiting = self._session.requests
        if len(waiting) >= MOST_REQUESTS:
            return False
        if sum(len(one) for _, one, _ in tuple(waiting)) + len(body) > MOST_REQUEST_BYTES:
            return False
        waiting.append((self, body, answer))
        self._session.interrupt()
        return True

    def handle(self, body: bytes, answer: Callable[[bool, bytes], None]) -> None:
        """Answer a request now, or later."""
        try:
            result = self._handler(self._server.codecs[0].unpack(body))
        except Exception as error:  # noqa: BLE001 - whatever a plugin raises
            self.refuse(error, answer)
            return
        if not isinstance(result, Later):
            self.answer(result, answer)
        elif len(self._session.later) >= MOST_REQUESTS:
            answer(False, b"too many requests wait for their answers")
        else:
            present = [one for service, one, _ in self._session.later if service is self and one.deadline > -math.inf]
            if len(present) >= result.most:
                present[0].deadline = -math.inf
            self._session.later.append((self, result, answer))

    def answer(self, response: Message, answer: Callable[[bool, bytes], None]) -> None:
        """Send a response."""
        try:
            answer(True, self._server.codecs[1].pack(response))
        except GazeboError as error:
            self.refuse(error, answer)

    def refuse(self, why: Exception, answer: Callable[[bool, bytes], None]) -> None:
        """Answer that a request is not granted."""
        self._session.log_refusal(self.name, why, "service")
        answer(False, str(why).encode())


class Session(Closing):
    """ROS of one server, from `with` to its end.

    Args:
        names: of its node.
        node: of ROS 1, or of ROS 2 by a bridge.

    Attributes:
        version: 1 or 2.
        gathered: whether native code has published something that was not sent yet.
        allowance: what there is for that which nodes have sent.
        tally: of what nodes cause in the log.
        interrupts: called, in the wire's thread, when something has come that waits for the end of a step.
    """

    gathered = Number()

    def __init__(self, names: NodeNames, node: Node | BridgedNode) -> None:
        self.names, self.node = names, node
        self.version = 2 if isinstance(node, BridgedNode) else 1
        self.allowance = Allowance()
        self.interrupts: list[Callable[[], object]] = []
        node.notify = self.interrupt
        self.waiting: deque[Subscription] = deque()
        self.requests: deque[tuple[Service, bytes, Callable[[bool, bytes], None]]] = deque()
        self.later: list[tuple[Service, Later, Callable[[bool, bytes], None]]] = []
        self.watchers: WeakKeyDictionary[Publisher | Channel, WeakSet[Publication]] = WeakKeyDictionary()
        self._transforms: dict[str, Publication] = {}  # by their topics
        self._events: Publication | None = None
        one = message_type("geometry_msgs/TransformStamped", self.version)()
        self._transform: Any = message_type("tf2_msgs/TFMessage", self.version)(transforms=[one])
        self.tally = Tally(MOST_LINES)
        self.node.start()
        _sessions.append(self)

    def close(self) -> None:
        """Unregister all that is left, and close the wires."""
        if self in _sessions:
            _sessions.remove(self)
            self._transforms, self._events = {}, None
            self.node.close()

    # Names -------------------------------------------------------------------------------------------------------

    def resolve(self, name: str, space: str = "") -> str:
        """The full name of a topic or service in a namespace."""
        return self.names.resolve(name, space)

    def parameter(self, name: str, default: Any = None) -> Any:
        """A parameter of the parameter server: absolute, relative, or private with ``~``."""
        value = self.node.parameter(self.names.resolve(name))
        return default if value is None else value

    def set_parameter(self, name: str, value: Any) -> None:
        """Set a parameter of ROS 1's parameter server, soon."""
        if isinstance(self.node, Node):
            self.node.set_parameter(self.names.resolve(name), value)

    def search_parameter(self, name: str, space: str = "") -> Any:
        """A parameter in a namespace, or in the nearest one around it that has it; None if none has."""
        return self.node.search_parameter(name, self.resolve("x", space).rpartition("/")[0])

    def log_refusal(self, name: str, why: object, what: str = "topic") -> None:
        """Log that a message of a topic, or a request of a service, is refused; of many, at growing counts only."""
        unforeseen = isinstance(why, Exception) and not isinstance(why, GazeboError)
        with repeated(self.tally):
            log.error("%s %s: %s", what, name, why, exc_info=why if unforeseen else None)  # type: ignore[arg-type]

    def frame(self, name: str, space: str = "") -> str:
        """A frame of TF with the prefix that the parameter tf_prefix gives for a namespace."""
        prefix = self.search_parameter("tf_prefix", space)
        return frame_with_prefix(str(prefix or ""), name)

    # Topics and services -----------------------------------------------------------------------------------------

    def publish(
        self,
        topic: str,
        kind: str,
        queue: int = 1,
        latch: bool = False,
        space: str = "",
        changed: Callable[[], object] | None = None,
        node: OwnNode | None = None,
        **more: Any,
    ) -> Publication:
        """Publish a topic.

        Args:
            topic: its name, resolved in the namespace `space`.
            kind: the name of its type.
            queue: messages that wait for a slow subscriber.
            latch: keep the last message for subscribers that come.
            space: a namespace.
            changed: called between steps when subscribers have come or gone.
            node: of ROS 2, whose topic it is; None: that of the server.
            more: policies of ROS 2, as `BridgedNode.advertise` takes them.
        """
        found, more = self._of(node, topic, space, more)
        return Publication(self, found, message_type(kind, self.version), queue, latch, changed, **more)

    def subscribe(
        self,
        topic: str,
        kind: str,
        callback: Callable[[Any], object],
        queue: int = 1,
        space: str = "",
        node: OwnNode | None = None,
        **more: Any,
    ) -> Subscription:
        """Subscribe to a topic; `callback` gets the messages between steps."""
        found, more = self._of(node, topic, space, more)
        return Subscription(self, found, message_type(kind, self.version), callback, queue, **more)

    def serve(
        self,
        name: str,
        kind: str,
        handler: Callable[[Any], Message | Later],
        space: str = "",
        node: OwnNode | None = None,
    ) -> Service:
        """Serve a service; `handler` gets the requests between steps, and returns responses."""
        found, more = self._of(node, name, space, {})
        more.pop("plain", None)
        return Service(self, found, service_type(kind, self.version), handler, **more)

    def served(self, name: str, node: OwnNode | None = None) -> bool:
        """Whether a service is served already."""
        wire: Any = self.node
        return bool(wire.served(self._of(node, name, "", {})[0]))

    def _of(self, node: OwnNode | None, name: str, space: str, more: dict[str, Any]) -> tuple[str, dict[str, Any]]:
        """(full name of a topic or service, what else the wire gets)."""
        if node is None:
            return self.resolve(name, space), more
        return node.resolve(name, space), {**more, "settings": node.settings, "plain": node.full(name, space)}

    @property
    def parameter_events(self) -> Publication:
        """The topic /parameter_events of ROS 2."""
        if self._events is None:
            with unowned():
                self._events = self.publish("/parameter_events", "rcl_interfaces/ParameterEvent", 1000)
        return self._events

    def transforms(self, node: OwnNode | None = None) -> Publication:
        """The topic /tf, or what a node of ROS 2 has in its place."""
        topic = self._of(node, "/tf", "", {})[0]
        if topic not in self._transforms:
            with unowned():
                self._transforms[topic] = self.publish(topic, "tf2_msgs/TFMessage", 100)
        return self._transforms[topic]

    def send_transform(
        self,
        now: Stamp,
        parent: str,
        child: str,
        place: Iterable[float],
        turn: Iterable[float],
        node: OwnNode | None = None,
    ) -> None:
        """Publish one transform on /tf.

        Args:
            now: its time.
            parent, child: names of the frames.
            place: the child's origin in the parent [m].
            turn: the child's rotation, x, y, z, w.
            node: of ROS 2, which publishes it.
        """
        transforms = self.transforms(node)
        if not transforms.listened:
            return
        (one,) = self._transform.transforms
        one.header.stamp, one.header.frame_id, one.child_frame_id = now, parent, child
        part, rotation = one.transform.translation, one.transform.rotation
        part.x, part.y, part.z = place
        rotation.x, rotation.y, rotation.z, rotation.w = turn
        transforms.publish(self._transform)

    def pack_transform(
        self,
        parent: str,
        child: str,
        changed: Callable[[], object] | None = None,
        node: OwnNode | None = None,
    ) -> PackedMessage:
        """A message with one transform, for the topic /tf.

        Args:
            parent, child: names of the frames.
            changed: called between steps when subscribers have come or gone.
            node: of ROS 2, which publishes it.
        """
        one = message_type("geometry_msgs/TransformStamped", self.version)(child_frame_id=child)
        one.header.frame_id, one.transform.rotation.w = parent, 1.0
        publication = self.publish("/tf", "tf2_msgs/TFMessage", 100, changed=changed, node=node)
        return PackedMessage(publication, publication.kind(transforms=[one]))

    # Between steps -----------------------------------------------------------------------------------------------

    def flush(self) -> None:
        """Send what native code has published; in the thread of the world."""
        if self.gathered and isinstance(self.node, Node):
            self.gathered = 0.0
            self.node.flush()

    def interrupt(self) -> None:
        """Something has come: let the steps that are made without this session end soon."""
        for interrupt in tuple(self.interrupts):
            interrupt()

    @property
    def pending(self) -> bool:
        """Whether something waits for the end of a step."""
        return bool(self.node.changed or self.waiting or self.requests or self.later)

    def deliver(self, deferred: Sized = ()) -> None:
        """Deliver what came, as far as may be, the rest after the next step; in the thread of the world.

        Args:
            deferred: the changes of the world that wait for the end of the step.
        """
        for _ in range(len(self.node.changed)):
            for publication in list(self.watchers.get(self.node.changed.popitem()[0], ())):
                publication.changed()
        before = len(deferred)
        self.allowance.begin()
        self.allowance.charge(self.node.take_spent())
        messages, requests = (
            repeat(self._deliver_next, len(self.waiting)),
            repeat(self._handle_next, len(self.requests)),
        )
        with repeated(self.tally):
            for turn in chain(messages, requests):
                if not self.allowance.left:
                    break
                turn()
                self.allowance.changes = max(0, len(deferred) - before)
                self.allowance.spend()
            if self.later:
                self._answer_later()

    def _deliver_next(self) -> None:
        self.waiting.popleft().deliver()

    def _handle_next(self) -> None:
        service, body, answer = self.requests.popleft()
        service.handle(body, answer)

    def _answer_later(self) -> None:
        now = time.monotonic()
        waiting, self.later = self.later, []
        for service, later, answer in waiting:
            try:
                response = later.poll()
            except GazeboError as error:
                service.refuse(error, answer)
                continue
            if response is None and now > later.deadline:
                response = later.overdue
            if response is None:
                self.later.append((service, later, answer))
            else:
                service.answer(response, answer)


class NodeSession:
    """A session whose topics and services are those of one node of ROS 2.

    Args:
        session: the session.
        node: the node.
    """

    def __init__(self, session: Session, node: OwnNode) -> None:
        self.version, self.log_refusal = session.version, session.log_refusal
        self.publish: Callable[..., Publication] = partial(session.publish, node=node)
        self.subscribe: Callable[..., Subscription] = partial(session.subscribe, node=node)
        self.serve: Callable[..., Service] = partial(session.serve, node=node)
        self.send_transform: Callable[..., None] = partial(session.send_transform, node=node)


def set_stamp(stamp: Stamp, seconds: float) -> None:
    """Set a time [s], to the nanosecond, or the nearest one that stamps can hold."""
    total = round(min(max(seconds, 0.0), LATEST) * 1e9)
    stamp.secs, stamp.nsecs = divmod(total, 1_000_000_000)


def finite(message: Any) -> bool:
    """Whether all numbers of a message are finite."""
    for field in message.kind.fields:
        value = getattr(message, field.name)
        if field.kind in ("float32", "float64"):
            if not (math.isfinite(value) if field.size is None else bool(np.isfinite(value).all())):
                return False
        elif field.kind in NUMBERS:
            continue
        elif isinstance(value, Message):
            if not finite(value):
                return False
        elif isinstance(value, list) and not all(finite(one) for one in value if isinstance(one, Message)):
            return False
    return True
