"""C++ plugins of Gazebo classic in worlds: what they see, what they do, and how they fail."""

import gc
import json
import logging
import os
import subprocess
import sys
from pathlib import Path

import pytest
from topics import Heard

import libgz
from libgz.apps.classic_command import SystemPlugins
from libgz.base.errors import NotFoundError, StateError, WorldFileError
from libgz.classic import msgs, physics, transport
from libgz.classic.math import Pose3d
from libgz.classic.sensors import SensorManager, SensorNoiseType, get_sensor
from libgz.classic.sensors.kinds import OWN
from libgz.classic.sensors.sensor import SensorCategory

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
  </model><light name="lamp" type="point"><pose>0 0 3 0 0 0</pose></light></world></sdf>
"""
COUNTER = "<pose>1 0 0 0 0 0</pose><update_rate>100</update_rate><topic>~/counts</topic>"
VISUAL = '<visual name="seen"><geometry><sphere><radius>0.1</radius></sphere></geometry></visual>'
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


@pytest.mark.parametrize("check", ["identity", "values", "results", "events"])
def test_checks_that_the_plugin_makes_itself(place, said, caplog, check):
    with world_of(check, visual=VISUAL) as world:
        world.step(3)
        assert not problems(caplog)
        assert said()[1:] == [f"{check} loaded", "initialized"]
        world.reset()
        assert said()[-1] == "reset at 3"
    gc.collect()
    assert said()[-1] == "deleted"


def test_a_plugin_may_remove_its_own_model(place, said, caplog):
    with world_of("remove its model") as world:
        world.step(5)
        gc.collect()
        assert physics.get_world().ModelByName("robot") is None
        assert said()[1:] == ["remove its model loaded", "initialized", "deleted"]
        assert not problems(caplog)


def test_lines_of_a_visual(place, said, caplog):
    with world_of("lines") as world:
        world.step(1)
        assert "lines loaded" in said()
        assert not problems(caplog)


def test_calls_of_classes_leave_no_memory_behind(place):
    with world_of("instances") as world:
        world.step(5)
        gc.collect()
        before = sys.getallocatedblocks()
        world.step(5)
        gc.collect()
        assert sys.getallocatedblocks() - before < 1000  # of 5000 calls


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


JOINTS = """\
<sdf version="1.6"><world name="default"><model name="arms">
  <link name="base"><inertial><mass>20</mass></inertial></link>
  <link name="arm"><pose>0 0 1 0 0 0.3</pose><inertial><pose>0.1 0 0.2 0 0 0</pose><mass>2</mass></inertial></link>
  <link name="drawer"><pose>1 0 1 0 0 0</pose><inertial><mass>1</mass></inertial></link>
  <link name="hand"><pose>2 0 1 0 0 0</pose><inertial><mass>1</mass></inertial></link>
  <joint name="hinge" type="revolute"><parent>base</parent><child>arm</child>
    <axis><xyz>0 1 0</xyz><limit><lower>-1.5</lower><upper>1.5</upper><effort>9</effort></limit></axis></joint>
  <joint name="slide" type="prismatic"><parent>base</parent><child>drawer</child>
    <axis><xyz>0 0 1</xyz><limit><effort>30</effort><velocity>2</velocity></limit></axis></joint>
  <joint name="wrist" type="universal"><parent>base</parent><child>hand</child>
    <axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint>
  {}</model></world></sdf>
