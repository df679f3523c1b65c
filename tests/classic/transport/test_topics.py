"""Topics within a process."""

import gc
import logging
import sys
import threading
from collections import deque

import pytest

import libgz
from libgz.base.errors import ClosedError, GazeboError, NotFoundError, ParameterError
from libgz.classic import msgs
from libgz.classic.transport import Node, TopicManager, getAdvertisedTopics, getTopicMsgType, request, requestNoReply
from libgz.classic.transport.publisher import drop_waiting, queue_message, waiting_messages

manager = TopicManager.Instance()


@pytest.fixture
def node():
    node = Node()
    node.Init("here")
    yield node
    manager.ProcessNodes()
    manager.clear("")
    manager.ClearBuffers()


def xs(messages):
    return [message.x for message in messages]


def test_messages_wait_for_the_end_of_the_iteration(node):
    got = []
    sub = node.Subscribe("~/a", got.append)
    pub = node.Advertise(msgs.Vector3d, "~/a")
    assert pub.HasConnections()
    message = msgs.Vector3d(x=1)
    pub.Publish(message)
    message.x = 2.0  # filled anew: what was published stays
    pub.Publish(message)
    assert not got
    assert pub.GetOutgoingCount() == 2
    manager.ProcessNodes()
    assert xs(got) == [1.0, 2.0]
    manager.ProcessNodes()
    assert len(got) == 2
    assert sub.GetTopic() == pub.GetTopic() == "/gazebo/here/a"


def test_order_over_topics_is_that_of_publishing(node):
    got = []
    subs = [node.Subscribe(f"~/{name}", lambda m, name=name: got.append((name, m.x))) for name in "ab"]
    a, b = (node.Advertise("Vector3d", f"~/{name}") for name in "ab")
    for i, pub in enumerate((b, a, a, b)):
        pub.Publish(msgs.Vector3d(x=i))
    manager.ProcessNodes()
    assert got == [("b", 0), ("a", 1), ("a", 2), ("b", 3)]
    assert len(subs) == 2


def test_a_blocking_publish_delivers_at_once_and_in_order(node):
    got = []
    sub = node.Subscribe("~/a", got.append)
    pub = node.Advertise(msgs.Vector3d, "~/a")
    pub.Publish(msgs.Vector3d(x=1))
    pub.Publish(msgs.Vector3d(x=2), True)
    assert xs(got) == [1.0, 2.0]
    manager.ProcessNodes()
    assert len(got) == 2
    sub.Unsubscribe()


def test_what_a_callback_publishes_waits(node):
    got = []
    pub = node.Advertise(msgs.Int, "~/count")

    def OnCount(message):
        got.append(message.data)
        pub.Publish(msgs.Int(data=message.data + 1))

    sub = node.Subscribe("~/count", OnCount)
    pub.Publish(msgs.Int(data=0))
    for _ in range(3):
        manager.ProcessNodes()
    assert got == [0, 1, 2]
    sub.Unsubscribe()


def test_latching_gives_the_last_message(node):
    pub = node.Advertise(msgs.Vector3d, "~/a")
    early, late, plain = [], [], []
    sub = node.Subscribe("~/a", early.append)
    pub.Publish(msgs.Vector3d(x=1))
    pub.Publish(msgs.Vector3d(x=2))
    latched = node.Subscribe("~/a", late.append, latching=True)
    other = node.Subscribe("~/a", plain.append)
    manager.ProcessNodes()
    assert (xs(early), xs(late), xs(plain)) == ([1, 2], [2], [])
    pub.Publish(msgs.Vector3d(x=3))
    manager.ProcessNodes()
    assert (xs(early), xs(late), xs(plain)) == ([1, 2, 3], [2, 3], [3])
    assert all((sub, latched, other))


class Plugin:
    def __init__(self, node, got):
        self.got = got
        self.sub = node.Subscribe("~/a", self.OnMsg)

    def OnMsg(self, message):
        self.got.append(message)


