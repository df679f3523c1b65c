"""What other processes can make a server hold, each and together."""

import contextlib
import socket
import time
from selectors import SelectorKey
from types import SimpleNamespace

import pytest

import libgz
from libgz.base import backlog
from libgz.base.backlog import Backlog
from libgz.base.errors import ParameterError
from libgz.classic.msgs.declare import message_type
from libgz.classic.transport import loop, master as master_module, received
from libgz.classic.transport.elements import check_elements
from libgz.classic.transport.framing import Frames, frame, packet
from libgz.classic.transport.loop import Connection, SocketLoop
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.master import Master, _Client
from libgz.classic.transport.node import Node
from libgz.classic.transport.received import Received
from libgz.classic.transport.topic import Incoming, Topic, sequence
from libgz.transport import allowance

MIB = 1 << 20
BOX = """<model name='box'><link name='link'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry>
</collision></link></model>"""


class Pair:
    """A connection of a loop, and its other end, which reads nothing."""

    def __init__(self, socket_loop, largest=MIB):
        own, self.other = socket.socketpair()
        for one in (own, self.other):
            one.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        self.connection = Connection(socket_loop, own, largest)
        socket_loop.call(self.connection.start)


@pytest.fixture
def socket_loop():
    made = SocketLoop()
    yield made
    made.close(0.0)


@pytest.fixture
def pairs(socket_loop):
    made = []

    def make(count, largest=MIB):
        made.extend(Pair(socket_loop, largest) for _ in range(count))
        return made

    yield make
    for pair in made:
        pair.other.close()


def until(condition):
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.002)


def test_slow_receivers_lose_their_oldest_messages_and_hold_no_more_than_the_bound_of_all(
    monkeypatch, socket_loop, pairs
):
    limit = 1 * MIB
    monkeypatch.setattr(socket_loop, "backlog", Backlog(limit))
    slow = pairs(20)
    for number in range(40):
        for pair in slow:
            pair.connection.send(frame(b"%08d" % number + bytes(10_000)))
        assert socket_loop.backlog.size <= limit
    assert sum(pair.connection.size for pair in slow) > limit // 2
    assert all(pair.connection.open for pair in slow)
    newest = [pair.connection._queue[-1] for pair in slow if pair.connection._queue]
    assert len(newest) == len(slow)
    assert {one[8:16] for one in newest} == {b"%08d" % 39}


def test_a_frame_for_many_is_counted_once(socket_loop, pairs):
    data = frame(bytes(100_000))
    for pair in pairs(10):
        pair.connection.send(data)
    assert socket_loop.backlog.size <= len(data)
    for pair in pairs(0):
        socket_loop.call(pair.connection.close)
    until(lambda: socket_loop.backlog.size == 0)


def test_where_nothing_may_be_lost_the_connection_ends(monkeypatch, socket_loop, pairs):
    monkeypatch.setattr(loop, "QUEUE_COUNT", 20)
    (pair,) = pairs(1)
    pair.connection.lossless = True
    for _ in range(40):
        pair.connection.send(frame(bytes(10_000)))
    until(lambda: not pair.connection.open)
    assert socket_loop.backlog.size == 0


def test_frames_stay_whole_while_the_oldest_are_dropped(monkeypatch, socket_loop, pairs):
    monkeypatch.setattr(loop, "QUEUE_COUNT", 5)
    (pair,) = pairs(1)
    for number in range(3000):
        pair.connection.send(frame(b"%06d" % number * 50))
    pair.other.settimeout(20.0)
    data = b""
    while not data.endswith(b"002999" * 50):
        data += pair.other.recv(1 << 16)
    while data:
        assert data[:8] == b"0000012c"
        content, data = data[8:308], data[308:]
        assert content == content[:6] * 50


