"""The plugins that come with libgz, each against a formula."""

import gc
import json
import math
import os
import subprocess
import sys
import textwrap

import pytest
from plugin_worlds import GROUND, HINGE, body, collision, command, plugin, wheel

from libgz.classic import gui, msgs, transport
from libgz.classic.loading import new_plugin
from libgz.classic.math import Quaterniond
from libgz.classic.server import attach
from libgz.sdf.element import Element

# Wheels --------------------------------------------------------------------------------------------------------------


def pioneer(*plugins, pose="0 0 0 0 0 0"):
    return f"{GROUND}<include><uri>model://pioneer2dx</uri><pose>{pose}</pose>{''.join(plugins)}</include>"


# The wheels have their speed at the beginning of each step, and lose some of it in turns; a torque is unused.
@pytest.mark.parametrize("torque", [{}, {"torque": 5}])
def test_diff_drive_turns_at_the_commanded_rate_right_if_positive(torque, run):
    wheels = {"left_joint": "left_wheel_hinge", "right_joint": "right_wheel_hinge"}
    core, world = run(pioneer(plugin("DiffDrivePlugin", **wheels, **torque), pose="0 0 0 0 0 0.7"))
    robot = world.ModelByName("pioneer2dx")
    kept = command("~/pioneer2dx/vel_cmd", 0.0, 0.5)
    core.run(2.0)
    assert robot.WorldPose().Yaw() == pytest.approx(0.7 - 0.5 * 2.0, abs=0.2)
    rates = [robot.GetJoint(f"{side}_wheel_hinge").GetVelocity(0) for side in ("left", "right")]
    assert rates == pytest.approx([0.5 * 0.175 / 0.095, -0.5 * 0.175 / 0.095], rel=0.4)
    core.Reset()
    core.run(0.5)
    assert robot.GetJoint("left_wheel_hinge").GetVelocity(0) == pytest.approx(0.0, abs=0.06)
    del kept


def test_diff_drive_reports_missing_elements(run, caplog):
    run(pioneer(plugin("DiffDrivePlugin", left_joint="left_hinge", right_joint="right_wheel_hinge")))
    assert "has no joint 'left_hinge'" in caplog.text
    run(pioneer(plugin("DiffDrivePlugin", left_joint="left_wheel_hinge")))
    assert "<right_joint> is missing" in caplog.text
    assert "Traceback" not in caplog.text  # the world's file is wrong, not the plugin's code
    assert 'File "' not in caplog.text


def four_wheels():
    places = {
        "left_front": (0.2, 0.2),
        "right_front": (0.2, -0.2),
        "left_rear": (-0.2, 0.2),
        "right_rear": (-0.2, -0.2),
    }
    wheels = "".join(wheel(name, *place) for name, place in places.items())
    base = "<link name='base'><pose>0 0 0.15 0 0 0</pose><inertial><mass>5</mass></inertial></link>"
    return f"<model name='rover'>{base}{wheels}{plugin('SkidSteerDrivePlugin')}</model>"


def test_skid_steer_drives_both_sides(run):
    core, world = run(GROUND, four_wheels())
    rover = world.ModelByName("rover")
    kept = command("~/rover/vel_cmd", 0.5)
    core.run(2.0)
    assert rover.WorldPose().Pos().X() < 0.5  # one message gives the wheels their velocity once
    begin = rover.WorldPose().Pos().X()
    for _ in range(300):
        kept = command("~/rover/vel_cmd", 0.5)
        core.run(0.01)
    assert rover.WorldPose().Pos().X() - begin == pytest.approx(1.5, abs=0.1)
    for _ in range(1000):
        kept = command("~/rover/vel_cmd", 0.0, 0.5)
        core.step(1)
    rates = {name: rover.GetJoint(name).GetVelocity(0) for name in ("left_front", "right_rear")}
    assert rates == pytest.approx({"left_front": -0.5 * 0.4 / 0.1, "right_rear": 0.5 * 0.4 / 0.1}, abs=0.02)
    assert rover.WorldPose().Yaw() > 0.005  # wheels that are set by their velocity turn it slowly; 0.07 in Gazebo 11.1
    del kept


# The legacy era ------------------------------------------------------------------------------------------------------