def test_a_dropped_plugin_receives_no_messages(node):
    gc.disable()
    try:
        got = []
        plugin = Plugin(node, got)
        pub = node.Advertise(msgs.Vector3d, "~/a")
        pub.Publish(msgs.Vector3d())
        manager.ProcessNodes()
        del plugin
        assert not pub.HasConnections()
        pub.Publish(msgs.Vector3d())
        manager.ProcessNodes()
        assert len(got) == 1
    finally:
        gc.enable()


def test_a_dropped_subscriber_or_publisher_ends(node):
    got = []
    sub = node.Subscribe("~/a", got.append)
    pub = node.Advertise(msgs.Vector3d, "~/a")
    assert getAdvertisedTopics() == ["/gazebo/here/a"]
    pub.Publish(msgs.Vector3d())
    del pub
    assert getAdvertisedTopics() == []
    manager.ProcessNodes()
    assert len(got) == 1  # what waited is delivered
    del sub
    assert not manager.topic("/gazebo/here/a").subscribers


def test_a_subscriber_that_is_not_kept_is_reported(node, caplog, monkeypatch):
    monkeypatch.setattr("libgz.classic.transport.subscriber.clock.monotonic", lambda: 5.0)
    node.Subscribe("~/a", print).Unsubscribe()
    assert not caplog.records
    node.Subscribe("~/a", print)
    assert caplog.messages == [
        "the subscription to /gazebo/here/a ended right after it began: keep what Subscribe returns"
    ]


def test_a_callback_may_unsubscribe_itself_and_others(node):
    got = []
    subs = {}

    def first(message):
        got.append("first")
        subs.pop("first").Unsubscribe()
        subs.pop("second").Unsubscribe()

    subs["first"] = node.Subscribe("~/a", first)
    subs["second"] = node.Subscribe("~/a", lambda m: got.append("second"))
    pub = node.Advertise(msgs.Vector3d, "~/a")
    pub.Publish(msgs.Vector3d())
    pub.Publish(msgs.Vector3d())
    manager.ProcessNodes()
    assert got == ["first"]


def test_a_callback_that_raises_is_reported_and_ends(node, caplog):
    got = []

    def OnBad(message):
        raise RuntimeError("bad day")

    bad = node.Subscribe("~/a", OnBad)
    good = node.Subscribe("~/a", got.append)
    pub = node.Advertise(msgs.Vector3d, "~/a")
    with caplog.at_level(logging.ERROR):
        for _ in range(2):
            pub.Publish(msgs.Vector3d())
            manager.ProcessNodes()
    assert len(got) == 2
    (record,) = caplog.records
    assert "OnBad of topic /gazebo/here/a failed" in record.getMessage()
    assert "RuntimeError: bad day" in record.getMessage()
    assert "subscriber.py" not in record.getMessage()
    assert all((bad, good))


def test_types_are_checked(node):
    pub = node.Advertise(msgs.Vector3d, "~/a")
    with pytest.raises(ParameterError, match=r"was advertised with gazebo.msgs.Vector3d; it cannot send a .*Pose"):
        pub.Publish(msgs.Pose())
    with pytest.raises(ParameterError, match="cannot send a dict"):
        pub.Publish({"x": 1})
    with pytest.raises(
        ParameterError, match=r"published with gazebo.msgs.Vector3d; it cannot be advertised with .*Pose"
    ):
        node.Advertise(msgs.Pose, "~/a")
    assert node.Advertise(msgs.Vector3d, "~/a").GetMsgType() == "gazebo.msgs.Vector3d"
    assert getTopicMsgType("/gazebo/here/a") == node.GetMsgType("~/a") == "gazebo.msgs.Vector3d"
    pub.Fini()
    assert node.GetMsgType("~/a") == ""
    node.Advertise(msgs.Pose, "~/a")


def test_arguments_are_checked(node):
    with pytest.raises(NotFoundError):
        node.Advertise("Vectr3d", "~/a")
    for wrong in [
        lambda: node.Advertise("~/a", msgs.Vector3d),
        lambda: node.Advertise(msgs.Vector3d, " "),
        lambda: node.Advertise(msgs.Vector3d, "~/"),
        lambda: node.Advertise(msgs.Vector3d, "~/a", 0),
        lambda: node.Advertise(msgs.Vector3d, "~/a", 1, -1.0),
        lambda: node.Subscribe("~/a", None),
    ]:
        with pytest.raises(GazeboError):
            wrong()
    with pytest.raises(ClosedError, match="before Init"):
        Node().Subscribe("~/a", print)


