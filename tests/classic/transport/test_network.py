"""Topics between processes: a second process, on an unused port."""

import contextlib
import functools
import logging
import socket
import subprocess
import sys
import textwrap
import threading
import time

import pytest
from classic_wire import Connection, Subscription, close_all, new
from descriptors import none_left
from master_uri import free_master_uri

from libgz.base.errors import GazeboError, ParameterError, ServerError
from libgz.classic import msgs
from libgz.classic.transport import (
    Link,
    Node,
    TopicManager,
    connect,
    fini,
    get_master_uri,
    getAdvertisedTopics,
    init,
    is_stopped,
    network,
    publicized_address,
    run,
    serve,
    stop,
)
from libgz.classic.transport.loop import SocketLoop
from libgz.classic.transport.master import Master

manager = TopicManager.Instance()
PATIENCE = 20.0  # [s]: a machine under load
_started = []  # processes of the present test


@pytest.fixture
def uri(monkeypatch):
    for topic in list(manager.topics.values()):
        for publisher in topic.live_publishers():
            publisher.Fini()
    found = free_master_uri()
    monkeypatch.setenv("GAZEBO_MASTER_URI", found)
    yield found
    close_all()
    for process in _started:
        with process:
            process.kill()
    _started.clear()
    fini()
    manager.RemoveTopicNamespace("w")
    manager.ClearBuffers()


@pytest.fixture
def node():
    manager.AddTopicNamespace("w")
    node = Node()
    node.Init("w")
    return node


def wait(condition):
    """Deliver messages until something holds."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it did not come"
        manager.ProcessNodes()
        time.sleep(0.002)


CLIENT = """
import sys, time
from libgz.classic import msgs
from libgz.classic.transport import Node, TopicManager, connect, getAdvertisedTopics
manager = TopicManager.Instance()

def wait(condition):
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end, "it did not come"
        manager.ProcessNodes()
        time.sleep(0.002)

