"""The wire of ROS 1: topics, services, a master that comes late, ends and returns; hostile peers."""

import contextlib
import http.client
import itertools
import logging
import socket
import struct
import threading
import time
import xmlrpc.client
from operator import attrgetter
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from descriptors import none_left
from ros_peers import (
    PATIENCE,
    Master,
    Service,
    Talker,
    ask,
    encode,
    open_topic,
    read_block,
    read_exactly,
    wait_for,
    within,
)

from libgz.base.errors import GazeboError
from libgz.ros import loop as loop_module, node as node_module, xmlrpc as xmlrpc_module
from libgz.ros.client import RosClient
from libgz.ros.names import read_names
from libgz.ros.node import Publisher
from libgz.ros.packing import codec
from libgz.ros.server import Ros1
from libgz.ros.types import message_type, service_type
from libgz.transport import allowance
from libgz.transport.peers import PeerCheck

EMPTY = "<sdf version='1.6'><world name='default'/></sdf>"
STRING = message_type("std_msgs/String")


@pytest.fixture
def node(master):
    with Ros1(["__name:=sim", "a:=/b", "_rate:=5"]) as found:
        wait_for(lambda: found.node.registered)
        yield found


def test_topics_are_published_with_their_definitions_and_kept_for_those_that_come(node, master):
    topic = node.publish("a", STRING.name, 10, latch=True)
    assert topic.topic == "/b"
    topic.publish(STRING(data="first"))
    wait_for(lambda: "/b" in master.publishers)
    sock, header = open_topic(master, "/b", md5sum=STRING.md5, type=STRING.name)
    wanted = {"callerid": "/sim", "latching": "1", "md5sum": STRING.md5, "topic": "/b", "type": "std_msgs/String"}
    assert header == {**wanted, "message_definition": "string data\n"}
    assert codec(STRING).unpack(read_block(sock)).data == "first"
    topic.publish(STRING(data="second"))
    node.deliver()
    assert codec(STRING).unpack(read_block(sock)).data == "second"
    assert master.parameters == {"/use_sim_time": True, "/sim/rate": 5}
    ((_, uri),) = master.publishers["/b"].values()
    assert ask(uri, "getPublications", "/tester") == [1, "", [["/b", "std_msgs/String"]]]
    assert ask(uri, "getBusInfo", "/tester")[2][0][2:] == ["o", "TCPROS", "/b", True]
    assert ask(uri, "requestTopic", "/tester", "/none", [["TCPROS"]])[0] == 0
    del topic
    wait_for(lambda: not master.publishers["/b"])
    with pytest.raises(EOFError):
        read_block(sock)


def test_other_users_of_this_machine_are_refused_at_both_ports(node, master, monkeypatch, caplog):
    topic = node.publish("talk", STRING.name)
    wait_for(lambda: "/talk" in master.publishers)
    ((_, uri),) = master.publishers["/talk"].values()
    _, _, (_, host, port) = ask(uri, "requestTopic", "/tester", "/talk", [["TCPROS"]])
    monkeypatch.setattr(PeerCheck, "_owner", lambda *_: 77)
    with pytest.raises((OSError, http.client.HTTPException)):
        ask(uri, "getPid", "/tester")
    with socket.create_connection((host, port)) as other:
        other.settimeout(10.0)
        with contextlib.suppress(OSError):
            other.sendall(encode({"callerid": "/x", "topic": "/talk", "md5sum": "*", "type": "*"}))
            assert other.recv(1) == b""
    for what in ("a request of 127.0.0.1", "a connection"):
        wait_for(lambda what=what: f"ROS: {what} was refused: it is of user 77, not of user" in caplog.text)
    assert not topic.listened


def test_a_wrong_type_is_refused_with_both_sums(node, master, caplog):
    topic = node.publish("talk", STRING.name)
    wait_for(lambda: "/talk" in master.publishers)
    _, header = open_topic(master, "/talk", md5sum="0" * 32, type="std_msgs/Int32")
    assert header["error"] == f"topic /talk has type std_msgs/String [{STRING.md5}], not std_msgs/Int32 [{'0' * 32}]"
    assert "is refused" in caplog.text
    assert not topic.listened


def test_messages_are_delivered_between_steps(node, master):
    got = []
    subscription = node.subscribe("~talk", STRING.name, lambda message: got.append(message.data), 3)
    waiting = subscription._waiting
    wait_for(lambda: "/sim/talk" in master.subscribers)
    talker = Talker(master, "/sim/talk", STRING.name, STRING.md5)
    assert talker.asked["md5sum"] == STRING.md5
    for index in range(5):
        talker.send(codec(STRING).pack(STRING(data=str(index))))
    wait_for(lambda: [message.data for message in waiting] == ["2", "3", "4"])
    assert got == []
    node.deliver()
    assert got == ["2", "3", "4"]
    talker.close()
    del subscription


def test_what_waits_for_a_long_step_is_bounded(node, master):
    heard = []
    subscription = node.subscribe("talk", STRING.name, heard.append, 3)
    for i in range(100):
        subscription._received(codec(STRING).pack(STRING(data=str(i))))
    assert len(node.waiting) == 1
    node.deliver()
    assert [message.data for message in heard] == ["97", "98", "99"]
    subscription._received(codec(STRING).pack(STRING(data="100")))
    node.deliver()
    assert heard[-1].data == "100"


def test_messages_that_come_faster_than_they_are_handled_do_not_hold_a_step(node, master):
    handled = []

    def slow(message):
        handled.append(message.data)
        assert len(handled) < 100
        subscription._received(codec(STRING).pack(message))

    subscription = node.subscribe("talk", STRING.name, slow)
    subscription._received(codec(STRING).pack(STRING(data="again")))
    node.deliver()
    assert handled == ["again"]