def test_names(node):
    assert node.DecodeTopicName("~/a//b") == "/gazebo/here/a/b"
    assert node.DecodeTopicName("/gazebo/there/a") == "/gazebo/there/a"
    assert node.EncodeTopicName("/gazebo/here/a/b") == "~/a/b"
    assert node.EncodeTopicName("/gazebo/hereafter/a") == "/gazebo/hereafter/a"
    assert node.GetTopicNamespace() == "here"


def test_worlds_have_their_own_topics():
    assert manager.GetTopicNamespaces() == []
    for name in ("one", "two"):
        manager.AddTopicNamespace(name)
    try:
        first, second = Node(), Node()
        first.Init()
        assert first.GetTopicNamespace() == "one"
        second.Init("two")
        got = []
        sub = second.Subscribe("~/a", got.append)
        ones, twos = (n.Advertise(msgs.Int, "~/a") for n in (first, second))
        ones.Publish(msgs.Int(data=1))
        twos.Publish(msgs.Int(data=2))
        manager.ProcessNodes()
        assert [m.data for m in got] == [2]
        manager.RemoveTopicNamespace("two")
        assert manager.GetTopicNamespaces() == ["one"]
        assert getAdvertisedTopics() == ["/gazebo/one/a"]
        assert getAdvertisedTopics("gazebo.msgs.Pose") == []
        with pytest.raises(ClosedError, match="after its world was closed"):
            twos.Publish(msgs.Int())
        assert sub
    finally:
        for name in ("one", "two"):
            manager.RemoveTopicNamespace(name)
    node = Node()
    node.Init()
    assert node.GetTopicNamespace() == "default"


def test_a_node_without_a_world_uses_that_of_its_plugin(tmp_path, monkeypatch):
    text = """from libgz.classic import *
class P(WorldPlugin):
    def Load(self, world, sdf):
        self.node = transport.Node()
        self.node.Init()
GZ_REGISTER_WORLD_PLUGIN(P)
"""
    (tmp_path / "named.py").write_text(text)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    sdf = "<sdf version='1.6'><world name='{}'><plugin name='p' filename='libnamed.so'/></world></sdf>"
    with libgz.World.from_string(sdf.format("one")) as one, libgz.World.from_string(sdf.format("two")) as two:
        servers = [companion for world in (one, two) for companion in world.companions]
        nodes = [server.plugins.of_world["p"].plugin.node for server in servers]
        assert [node.GetTopicNamespace() for node in nodes] == ["one", "two"]


def test_a_world_without_plugins_has_topics_as_soon_as_there_is_a_node():
    model = "<model name='m'><link name='l'/></model>"
    with libgz.World.from_string(f"<sdf version='1.6'><world name='quiet'>{model}</world></sdf>") as world:
        node, heard = Node(), []
        node.Init()
        assert node.GetTopicNamespace() == "quiet"
        kept = node.Subscribe("~/pose/info", heard.append)
        world.step(2)
        assert [pose.name for pose in heard[0].pose] == ["m", "m::l"]
        kept.Unsubscribe()


def test_fini_of_a_node_ends_what_it_made(node):
    other = Node()
    other.Init("here")
    got = []
    sub, pub = other.Subscribe("~/a", got.append), other.Advertise(msgs.Int, "~/b")
    other.Fini()
    assert getAdvertisedTopics() == []
    mine = node.Advertise(msgs.Int, "~/a")
    assert not mine.HasConnections()
    with pytest.raises(ClosedError):
        pub.Publish(msgs.Int())
    assert not other.IsInitialized()
    assert sub


def test_the_queue_has_a_limit(node, caplog):
    got = []
    sub = node.Subscribe("~/a", got.append)
    pub = node.Advertise(msgs.Int, "~/a", 3)
    for i in range(6):
        pub.Publish(msgs.Int(data=i))
    manager.ProcessNodes()
    assert [m.data for m in got] == [3, 4, 5]
    assert len(caplog.records) == 1
    assert sub