connect()
node = Node()
node.Init()
"""


def client(code, **options):
    """A second process that has connected and made a node."""
    text = CLIENT + textwrap.dedent(code)
    command = [sys.executable, "-c", text]
    _started.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options))
    return _started[-1]


def finish(process):
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    return out


def test_messages_go_both_ways(uri, node):
    with serve():
        got = []
        sub = node.Subscribe("~/up", got.append)
        pub = node.Advertise(msgs.Pose, "~/down")
        assert not pub.HasConnections()
        process = client(
            """
            assert node.GetTopicNamespace() == "w"
            assert getAdvertisedTopics() == ["/gazebo/w/down"], getAdvertisedTopics()
            assert node.GetMsgType("~/down") == "gazebo.msgs.Pose"
            got = []
            sub = node.Subscribe("~/down", got.append)
            wait(lambda: got)
            print(got[0].position.x, got[0].name)
            up = node.Advertise(msgs.LaserScan, "~/up")
            assert up.WaitForConnection(20)
            up.Publish(msgs.LaserScan(ranges=[1.5, float("inf")], frame="é"))
            """
        )
        assert pub.WaitForConnection(PATIENCE) or finish(process)
        pose = msgs.Pose(name="box")
        pose.position.x = 2.5
        pub.Publish(pose)
        wait(lambda: got)
        assert finish(process) == "2.5 box\n"
        assert (list(got[0].ranges), got[0].frame) == ([1.5, float("inf")], "é")
        wait(lambda: not pub.HasConnections())
        assert sub.GetTopic() == "/gazebo/w/up"
        assert getAdvertisedTopics() == ["/gazebo/w/down"]


def test_latching_between_processes(uri, node):
    with serve():
        pub = node.Advertise(msgs.Int, "~/a")
        other = node.Advertise(msgs.Int, "~/a")
        for i in (1, 2):
            pub.Publish(msgs.Int(data=i))
        other.Publish(msgs.Int(data=3))
        run()  # as a server does after each iteration
        process = client(
            """
            plain, got = [], []
            subs = [node.Subscribe("~/a", plain.append), node.Subscribe("~/a", got.append, True)]
            wait(lambda: len(got) == 2)
            print(sorted(m.data for m in got), plain, flush=True)
            wait(lambda: plain)
            late = []
            subs.append(node.Subscribe("~/a", late.append, True))
            wait(lambda: len(late) == 2)
            print([m.data for m in plain], len(got), sorted(m.data for m in late))
            """
        )
        assert process.stdout.readline() == "[2, 3] []\n"
        network = TopicManager.Instance().remote
        wait(lambda: network.receivers("/gazebo/w/a") == 2)  # the latching subscriber has a connection of its own
        pub.Publish(msgs.Int(data=4))
        assert finish(process) == "[4] 3 [3, 4]\n"


def test_clients_reach_each_other(uri, node):
    with serve():
        listener = client(
            """
            got = []
            sub = node.Subscribe("/free", got.append)
            wait(lambda: len(got) == 500)
            print([m.data for m in got] == list(range(500)))
            """
        )
        speaker = client(
            """
            pub = node.Advertise(msgs.Int, "/free")
            assert pub.WaitForConnection(20)
            for i in range(500):
                pub.Publish(msgs.Int(data=i))
            """
        )
        finish(speaker)  # which ends at once: nothing is lost
        assert finish(listener) == "True\n"


def test_publishers_and_subscribers_of_other_processes(uri, node):
    with serve():
        pub = node.Advertise(msgs.Int, "~/a")
        process = client(
            """
            sub = node.Subscribe("~/a", print)
            other = node.Advertise(msgs.Pose, "~/b")
            wait(lambda: len(manager.TopicInfo("/gazebo/w/a").publisher) == 1)
            try:
                node.Advertise(msgs.Pose, "~/a")
            except ValueError as error:
                print(error, flush=True)
            input()
            """,
            stdin=subprocess.PIPE,
        )
        assert "published with gazebo.msgs.Int; it cannot" in process.stdout.readline()
        wait(lambda: pub.HasConnections() and node.GetMsgType("~/b"))
        wait(lambda: manager.TopicInfo("/gazebo/w/a").subscriber)
        info = manager.TopicInfo("/gazebo/w/a")
        assert info.msg_type == "gazebo.msgs.Int"
        assert [(p.msg_type, p.host) for p in info.publisher] == [("gazebo.msgs.Int", "127.0.0.1")]
        assert [s.topic for s in info.subscriber] == ["/gazebo/w/a"]
        assert info.publisher[0].port != info.subscriber[0].port
        assert getAdvertisedTopics() == ["/gazebo/w/a", "/gazebo/w/b"]
        process.kill()  # leaves nothing behind
        process.communicate()
        wait(lambda: not pub.HasConnections() and getAdvertisedTopics() == ["/gazebo/w/a"])


def test_a_topic_may_be_advertised_again_and_with_another_type(uri, node):
    with serve():
        process = client(
            """
            sub = node.Subscribe("~/a", lambda m: print(m.GetTypeName(), flush=True))
            wait(lambda: node.GetMsgType("~/a") == "gazebo.msgs.GzString")
            wait(lambda: not getAdvertisedTopics())
            """
        )
        for kind in (msgs.Int, msgs.Int, msgs.Pose, msgs.GzString):
            pub = node.Advertise(kind, "~/a")
            assert pub.WaitForConnection(PATIENCE) or finish(process)
            pub.Publish(kind())
            assert process.stdout.readline() == kind.GetTypeName() + "\n"
            pub.Fini()
        finish(process)


def test_nothing_is_serialized_for_nobody(uri, node, monkeypatch):
    with serve():
        got = []
        sub = node.Subscribe("~/a", got.append)
        pub = node.Advertise(msgs.Int, "~/a")
        monkeypatch.setattr(msgs.Int, "SerializeToString", lambda self: pytest.fail("serialized"))
        pub.Publish(msgs.Int(data=1))
        manager.ProcessNodes()
        assert got[0].data == 1
        assert sub


def test_a_message_of_an_unknown_type_is_reported(uri, node, caplog):
    with serve():
        got = []
        sub = node.Subscribe("~/a", got.append)
        process = client(
            """
            pub = node.Advertise(msgs.declare("my.Own", "int32 n"), "~/a")
            assert pub.WaitForConnection(20)
            pub.Publish(msgs.message_type("my.Own")(n=5))
            """
        )
        finish(process)
        wait(lambda: caplog.records)
        assert "there is no message type 'my.Own'" in caplog.text
        assert not got
        assert sub


def test_clients_deliver_in_a_thread(uri, node):
    with serve():
        pub = node.Advertise(msgs.Int, "~/a")
        process = client(
            """
            from libgz.classic import transport
            assert transport.init()
            transport.run()
            got = []
            sub = node.Subscribe("~/a", got.append)
            end = time.monotonic() + 20
            while not got and time.monotonic() < end:
                time.sleep(0.002)
            print(got[0].data)
            """  # and ends without stop() and fini()
        )
        assert pub.WaitForConnection(PATIENCE) or finish(process)
        pub.Publish(msgs.Int(data=7))
        assert finish(process) == "7\n"
    run()
    assert not is_stopped()
    stop()
    assert is_stopped()


def test_a_port_in_use(uri):
    text = (
        r"^Unable to start server\[bind: Address already in use\]. There is probably another Gazebo process running. GA"
    )
    with serve(), pytest.raises(ServerError, match=r"has a link to http://127.0.0.1:"):
        serve()
    with serve():
        code = "from libgz.classic.transport import serve; serve()"
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE)
    assert done.stderr.splitlines()[-1].partition(": ")[2].startswith("Unable to start server[bind: Address already in")
    port = int(uri.rpartition(":")[2])
    with socket.create_server(("127.0.0.1", port)), pytest.raises(ServerError, match=text):
        serve()
    assert Link.current is None
    with serve() as link:  # the port is free again
        assert link.address.port == port
    with serve("http://localhost:0") as link:
        assert link.address.port not in (0, port)


def test_no_server(uri, caplog):
    with pytest.raises(ServerError, match=r"^Failed to connect to master in 0.2 seconds. \(there is no server at http"):
        connect(timeout=0.2)
    assert not init(timeoutIterations=0)
    assert "Failed to connect to master in 0 seconds." in caplog.text
    silent = socket.create_server(("127.0.0.1", int(uri.rpartition(":")[2])))
    with silent, pytest.raises(ServerError, match=r"does not answer as a master of Gazebo"):
        connect(timeout=0.2)


def test_a_client_waits_for_its_server(uri):
    process = client("print(node.GetTopicNamespace())")
    time.sleep(0.3)
    with serve():
        manager.AddTopicNamespace("w")
        assert finish(process) == "w\n"


def test_a_client_notices_the_end_of_its_server(uri):
    code = "from libgz.classic.transport import serve; link = serve(); print('here', flush=True); input()"
    command = [sys.executable, "-c", code]
    for end in ("kill", "terminate"):
        server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        _started.append(server)
        with connect(timeout=PATIENCE) as link:
            assert link.connected()
            getattr(server, end)()
            server.communicate(timeout=PATIENCE)
            wait(lambda link=link: not link.connected())
            Node().Init("w")


def test_the_master_uri(monkeypatch, caplog):
    monkeypatch.delenv("GAZEBO_MASTER_URI", raising=False)
    assert get_master_uri() == ("127.0.0.1", 11345)
    assert get_master_uri().uri == "http://127.0.0.1:11345"
    monkeypatch.setenv("GAZEBO_MASTER_URI", "http://robot:123")
    assert get_master_uri() == ("robot", 123)
    assert get_master_uri("[::1]:5").uri == "http://[::1]:5"
    with caplog.at_level(logging.WARNING):
        assert get_master_uri("http://robot").port == 11345
    assert caplog.messages == ["Port missing in master URI[http://robot]. Using default value of 11345."]
    for wrong in ("http://:1", "http://a:b", "http://a:99999"):
        with pytest.raises(ParameterError, match="must be like http://localhost:11345"):
            get_master_uri(wrong)
    monkeypatch.setenv("GAZEBO_IP", "10.1.2.3")
    assert publicized_address() == "10.1.2.3"
    monkeypatch.delenv("GAZEBO_IP")
    monkeypatch.delenv("GAZEBO_HOSTNAME", raising=False)
    assert publicized_address() == "127.0.0.1"


def test_a_server_may_announce_many_topics(uri, node):
    with serve() as link:
        kept = [node.Subscribe(f"~/t{number}", print) for number in range(1200)]
        master = Connection(link.address.port)
        info = {}

        def last_is_known():
            info["last"] = master.ask("topic_info", "topic_info_response", "TopicInfo", "/gazebo/w/t1199")
            return info["last"].subscriber

        wait(last_is_known)
        assert link.connected()
        assert len(kept) == 1200


def test_threads_that_ask_the_master_get_their_own_answers(uri, node):
    with serve():
        kept = [node.Advertise(kind, f"~/{kind.__name__}") for kind in (msgs.Pose, msgs.Int, msgs.Wind)]
        wrong = []

        def ask(publisher):
            for _ in range(50):
                found = manager.TopicInfo(publisher.GetTopic()).msg_type
                if found != publisher.GetMsgType():
                    wrong.append(found)

        threads = [threading.Thread(target=ask, args=(publisher,)) for publisher in kept]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert wrong == []


def test_an_answer_of_the_master_that_comes_late_is_not_that_of_the_next_question(uri, node, monkeypatch):
    answer, held = Master._request, []

    def answer_late(master, client, request):
        held.append(functools.partial(answer, master, client, request))
        if request.data.endswith("second"):
            held[0]()
            threading.Timer(0.1, manager.remote._loop.call, held[1:]).start()

    monkeypatch.setattr(Master, "_request", answer_late)
    with serve():
        kept = [node.Advertise(msgs.Pose, "~/first"), node.Advertise(msgs.Int, "~/second")]
        with monkeypatch.context() as short:
            short.setattr(network, "ANSWER_PATIENCE", 0.01)
            with pytest.raises(GazeboError, match="did not answer"):
                manager.TopicInfo(kept[0].GetTopic())
        assert manager.TopicInfo(kept[1].GetTopic()).msg_type == "gazebo.msgs.Int"


def test_a_question_that_the_master_never_answers_does_not_spoil_later_ones(uri, node, monkeypatch):
    answer = Master._request

    def answer_some(master, client, request):
        if not request.data.endswith("lost"):
            answer(master, client, request)

    monkeypatch.setattr(Master, "_request", answer_some)
    monkeypatch.setattr(network, "ANSWER_PATIENCE", 0.2)
    with serve():
        kept = node.Advertise(msgs.Int, "~/topic")
        with pytest.raises(GazeboError, match="did not answer"):
            manager.TopicInfo("/lost")
        monkeypatch.setattr(network, "ANSWER_PATIENCE", 2.0)
        assert manager.TopicInfo(kept.GetTopic()).msg_type == "gazebo.msgs.Int"  # after the time of patience
        monkeypatch.setattr(network, "ANSWER_PATIENCE", PATIENCE)
        assert manager.TopicInfo(kept.GetTopic()).msg_type == "gazebo.msgs.Int"  # at once


def test_without_descriptors_a_publisher_is_left_out_with_one_line(uri, node, caplog):
    with serve() as link:
        kept = node.Subscribe("~/topic", lambda _: None, kind=msgs.Int)
        other = Connection(link.address.port)
        with none_left():
            other.send("advertise", new("Publish", topic="/gazebo/w/topic", msg_type="x", host="127.0.0.1", port=1))
            wait(lambda: caplog.records)
        assert "clients publish on /gazebo/w/topic is not received: [Errno 24]" in caplog.records[0].getMessage()
        assert manager.TopicInfo("/gazebo/w/topic").publisher
        del kept


@pytest.mark.trial
def test_connections_to_publishers_that_have_ended_make_room_for_others(uri, node, monkeypatch):
    monkeypatch.setattr(network, "SOURCES", 2)
    listeners = [socket.create_server(("127.0.0.1", 0)) for _ in range(3)]
    ended, *others = [
        new("Publish", topic=node.DecodeTopicName("~/topic"), msg_type="gazebo.msgs.Int", host="127.0.0.1", port=port)
        for port in (one.getsockname()[1] for one in listeners)
    ]
    with serve(uri) as link, contextlib.ExitStack() as kept:
        sources = manager.remote._sources
        subscriber = node.Subscribe("~/topic", lambda _message: None)
        for one in listeners:
            kept.enter_context(one).settimeout(PATIENCE)
        other = Connection(link.address.port)
        other.send("advertise", ended)
        held = kept.enter_context(listeners[0].accept()[0])
        other.send("unadvertise", ended)
        other.send("advertise", others[0])  # the last messages of the other may still come
        kept.enter_context(listeners[1].accept()[0])
        wait(lambda: len(sources) == 2)
        other.send("advertise", others[1])
        kept.enter_context(listeners[2].accept()[0])
        wait(lambda: {key[2] for key, _ in sources} == {one.port for one in others})
        held.settimeout(PATIENCE)
        while held.recv(1 << 16):
            pass
        del subscriber


def test_nothing_is_sent_to_a_subscriber_that_never_reads_until_it_reads(uri, node, monkeypatch):
    monkeypatch.setattr("libgz.classic.transport.loop.STALLED", 0.05)
    with serve() as link:
        pub = node.Advertise(msgs.GzString, "~/a")
        master = Connection(link.address.port)
        deaf = Subscription(master, "/gazebo/w/a", "GzString")
        assert pub.WaitForConnection(PATIENCE)
        end = time.monotonic() + PATIENCE
        while pub.HasConnections():
            assert time.monotonic() < end, "it is still sent to"
            pub.Publish(msgs.GzString(data="x" * 100_000))
            time.sleep(0.001)
        enough = threading.Event()

        def publish():
            while not enough.wait(0.01):
                pub.Publish(msgs.GzString(data="last"))

        thread = threading.Thread(target=publish)
        thread.start()
        try:
            assert deaf.until(lambda message: message.data == "last")
        finally:
            enough.set()
            thread.join()


def test_a_collection_of_garbage_does_not_make_a_server_deaf():
    """It may take a second, in the thread that handles what comes in, and is none of the clients' doing."""
    loop, found, looked = SocketLoop(0.02), [], threading.Event()

    def look():
        loop._reading = False
        loop._count(2.0)
        found.append(loop._pause())
        loop._reading = True
        looked.set()

    try:
        loop.call(look)
        assert looked.wait(PATIENCE)
        assert 2.9 < found[0] < 3.1
    finally:
        loop.close(0.0)