POSITION = {"leftJoint": "left_wheel_hinge", "rightJoint": "right_wheel_hinge", "id": "robot1"}


def test_position_serves_odometry_of_the_wheels_and_obeys(run):
    core, world = run(pioneer(plugin("libgz_position", **POSITION)))
    robot, position = world.ModelByName("pioneer2dx"), core.interface("position", "robot1")
    position.command(vx=0.3, vyaw=0.4)
    core.run(4.0)
    pose, (x, y, yaw) = robot.WorldPose(), position.pose
    assert yaw == pytest.approx(0.4 * 4.0, abs=0.06)  # left is positive
    # An arc: radius 0.3 / 0.4.
    assert (x, y) == pytest.approx((0.75 * math.sin(1.6), 0.75 * (1.0 - math.cos(1.6))), abs=0.06)
    assert (pose.Pos().X(), pose.Pos().Y(), pose.Yaw()) == pytest.approx((x, y, yaw), abs=0.12)
    assert position.vel_pos[0] == pytest.approx(0.3, abs=0.01)
    assert position.vel_rot[2] == pytest.approx(0.4, abs=0.02)
    position.enable_motors(False)
    core.run(0.5)
    assert robot.WorldLinearVel().Length() < 0.01


def test_position_begins_again_after_a_reset_and_doubts_wild_numbers(run, caplog):
    core, _ = run(pioneer(plugin("libgz_position", **POSITION, torque=5)))
    position = core.interface("position", "robot1")
    position.command(vx=0.2)
    core.run(1.0)
    core.Reset()
    core.run(0.5)
    assert position.pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
    position.command(vx=0.2)
    core.run(1.0)
    assert position.pose[0] == pytest.approx(0.2, abs=0.02)
    position.data.cmd_vel_pos[0] = math.nan  # as a C program may write
    core.run(1.0)
    assert position.pose[0] == pytest.approx(0.4, abs=0.02)
    assert "is nan, and is ignored" in caplog.text


@pytest.fixture
def no_collection():
    """Python collects nothing meanwhile, so that objects that refer to each other stay."""
    gc.disable()
    yield
    gc.enable()


@pytest.mark.usefixtures("no_collection")
def test_position_is_served_by_a_plugin_that_took_the_place_of_another(run, caplog):
    core, world = run(pioneer(plugin("libgz_position", **POSITION)))
    core.run(0.1)
    state = core.get_state()
    for name in ("other", "libgz_position"):  # as in the state of a world that was changed so
        (loaded,) = attach(core).plugins.of_model(world.ModelByName("pioneer2dx"))
        loaded.name = name
        core.set_state(state)
        assert core.get_state() == state
    (loaded,) = attach(core).plugins.of_model(world.ModelByName("pioneer2dx"))
    loaded.drop()
    assert "robot1" not in {name for _, name in core.gz_server.interfaces}
    core.set_state(state)
    assert core.get_state() == state
    core.reload_plugin("libgz_position")
    core.interface("position", "robot1").command(vx=0.3)
    core.run(0.5)
    assert core.interface("position", "robot1").vel_pos[0] == pytest.approx(0.3, abs=0.02)
    assert "second" not in caplog.text


CLIENT = """
import sys, time, libgz
with libgz.Client(int(sys.argv[1])) as client:
    position = client.position("robot1")
    position.command(vx=0.25)
    end = time.monotonic() + 60.0
    while position.pose[0] < 0.2 and time.monotonic() < end:
        client.wait()
    print(f"{position.pose[0]:.3f}")
"""


def test_position_is_driven_by_a_client_in_another_process(run, monkeypatch, tmp_path):
    server_id = 300 + os.getpid() % 600
    monkeypatch.setenv("TMP", str(tmp_path))
    core, world = run(pioneer(plugin("libgz_position", **POSITION)), server_id=server_id)
    client = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(CLIENT), str(server_id)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    for _ in range(60_000):
        core.step()
        if client.poll() is not None:
            break
    out, error = client.communicate(timeout=10)
    assert client.returncode == 0, error
    assert float(out) >= 0.2
    assert world.ModelByName("pioneer2dx").WorldPose().Pos().X() > 0.18


