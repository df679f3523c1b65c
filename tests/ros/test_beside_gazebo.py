"""What gazebo_ros_pkgs said with Gazebo 11.1 in some worlds, field by field beside what libgz says there.

tests/trials/test_ros1_beside_gazebo.py asks them again; tests/data/gazebo_ros.json has what they said.
"""

import json
from pathlib import Path

import pytest
from ros_messages import Tap, differences, digest, last_time
from ros_peers import Service, Talker, ask, wait_for
from ros_scenes import SCENES, values_of

from libgz.ros.packing import codec
from libgz.ros.types import message_type

RECORDED = json.loads((Path(__file__).parents[1] / "data/gazebo_ros.json").read_text())


def listen(master, topics):
    """A tap of topics."""
    addresses = {}
    for topic in topics:
        ((_, uri),) = master.publishers[topic].values()
        code, text, (_, host, port) = ask(uri, "requestTopic", "/tap", topic, [["TCPROS"]])
        assert code == 1, text
        addresses[topic] = host, port
    return Tap(addresses)


def send_commands(master, ros, commands):
    """Send messages before the first step."""
    talkers = []
    for topic, type_, values in commands:
        kind = message_type(type_)
        wait_for(lambda topic=topic: topic in master.subscribers)
        talkers.append(Talker(master, topic, kind.name, kind.md5))
        talkers[-1].send(codec(kind).pack(values_of(values, kind())))
    wait_for(lambda: len(ros.waiting) == len(commands))
    ros.deliver()
    return talkers


def call(master, ros, name):
    """Call a service of std_srvs/Empty before the first step."""
    service = Service(master, name)
    service.send(b"")
    wait_for(lambda: ros.requests)
    ros.deliver()
    assert service.answer() == (True, b"")


@pytest.mark.parametrize("name", SCENES)
def test_topics_say_what_those_of_gazebo_say(name, master, start):
    scene, there = SCENES[name], RECORDED[name]
    core, ros = start(scene.text)
    wait_for(lambda: set(scene.topics) <= set(master.publishers))
    tap = listen(master, scene.topics)
    talkers = send_commands(master, ros, scene.commands)
    for service in scene.calls:
        call(master, ros, service)
    wait_for(lambda: all(ros.node.publication(topic).readers for topic in scene.topics))
    for _ in range(round((scene.seconds + 0.2) * 200)):  # with 10 Hz or more, each topic has said something after it
        core.step(5)
        tap.read()
    wait_for(lambda: all(last_time(tap.messages[topic]) >= scene.seconds for topic in scene.topics), tap.read)
    found = []
    for topic, kind in scene.topics.items():
        said, header = there[topic], tap.headers[topic]
        assert [header["type"], header["md5sum"]] == [kind, said["md5"]]
        here = digest(tap.messages[topic], scene.seconds, [moment for moment, _ in said["samples"]])
        found += differences(topic, said, here, scene.tolerances)
    for one in (*talkers, tap):
        one.close()
    assert not found, "\n".join(found)