def test_incomplete_messages_are_bounded_together(monkeypatch, socket_loop, pairs):
    monkeypatch.setattr(loop, "PARTIAL_BYTES", 300_000)
    made = pairs(5)
    for pair in made:
        pair.connection.valid = True
        pair.other.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 18)
        pair.other.setblocking(False)
    ends = list(made)
    head = b"%08x" % 500_000
    for pair in ends:
        pair.other.send(head)
    for _ in range(30):
        for pair in ends:
            try:
                pair.other.send(bytes(8000))
            except OSError:
                continue
        time.sleep(0.002)
        assert sum(pair.connection.partial for pair in ends) <= 300_000 + (1 << 16)
    until(lambda: not all(pair.connection.open for pair in ends))
    assert any(pair.connection.open for pair in ends)


def test_received_messages_are_bounded_in_number_and_size(caplog):
    topic, other, waiting = Topic("/a"), Topic("/b"), Received(limit=10_000)
    asked = [waiting.add(topic, Incoming(n, "t", b"", None)) for n in range(received.COUNT + 5)]
    assert sum(asked) == len(topic.incoming) == received.COUNT
    assert waiting.take(topic).number == 5
    waiting.clear(topic)
    for number in range(30):
        waiting.add(topic, Incoming(number, "t", bytes(1000), None))
        assert waiting.size <= 10_000
    assert waiting.add(other, Incoming(0, "t", bytes(2000), None))
    assert [one.number for one in topic.incoming] == list(range(22, 30))
    while waiting.take(topic) or waiting.take(other):
        pass
    assert waiting.size == 0
    assert waiting.add(topic, Incoming(0, "t", bytes(20_000), None))  # it is handled alone
    assert "the oldest are dropped" in caplog.text


LISTS_OF = b"\x0a\x03box"  # a Model with a name; then its other fields, and whether they are too many
LISTS = {
    "empty messages in a list": (b"\x42\x00" * 100_001, True),
    "as many as are allowed": (b"\x42\x00" * 100_000, False),
    "messages with overlong lengths": (b"\x42\x80\x80\x00" * 100_001, True),
    "numbers, one after the other": (b"\x10\x01" * 1_000_001, True),
    "a long text": (b"\x0a\x80\x80\x80\x01" + b"x" * (1 << 21), False),
    "a length beyond the end": (b"\x42\xff\xff\xff\x7f" + b"x" * 300_000, False),
    "half a tag": (b"\x42\x00" * 100_000 + b"\xff", False),
}


@pytest.mark.parametrize("name", LISTS)
def test_lists_of_received_messages_are_bounded_before_they_are_decoded(name):
    data, refused = LISTS[name]
    kind = message_type("Model").DESCRIPTOR
    with pytest.raises(ParameterError, match="more than 100000") if refused else contextlib.nullcontext():
        check_elements(kind, LISTS_OF + data)


def test_elements_of_messages_in_messages_are_counted_together():
    kind = message_type("Model").DESCRIPTOR
    inner = next(field.number for field in kind.fields if field.name == "model")
    parts = b"\x42\x00" * 60_000
    one = bytes([inner << 3 | 2, len(parts) & 127 | 128, len(parts) >> 7 & 127 | 128, len(parts) >> 14]) + parts
    check_elements(kind, one)
    with pytest.raises(ParameterError, match="more than 100000"):
        check_elements(kind, one * 2)


def test_texts_are_counted_and_readings_are_not_looked_through():
    with pytest.raises(ParameterError, match="more than 100000"):
        check_elements(message_type("GzString_V").DESCRIPTOR, b"\x0a\x00" * 100_001)
    check_elements(message_type("LaserScanStamped").DESCRIPTOR, b"\x10\x01" * 1_000_001)


