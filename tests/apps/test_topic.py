"""The command `libgz topic`, in a process of its own."""

import json
import re
import subprocess
import sys
import time

import pytest
from master_uri import free_master_uri

from libgz.classic import msgs
from libgz.classic.transport import Node, TopicManager, fini, run, serve

manager = TopicManager.Instance()


@pytest.fixture(scope="module", autouse=True)
def server():
    """A server with one world, which delivers messages in a thread."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("GAZEBO_MASTER_URI", free_master_uri())
        with serve():
            manager.AddTopicNamespace("w")
            run()
            yield
        fini()
        manager.RemoveTopicNamespace("w")


@pytest.fixture
def node():
    node = Node()
    node.Init("w")
    yield node
    node.Fini()


def wait(condition):
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end, "it did not come"
        time.sleep(0.002)


def topic(*words, code=0):
    """What the command prints; with another exit code, on stderr."""
    command = [sys.executable, "-m", "libgz.apps.libgz", "topic", *words]
    done = subprocess.run(command, capture_output=True, text=True, timeout=30)
    assert done.returncode == code, done.stderr
    return done.stderr if code else done.stdout


def test_list_and_info(node):
    ends = [node.Advertise(msgs.Pose, "~/b"), node.Advertise(msgs.Int, "~/a"), node.Subscribe("~/b", print)]
    assert json.loads(topic("-l", "--json")) == ["/gazebo/w/a", "/gazebo/w/b"]
    ends += [node.Subscribe("~/c", print, kind=msgs.Wind), node.Subscribe("~/d", print)]
    about = json.loads(topic("-i", "~/b", "--json"))
    assert (about["topic"], about["type"], len(about["publishers"])) == ("/gazebo/w/b", "gazebo.msgs.Pose", 1)
    assert json.loads(topic("-i", "/gazebo/w/c", "--json"))["type"] == "gazebo.msgs.Wind"
    ends.append(node.Subscribe("~/e\x1b[2J\nf", print))  # peers name topics, too: none commands a terminal
    assert topic("-l").splitlines() == [f"/gazebo/w/{name}" for name in ("a", "b", "c", "d", "e\\x1b[2J\\nf")]
    text = topic("-i", "~/b")
    assert re.fullmatch(r"Type: gazebo.msgs.Pose\n\nPublishers:\n\t.*, process \d+\n\nSubscribers:\n\t.*\n", text)
    assert "did you mean '/gazebo/w/a'" in topic("-i", "~/aa", code=1)
    assert len(ends) == 6


def test_echo(node):
    publisher = node.Advertise(msgs.Vector3d, "~/v")
    publisher.Publish(msgs.Vector3d(x=1, y=float("inf")))
    assert topic("-e", "/gazebo/w/v", "-n", "1") == "x: 1\ny: inf\nz: 0\n\n"
    assert json.loads(topic("-e", "~/v", "-w", "w", "-u", "-n", "1")) == {"x": 1.0, "y": float("inf"), "z": 0.0}


def test_rate_and_bandwidth(node):
    publisher = node.Advertise(msgs.Vector3d, "~/v")
    for option, pattern in [
        ("-z", r"Hz: +\d+\.\d\d\n"),
        ("-b", r"Total\[.*/s\] Mean\[27.00 B\] Min.* Messages\[\d+\]\n"),
    ]:
        command = [sys.executable, "-m", "libgz.apps.libgz", "topic", option, "~/v", "-n", "50"]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert publisher.WaitForConnection(20.0)
        while process.poll() is None:
            publisher.Publish(msgs.Vector3d(x=1))
            publisher.WaitForConnection(0.002)
        assert re.fullmatch(f"({pattern})+", process.communicate()[0])
        wait(lambda: not publisher.HasConnections())


def test_publish(node, tmp_path):
    got = []
    sub = node.Subscribe("~/v", got.append)
    assert "is not known; give it by -t, such as -t Vector3d" in topic("-p", "~/v", "-m", "x: 1", code=1)
    topic("-p", "~/v", "-t", "Vector3d", "-m", "x: 1")
    publisher = node.Advertise(msgs.Vector3d, "~/v")
    topic("-p", "/gazebo/w/v", "-m", '{"y": 2}')
    (tmp_path / "message").write_text("x: 3\nz: 4\n")
    topic("-p", "~/v", "-f", str(tmp_path / "message"))
    assert "there is no" in topic("-p", "~/v", "-t", "Vectr3d", "-m", "x: 1", code=1)
    assert 'has no field named "w"' in topic("-p", "~/v", "-m", "w: 1", code=1)
    assert "not valid JSON" in topic("-p", "~/v", "-m", "{x: 1}", code=1)
    assert "-m TEXT or -f FILE" in topic("-p", "~/v", code=1)
    assert "cannot be advertised with" in topic("-p", "~/v", "-t", "Pose", "-m", "", code=1)
    assert "/gazebo/w/u has no subscribers" in topic("-p", "~/u", "-t", "Int", "-m", "", "-d", "0", code=1)
    wait(lambda: len(got) == 3)
    assert [(m.x, m.y, m.z) for m in got] == [(1, 0, 0), (0, 2, 0), (3, 0, 4)]
    assert sub
    assert publisher


def test_publish_where_only_a_subscriber_names_the_type(node):
    got = []
    sub = node.Subscribe("~/commands", got.append, kind="Vector3d")
    topic("-p", "~/commands", "-m", "x: 1")
    wait(lambda: got)
    assert (type(got[0]), got[0].x) == (msgs.Vector3d, 1)
    assert "did you mean '/gazebo/w/commands'" in topic("-p", "~/comands", "-m", "x: 1", code=1)
    assert sub


def test_request(node):
    got = []
    answer = node.Advertise(msgs.Response, "~/response")

    def OnRequest(message):
        got.append(message.request)
        packed = msgs.Model(name=message.data).SerializeToString()
        if message.request == "entity_info":
            answer.Publish(
                msgs.Response(id=message.id, request=message.request, type="gazebo.msgs.Model", serialized_data=packed)
            )

    sub = node.Subscribe("~/request", OnRequest)
    text = topic("-r", "entity_info", "-m", "box")
    assert 'request: "entity_info"' in text
    assert text.endswith('gazebo.msgs.Model:\nname: "box"\n')
    assert topic("-r", "entity_delete", "-m", "box", "-d", "0") == ""
    assert "did not answer the request 'other'" in topic("-r", "other", "-d", "0.1", code=1)
    wait(lambda: got[:2] == ["entity_info", "entity_delete"])
    assert sub


def test_the_command_line_is_checked():
    assert "one of the arguments" in topic(code=2)
    assert "not allowed with" in topic("-l", "-e", "a", code=2)
    assert "must not be negative" in topic("-l", "-d", "-1", code=1)
    assert "at least 1" in topic("-l", "-n", "0", code=1)