def test_the_rate_has_a_limit(node):
    got = []
    sub = node.Subscribe("~/a", got.append)
    pub = node.Advertise(msgs.Int, "~/a", 1000, 1e-3)
    for i in range(3):
        pub.Publish(msgs.Int(data=i))
    manager.ProcessNodes()
    assert [m.data for m in got] == [0]
    assert sub


def test_waiting_for_a_connection(node):
    pub = node.Advertise(msgs.Int, "~/a")
    assert not pub.WaitForConnection(0.0)
    assert not pub.WaitForConnection(0.01)
    subs = []
    thread = threading.Timer(0.01, lambda: subs.append(node.Subscribe("~/a", print)))
    thread.start()
    assert pub.WaitForConnection()
    thread.join()
    assert pub.WaitForConnection(0)


@pytest.fixture
def fast_switches():
    """Threads take turns as often as they can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.parametrize("limit", [1, 200])
def test_threads_may_publish(node, fast_switches, limit):
    got = []
    sub = node.Subscribe("~/a", got.append)
    pubs = [node.Advertise(msgs.Vector2d, "~/a", limit) for _ in range(8)]

    def work(n):
        for i in range(200):
            pubs[n].Publish(msgs.Vector2d(x=n, y=i))

    threads = [threading.Thread(target=work, args=(n,)) for n in range(8)]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        manager.ProcessNodes()
    manager.ProcessNodes()
    for n in range(8):
        heard = [m.y for m in got if m.x == n]
        assert heard == list(range(200)) if limit == 200 else heard[-1] == 199  # older ones may be dropped
    assert sub


def test_waiting_messages_are_read_while_threads_publish(node, fast_switches):
    sub = node.Subscribe("~/a", lambda _: None)
    pub, ended = node.Advertise(msgs.Vector2d, "~/a", 50), threading.Event()

    def work():
        while not ended.is_set():
            pub.Publish(msgs.Vector2d())

    thread = threading.Thread(target=work)
    thread.start()
    try:
        for _ in range(300):
            assert len(waiting_messages("/gazebo/here/")) <= 50
    finally:
        ended.set()
        thread.join()
    assert len(waiting_messages("/gazebo/here/")) == pub.GetOutgoingCount()
    assert sub


def test_waiting_messages_are_dropped_although_a_thread_delivers_them(node, monkeypatch):
    class Delivered(deque):
        def remove(self, entry):
            self.clear()
            super().remove(entry)

    monkeypatch.setattr(manager, "queue", Delivered())
    queue_message("/gazebo/here/a", msgs.Vector2d())
    drop_waiting("/gazebo/here/")
    assert waiting_messages("/gazebo/here/") == []


def test_a_handler_of_signals_may_publish_while_its_thread_does(node, monkeypatch):
    got = []
    sub = node.Subscribe("~/a", got.append)
    pub = node.Advertise(msgs.Vector2d, "~/a")

    class Interrupted(deque):
        def append(self, entry):
            super().append(entry)
            if len(self) == 1:
                pub.Publish(msgs.Vector2d(x=2))

    monkeypatch.setattr(manager, "queue", Interrupted())
    thread = threading.Thread(target=pub.Publish, args=(msgs.Vector2d(x=1),), daemon=True)
    thread.start()
    thread.join(10.0)
    assert not thread.is_alive()
    manager.ProcessNodes()
    assert sorted(xs(got)) == [1.0, 2.0]
    assert sub


def test_requests(node):
    answer = node.Advertise(msgs.Response, "~/response")

    def OnRequest(message):
        if message.request == "scale":
            answer.Publish(msgs.Response(id=message.id, request=message.request, response=message.data * 2))

    sub = node.Subscribe("~/request", OnRequest)
    assert request("here", "scale", "ab").response == "abab"
    with pytest.raises(GazeboError, match="did not answer the request 'nothing'"):
        request("here", "nothing", timeout=0.02)
    got = []
    watch = node.Subscribe("~/request", got.append)
    requestNoReply("here", "one")
    requestNoReply(node, "two", "data")
    manager.ProcessNodes()
    assert [(m.request, m.data) for m in got] == [("one", ""), ("two", "data")]
    assert all((sub, watch))
