"""C++ plugins of Gazebo classic in worlds: what they see, what they do, and how they fail."""

import gc
import logging
import os
import subprocess
import sys
from pathlib import Path

import pytest

import libgz
from libgz.classic import msgs, transport

WORLD = """\
<sdf version="1.6"><world name="default">{world}
  <model name="robot">
    <link name="base"><inertial><mass>20</mass></inertial>
      <collision name="c"><geometry><box><size>1 1 0.2</size></box></geometry></collision>{visual}</link>
    <link name="arm"><pose>0 0 1 0 0 0.3</pose><inertial><pose>0.1 0 0.2 0 0 0</pose><mass>2</mass></inertial>
      <collision name="shape"><geometry><box><size>0.1 0.1 1</size></box></geometry></collision>
      <sensor name="imu" type="imu"><update_rate>100</update_rate>{sensor}</sensor></link>
    <joint name="hinge" type="revolute"><parent>base</parent><child>arm</child>
      <axis><xyz>0 1 0</xyz><limit><lower>-1.5</lower><upper>1.5</upper></limit></axis></joint>
    {model}
  </model></world></sdf>
"""
CHECKS = '<plugin name="checks" filename="libmodel.so"><check>{}</check><vector unit="m">1 2 3</vector></plugin>'


def world_of(check=None, **parts):
    parts = {"world": "", "visual": "", "sensor": "", "model": CHECKS.format(check) if check else "", **parts}
    return libgz.World.from_string(WORLD.format(**parts))


@pytest.fixture
def said(caplog):
    """What plugins have written to the console."""
    caplog.set_level(logging.DEBUG)
    return lambda: [r.getMessage() for r in caplog.records if r.name.startswith("libgz.classic.console")]


def problems(caplog):
    return [r.getMessage() for r in caplog.records if r.levelno >= logging.ERROR and "console" not in r.name]


@pytest.mark.parametrize("check", ["identity", "values", "events"])
def test_checks_that_the_plugin_makes_itself(place, said, caplog, check):
    with world_of(check) as world:
        world.step(3)
        assert not problems(caplog)
        assert said()[1:] == [f"{check} loaded", "initialized"]
        world.reset()
        assert said()[-1] == "reset at 3"
    gc.collect()
    assert said()[-1] == "deleted"


PYTHON = """
from libgz.classic import *
class Twin(ModelPlugin):
    def Load(self, model, sdf):
        self.model, self.updates = model, 0
        self.connection = event.Events.ConnectWorldUpdateBegin(self.OnUpdate)
    def OnUpdate(self):
        self.updates += 1
        link, joint = self.model.GetLink("arm"), self.model.GetJoint("hinge")
        link.AddForce((0, 3, 0)); link.AddRelativeTorque((0, 0.25, 0)); link.AddLinkForce((1, 0, 0), (0, 0.1, 0))
        if self.updates % 10: return
        pose, frame, centre = link.WorldPose(), self.model.WorldPose(), link.WorldCoGPose()
        numbers = [pose.pos.y, pose.rot.w, frame.pos.x, frame.rot.z, centre.pos.z, link.WorldLinearVel().y,
            link.WorldCoGLinearVel().x, link.WorldAngularVel().z, link.RelativeLinearVel().x,
            link.RelativeAngularVel().y, joint.Position(0), joint.GetVelocity(0)]
        gzmsg << "numbers " << " ".join(map(repr, map(float, numbers)))
GZ_REGISTER_MODEL_PLUGIN(Twin)
"""


def test_both_languages_move_a_model_in_the_same_way_to_the_last_bit(place, said, caplog):
    (place / "twin.py").write_text(PYTHON)
    found = []
    for model in (CHECKS.format("step"), '<plugin name="twin" filename="libtwin.so"/>'):
        with world_of(model=model) as world:
            world.step(200)
        found.append([line for line in said() if line.startswith("numbers")])
        caplog.clear()
    cxx, python = ([[float(word) for word in line.split()[1:]] for line in lines] for lines in found)
    assert len(cxx) == 20
    assert cxx == python