LEGACY = """
<plugin name='legacy' filename='libgz_legacy.so'>
  <model:Pioneer2AT xmlns:model='http://playerstage.sourceforge.net/gazebo/xmlschema/#model'>
    <id>robot1</id><xyz>0 0 0</xyz>
  </model:Pioneer2AT>
  <model:SimpleSolid xmlns:model='http://playerstage.sourceforge.net/gazebo/xmlschema/#model'>
    <id>ball</id><xyz>0 2 1</xyz><shape>sphere</shape><size>0.5</size>
  </model:SimpleSolid>
</plugin>
"""


def test_legacy_models_drive_among_sdf_models_and_all_are_reset(run):
    shape = "<box><size>0.5 0.5 0.5</size></box>"
    core, world = run(GROUND, body("box", "1.0 0 0.25 0 0 0", 2.0, link=collision(shape)), LEGACY)
    places = {model.GetName(): model.WorldPose().Pos() for model in world.Models()}
    assert set(places) == {"ground_plane", "box", "robot1", "ball"}
    for _ in range(2):
        core.interface("position", "robot1").command(vx=0.3)
        core.run(5.0)
        assert world.ModelByName("robot1").WorldPose().Pos().X() == pytest.approx(1.5, abs=0.1)
        assert core.interface("position", "robot1").time == pytest.approx(5.0, abs=0.11)
        assert world.ModelByName("box").WorldPose().Pos().X() > 1.8  # pushed along
        assert world.ModelByName("ball").WorldPose().Pos().Z() < 0.6
        core.Reset()
        for name, place in places.items():
            assert world.ModelByName(name).WorldPose().Pos().Equal(place, 1e-12), name


def test_errors_of_legacy_models_are_reported_and_the_world_runs(run, caplog):
    text = "<model:Pioneer3AT xmlns:model='model'><id>a</id></model:Pioneer3AT>"
    core, world = run(GROUND, f"<plugin name='legacy' filename='libgz_legacy.so'>{text}</plugin>")
    core.step(2)
    assert "Pioneer3AT" in caplog.text
    assert "This plugin will not run." in caplog.text
    assert world.ModelCount() == 1


# Events --------------------------------------------------------------------------------------------------------------

SIM_EVENTS = """
<plugin name='events' filename='libSimEventsPlugin.so'>
  <region><name>below</name><volume><min>-1 -1 -99</min><max>1 1 4</max></volume></region>
  <event><name>fallen</name><type>inclusion</type><model>stone</model><region>below</region></event>
  <event><name>quiet</name><type>inclusion</type><active>false</active><model>stone</model><region>below</region></event>
  <event><name>turned</name><type>joint</type><model>whe</model><joint>axle</joint>
    <range><type>normalized_angle</type><min>3</min></range></event>
  <event><name>new</name><type>existence</type><model>guest</model></event>
  <event><name>pause</name><type>sim_state</type></event>
  <event><name>full</name><type>occupied</type><region>below</region><topic>~/full</topic><msg_data>yes</msg_data></event>
</plugin>
"""


def test_sim_events_are_published_when_they_happen(run):
    axle = HINGE.format(name="axle")
    spin = plugin("InitialVelocityPlugin", angular="0 0 2")
    core, world = run(body("stone", "0 0 5 0 0 0"), body("wheel", "5 0 5 0 0 0", inside=axle + spin), SIM_EVENTS)
    node, received, full = transport.Node(), [], []
    node.Init("default")
    kept = [node.Subscribe("/gazebo/sim_events", received.append), node.Subscribe("~/full", full.append)]
    core.run(3.0)

    # The stone is 1 m lower after sqrt(2 / 9.8) s; the wheel is at 3 rad after 1.5 s, and back at -pi after 1.57 s.
    times = [(m.name, json.loads(m.data)["state"], m.world_statistics.sim_time) for m in received]
    found = [(name, state, time.sec + 1e-9 * time.nsec) for name, state, time in times]
    assert [(name, state) for name, state, _ in found] == [
        ("fallen", "inside"), ("turned", "in_range"), ("turned", "out_of_range"),
    ]  # fmt: skip
    assert [time for _, _, time in found] == pytest.approx([math.sqrt(2.0 / 9.8), 1.5, math.pi / 2.0], abs=3e-3)
    assert json.loads(received[0].data) == {"state": "inside", "region": "below", "model": "stone"}
    assert received[0].type == "inclusion"
    assert {message.data for message in full} == {"yes"}
    assert len(full) == pytest.approx((3.0 - math.sqrt(2.0 / 9.8)) / 0.001, abs=3)

    received.clear()
    world.InsertModelString(f"<sdf version='1.6'>{body('guest_7', '0 0 50 0 0 0')}</sdf>")
    core.step(2)
    world.RemoveModel("guest_7")
    core.step(2)
    world.SetPaused(True)
    world.SetPaused(False)
    core.step(2)
    assert [(m.name, json.loads(m.data)["state"]) for m in received] == [
        ("new", "creation"), ("new", "deletion"), ("pause", "paused"), ("pause", "running"),
    ]  # fmt: skip
    assert json.loads(received[0].data)["model"] == "guest_7"
    del kept