"""
TWIN_OF_JOINTS = """
from libgz.classic import *
class Twin(ModelPlugin):
    def Load(self, model, sdf):
        self.model, self.updates = model, 0
        self.connection = event.Events.ConnectWorldUpdateBegin(self.OnUpdate)
    def OnUpdate(self):
        self.updates += 1
        n, line = self.updates, []
        for joint in self.model.GetJoints():
            joint.SetForce(0, 0.9 * n * (-1.0) ** (n // 7)); joint.SetForce(0, 0.125)
            line.append(joint.GetForce(0))
            if n == 20: joint.SetEffortLimit(0, 2.5)
            if n == 30: joint.SetVelocityLimit(0, 0.75)
            if n == 40:
                done = [joint.SetParam("fmax", 0, 3.0), joint.SetParam("vel", 0, -1), joint.SetParam("vel", 0, 1e9)]
                line.append("".join(str(int(one)) for one in done))
            if n == 45: joint.SetParam("vel", 0, -0.4000000059604645)
            if n == 60: joint.SetParam("fmax", 0, -1.0)
            if n == 70: joint.SetParam("friction", 0, 0.25)
            if n == 80: joint.SetParam("stop_erp", 0, 0.5)
            if n == 85: joint.SetParam("hi_stop", 0, 0.5)
            line += [joint.GetParam(key, 0) for key in ("fmax", "vel", "friction", "stop_erp", "hi_stop", "lo_stop")]
            line += [joint.Position(0), joint.GetVelocity(0)]
        gzmsg << "joints " << " ".join(str(float(number)) for number in line)
GZ_REGISTER_MODEL_PLUGIN(Twin)
"""


def test_efforts_and_parameters_of_joints_are_pythons_to_the_last_bit(place, said, caplog, monkeypatch):
    (place / "twin.py").write_text(TWIN_OF_JOINTS)
    found, records, through_python = [], [], []
    for name in ("SetForce", "GetForce", "GetParam"):
        method = getattr(physics.Joint, name)

        def counted(self, *values, name=name, method=method):
            through_python.append((name, self.GetName()))
            return method(self, *values)

        monkeypatch.setattr(physics.Joint, name, counted)
    for model in (CHECKS.format("joints"), '<plugin name="twin" filename="libtwin.so"/>'):
        with libgz.World.from_string(JOINTS.format(model)) as world:
            world.step(120)
            joints = world.models[0].sdf_joints.values()
            records.append([(joint.efforts, joint.record.given) for joint in joints])
        found.append([line for line in said() if line.startswith("joints ") and line != "joints loaded"])
        if len(found) == 1:
            # Hinges and sliders are served without Python, but for a rate that the engine has not computed yet.
            assert len(through_python) > 500
            assert len([name for _, name in through_python if name != "wrist"]) <= 2
        caplog.clear()
    cxx, python = ([[float(word) for word in line.split()[1:]] for line in lines] for lines in found)
    assert len(cxx) == 120
    assert cxx == python
    assert records[0] == records[1]


def test_both_languages_share_a_world_whose_states_keep_what_it_has(place, said, caplog):
    (place / "twin.py").write_text(PYTHON)
    with world_of(model=CHECKS.format("step") + '<plugin name="twin" filename="libtwin.so"/>') as world:
        arm = world.models[0].links["arm"]
        start = arm.GetPose()
        world.step(20)
        state = world.get_state()
        world.step(30)
        after = arm.GetPose(), world.models[0].sdf_joints["hinge"].position()
        world.set_state(state)
        assert world.GetSimTime() == pytest.approx(0.02)
        world.step(30)
        assert (arm.GetPose(), world.models[0].sdf_joints["hinge"].position()) == after
        world.reset()
        assert arm.GetPose() == start
        assert said()[-1] == "reset at 80"  # a state keeps no variables of C++
    assert not problems(caplog)


def test_topics_and_threads(place, said, caplog):
    answers, ticks = [], []
    with world_of("topics", world="", model=CHECKS.format("topics") + "") as world:
        node = transport.Node()
        node.Init("default")
        pong = node.Subscribe("~/pong", lambda m: answers.append(m.x))
        assert transport.TopicManager.Instance().TopicInfo("/gazebo/default/ping").msg_type == "gazebo.msgs.Vector3d"
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
    with SystemPlugins(["libsystem.so"]) as system:
        system.load(["gzserver", "-s", "libsystem.so"])
        assert "system 3 libsystem.so" in said()
    assert not problems(caplog)


def test_a_sensor_of_a_plugins_own_class(place, said, caplog, monkeypatch):
    monkeypatch.delitem(OWN, "counter", raising=False)
    inside = "<always_on>1</always_on>" + COUNTER
    own = f"</sensor><sensor name='own' type='counter'>{inside}"
    with SystemPlugins(["libsystem.so"]) as system:
        with world_of(sensor=own) as world:
            world.step(1)
        assert "type 'counter' is not simulated" in caplog.text
        system.load(["gzserver", "-s", "libsystem.so"])
        assert "counter" in SensorManager.Instance().GetSensorTypes()
        heard = Heard("~/own/counts")
        with world_of(sensor=own) as world:
            assert "counter of robot::arm" in said()
            sensor = get_sensor("default::robot::arm::own")
            measured = []
            connection = sensor.ConnectUpdated(lambda: measured.append(round(sensor.world.SimTime().Double(), 3)))
            world.step(100)
            # Not before IsActive says so; a call of UpdateImpl that fails is repeated after a period.
            assert measured == [0.046, 0.066, 0.076, 0.086, 0.096]
            assert sensor.LastMeasurementTime().Double() == pytest.approx(0.096)
            assert [message.data for message in heard] == [1, 3, 4, 5, 6]
            connection.Disconnect()
        sensor = world = connection = None
        gc.collect()
        assert said()[-2:] == ["counter ends", "own deleted"]
    assert problems(caplog) == [
        "Fini of sensor default::robot::arm::own failed: it threw std::runtime_error: no end",
    ]


def test_a_sensor_of_a_plugins_own_class_measures_while_it_is_active(place, said, caplog, monkeypatch):
    monkeypatch.delitem(OWN, "counter", raising=False)
    with SystemPlugins(["libsystem.so"]) as system:
        system.load(["gzserver", "-s", "libsystem.so"])
        heard = Heard("~/own/counts")
        with world_of(sensor=f"</sensor><sensor name='own' type='counter'>{COUNTER}") as world:
            sensor = get_sensor("default::robot::arm::own")
            assert (sensor.Category(), sensor.UpdateRate(), sensor.Pose().Pos().X()) == (SensorCategory.RAY, 100.0, 1.0)
            assert sensor.Topic() == "~/own/counts"
            connection = sensor.ConnectUpdated(lambda: None)  # which asks for nothing, as in Gazebo
            world.step(60)
            assert not sensor.IsActive()
            sensor.Update(True)
            sensor.Update(True)  # fails
            world.step(1)
            assert [message.data for message in heard] == [-1]
            sensor.SetActive(True)
            sensor.SetUpdateRate(50.0)
            world.step(20)
            times = sensor.LastUpdateTime(), sensor.LastMeasurementTime()
            state = world.get_state()
            world.step(50)
            noises = [line for line in said() if line.startswith("noise")]
            sensor.SetActive(False)
            world.set_state(state)
            assert sensor.IsActive()
            assert (sensor.LastUpdateTime(), sensor.LastMeasurementTime()) == times
            world.step(50)
            again = [line for line in said() if line.startswith("noise")][len(noises) :]
            assert len(again) == 2
            assert again == noises[-2:]
            sensor.SetPose(Pose3d(2, 0, 0, 0, 0, 0))
            assert sensor.world_pose().pos != sensor.link.pose().pos
            sensor.LoadState(sensor.SaveState())
            with pytest.raises(StateError, match="it has not the numbers of a sensor"):
                sensor.LoadState((0.0, float("nan")))
            with pytest.raises(NotFoundError, match=r"has no noise .*; it has RAY_NOISE"):
                sensor.Noise(SensorNoiseType.CAMERA_NOISE)
            assert connection is not None
    assert not [line for line in problems(caplog) if "no end" not in line]


def test_a_factory_that_makes_no_sensor_is_named(place, caplog, monkeypatch):
    monkeypatch.delitem(OWN, "counter", raising=False)
    monkeypatch.delitem(OWN, "nothing", raising=False)
    with SystemPlugins(["libsystem.so"]) as system:
        system.load(["gzserver", "-s", "libsystem.so"])
        with pytest.raises(WorldFileError, match="the factory of sensors of type nothing made none"):
            world_of(sensor="</sensor><sensor name='none' type='nothing'>")


def derived(name, inside, **parts):
    """A world with a plugin that is derived from one of Gazebo."""
    return world_of(model=f'<plugin name="own" filename="lib{name}.so">{inside}</plugin>', **parts)


def test_a_plugin_derived_from_the_battery_is_used_up_by_its_own_consumer(place, said, caplog):
    cell = {"link_name": "arm", "battery_name": "main", "open_circuit_voltage_constant_coef": 12,
            "open_circuit_voltage_linear_coef": -2, "initial_charge": 0.01, "capacity": 0.01, "resistance": 0.5,
            "smooth_current_tau": 0.05}  # fmt: skip
    inside = "".join(f"<{tag}>{value}</{tag}>" for tag, value in cell.items())
    battery = "</sensor><battery name='main'><voltage>12</voltage></battery><sensor name='more' type='imu'>"
    with derived("battery", inside, sensor=battery) as world:
        world.step(200)
        assert not problems(caplog)
        used = [float(part) for part in said()[-1].split()[1:]]
    voltage = 12.0 - 2.0 * used[0] * 1e-6 / 0.01 - 0.5 * used[1]
    assert used[1] == pytest.approx(12.0 / voltage, rel=0.05)
    assert used[0] == pytest.approx(1e6 * 1.05 * (0.2 - 0.05) / 3600.0, rel=0.05)


def test_plugins_derived_from_those_of_models(place, caplog):
    limit = "<limit><lower>-10</lower><upper>10</upper></limit>"
    up = f"<axis><xyz>0 0 1</xyz>{limit}</axis>"
    joint = f'<joint name="rope" type="prismatic"><parent>world</parent><child>base</child>{up}</joint>'
    pid = "<p>{}</p><cmd_min>-9000</cmd_min><cmd_max>9000</cmd_max>"
    controllers = f"<pos_pid>{pid.format(5000)}</pos_pid><vel_pid>{pid.format(5000)}</vel_pid>"
    with derived("winch", f"{joint}<winch><joint>rope</joint>{controllers}</winch><detach>rope</detach>") as world:
        model = physics.get_world().ModelByName("robot")
        world.step(900)
        assert model.GetJoint("rope").GetVelocity(0) == pytest.approx(-0.5, abs=0.05)
        world.step(200)
        assert model.GetJoint("rope") is None
    wheel = "<wheel link_name='arm'><wheel_normal_force>10</wheel_normal_force><wheel_radius>0.1</wheel_radius></wheel>"
    with derived("wheels", wheel) as world:
        model = physics.get_world().ModelByName("robot")
        model.GetJoint("hinge").SetVelocity(0, 2.0)
        spin = model.GetJoint("hinge").GetVelocity(0)
        world.step(1)
        surface = model.GetLink("arm").GetCollision("shape").GetSurface()
        assert (surface.slip1, surface.slip2) == pytest.approx((0.01 * spin * 0.25, 0.01 * spin * 0.5))
    names = "<lift_joint>hinge</lift_joint><door_joint>hinge</door_joint><topic>~/elevator</topic>"
    gains = "".join(f"<{tag}><p>1000</p><d>500</d></{tag}>" for tag in ("lift_pid", "door_pid"))
    with derived("elevator", f"{names}{gains}<floor_height>0.5</floor_height>") as world:
        world.step(2000)
        joint = physics.get_world().ModelByName("robot").GetJoint("hinge")
        assert joint.Position(0) == pytest.approx(0.75, abs=0.01)  # between the floor's 0.5 and the open doors' 1
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


LOADS = """
import gc, json, logging, os, re, sys, tempfile
from pathlib import Path
import libgz
logging.disable()
resident = re.compile(r"^VmRSS:\\s+(\\d+) kB", re.MULTILINE)

def load(times):
    for number in range(times):
        os.utime("libmodel.so")
        with libgz.World.from_string(texts[number % len(texts)]) as world:
            world.step(2)
        del world
    gc.collect()
    copies = Path(tempfile.gettempdir()).glob(f"libgz-plugin-{os.getpid()}-*")
    counts = [len(list(Path("/proc/self", name).iterdir())) for name in ("fd", "task")]
    memory = int(resident.search(Path("/proc/self/status").read_text())[1])
    return memory, Path("/proc/self/maps").read_text().count("libmodel.so"), *counts, len(list(copies))

texts = json.load(sys.stdin)
print(json.dumps([load(100), load(1000)]))
"""


@pytest.mark.trial
def test_a_thousand_loads_and_unloads_leave_nothing(place):
    """Each load is of a file that was built again: nothing of the one before may stay."""
    checks = ("step", "topics", "events", "throw in Load", "throw in OnUpdate", "joints", "identity", "threads")
    texts = [WORLD.format(world="", visual="", sensor="", model=CHECKS.format(check)) for check in checks]
    done = subprocess.run(
        [sys.executable, "-P", "-c", LOADS], input=json.dumps(texts), capture_output=True, text=True, check=False
    )
    before, after = json.loads(done.stdout)
    assert after[1] <= before[1] + 5, (before, after)
    assert after[2:] == before[2:], (before, after)
    assert after[0] < before[0] + 8_000, (before, after)  # memory [kB]