def test_a_message_with_too_many_elements_is_dropped(caplog):
    manager, got = TopicManager.Instance(), []
    node = Node()
    node.Init("bounds")
    kept = node.Subscribe("~/many", got.append)
    topic = manager.topics["/gazebo/bounds/many"]
    for count in (100_001, 100_000):
        incoming = Incoming(next(sequence), "gazebo.msgs.GzString_V", b"\x0a\x00" * count, None)
        manager.receive(topic, incoming)
    until(lambda: manager.ProcessNodes() or not manager.waits)
    assert [len(message.data) for message in got] == [100_000]
    assert "a received message was dropped: it has more than 100000" in caplog.text
    kept.Unsubscribe()
    node.Fini()
    manager.clear("/gazebo/bounds/")


def test_messages_in_messages_count_though_no_list_has_them():
    kind = message_type("Model").DESCRIPTOR
    (link,) = (field.number for field in kind.fields if field.name == "link")
    made = message_type("Model")(name="box")
    made.link.add(name="l").pose.position.x = 1.0
    data = made.SerializeToString()[len(LISTS_OF) :]
    assert data[0] == link << 3 | 2
    check_elements(kind, LISTS_OF + data * 25_000)  # each a link, a pose, its position and its orientation
    with pytest.raises(ParameterError, match="more than 100000"):
        check_elements(kind, LISTS_OF + data * 25_001)


def test_messages_to_handlers_of_a_world_have_fewer_elements(caplog):
    with libgz.World.from_string(f"<sdf version='1.6'><world name='default'>{BOX}</world></sdf>") as world:
        world.attach_era()
        manager = TopicManager.Instance()
        for name in ("model/modify", "box/link/wrench"):
            topic = manager.topics[f"/gazebo/{world.topic_space}/{name}"]
            manager.receive(topic, Incoming(next(sequence), "gazebo.msgs.Model", LISTS_OF + b"\x42\x00" * 10_001, None))
        until(lambda: manager.ProcessNodes() or not manager.waits)
    assert caplog.text.count("a received message was dropped: it has more than 10000 ") == 2


@pytest.fixture
def delivered():
    """A topic, a publisher of it, and what its subscriber gets."""
    manager, node, got = TopicManager.Instance(), Node(), []
    node.Init("bounds")
    publisher = node.Advertise(message_type("GzString"), "~/few")
    kept = node.Subscribe("~/few", lambda message: got.append(message.data))
    yield manager.topics["/gazebo/bounds/few"], publisher, got
    kept.Unsubscribe()
    node.Fini()
    manager.clear("/gazebo/bounds/")


def receive(topic, *texts):
    for text in texts:
        data = message_type("GzString")(data=text).SerializeToString()
        TopicManager.Instance().receive(topic, Incoming(next(sequence), "gazebo.msgs.GzString", data, None))