def test_topics_and_threads(place, said, caplog):
    answers, ticks = [], []
    with world_of("topics", world="", model=CHECKS.format("topics") + "") as world:
        node = transport.Node()
        node.Init("default")
        pong = node.Subscribe("~/pong", lambda m: answers.append(m.x))
        ping = node.Advertise(msgs.Vector3d, "~/ping")
        ping.Publish(msgs.Vector3d(x=1.5, y=0, z=0))
        world.step(3)
        assert answers == [2.5]
        assert pong is not None
    with world_of("threads") as world:
        node.Init("default")
        watch = node.Subscribe("~/ticks", lambda m: ticks.append(m.sec))
        for _ in range(1000):
            world.step(10)
            if len(ticks) > 20:
                break
        assert len(ticks) > 20
        assert watch is not None
    assert not problems(caplog)


@pytest.mark.parametrize(
    ("check", "message"),
    [
        ("throws", "it threw std::runtime_error: no luck"),
        ("gzthrows", "it threw gazebo::common::Exception at"),
        ("unknown", "it threw int"),
        ("null", "it threw std::runtime_error: a null pointer was used: one to a gazebo::physics::Link"),
        ("libgz", "ParameterError: position [m]"),
    ],
)
def test_an_exception_stops_one_plugin_with_its_name(place, said, caplog, check, message):
    with world_of(model=CHECKS.format(check), world='<plugin name="hello" filename="libworld.so"/>') as world:
        world.step(2)
        (line,) = problems(caplog)
        assert "the Load function of plugin with name[checks] and filename[libmodel.so]" in line
        assert message in line
        assert "Hello default" in said()
        assert world.GetSimTime() > 0


def test_an_exception_of_a_callback_ends_its_plugin(place, caplog):
    with world_of("fails later") as world:
        world.step(5)
        (line,) = problems(caplog)
        assert "a callback of event WorldUpdateBegin of plugin with name[checks]" in line
        assert "null pointer" in line


@pytest.mark.parametrize(
    ("check", "message", "code"),
    [
        ("segv", "SIGSEGV in Load of plugin 'checks' ({}): the process ends", -11),
        ("exit", "exit() was called in Load of plugin 'checks' ({})", 3),
    ],
)
def test_a_crash_names_plugin_and_function(place, check, message, code):
    (place / "w.world").write_text(WORLD.format(world="", visual="", sensor="", model=CHECKS.format(check)))
    program = "import libgz; libgz.World.from_file('w.world')"
    done = subprocess.run(
        [sys.executable, "-P", "-c", program], capture_output=True, text=True, timeout=120, env=dict(os.environ)
    )
    assert done.returncode == code
    assert message.format(place / "libmodel.so") in done.stderr


def test_all_kinds(place, said, caplog):
    parts = {
        "world": '<plugin name="hello" filename="libworld.so"/>',
        "sensor": '<plugin name="watcher" filename="libsensor.so"/>',
    }
    with world_of(**parts) as world:
        world.step(20)
        lines = said()
        assert "Hello default" in lines
        assert sum(line.startswith("imu 9.") or line.startswith("imu") for line in lines) >= 1
    from libgz.apps.classic_command import SystemPlugins

    with SystemPlugins(["libsystem.so"]) as system:
        system.load(["gzserver", "-s", "libsystem.so"])
        assert "system 3 libsystem.so" in said()
    assert not problems(caplog)


def test_a_wrong_kind_and_a_wrong_version(place, caplog):
    with world_of(world='<plugin name="hello" filename="libmodel.so"/>'):
        assert "detected an incorrect plugin type" in problems(caplog)[0]
    caplog.clear()
    data = (place / "libworld.so").read_bytes()
    start = data.index(b"libgz classic plugin: World; ") + 29
    (place / "libworld.so").write_bytes(data[:start] + b"0" * 16 + data[start + 16 :])
    with world_of(world='<plugin name="hello" filename="libworld.so"/>'):
        assert "was built with another version of libgz or Python; build it again" in problems(caplog)[0]
    caplog.clear()
    (place / "libworld.so").write_bytes(data[:2000])
    with world_of(world='<plugin name="hello" filename="libworld.so"/>'):
        assert "port it to Python" in problems(caplog)[0]


def test_reload_and_unload(place, said, plugins):
    def mapped():
        return Path("/proc/self/maps").read_text().count("libmodel.so")

    with world_of("step") as world:
        world.step()
        assert said()[0] == "made number 1" or said()[0].startswith("made number")
        os.utime(place / "libmodel.so")
        world.reload_plugin("checks")
        world.step()
        assert "deleted" in said()
    gc.collect()
    before = mapped()
    for _ in range(20):
        os.utime(place / "libmodel.so")
        with world_of("identity") as world:
            world.step()
    gc.collect()
    assert mapped() <= before + 5