def test_sim_events_tell_what_they_do_not_know(run, caplog):
    for wrong in ("<type>inclusoin</type>", "<type>inclusion</type><region>nowhere</region>"):
        caplog.clear()
        run(f"<plugin name='events' filename='libSimEventsPlugin.so'><event><name>a</name>{wrong}</event></plugin>")
        assert "did you mean 'inclusion'" in caplog.text or "there is no region 'nowhere'" in caplog.text


# Keys ----------------------------------------------------------------------------------------------------------------


def test_plane_demo_is_flown_by_keys(run):
    text = """
    <plugin name='plane' filename='libPlaneDemoPlugin.so'>
      <engine><joint_name>j</joint_name><inc_key>119</inc_key><dec_key>115</dec_key>
        <inc_val>0.5</inc_val><min_val>-1</min_val><max_val>1</max_val></engine>
      <thruster><link_name>link</link_name><inc_key>116</inc_key><dec_key>103</dec_key>
        <inc_val>0 0 2</inc_val><min_val>0 0 0</min_val><max_val>0 0 3</max_val></thruster>
    </plugin>"""
    axle = HINGE.format(name="j").replace("child>link", "child>rotor").replace("parent>world", "parent>link")
    rotor = "<link name='rotor'><gravity>false</gravity></link>"
    core, world = run(body("plane", inside=rotor + axle + text, gravity="false"))
    plane = world.ModelByName("plane")
    node = transport.Node()
    node.Init("default")
    publisher = node.Advertise(msgs.Any, "~/keyboard/keypress")

    def press(*keys):
        for key in keys:
            publisher.Publish(msgs.Any(int_value=key))
        core.step()

    press(*[ord("w")] * 3, ord("t"), ord("t"), ord("x"))
    plane.SetLinearVel((0, 0, 0))
    core.step(100)
    assert plane.GetJoint("j").GetVelocity(0) == pytest.approx(2.0 * 1.0 * 0.1, rel=1e-3)  # both have 1 kg m^2
    assert plane.WorldLinearVel().Z() == pytest.approx(3.0 / 2.0 * 0.1, rel=1e-3)  # of 2 kg
    core.Reset()
    core.step(50)
    assert plane.WorldLinearVel().Length() == pytest.approx(0.0, abs=1e-9)


def test_plane_demo_holds_its_control_surfaces(run):
    text = """
    <plugin name='plane' filename='libPlaneDemoPlugin.so'>
      <control><joint_name>j</joint_name><inc_key>104</inc_key><dec_key>106</dec_key><inc_val>0.2</inc_val>
        <min_val>-0.5</min_val><max_val>0.5</max_val><p>50</p><i>0</i><d>10</d></control>
    </plugin>"""
    core, world = run(body("plane", inside=HINGE.format(name="j") + text, gravity="false"))
    joint = world.ModelByName("plane").GetJoint("j")
    node = transport.Node()
    node.Init("default")
    publisher = node.Advertise(msgs.Any, "~/keyboard/keypress")
    for keys, position in (("h", 0.2), ("hh", 0.5), ("jjj", -0.1), ("c", 0.0)):
        for key in keys:
            publisher.Publish(msgs.Any(int_value=ord(key)))
        core.run(3.0)
        assert joint.Position(0) == pytest.approx(position, abs=0.01), keys