def test_messages_and_requests_wait_when_they_have_had_their_time(node, monkeypatch):
    now, handled, kind = [0.0], [], service_type("std_srvs/SetBool")
    monkeypatch.setattr(allowance, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(node, "allowance", allowance.Allowance())

    def slow(message):
        handled.append(type(message).__name__)
        now[0] += 0.08
        return kind.response()

    subscriptions = [node.subscribe(name, STRING.name, slow) for name in "ab"]
    service = node.serve("switch", kind.name, slow)
    for one in subscriptions:
        one._received(codec(STRING).pack(STRING(data="x")))
    for _ in range(2):
        assert service._received(b"\1", lambda *_: None)
    counts = []
    for _ in range(4):
        node.deliver()
        counts.append(len(handled))
        now[0] += 0.09
    assert counts == [2, 3, 4, 4]  # 0.1 s are allowed at once, and then as much as passes otherwise
    assert not node.pending


class Collector(loop_module.Connection):
    """Collects the first letters of frames."""

    def __init__(self, loop, sock, found):
        super().__init__(loop, sock, "a test")
        self.deadline, self._found = None, found

    def frame(self, body):
        self._found.append(body[:1].decode())


def test_what_comes_in_is_read_in_turn_and_in_its_share_of_the_time(monkeypatch):
    now, used, found = [0.0], itertools.count(), []
    monkeypatch.setattr(allowance, "time", SimpleNamespace(monotonic=lambda: now[0]))
    clock = SimpleNamespace(**vars(time) | {"thread_time": lambda: float(next(used))})  # each look takes a second
    monkeypatch.setattr(loop_module, "time", clock)
    monkeypatch.setattr(loop_module, "READ_SIZE", 1000)
    loop = loop_module.Loop("test")
    with contextlib.ExitStack() as stack:
        pairs = [socket.socketpair() for _ in range(2)]
        for ours, theirs in pairs:
            stack.enter_context(theirs)
            loop.add(Collector(loop, ours, found))
        for letter, (_, theirs) in zip(b"ab", pairs, strict=True):
            theirs.sendall(3 * (struct.pack("<I", 996) + bytes([letter]) * 996))
        stack.callback(loop.close)
        loop.start()
        for number in range(1, 7):
            wait_for(lambda: len(found) >= number, lambda: loop.call(len, ""))  # noqa: B023
            for _ in range(2):  # what else is ready is not read now
                looked = threading.Event()
                loop.call(looked.set)
                assert looked.wait(PATIENCE)
            assert found == list("ababab"[:number])
            now[0] += allowance.DEBT / allowance.SHARE + 1.0


def test_what_reading_took_is_time_of_messages(node, monkeypatch):
    now, handled = [0.0], []
    monkeypatch.setattr(allowance, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(node, "allowance", allowance.Allowance())
    subscription = node.subscribe("a", STRING.name, handled.append)
    subscription._received(codec(STRING).pack(STRING(data="x")))
    node.node.take_spent()
    for share in node.node._loop.share, node.node._slave.share:
        share.spend(0.1)
    node.deliver()
    assert not handled
    now[0] += 0.2
    node.deliver()
    assert len(handled) == 1


def test_few_changes_of_a_world_are_made_for_requests_in_a_step(node):
    kind, deferred = service_type("std_srvs/SetBool"), []
    service = node.serve("switch", kind.name, lambda _: deferred.append(1) or kind.response())
    for _ in range(40):
        assert service._received(b"\1", lambda *_: None)
    done = []
    for _ in range(3):
        node.deliver(deferred)
        done.append(len(deferred))
        deferred.clear()
    assert done == [16, 16, 8]


def test_services_are_answered_between_steps(node, master):
    kind = service_type("std_srvs/SetBool")
    answers = []

    def handle(request):
        answers.append(request.data)
        return kind.response(success=True, message="done")

    service = node.serve("switch", kind.name, handle)
    wait_for(lambda: "/switch" in master.services)
    client = Service(master, "/switch", md5sum=kind.md5)
    assert (client.header["type"], client.header["request_type"]) == (kind.name, "std_srvs/SetBoolRequest")
    for _ in range(2):
        client.send(b"\1")
        wait_for(lambda: node.requests)
        node.deliver()
        good, body = client.answer()
        assert good
        assert codec(kind.response).unpack(body).message == "done"
    assert answers == [True, True]
    client.send(b"\1\1")  # too long
    wait_for(lambda: node.requests)
    node.deliver()
    good, text = client.answer()
    assert not good
    assert b"1 bytes follow" in text
    assert "error" in Service(master, "/switch", md5sum="0" * 32).header
    del service


def test_the_master_may_come_late_end_and_return(monkeypatch, caplog):
    first = Master()
    port = first.port
    first.close()
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{port}")
    with Ros1([]) as ros:
        topic = ros.publish("talk", STRING.name)
        wait_for(lambda: "is waited for" in caplog.text)
        master = Master(port)
        wait_for(lambda: "/talk" in master.publishers)
        sock, _ = open_topic(master, "/talk")
        sockets, master.sockets = master.sockets, []
        wait_for(lambda: topic.listened)
        master.close()
        wait_for(lambda: "is gone; connected" in caplog.text)
        topic.publish(STRING(data="x"))
        ros.deliver()
        assert codec(STRING).unpack(read_block(sock)).data == "x"  # those that know each other need no master
        master = Master(port)
        master.sockets = sockets
        wait_for(lambda: "/talk" in master.publishers)
    assert not master.publishers["/talk"]  # unregistered at the end
    master.close()


HEADER = encode({"callerid": "/x", "topic": "/talk", "type": "*", "md5sum": "*"})
ATTACKS = {
    "giant length": (b"\xff\xff\xff\xff", "announced 4294967295 bytes"),
    "no fields": (struct.pack("<I", 8) + b"\x04\0\0\0abcd", "header is damaged"),
    "field beyond the end": (struct.pack("<I", 8) + b"\xff\0\0\0a=cd", "header is damaged"),
    "many fields": (encode({str(i): "" for i in range(100)}), "header is damaged"),
    "HTTP": (b"GET / HTTP/1.1\r\n\r\n", "announced"),
    "giant request": (encode({"service": "/serve", "md5sum": "*"}) + b"\xff\xff\xff\x7f", "announced 2147483647 bytes"),
}


@pytest.mark.parametrize("name", ATTACKS)
def test_broken_peers_are_closed_with_one_line(node, master, caplog, name):
    data, words = ATTACKS[name]
    kind = service_type("std_srvs/Empty")
    service = node.serve("serve", kind.name, lambda _: kind.response())
    port = int(node.node._listener.port)
    caplog.set_level(logging.WARNING)
    with socket.create_connection(("127.0.0.1", port), 10.0) as sock:
        sock.sendall(data)
        wait_for(lambda: words in caplog.text)
        with contextlib.suppress(EOFError, ConnectionError):
            read_exactly(sock, 1 << 20)
    assert len(caplog.records) == 1
    wait_for(lambda: not node.node._loop.connections)
    del service


def test_a_publisher_of_other_bytes_is_closed(node, master, caplog):
    subscription = node.subscribe("talk", STRING.name, lambda _: None)
    wait_for(lambda: "/talk" in master.subscribers)
    talker = Talker(master, "/talk", STRING.name, STRING.md5)
    talker.send(b"\xff\xff\xff\xff")
    wait_for(lambda: "/talk: the data end after 4 bytes" in caplog.text)
    talker.close()
    del subscription


@pytest.fixture(params=[False, True], ids=["real time", "hurried"])
def paced(node, request):
    """A node beside a world that runs in real time, or faster."""
    node.node.follow_pace(lambda: request.param)
    return node


def test_a_slow_reader_holds_a_bounded_number_of_messages(paced, master, caplog):
    node = paced
    topic = node.publish("talk", STRING.name, 10)
    wait_for(lambda: "/talk" in master.publishers)
    _sock, _ = open_topic(master, "/talk")  # which is never read
    wait_for(lambda: topic.listened)
    (reader,) = topic._publisher.readers
    for _ in range(300):
        topic.publish(STRING(data="x" * 100_000))
        node.deliver()
    assert sum(len(part) for frame in list(reader.connection.queue) for part in frame) < 6_000_000
    wait_for(lambda: reader.dropped > 100)
    assert caplog.text.count("reads /talk too slowly") == 1


def test_messages_of_native_code_that_wait_for_a_slow_reader_are_bounded(node, master):
    node.node.follow_pace(lambda: True)
    topic = node.publish("talk", STRING.name, 1000)
    wait_for(lambda: "/talk" in master.publishers)
    _sock, _ = open_topic(master, "/talk")  # which is never read
    wait_for(lambda: topic.listened)
    publisher = topic._publisher
    (reader,) = publisher.readers
    for _ in range(1000):
        publisher.outbox.used = float(publisher.outbox.memory.size)
        publisher.flush()
    assert sum(len(part) for frame in list(reader.connection.queue) for part in frame) < 6_000_000
    assert reader.dropped > 500


def test_a_subscriber_gets_nothing_that_was_gathered_before_it_came():
    got = []
    reader = SimpleNamespace(skipped=0, push=lambda parts, size, several: got.append(b"".join(parts)))
    publisher = Publisher(SimpleNamespace(note_change=lambda _: None), "/t", message_type("std_msgs/Empty"), 1, False)

    def gather(frames):
        begin = int(publisher.outbox.used)
        publisher.outbox.memory[begin : begin + len(frames)] = list(frames)
        publisher.outbox.used = begin + len(frames)

    gather(b"old")
    publisher.connected(reader)
    publisher.flush()
    assert got == []
    gather(b"new")
    publisher.flush()
    assert got == [b"new"]


def test_messages_of_a_hurried_world_arrive_in_order_and_none_is_lost(node, master):
    node.node.follow_pace(lambda: True)
    topic = node.publish("talk", STRING.name, 1)
    wait_for(lambda: "/talk" in master.publishers)
    sock, _ = open_topic(master, "/talk")
    wait_for(lambda: topic.listened)
    sent = [str(number) for number in range(2000)]
    reading = threading.Thread(target=lambda: found.extend(codec(STRING).unpack(read_block(sock)).data for _ in sent))
    found = []
    reading.start()
    for text in sent:
        topic.publish(STRING(data=text))  # the last ones are sent though nothing follows
    wait_for(lambda: not reading.is_alive())
    assert found == sent
    (reader,) = topic._publisher.readers
    assert not reader.dropped


def test_messages_of_a_hurried_world_arrive_though_their_socket_was_used_or_their_topic_ends(node, master, monkeypatch):
    node.node.follow_pace(lambda: True)
    monkeypatch.setattr(loop_module, "LONGEST_SEND", 0.01)
    topic = node.publish("talk", STRING.name, 10)
    wait_for(lambda: "/talk" in master.publishers)
    sock, _ = open_topic(master, "/talk")
    publisher = topic._publisher
    (reader,) = wait_for(lambda: publisher.readers)
    with reader.connection.using:
        topic.publish(STRING(data="first"))
    assert codec(STRING).unpack(read_block(sock)).data == "first"
    node.node._loop._due = time.monotonic() + 5.0  # something was sent just now
    topic.publish(STRING(data="last"))
    del topic
    assert codec(STRING).unpack(read_block(sock)).data == "last"
    with pytest.raises(EOFError):
        read_block(sock)


def test_a_publisher_that_comes_while_its_topic_is_registered_is_heard(node, master, monkeypatch):
    wire, talkers, original = node.node, [], node_module.call

    def call(uri, method, *values, **more):
        answer = original(uri, method, *values, **more)
        if method == "registerSubscriber" and not talkers:  # the answer, without this one, comes later
            talkers.append(Talker(master, "/s", STRING.name, STRING.md5))
            wait_for(lambda: any(wire._subscribers["/s"].publishers.values()))
        return answer

    monkeypatch.setattr(node_module, "call", call)
    heard = []
    wire.subscribe("/s", STRING, heard.append)
    wire.advertise("/next", STRING)
    wait_for(lambda: master.publishers.get("/next"))  # all before it has been done
    talkers[0].send(codec(STRING).pack(STRING(data="here")))
    wait_for(lambda: heard)
    talkers[0].close()


def test_large_arrays_arrive_as_they_were_when_they_were_published(paced, master):
    node = paced
    kind = message_type("sensor_msgs/Image")
    topic = node.publish("images", kind.name, 10)
    wait_for(lambda: "/images" in master.publishers)
    sock, _ = open_topic(master, "/images")
    wait_for(lambda: topic.listened)
    pixels = np.zeros(3_000_000, np.uint8)
    for shade in range(4):  # more than the socket takes at once: the rest has to be kept
        pixels[:] = shade
        topic.publish(kind(encoding="rgb8", data=pixels))
    pixels[:] = 9
    for shade in range(4):
        found = codec(kind).unpack(read_block(sock)).data
        assert set(found.tolist()) == {shade}


def test_a_message_may_be_filled_again_when_it_is_published(node, master):
    topic, message = node.publish("talk", STRING.name, 10, latch=True), STRING(data="published")
    wait_for(lambda: "/talk" in master.publishers)
    topic.publish(message)
    message.data = "filled again"
    sock, _ = open_topic(master, "/talk")  # which gets what was kept
    assert codec(STRING).unpack(read_block(sock)).data == "published"


def test_a_kept_message_comes_once_where_another_one_is_published_meanwhile(node, master):
    topic = node.publish("talk", STRING.name, 10, latch=True)
    topic.publish(STRING(data="kept"))
    node.node.notify = lambda: topic.publish(STRING(data="meanwhile"))  # as a step may, when a subscriber comes
    wait_for(lambda: "/talk" in master.publishers)
    sock, _ = open_topic(master, "/talk")
    assert [codec(STRING).unpack(read_block(sock)).data for _ in range(2)] == ["kept", "meanwhile"]
    topic.publish(STRING(data="later"))
    assert codec(STRING).unpack(read_block(sock)).data == "later"


def test_a_repeated_refusal_does_not_fill_the_log(node, master, caplog):
    node.publish("talk", STRING.name)
    for _ in range(150):
        with socket.create_connection(("127.0.0.1", int(node.node._listener.port)), 10.0) as sock:
            sock.sendall(encode({"callerid": "/x", "topic": "/none", "type": "*", "md5sum": "*"}))
            assert b"does not publish" in read_block(sock)
    assert caplog.text.count("does not publish '/none'") == 2  # the first one, and the hundredth


def test_what_a_peer_calls_itself_is_one_line_that_commands_no_terminal(node, master, caplog):
    with socket.create_connection(("127.0.0.1", int(node.node._listener.port)), 10.0) as sock:
        sock.sendall(encode({"callerid": "/x\n[Err] made up\x1b[2J", "topic": "/none", "type": "*", "md5sum": "*"}))
        assert b"does not publish" in read_block(sock)
    with pytest.raises(xmlrpc.client.Fault):
        ask(node.node.uri, "none\n[Err] made up")
    lines = [record.getMessage() for record in caplog.records]
    assert any("/x\\n[Err] made up\\x1b[2J" in line for line in lines)
    assert not [line for line in lines if not line.isprintable()]


def test_a_master_whose_list_of_publishers_is_none_is_one_warning(node, master, caplog, monkeypatch):
    master.server.register_function(lambda *_: (1, "", 5), "registerSubscriber")
    subscription = node.subscribe("talk", STRING.name, lambda _: None)
    wait_for(lambda: "a list of publishers is 5" in caplog.text)
    assert not [record for record in caplog.records if record.exc_info]
    del subscription


def test_requests_that_are_none_do_not_fill_the_log(node, master, caplog):
    kind = service_type("std_srvs/SetBool")
    service = node.serve("switch", kind.name, lambda request: {}[request.data])  # which fails
    answers = []
    for body in (b"\1\1", b"\1"):
        for _ in range(150):
            service.handle(body, lambda good, text: answers.append(good))
    assert answers == [False] * 300
    refusals = [record for record in caplog.records if "service /switch" in record.getMessage()]
    assert [record.exc_info is not None for record in refusals] == [
        False,
        False,
        True,
        True,
    ]  # the first, the hundredth


def test_all_of_many_clients_that_ask_at_once_and_keep_their_connections_are_answered(node):
    body = xmlrpc.client.dumps(("/tester",), "getPid").encode()
    head = b"POST /RPC2 HTTP/1.1\r\nHost: x\r\nContent-Type: text/xml\r\nContent-Length: %d\r\n\r\n" % len(body)
    address = ("127.0.0.1", node.node._slave.port)
    with contextlib.ExitStack() as stack:
        kept = [
            stack.enter_context(socket.create_connection(address, 20.0)) for _ in range(2 * xmlrpc_module.MOST_THREADS)
        ]
        for one in kept:
            one.sendall(head + body)
        for one in kept:
            assert b"200 OK" in one.recv(1 << 16)


def test_calls_by_xmlrpc_have_bounds(node, caplog):
    address = ("127.0.0.1", node.node._slave.port)
    for head in ("Content-Length: 99999999999", "Content-Length: x", ""):
        with socket.create_connection(address, 10.0) as sock:
            sock.sendall(f"POST / HTTP/1.1\r\n{head}\r\n\r\n".encode())
            assert b"413" in sock.recv(100)
    bomb = (
        b"<?xml version='1.0'?><!DOCTYPE a [<!ENTITY b 'c'>]><methodCall><methodName>getPid</methodName></methodCall>"
    )
    with socket.create_connection(address, 10.0) as sock:
        sock.sendall(b"POST / HTTP/1.0\r\nContent-Length: %d\r\n\r\n" % len(bomb) + bomb)
        answer = b"".join(iter(lambda: sock.recv(4096), b""))
    assert b"a document type" in answer
    with pytest.raises(xmlrpc.client.Fault, match="no method"):
        ask(node.node.uri, "steal")


@pytest.mark.parametrize("coding", ["utf-8", "utf-16"])
def test_document_types_are_refused_in_all_encodings(coding):
    text = "<!DOCTYPE a [<!ENTITY b 'c'>]><methodResponse><params><param><value>&b;</value></param></params>"
    with pytest.raises(ValueError, match="a document type"):
        xmlrpc_module._loads(f"{text}</methodResponse>".encode(coding), 1 << 20)


WRONG_ANSWERS = (
    "<methodResponse><params></params></methodResponse>",
    "<methodResponse><params><param><data></data></param></params></methodResponse>",
    "<methodResponse><params><param><value><struct><name>a</name></struct></value></param></params></methodResponse>",
    "<?xml version='1.0' encoding='none'?><methodResponse/>",
    "<methodResponse><params><param><value><int>1.5</int></value></param></params></methodResponse>",
    "<methodResponse><params><param><value><base64>a</base64></value></param></params></methodResponse>",
)


@pytest.mark.parametrize("answer", WRONG_ANSWERS)
def test_answers_that_are_none_are_one_error(answer):
    def serve():
        sock, _ = listener.accept()
        with sock:
            sock.recv(1 << 16)
            sock.sendall(f"HTTP/1.0 200 OK\r\nContent-Length: {len(answer)}\r\n\r\n{answer}".encode())

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=serve)
        thread.start()
        with pytest.raises(xmlrpc_module.XmlRpcError, match="getPid of http"):
            xmlrpc_module.call(f"http://127.0.0.1:{listener.getsockname()[1]}/", "getPid")
        thread.join()


@contextlib.contextmanager
def peer_of_xmlrpc(answer):
    """The address of a peer that gets each connection's request and socket in a thread of its own."""

    def serve():
        with contextlib.suppress(OSError):
            while True:
                sock, _ = listener.accept()
                with sock, contextlib.suppress(OSError):
                    answer(sock.recv(1 << 16), sock)
                    sock.shutdown(socket.SHUT_WR)
                    while sock.recv(1 << 16):  # with a request half read, closing would take the answer back
                        pass

    with socket.create_server(("127.0.0.1", 0)) as listener:
        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{listener.getsockname()[1]}/"
        listener.shutdown(socket.SHUT_RDWR)
    thread.join(10.0)


def test_an_answer_that_comes_byte_by_byte_ends_a_call_in_time():
    def drip(_request, sock):
        sock.sendall(b"HTTP/1.0 200 OK\r\nContent-Length: 100000\r\n\r\n")
        while True:
            sock.sendall(b"x")
            time.sleep(0.01)

    with peer_of_xmlrpc(drip) as uri, pytest.raises(xmlrpc_module.XmlRpcError, match="getPid of http"):
        xmlrpc_module.call(uri, "getPid", patience=0.2)


def test_of_an_answer_without_an_end_no_more_is_read_than_may_be(monkeypatch):
    monkeypatch.setattr(xmlrpc_module, "MOST_ANSWER", 1000)

    def pour(_request, sock):
        sock.sendall(b"HTTP/1.0 200 OK\r\n\r\n")
        while True:
            sock.sendall(b"x" * 1000)

    with peer_of_xmlrpc(pour) as uri, pytest.raises(xmlrpc_module.XmlRpcError, match="more than 1000 bytes"):
        xmlrpc_module.call(uri, "getPid")


def test_peers_that_announce_too_much_or_say_nothing_or_are_too_many_are_closed(node, master, monkeypatch, caplog):
    service = node.serve("serve", "std_srvs/SetBool", lambda _: None)
    wait_for(lambda: "/serve" in master.services)
    host, port = master.services["/serve"].removeprefix("rosrpc://").split(":")
    place = host, int(port)
    monkeypatch.setattr(loop_module, "GREETING_TIME", 0.1)
    monkeypatch.setattr(loop_module, "PERIOD", 0.02)
    with socket.create_connection(place, 20.0) as silent:
        assert silent.recv(1) == b""
    assert "it said nothing" in caplog.text
    monkeypatch.setattr(loop_module, "GREETING_TIME", 60.0)
    with socket.create_connection(place, 20.0) as long:
        long.sendall(struct.pack("<I", (1 << 16) + 1))
        assert long.recv(1) == b""
    assert f"it announced {(1 << 16) + 1} bytes" in caplog.text
    monkeypatch.setattr(loop_module, "MOST_CONNECTIONS", len(node.node._loop.connections))
    with socket.create_connection(place, 20.0) as further:
        assert further.recv(1) == b""
    assert "is refused" in caplog.text
    del service


DEEP = "<array><data><value>" * 1300 + "x" + "</value></data></array>" * 1300
ANSWERS = [
    DEEP,
    f"<array><data><value><i4>0</i4></value><value>{DEEP}</value><value>x</value></data></array>",
    "x" * 1_000_000,
]


@pytest.mark.parametrize("deep", ["uri", "host"])
def test_addresses_that_are_nested_deeply_are_refused(node, master, caplog, deep):
    """Python's text of a list this deep is an error that is none of a wire."""
    place = {"uri": DEEP, "host": f"<array><data><value>TCPROS</value><value>{DEEP}</value><value><i4>1</i4></value>"
             "</data></array>"}[deep]  # fmt: skip
    value = f"<array><data><value><i4>1</i4></value><value>x</value><value>{place}</value></data></array>"
    body = f"<methodResponse><params><param><value>{value}</value></param></params></methodResponse>".encode()
    head = f"HTTP/1.0 200 OK\r\nContent-Length: {len(body)}\r\n\r\n".encode()
    with peer_of_xmlrpc(lambda _, sock: sock.sendall(head + body)) as uri:
        if deep == "uri":
            with pytest.raises(GazeboError, match="elements in each other"):
                RosClient(node.node.names._replace(master=uri)).call("x", "std_srvs/Empty")
            return
        subscription = node.subscribe("talk", STRING.name, lambda _: None)
        wait_for(lambda: "/talk" in master.subscribers)
        ask(node.node.uri, "publisherUpdate", "/master", "/talk", [uri])
        wait_for(lambda: "elements in each other" in caplog.text)
        wait_for(lambda: not node.node._subscribers["/talk"].publishers)
        del subscription


@pytest.mark.parametrize("value", ANSWERS, ids=["deep", "deep text", "long"])
def test_a_master_of_other_answers_is_waited_for(monkeypatch, caplog, value):
    body = f"<methodResponse><params><param><value>{value}</value></param></params></methodResponse>".encode()
    head = f"HTTP/1.0 200 OK\r\nContent-Length: {len(body)}\r\n\r\n".encode()
    asked = threading.Semaphore(0)

    def answer(_request, sock):
        sock.sendall(head + body)
        asked.release()

    with peer_of_xmlrpc(answer) as uri:
        monkeypatch.setenv("ROS_MASTER_URI", uri)
        monkeypatch.setattr(node_module, "CHECK_PERIOD", 0.01)
        names = read_names(["__name:=sim"])
        with Ros1(["__name:=sim"]) as found:
            for _ in range(6):  # it asks again and again
                assert asked.acquire(timeout=20.0)
            assert found.node.parameter("a") is None
        with pytest.raises(GazeboError):
            RosClient(names).call("x", "std_srvs/Empty")
    assert all(len(record.getMessage()) < 2000 for record in caplog.records)
    assert sum("no master" in record.getMessage() for record in caplog.records) == 1


@pytest.mark.parametrize("method", ["lookupNode", "getParam", "registerPublisher", "unregisterPublisher"])
def test_a_master_that_forgets_and_refuses_does_not_fill_the_log(monkeypatch, caplog, method):
    caplog.set_level(logging.INFO)
    monkeypatch.setattr(node_module, "CHECK_PERIOD", 0.01)
    master, refused = Master(), threading.Semaphore(0)

    def refuse(*_values):
        refused.release()
        return "x" if method == "getParam" else (-1, "refused", 0)

    monkeypatch.setenv("ROS_MASTER_URI", master.uri)
    with Ros1([]) as ros:
        wait_for(lambda: ros.node.registered)
        master.server.register_function(refuse, method)
        topics = []
        for number in range(40):
            topics.append(ros.publish(f"talk{number}", STRING.name))
            if method == "unregisterPublisher":
                topics.pop().end()
            if method == "getParam":
                ros.parameter("a")
            if method == "lookupNode":
                assert refused.acquire(timeout=20.0)
        wait_for(ros.node._tasks.empty)
    assert len(caplog.records) < 15
    master.close()


def test_addresses_of_publishers_do_not_fill_the_log(node, master, caplog):
    subscription = node.subscribe("talk", STRING.name, lambda _: None)
    wait_for(lambda: "/talk" in master.subscribers)
    uris = [f"none://{number}" for number in range(60)]
    for _ in range(8):
        ask(node.node.uri, "publisherUpdate", "/master", "/talk", [*uris, "http://" + "x" * 100_000])
        wait_for(lambda: not node.node._subscribers["/talk"].publishers)
    assert 60 <= len(caplog.records) <= 110
    assert all(len(record.getMessage()) < 2000 for record in caplog.records)
    del subscription


def test_of_a_long_list_of_publishers_few_are_asked(node, master, monkeypatch):
    asked, real = [], node_module.call

    def nobody(uri, method, *values, **options):
        if method != "requestTopic":
            return real(uri, method, *values, **options)
        asked.append(uri)
        raise xmlrpc_module.XmlRpcError("nobody is there")

    monkeypatch.setattr(node_module, "call", nobody)
    subscription = node.subscribe("talk", STRING.name, lambda _: None)
    wait_for(lambda: "/talk" in master.subscribers)
    uris = [f"http://127.0.0.1:1/{number}" for number in range(3000)]
    ask(node.node.uri, "publisherUpdate", "/master", "/talk", uris)
    wait_for(lambda: not node.node._subscribers["/talk"].publishers)
    assert len(asked) == node_module.MOST_PUBLISHERS
    ask(node.node.uri, "publisherUpdate", "/master", "/talk", uris[:1] * 3000)
    wait_for(lambda: not node.node._subscribers["/talk"].publishers)
    assert len(asked) == node_module.MOST_PUBLISHERS + 1
    del subscription


def test_messages_that_do_not_come_whole_have_a_common_bound(node, master, monkeypatch, caplog):
    monkeypatch.setattr(loop_module, "MOST_INCOMPLETE", 1 << 20)
    service = node.serve("serve", "std_srvs/SetBool", lambda _: None)
    wait_for(lambda: "/serve" in master.services)
    clients = [Service(master, "/serve") for _ in range(8)]
    for client in clients:
        with contextlib.suppress(OSError):  # of one that has the longest
            client.socket.sendall(struct.pack("<I", 1 << 20) + bytes(300_000))
    wait_for(lambda: "that have not come whole" in caplog.text)
    wait_for(lambda: len(node.node._loop.connections) <= 4)
    assert sum(one.incomplete for one in node.node._loop.connections) <= 1 << 20
    del service


def test_a_client_that_takes_no_answers_is_closed(node, master, caplog):
    kind = service_type("gazebo_msgs/GetWorldProperties")
    many = kind.response(model_names=["x" * 1000] * 2000)
    service = node.serve("serve", kind.name, lambda _: many)
    wait_for(lambda: "/serve" in master.services)
    client = Service(master, "/serve", md5sum=kind.md5)

    def ask_again():
        with contextlib.suppress(OSError):
            client.send(b"")
        node.deliver()

    wait_for(lambda: "before it took the answer" in caplog.text, ask_again)
    wait_for(lambda: not node.node._loop.connections)
    del service


def test_requests_that_come_byte_by_byte_are_closed_when_others_wait(node, monkeypatch):
    monkeypatch.setattr(xmlrpc_module, "QUICK", 0.05)
    address = ("127.0.0.1", node.node._slave.port)
    with contextlib.ExitStack() as stack:
        slow = [stack.enter_context(socket.create_connection(address, 10.0)) for _ in range(xmlrpc_module.MOST_THREADS)]
        for one in slow:
            one.sendall(b"POST / HTTP/1.1\r\n")

        def served():
            try:
                return ask(node.node.uri, "getPid", "/tester")[0] == 1
            except (OSError, http.client.HTTPException):
                return False

        wait_for(served)


def test_many_that_ask_byte_by_byte_keep_nobody_waiting_long(node, monkeypatch):
    """Those that wait before one must not each take the time after which a request is slow."""
    monkeypatch.setattr(xmlrpc_module, "QUICK", 0.5)
    address, slow, ending = ("127.0.0.1", node.node._slave.port), [], threading.Event()

    def drip():
        while not ending.wait(0.01):
            for one in slow:
                with contextlib.suppress(OSError):
                    one.send(b"P")

    with contextlib.ExitStack() as stack:
        for _ in range(3 * xmlrpc_module.MOST_THREADS):
            slow.append(stack.enter_context(socket.create_connection(address, 20.0)))
        thread = threading.Thread(target=drip)
        stack.callback(thread.join)
        stack.callback(ending.set)
        thread.start()
        with socket.create_connection(address, 20.0) as sock:
            sock.sendall(b"POST / HTTP/1.1\r\nContent-Length: 0\r\n\r\n")
            assert b"200 OK" in sock.recv(100)


def test_a_request_that_comes_byte_by_byte_has_an_end(node, monkeypatch):
    """Each byte is in time."""
    monkeypatch.setattr(xmlrpc_module, "PATIENCE", 0.2)
    with socket.create_connection(("127.0.0.1", node.node._slave.port), 10.0) as sock:
        sock.setblocking(False)

        def closed():
            try:
                return not sock.recv(100)
            except BlockingIOError:
                sock.send(b"P")
            except ConnectionError:
                return True

        wait_for(closed, lambda: time.sleep(0.01))


def test_requests_are_handled_in_turn_and_in_their_share_of_the_time(monkeypatch):
    inside, most, rests, asked = [], [], [], threading.Barrier(4)

    def count(number):
        inside.append(number)
        most.append(len(inside))
        inside.remove(number)
        return 0

    spent, clock = threading.local(), time.thread_time

    def used():  # each look at it in a thread is a second later
        spent.seconds = getattr(spent, "seconds", clock()) + 1.0
        return spent.seconds

    def rest(seconds):
        rests.append((len(inside), seconds))

    monkeypatch.setattr(allowance, "time", SimpleNamespace(monotonic=lambda: 0.0))
    monkeypatch.setattr(xmlrpc_module, "time", SimpleNamespace(**vars(time) | {"thread_time": used, "sleep": rest}))
    server = xmlrpc_module.Server("127.0.0.1", {"count": count})
    server.share.spend(allowance.BURST)
    server.start()

    def client(number):
        asked.wait(20.0)
        assert ask(f"http://127.0.0.1:{server.port}/", "count", number) == 0

    threads = [threading.Thread(target=client, args=(number,)) for number in range(4)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    server.close()
    assert most == [1] * 4
    assert len([one for one in rests if one == (0, pytest.approx(allowance.DEBT / allowance.SHARE))]) >= 4
    assert server.share.take_spent() > 8.0  # two looks of each request, and those of the thread that accepts


def test_an_answer_where_a_publisher_is_has_a_bound(node, master, caplog):
    body = b"<methodResponse><params><param><value>" + b"x" * node_module.MOST_PLACE + b"</value></param></params>"
    head = f"HTTP/1.0 200 OK\r\nContent-Length: {len(body)}\r\n\r\n".encode()
    subscription = node.subscribe("talk", STRING.name, lambda _: None)
    wait_for(lambda: "/talk" in master.subscribers)
    with peer_of_xmlrpc(lambda _, sock: sock.sendall(head + body)) as uri:
        ask(node.node.uri, "publisherUpdate", "/master", "/talk", [uri])
        wait_for(lambda: f"more than {node_module.MOST_PLACE} bytes" in caplog.text)
    del subscription


def test_threads_that_cannot_start_are_not_counted(node, monkeypatch):
    start = threading.Thread.start

    def fail(thread):
        if "process_request_thread" in thread.name:
            raise RuntimeError("can't start new thread")
        start(thread)

    with monkeypatch.context() as broken:
        broken.setattr(threading.Thread, "start", fail)
        for _ in range(xmlrpc_module.MOST_THREADS):
            with pytest.raises((OSError, http.client.HTTPException)):
                ask(node.node.uri, "getPid", "/tester")
    assert ask(node.node.uri, "getPid", "/tester")[0] == 1


@pytest.mark.parametrize(
    "first", ["GET /", "PUT /", "DELETE /", "CONNECT x:1", "TRACE /", "OPTIONS *", "do_POST /", "_ /"]
)
def test_other_methods_of_http_are_refused(node, first):
    body = xmlrpc.client.dumps(("/tester",), "getPid").encode()
    with socket.create_connection(("127.0.0.1", node.node._slave.port), 10.0) as sock:
        sock.sendall(f"{first} HTTP/1.1\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body)
        answer = b""
        with contextlib.suppress(ConnectionError):  # what it has not read
            while piece := sock.recv(4096):
                answer += piece
    assert answer.startswith(b"HTTP/1.1 501 ")
    assert b"methodResponse" not in answer


def test_a_body_that_comes_in_chunks_begins_no_second_request(node):
    """One of both lengths counts; what is behind it is not read."""
    body = xmlrpc.client.dumps(("/tester",), "getPid").encode()
    lengths = b"Transfer-Encoding: chunked\r\nContent-Length: %d\r\n\r\n" % len(body)
    with socket.create_connection(("127.0.0.1", node.node._slave.port), 10.0) as sock:
        sock.sendall(2 * (b"POST / HTTP/1.1\r\n" + lengths + body))
        answer = b""
        with contextlib.suppress(ConnectionError):
            while piece := sock.recv(4096):
                answer += piece
    assert answer.count(b"HTTP/1.1 ") == 1


def test_without_descriptors_a_node_neither_spins_nor_ends(node, caplog):
    loop = node.node._loop
    with socket.socket() as sock, none_left():
        sock.connect(("127.0.0.1", int(node.node._listener.port)))
        wait_for(lambda: "cannot be accepted" in caplog.text)
        before = loop.tally._counts["accept"][0]
        time.sleep(3.0 * loop_module.PAUSE)
        assert loop.tally._counts["accept"][0] - before <= 3  # thousands if it spun
    with socket.create_connection(("127.0.0.1", int(node.node._listener.port)), 10.0) as sock:
        wait_for(lambda: len(loop.connections) == 1)


def test_names_and_addresses(monkeypatch):
    for name in ("ROS_IP", "ROS_HOSTNAME", "ROS_NAMESPACE", "ROS_MASTER_URI"):
        monkeypatch.delenv(name, raising=False)
    names = read_names(["__ns:=/robots", "scan:=laser", "/tf:=/other"])
    assert (names.name, names.master, names.host, names.address) == (
        "/robots/gazebo",
        "http://localhost:11311",
        "127.0.0.1",
        "127.0.0.1",
    )
    resolved = [names.resolve(*one) for one in (("scan",), ("/tf",), ("~x",), ("odom", "r1"), ("odom", "/r1"), ("/a",))]
    assert resolved == ["/robots/laser", "/other", "/robots/gazebo/x", "/robots/r1/odom", "/r1/odom", "/a"]
    where = attrgetter("host", "address")
    monkeypatch.setenv("ROS_HOSTNAME", "localhost")
    assert where(read_names([])) == ("localhost", "127.0.0.1")
    monkeypatch.setenv("ROS_HOSTNAME", "robot.lan")
    assert where(read_names([])) == ("robot.lan", "")
    assert where(read_names([], "10.0.0.1")) == ("10.0.0.1", "10.0.0.1")


def test_what_has_just_ended_is_unregistered_before_the_node_is(master):
    unregister = master.unregisterPublisher
    master.server.register_function(
        lambda *values: time.sleep(0.05) or unregister(*values), "unregisterPublisher"
    )  # a busy master
    with Ros1([]) as node:
        topics = [node.publish(f"t{number}", STRING.name) for number in range(8)]
        wait_for(lambda: all(master.publishers.get(topic.topic) for topic in topics))
        topics.clear()
    assert not any(master.publishers.values())


def test_what_a_world_serves_ends_with_it(master, start):
    core, _ = start((Path(__file__).parent / "legacy.world").read_text())
    wait_for(lambda: "/robot/cmd_vel" in master.subscribers and "/gazebo/pause_physics" in master.services, core.Step)
    core.close()
    wait_for(lambda: "/gazebo/pause_physics" not in master.services)
    wait_for(lambda: not any(master.subscribers.values()))


def test_a_topic_that_is_collected_within_a_lock_ends(start):
    _, ros = start()
    publisher = ros.node.advertise("/a", message_type("std_msgs/Float64"))
    assert within(ros.node._lock, lambda: ros.node.withdraw(publisher))


def test_an_end_does_not_overtake_the_next_beginning_at_the_master(node, master):
    wire, tasks = node.node, node.node._tasks
    begin = threading.Thread(target=lambda: wire.subscribe("/s", STRING, bool))

    class Slow:
        get = staticmethod(tasks.get)

        def put(self, task):
            if not begin.ident:  # the first one, which is to end the subscription
                begin.start()
                begin.join(0.2)
            tasks.put(task)

    first = wire.subscribe("/s", STRING, bool)
    wait_for(lambda: master.subscribers.get("/s"))
    wire._tasks = Slow()
    wire.unsubscribe(first, bool)
    begin.join()
    service = wire.serve("/last", service_type("std_srvs/Empty"), lambda *_: True)
    wait_for(lambda: service.name in master.services)  # all before it has been done
    assert wire._subscribers["/s"] is not first
    assert master.subscribers["/s"]


def test_a_master_that_did_not_answer_hears_later_of_what_began_and_ended(node, master, monkeypatch):
    wire, lost = node.node, []
    old = wire.advertise("/old", STRING)
    wait_for(lambda: master.publishers.get("/old"))

    def call(uri, method, *values, **more):
        if method in ("registerSubscriber", "unregisterPublisher") and method not in lost:
            lost.append(method)
            raise xmlrpc_module.XmlRpcError("no answer in time")
        return original(uri, method, *values, **more)

    original = node_module.call
    monkeypatch.setattr(node_module, "call", call)
    wire.withdraw(old)
    wire.subscribe("/new", STRING, lambda _: None)
    wait_for(lambda: not master.publishers["/old"] and master.subscribers.get("/new"))
    assert "unregisterPublisher" in lost
