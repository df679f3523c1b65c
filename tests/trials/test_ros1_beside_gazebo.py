"""The worlds of tests/ros_scenes.py with the real gazebo_ros_pkgs and Gazebo 11.1, asked again.

LIBGZ_GAZEBO_ROS_ROOT names a root with Gazebo 11.1, roscore and gazebo_ros_pkgs, which is entered by chroot, as root;
LIBGZ_GAZEBO_ROS_LIB the folder in it that has the plugins. With LIBGZ_RECORD=1, what they say is written to
tests/data/gazebo_ros.json; else it is compared with what is there: types and rates.
"""

import contextlib
import json
import os
import signal
import subprocess
import time
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
from ros_messages import Tap, differences, digest, last_time
from ros_peers import Talker, ask
from ros_scenes import SCENES, values_of

from libgz.ros.packing import codec
from libgz.ros.types import message_type

TESTS = Path(__file__).parents[1]
ROOT, LIBRARIES = os.environ.get("LIBGZ_GAZEBO_ROS_ROOT", ""), os.environ.get("LIBGZ_GAZEBO_ROS_LIB", "")
pytestmark = [
    pytest.mark.trial,
    pytest.mark.skipif(not (ROOT and LIBRARIES), reason="LIBGZ_GAZEBO_ROS_ROOT and _LIB name no gazebo_ros_pkgs"),
]
DATA, PORT, DISPLAY = TESTS / "data/gazebo_ros.json", 21611, ":97"
URI = f"http://127.0.0.1:{PORT}/"
ENVIRONMENT = {
    "DISPLAY": DISPLAY,
    "GAZEBO_MASTER_URI": "http://127.0.0.1:21612",
    "GAZEBO_MODEL_DATABASE_URI": "",
    "GAZEBO_PLUGIN_PATH": LIBRARIES,
    "GAZEBO_RESOURCE_PATH": "/usr/share/gazebo-11",
    "HOME": "/root",
    "LD_LIBRARY_PATH": LIBRARIES,
    "PATH": "/usr/sbin:/usr/bin:/sbin:/bin",
    "ROS_IP": "127.0.0.1",
    "ROS_MASTER_URI": URI,
}


def wait_until(condition, patience=60.0):
    end = time.monotonic() + patience
    while not (value := condition()):
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.1)
    return value


@contextlib.contextmanager
def running(*command):
    process = subprocess.Popen(command, env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(30)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def known(which):
    """What the master knows: publishers (0) or subscribers (1) of topics, or services (2)."""
    return {name: nodes[0] for name, nodes in ask(URI, "getSystemState", "/tester")[2][which]}


def answers():
    with contextlib.suppress(OSError):
        return bool(ask(URI, "getPid", "/tester"))
    return False


def call(service):
    subprocess.run(["chroot", ROOT, "rosservice", "call", service], env=ENVIRONMENT, check=True, capture_output=True)


def said(scene, world):
    """What Gazebo says in a world: the topics' digests."""
    with contextlib.ExitStack() as stack:
        stack.enter_context(running("chroot", ROOT, "roscore", "-p", str(PORT)))
        wait_until(answers)
        ask(URI, "setParam", "/tester", "/use_sim_time", True)  # before Gazebo starts, or it stamps with real time
        system = ("-s", "libgazebo_ros_paths_plugin.so", "-s", "libgazebo_ros_api_plugin.so")
        stack.enter_context(running("chroot", ROOT, "gzserver", "-u", *system, f"/tmp/{world.name}"))
        wait_until(lambda: set(scene.topics) <= set(known(0)) and "/gazebo/unpause_physics" in known(2))
        nodes, addresses = known(0), {}
        for topic in scene.topics:
            uri = ask(URI, "lookupNode", "/tester", nodes[topic])[2]
            addresses[topic] = tuple(ask(uri, "requestTopic", "/tap", topic, [["TCPROS"]])[2][1:])
        tap = Tap(addresses)
        stack.callback(tap.close)
        calls = {name: partial(ask, URI, name) for name in ("registerPublisher", "unregisterPublisher")}
        master = SimpleNamespace(**calls, sockets=[])
        for topic, type_, values in scene.commands:
            kind = message_type(type_)
            wait_until(lambda topic=topic: topic in known(1))
            master.subscribers = known(1)
            talker = Talker(master, topic, kind.name, kind.md5)
            stack.callback(talker.close)
            talker.send(codec(kind).pack(values_of(values, kind())))
        for service in scene.calls:
            wait_until(lambda service=service: service in known(2))
            call(service)
        time.sleep(1.0)  # the command is taken by another thread of Gazebo, which does not say when
        call("/gazebo/unpause_physics")
        end = time.monotonic() + 60.0
        while min(last_time(tap.messages[topic]) for topic in scene.topics) < scene.seconds:
            assert time.monotonic() < end, {topic: len(found) for topic, found in tap.messages.items()}
            tap.read(0.05)
        return {
            topic: {"md5": tap.headers[topic]["md5sum"], **digest(messages, scene.seconds)}
            for topic, messages in tap.messages.items()
        }


def test_gazebo_says_it_again():
    """Types and rates; values are printed where they differ: times of Gazebo's messages are others in each run."""
    found, recorded = {}, json.loads(DATA.read_text()) if DATA.exists() else {}
    with running("Xvfb", DISPLAY, "-screen", "0", "640x480x24"):
        for name, scene in SCENES.items():
            world = Path(ROOT) / "tmp" / f"libgz-{name}.world"
            world.write_text(scene.text)
            try:
                found[name] = said(scene, world)
            finally:
                world.unlink()
    if os.environ.get("LIBGZ_RECORD"):
        lines = [f"{json.dumps(name)}: {json.dumps(said)}" for name, said in found.items()]
        DATA.write_text("{\n" + ",\n".join(lines) + "\n}\n")
        return
    for name, topics in recorded.items():
        for topic, there in topics.items():
            again = found[name][topic]
            assert again["md5"] == there["md5"], topic
            assert again["gap"] == pytest.approx(there["gap"], rel=0.05, abs=2e-3), topic
            print(*differences(topic, there, again, SCENES[name].tolerances), sep="\n")