# Sensors -------------------------------------------------------------------------------------------------------------

SMALL = "<camera><image><width>8</width><height>6</height></image></camera>"
RAY = """<ray>
  <scan><horizontal><samples>3</samples><min_angle>-0.1</min_angle><max_angle>0.1</max_angle></horizontal></scan>
  <range><min>0.1</min><max>9</max></range>
</ray>"""
SENSORS = {
    "CameraPlugin": f"<sensor name='s' type='camera'>{SMALL}",
    "DepthCameraPlugin": f"<sensor name='s' type='depth'>{SMALL}",
    "RayPlugin": f"<sensor name='s' type='ray'>{RAY}",
    "GpuRayPlugin": f"<sensor name='s' type='gpu_ray'>{RAY}",
    "ContactPlugin": "<sensor name='s' type='contact'><contact><collision>c</collision></contact>",
    "ImuSensorPlugin": "<sensor name='s' type='imu'>",
    "SonarPlugin": "<sensor name='s' type='sonar'>",
    "ForceTorquePlugin": "<sensor name='s' type='force_torque'>",
}


@pytest.mark.parametrize("name", SENSORS)
def test_sensor_hooks_switch_the_sensor_on_and_are_called(name, run, monkeypatch):
    from libgz.classic.plugins import hooks

    kind, calls = getattr(hooks, name), []
    hook = next(word for word in vars(kind) if word.startswith("On"))
    monkeypatch.setattr(kind, hook, lambda _self, *values: calls.append(values))
    sensor = f"{SENSORS[name]}<update_rate>100</update_rate>{plugin(name)}</sensor>"
    shape = collision("<box><size>1 1 1</size></box>")
    joint = HINGE.format(name="j").replace("</joint>", f"{sensor}</joint>") if name == "ForceTorquePlugin" else ""
    core, _ = run(body("thing", "0 0 0.5 0 0 0", link=shape + (sensor if not joint else ""), inside=joint))
    (loaded,) = core.companions[0].sensors.plugins()
    assert loaded.plugin.sensor.IsActive()
    core.run(0.1)
    assert len(calls) == pytest.approx(10, abs=1)
    assert len(calls[0]) == {"OnNewFrame": 5, "OnNewDepthFrame": 5, "OnNewLaserScans": 0}.get(hook, len(calls[0]))


def test_a_hook_is_made_for_deriving(run, tmp_path, monkeypatch, capsys):
    (tmp_path / "nearest.py").write_text(
        textwrap.dedent("""
        from libgz.classic import GZ_REGISTER_SENSOR_PLUGIN
        from libgz.classic.plugins.hooks import RayPlugin

        class Nearest(RayPlugin):
            def OnNewLaserScans(self):
                print(f"{min(self.sensor.Ranges()):.2f}")

        GZ_REGISTER_SENSOR_PLUGIN(Nearest)
        """)
    )
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    ray = f"<sensor name='s' type='ray'>{RAY}{plugin('nearest')}</sensor>"
    wall = body("wall", "3 0 0 0 0 0", link=collision("<box><size>1 9 9</size></box>"), gravity="false")
    core, _ = run(body("eye", link=ray, gravity="false"), wall)
    core.step()
    assert capsys.readouterr().out.split() == ["2.50"]


def test_keys_of_the_client_drive_a_robot(run):
    wheels = {"left_joint": "left_wheel_hinge", "right_joint": "right_wheel_hinge", "torque": 5}
    topic = "~/pioneer2dx/vel_cmd"
    keys = plugin("KeysToCmdVelPlugin", cmd_vel_topic=topic, max_linear_vel=0.5, linear_increment=0.2)
    core, world = run(pioneer(plugin("DiffDrivePlugin", **wheels), keys))
    robot, received, node = world.ModelByName("pioneer2dx"), [], transport.Node()
    node.Init("default")

    def hear(message):
        received.append((message.position.x, Quaterniond(msgs.ConvertIgn(message.orientation)).Yaw()))

    kept = node.Subscribe(topic, hear)
    keyboard = new_plugin("GUI", "libKeyboardGUIPlugin.so", "keyboard", "System", core.events)
    assert keyboard.start(Element("plugin"))
    up, down, left, space = 16777235, 16777237, 37, {"text": " "}
    for key in (up, up, up, down, left, 120):
        gui.Events.keyPress(msgs.KeyEvent(key=key))
    core.run(2.0)
    assert received == [pytest.approx(pair) for pair in [(0.2, 0), (0.4, 0), (0.5, 0), (0.3, 0), (0.3, -0.5)]]
    assert robot.WorldLinearVel().Length() == pytest.approx(0.3, abs=0.03)
    assert robot.WorldPose().Yaw() > 0.7  # left
    gui.Events.keyPress(msgs.KeyEvent(**space))
    core.run(0.5)
    assert robot.WorldLinearVel().Length() < 0.02
    del kept
    keyboard.drop()
    gui.Events.keyPress(msgs.KeyEvent(key=up))
    core.step(3)
    assert len(received) == 6