def test_names_of_machines_that_are_none_are_left_out_and_few_are_looked_up_at_a_time(uri, node, monkeypatch, caplog):
    looking, free, most = [], threading.Event(), 0
    asked = network.socket.getaddrinfo

    def slow(host, *values, **options):
        if threading.current_thread().name == "names" and host.startswith("slow"):
            looking.append(host)
            free.wait(PATIENCE)
        return asked(host, *values, **options)

    monkeypatch.setattr(network.socket, "getaddrinfo", slow)
    try:
        with serve() as link:
            heard = []
            subscriber = node.Subscribe("/gazebo/w/talk", heard.append)
            client = Connection(link.address.port)
            names = ["a" * 300, "..", "\0", "", *(f"slow{i}.invalid" for i in range(3 * network.LOOK_UPS))]
            for number, name in enumerate(names):
                publish = msgs.Publish(topic="/gazebo/w/talk", host=name, port=number + 1, msg_type="gazebo.msgs.Any")
                client.send("advertise", publish)
            client.ask("get_publishers", "publisher_list", "Publishers")  # all of them have been handled
            wait(lambda: len(looking) >= network.LOOK_UPS - 4)  # the names that are none may still be looked up
            most = len(looking)
            free.set()
            wait(lambda: len(set(looking)) == len(looking) == 3 * network.LOOK_UPS)  # each once
            assert subscriber is not None
    finally:
        free.set()
    assert most <= network.LOOK_UPS
    assert "could not be handled" not in caplog.text


def test_a_publisher_of_a_machine_with_a_name_is_looked_up_once_and_forgotten_when_it_ends(uri, node, monkeypatch):
    asked, looked = network.socket.getaddrinfo, []

    def named(host, *values, **options):
        if threading.current_thread().name == "names":
            looked.append(host)
            host = "127.0.0.1"
        return asked(host, *values, **options)

    monkeypatch.setattr(network.socket, "getaddrinfo", named)
    with serve() as link, socket.create_server(("127.0.0.1", 0)) as publisher:
        publisher.settimeout(PATIENCE)
        subscriber = node.Subscribe("/gazebo/w/talk", print)
        client = Connection(link.address.port)
        port = publisher.getsockname()[1]
        publish = msgs.Publish(topic="/gazebo/w/talk", host="here.invalid", port=port, msg_type="gazebo.msgs.Any")
        client.send("advertise", publish)
        with publisher.accept()[0]:
            wait(lambda: getAdvertisedTopics() == [subscriber.GetTopic()])
            client.send("unadvertise", publish)
            wait(lambda: getAdvertisedTopics() == [])
    assert looked == ["here.invalid"]