def test_messages_of_other_processes_wait_when_they_have_had_their_time_and_those_of_this_one_do_not(
    delivered, monkeypatch
):
    (topic, publisher, got), manager, now = delivered, TopicManager.Instance(), [0.0]
    monkeypatch.setattr(allowance, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(manager, "allowance", allowance.Allowance())
    slow = Node()
    slow.Init("bounds")
    kept = slow.Subscribe("~/few", lambda message: now.__setitem__(0, now[0] + 0.04 * (message.data != "own")))
    receive(topic, "1", "2", "3", "4", "5")
    manager.ProcessNodes()
    assert got == ["1", "2", "3"]  # 0.1 s are allowed at once
    publisher.Publish(message_type("GzString")(data="own"))
    manager.ProcessNodes()
    assert got == ["1", "2", "3", "own"]
    for text in "45":
        now[0] += 0.05
        assert manager.waits
        manager.ProcessNodes()
        assert got[-1] == text
    assert not manager.waits
    kept.Unsubscribe()
    slow.Fini()


def test_what_takes_long_is_counted_up_to_a_bound(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(allowance, "time", SimpleNamespace(monotonic=lambda: now[0]))
    one = allowance.Allowance()
    now[0] = 100.0
    one.spend()
    assert not one.left
    now[0] += allowance.DEBT + 0.01
    one.begin()
    assert one.left


def test_few_changes_of_a_world_are_made_for_messages_in_a_step(monkeypatch):
    with libgz.World.from_string(f"<sdf version='1.6'><world name='default'>{BOX}</world></sdf>") as world:
        world.attach_era()
        manager, resets = TopicManager.Instance(), []
        monkeypatch.setattr(allowance, "time", SimpleNamespace(monotonic=lambda: 0.0))  # only changes are counted
        monkeypatch.setattr(manager, "allowance", allowance.Allowance())
        monkeypatch.setattr(world.era, "reset", lambda _world: resets.append(1))
        data = message_type("WorldControl")(reset=message_type("WorldReset")(all=True)).SerializeToString()
        for _ in range(40):
            topic = manager.topics[f"/gazebo/{world.topic_space}/world_control"]
            manager.receive(topic, Incoming(next(sequence), "gazebo.msgs.WorldControl", data, None))
        done = []
        for _ in range(4):
            world.step(1)
            done.append(len(resets))
    assert done == [16, 32, 40, 40]


def test_the_time_of_deferred_changes_counts(monkeypatch):
    with libgz.World.from_string(f"<sdf version='1.6'><world name='default'>{BOX}</world></sdf>") as world:
        world.attach_era()
        manager, calls = TopicManager.Instance(), []
        monkeypatch.setattr(manager.allowance, "spend", lambda: calls.append("spend"))
        monkeypatch.setattr(world.era, "reset", lambda _world: calls.append("reset"))
        data = message_type("WorldControl")(reset=message_type("WorldReset")(all=True)).SerializeToString()
        topic = manager.topics[f"/gazebo/{world.topic_space}/world_control"]
        manager.receive(topic, Incoming(next(sequence), "gazebo.msgs.WorldControl", data, None))
        world.step(1)
    assert calls == ["spend", "reset", "spend"]


def test_the_bounds_are_those_of_the_security_page():
    text = (__import__("pathlib").Path(__file__).parents[3] / "SECURITY.md").read_text()
    for size in (loop.QUEUE_BYTES, backlog.BACKLOG_BYTES, loop.PARTIAL_BYTES, received.BYTES):
        assert f"{size // MIB} MiB" in text


def test_what_short_frames_cost_is_counted_after_few_of_them(socket_loop):
    own, other = socket.socketpair()
    with other:
        connection, got = Connection(socket_loop, own, 1 << 16), []
        connection.on_frame = got.append
        other.sendall(frame(b"x" * 8) * 1000)
        connection.on_input(0)
        assert 100 < len(got) < 400
        connection.close()


class Announced:
    """Something that a client announces; it counts how often the master looks at it."""

    looks = 0

    def __init__(self, topic):
        self._topic = topic

    @property
    def topic(self):
        Announced.looks += 1
        return self._topic

    def SerializeToString(self):
        return b""


class Far:
    """A connection of a client that takes all."""

    def __init__(self):
        self.socket = socket.socket()
        self.socket.close()  # it has no peer

    def send(self, data):
        pass


def test_who_leaves_costs_what_it_has_announced_not_what_others_have(socket_loop):
    master = Master(socket_loop, [])
    clients = [_Client(Far()) for _ in range(2)]
    master._clients.extend(clients)
    for number in range(500):
        master._subscribe(clients[0], Announced(f"/others/{number}"))
        master._advertise(clients[1], Announced(f"/own/{number}"))
    Announced.looks = 0
    master._remove(clients[1])
    assert 500 <= Announced.looks <= 5000
    assert master._all_publishers().publisher == []


def test_who_is_found_to_have_left_while_it_announces_leaves_nothing(socket_loop):
    master, (left, other) = Master(socket_loop, []), (_Client(Far()) for _ in range(2))
    left.connection.send = lambda _data: left in master._clients and master._remove(left)
    sent = []
    other.connection.send = sent.append
    master._clients.extend((left, other))
    message = message_type("Publish")(topic="/t", msg_type="gazebo.msgs.Pose", host="127.0.0.1", port=1)
    master._receive(left, packet("advertise", message)[8:])
    sent.clear()
    master._receive(other, packet("subscribe", message_type("Subscribe")(topic="/t", host="h", port=1))[8:])
    assert sent == []


def test_what_clients_announce_is_bounded_each_and_together(socket_loop, monkeypatch):
    monkeypatch.setattr(master_module, "MOST", 3)
    monkeypatch.setattr(master_module, "MOST_OF_ALL", 6)
    master = Master(socket_loop, [])
    master.own = "this process"
    clients = [_Client(Far()) for _ in range(3)]
    master._clients.extend(clients)

    def announce(client, topic="/t"):
        message = message_type("Publish")(topic=topic, msg_type="gazebo.msgs.Pose", host="127.0.0.1", port=1)
        master._receive(client, packet("advertise", message)[8:])

    with pytest.raises(ParameterError, match="1 to 1000 are allowed"):
        announce(clients[0], "x" * 1001)
    with pytest.raises(ParameterError, match="4096 are allowed"):
        announce(clients[0], "x" * 5000)
    for _ in range(4):
        announce(clients[0])
    with pytest.raises(ParameterError, match="it has announced more than 3"):
        announce(clients[0])
    for _ in range(3):
        announce(clients[1])
    with pytest.raises(ParameterError, match="clients have announced more than 6"):
        announce(clients[2])


def test_a_frame_that_is_larger_than_allowed_is_refused_by_its_head():
    frames = Frames(10)
    frames.add(b"%08x" % 10)
    assert frames.take() is None
    frames = Frames(10)
    frames.add(b"%08x" % 11)
    with pytest.raises(ParameterError, match="a message has 11 bytes; 10 are allowed"):
        frames.take()


def test_what_comes_in_is_handled_for_a_while_only_and_the_rest_later(monkeypatch):
    """One short packet may go to hundreds of clients: what hundreds of them cost would be handled at once."""
    monkeypatch.setattr(loop, "BURST", 0.0)
    limited, own, other = SocketLoop(1e-9), *socket.socketpair()  # its thread does not read from it
    with other:
        connection, got = Connection(limited, own, 1 << 16), []
        connection.on_frame = lambda data: got.append((data, sum(range(1000))))
        other.sendall(b"".join(frame(b"%d" % number) for number in range(20)) + frame(b"rest")[:9])
        for count in range(1, 21):
            connection.on_input(0)
            assert len(got) == count
        connection.on_input(0)  # half a frame
        other.sendall(frame(b"rest")[9:])
        connection.on_input(0)
        assert [data for data, _ in got] == [*(b"%d" % number for number in range(20)), b"rest"]
        connection.close()
    limited.close(0.0)


def test_no_more_connections_are_accepted_at_once_than_there_is_time_for(monkeypatch):
    monkeypatch.setattr(loop, "BURST", 0.0)
    monkeypatch.setattr(loop.SocketLoop, "_run", lambda _: None)  # this thread is that of the loop
    limited, accepted = SocketLoop(0.02), []
    with socket.create_server(("127.0.0.1", 0)) as listener:
        limited.listen(listener, accepted.append, 1 << 16)
        limited._calls.popleft()()
        made = [socket.create_connection(listener.getsockname()) for _ in range(3)]
        limited._handle_inputs(0)
        assert len(accepted) == 1
        for one in (*made, accepted[0].socket):
            one.close()
    limited.close(0.0)


def test_what_fails_for_one_frame_costs_none_behind_it(socket_loop):
    own, other = socket.socketpair()
    with other:
        connection, got = Connection(socket_loop, own, 1 << 16), []

        def fail(data):
            got.append(data)
            if data == b"bad":
                raise OSError("no descriptors are left")

        connection.on_frame = fail
        other.sendall(frame(b"bad") + frame(b"good"))
        with pytest.raises(OSError, match="no descriptors"):
            connection.on_input(0)
        other.sendall(frame(b"next"))
        connection.on_input(0)
        assert got == [b"bad", b"good", b"next"]
        connection.close()


def test_who_leaves_is_announced_to_each_client_at_once(socket_loop):
    """Packet by packet, what one has announced to hundreds would keep all of them waiting."""
    master = Master(socket_loop, [])
    clients, sent = [_Client(Far()) for _ in range(3)], []
    clients[0].connection.send = lambda data: sent.append(data)
    master._clients.extend(clients)
    master._subscribe(clients[0], message_type("Subscribe")(topic="/t", host="h", port=1))
    for client in clients[1:]:
        for port in range(100):
            master._advertise(client, message_type("Publish")(topic="/t", msg_type="x", host="h", port=port))
    sent.clear()
    master._remove(clients[1])
    assert [data.count(kind) for data, kind in zip(sent, (b"publisher_del", b"unadvertise"), strict=True)] == [100, 100]
    assert len(master._all_publishers().publisher) == len(master._published.of("/t")) == 100


def test_who_sends_without_an_end_keeps_nobody_waiting(socket_loop, monkeypatch):
    handled = []

    def flood(_mask):
        handled.append("flood")
        sum(range(10_000))

    def ready(_timeout):  # all the time, in the same order
        keys = [SelectorKey(number, number, 1, flood) for number in (1001, 1002, 1003)]
        return [(key, 1) for key in (*keys, SelectorKey(1004, 1004, 1, lambda _: handled.append("quiet")))]

    monkeypatch.setattr(loop, "EVENTS", 2)
    monkeypatch.setattr(socket_loop, "_inputs", SimpleNamespace(select=ready))
    for _ in range(4):
        socket_loop._handle_inputs(0)
    assert handled.count("quiet") >= 2


def test_who_connects_again_and_again_keeps_nobody_waiting(socket_loop, monkeypatch):
    """Of each new connection one frame is handled, then what others have sent, then the rest."""
    handled, keys = [], [SelectorKey(1001, 1001, 1, lambda _: handled.append("quiet"))]

    def register(own, events, data):
        keys.insert(0, SelectorKey(own, own.fileno(), events, data))

    def accept(connection):
        connection.on_frame = lambda _: handled.append("new")

    inputs = SimpleNamespace(select=lambda _: [(key, 1) for key in keys], register=register)
    monkeypatch.setattr(socket_loop, "_inputs", inputs)
    socket_loop._costs[1001] = 1.0
    own, other = socket.socketpair()
    with other:
        other.sendall(2 * frame(b"x"))
        socket_loop._greet(own, accept, 1 << 16)
        assert handled == []
        socket_loop._costs[1001] = 0.5
        socket_loop._handle_inputs(0)
        assert handled == ["new", "quiet"]
        socket_loop._handle_inputs(0)
    assert handled == ["new", "quiet", "quiet", "new"]


def test_what_came_on_a_new_connection_is_handled_before_what_was_sent_after_it(monkeypatch):
    """A client that subscribes to answers, and then asks on a connection that it has, must be sent the answer."""
    monkeypatch.setattr(loop.SocketLoop, "_run", lambda _: None)  # this thread is that of the loop
    served, handled = SocketLoop(0.02), []

    def accept(connection):
        connection.on_frame = handled.append

    with socket.create_server(("127.0.0.1", 0)) as listener:
        served.listen(listener, accept, 1 << 16)
        served._calls.popleft()()
        with socket.create_connection(listener.getsockname()) as asking:
            asking.sendall(frame(b"begin"))
            served._handle_inputs(0)
            with socket.create_connection(listener.getsockname()) as answers:
                answers.sendall(frame(b"subscribe"))
                asking.sendall(frame(b"ask"))
                served._handle_inputs(0)
    assert handled == [b"begin", b"subscribe", b"ask"]
    served.close(0.0)