def test_keys_can_be_chosen(run, caplog):
    controls = "<key_controls><accelerate>119</accelerate><accelerate>87</accelerate><stop>120</stop></key_controls>"
    core, _ = run(body("cart", inside=plugin("KeysToCmdVelPlugin").replace("</plugin>", f"{controls}</plugin>")))
    assert "Key left has no assigned keycode." in caplog.text
    node, received = transport.Node(), []
    node.Init("default")
    kept = node.Subscribe("~/cmd_vel", lambda message: received.append(message.position.x))
    publisher = node.Advertise(msgs.Any, "~/keyboard/keypress")
    for key in "wWsx":
        publisher.Publish(msgs.Any(int_value=ord(key)))
    core.step(3)
    assert received == [0.5, 1.0, 0.0]
    del kept


def test_keys_can_give_twists(run):
    core, _ = run(body("cart", inside=plugin("KeysToCmdVelPlugin", publish_as_twist="true")))
    node, received = transport.Node(), []
    node.Init("default")
    kept = node.Subscribe("~/cmd_vel", lambda message: received.append((message.linear.x, message.angular.z)))
    publisher = node.Advertise(msgs.Any, "~/keyboard/keypress")
    for key in (38, 37):
        publisher.Publish(msgs.Any(int_value=key))
    core.step(3)
    assert received == [(0.5, 0.0), (0.5, -0.5)]
    del kept


# Batteries -----------------------------------------------------------------------------------------------------------


def test_a_battery_is_used_up_by_its_consumers(run):
    which = {"link_name": "link", "battery_name": "main"}
    cell = {"open_circuit_voltage_constant_coef": 12.0, "open_circuit_voltage_linear_coef": -2.0, "capacity": 0.01,
            "initial_charge": 0.01, "resistance": 0.5, "smooth_current_tau": 0.05}  # fmt: skip
    drain = plugin("LinearBatteryConsumerPlugin", **which, power_load=12)
    extra = plugin("LinearBatteryPlugin", **which, **cell) + drain
    link = "<battery name='main'><voltage>12</voltage></battery>"
    core, world = run(body("robot", inside=extra, link=link, gravity="false"))
    battery = world.ModelByName("robot").GetLink().Battery("main")
    voltages = []
    for _ in range(2):
        core.run(1.0)
        # Its current is P / V, after the time constant; V falls by r i, and by e1 times the share that is gone.
        current = 12.0 / battery.Voltage()
        gone = current * (1.0 - 0.05) / 3600.0 / 0.01
        assert battery.Voltage() == pytest.approx(12.0 - 2.0 * gone - 0.5 * current, abs=2e-3)
        voltages.append(battery.Voltage())
        core.Reset()
    assert voltages[0] == pytest.approx(voltages[1], abs=1e-9)
    world.server.plugins.of_model(world.ModelByName("robot"))[-1].drop()
    gc.collect()
    core.run(1.0)
    assert battery.PowerLoads() == {}
    assert battery.Voltage() == pytest.approx(12.0, abs=1e-3)


def test_a_missing_battery_is_reported(run, caplog):
    link = "<battery name='main'><voltage>12</voltage></battery>"
    wrong = plugin("LinearBatteryConsumerPlugin", link_name="link", battery_name="mian", power_load=1)
    run(body("robot", inside=wrong, link=link))
    assert "did you mean 'main'" in caplog.text
