"""Ready plugins in their example worlds, each against a number; those marked Gazebo are what Gazebo 11.1 does."""

import ast
import contextlib
import math
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest
from gzserver_process import new_environment
from plugin_worlds import plugin
from topics import Heard, send

import libgz
from libgz.classic import gui, msgs, plugins
from libgz.classic.loading import new_plugin
from libgz.classic.physics import get_world
from libgz.classic.plugins._tracks import _limited
from libgz.classic.rendering import get_scene
from libgz.sdfworld.population import MOST_MODELS

EXAMPLES = Path(__file__).parents[3] / "examples" / "plugins" / "ready"
INERTIAL = "<inertial><mass>1</mass><inertia><ixx>{0}</ixx><iyy>{0}</iyy><izz>{0}</izz></inertia></inertial>"


@contextlib.contextmanager
def example(name, change=lambda text: text):
    text = change((EXAMPLES / f"{name}.world").read_text())
    with libgz.World.from_string(text) as core:
        yield core, get_world()


def spinning(*names, damping=0.0):
    """A base that stands, and links that turn on it about z."""
    parts = [
        f"<link name='{name}'><gravity>0</gravity>{INERTIAL.format(1)}</link><joint name='{name}_j' type='revolute'>"
        f"<parent>base</parent><child>{name}</child><axis><xyz>0 0 1</xyz><dynamics><damping>{damping}</damping>"
        "</dynamics></axis></joint>"
        for name in names
    ]
    base = f"<link name='base'><gravity>0</gravity>{INERTIAL.format(1)}</link>"
    return f"{base}<joint name='f' type='fixed'><parent>world</parent><child>base</child></joint>{''.join(parts)}"


def test_plugins_name_the_types_that_they_receive():
    calls = [
        (path.name, call)
        for path in Path(plugins.__file__).parent.glob("*.py")
        for call in ast.walk(ast.parse(path.read_text()))
        if isinstance(call, ast.Call) and ast.unparse(call.func).endswith("node.Subscribe")
    ]
    assert len(calls) > 20
    for name, call in calls:
        kinds = [word.value.value for word in call.keywords if word.arg == "kind"]
        assert [msgs.message_type(kind).GetTypeName() for kind in kinds] != [], f"{name}: {ast.unparse(call)}"


# Images --------------------------------------------------------------------------------------------------------------


def test_blink_fades_from_one_colour_to_the_other_and_back():
    with example("blink") as (core, _):
        visual, found = get_scene().GetVisual("box::link::visual"), {}
        for tenth in range(1, 31):
            core.run(0.1)
            found[tenth] = visual.geoms[0].appearance.diffuse
        for tenth in (5, 10, 15, 20, 25):  # images at 10 Hz, in the middle of a step of 0.1 s at the latest
            share = 1.0 - abs(2.0 * (tenth / 20.0 % 1.0) - 1.0)
            color = found[tenth]
            assert (color.r, color.g, color.b) == pytest.approx((1.0 - share, 0.0, share), abs=0.101)
        assert found[10].b > 0.89 > 0.6 > found[5].b


def test_blink_needs_a_period(caplog):
    with example("blink", lambda text: text.replace("<period>2</period>", "<period>0</period>")) as (core, _):
        core.run(0.1)
        assert "<period> is 0; it must be positive" in caplog.text


def test_fiducial_camera_finds_what_no_wall_hides():
    with example("fiducial") as (core, _):
        heard = Heard("~/camera/fiducial")
        core.run(0.35)
        assert len(heard) == 3
        (pose,) = heard[-1].pose
        assert pose.name == "ball"
        focal = 40.0 / math.tan(1.05 / 2.0)
        assert (pose.position.x, pose.position.y) == (math.floor(40.0 - focal * 0.5 / 3.0), 30.0)


@pytest.mark.trial
def test_follower_drives_to_the_box_and_stops_before_it():
    with example("follower") as (core, world):
        robot = world.ModelByName("robot")
        core.run(15.0)
        x, y, _ = robot.WorldPose().Pos()
        assert math.atan2(y, x) == pytest.approx(math.atan2(0.6, 2.5), abs=0.15)
        # The face of the box is at x = 2.25, and the camera 0.25 m in front of the robot.
        assert 2.25 - x - 0.25 == pytest.approx(0.65, abs=0.2)
        assert robot.WorldLinearVel().Length() < 0.08


@pytest.mark.trial
def test_prop_shop_saves_five_images_and_ends_the_server(tmp_path):
    shape = "<geometry><box><size>1 0.5 0.3</size></box></geometry>"
    (tmp_path / "thing.sdf").write_text(
        f"<sdf version='1.6'><model name='thing'><link name='l'><visual name='v'>{shape}</visual></link></model></sdf>"
    )
    (tmp_path / "blank.world").write_text("<sdf version='1.6'><world name='default'/></sdf>")
    command = [sys.executable, "-m", "libgz.apps.gzserver", "--verbose", "-s", "libModelPropShop.so"]
    files = [str(tmp_path / "blank.world"), "--propshop-save", str(tmp_path / "shop"), "--propshop-model"]
    environment = new_environment(tmp_path)
    run = subprocess.run(
        [*command, *files, str(tmp_path / "thing.sdf")], capture_output=True, text=True, timeout=60, env=environment
    )
    assert run.returncode == 0, run.stderr
    assert sorted(path.name for path in (tmp_path / "shop").iterdir()) == [f"{i}.png" for i in range(1, 6)]
    assert "saved 5 images of thing" in run.stdout


# Forces --------------------------------------------------------------------------------------------------------------


def test_pressure_is_weight_over_the_largest_side():
    with example("pressure") as (core, _):
        heard = Heard("~/scale/tactile")
        core.run(2.05)
        assert heard[-1].pressure[0] == pytest.approx(10.0 * 9.8 / 1.0, rel=1e-3)
        assert list(heard[-1].collision_name) == ["plate::link::collision"]
        times = [message.time.sec + 1e-9 * message.time.nsec for message in heard]
        assert all(later - now == pytest.approx(0.1) for now, later in pairwise(times))


def test_gravity_compensation_holds_the_arm():
    with example("gravity_compensation") as (core, world):
        arm = world.ModelByName("arm")
        arm.SetJointPositions({"arm::shoulder": 0.3, "arm::elbow": -0.5})
        core.run(2.0)
        assert arm.GetJoint("shoulder").Position(0) == pytest.approx(0.3, abs=2e-3)
        assert arm.GetJoint("elbow").Position(0) == pytest.approx(-0.5, abs=2e-3)


def test_an_electric_motor_has_its_torque_and_then_its_power():
    with example("actuator") as (core, world):
        axle = world.ModelByName("motor").GetJoint("axle")
        core.run(0.05)
        assert axle.GetVelocity(0) == pytest.approx(5.0 * 0.05, rel=0.03)
        core.run(1.95)
        # 5 N m up to 0.4 rad/s, that is for 0.08 s; from then on the energy grows by 2 W.
        assert axle.GetVelocity(0) == pytest.approx(math.sqrt(0.4**2 + 2.0 * 2.0 * 1.92), rel=0.01)  # Gazebo: 2.71


def test_a_velocity_limiter_ends_at_its_velocity_and_unknown_types_are_reported(run, caplog):
    numbers = {"power": 2, "max_velocity": 3, "max_torque": 5}
    inside = "".join(f"<{tag}>{value}</{tag}>" for tag, value in numbers.items())
    drive = "<controller type='force'><joint>a_j</joint><target>10</target></controller>"
    control = f"<plugin name='q' filename='libJointControlPlugin.so'>{drive}</plugin>"

    def motor(kind):
        element = f"<actuator><joint>a_j</joint><type>{kind}</type>{inside}</actuator>"
        return f"<plugin name='p' filename='libActuatorPlugin.so'>{element}</plugin>"

    core, world = run(f"<model name='m'>{spinning('a')}{motor('velocity_limiter')}{control}</model>")
    core.run(2.0)
    assert world.ModelByName("m").GetJoint("a_j").GetVelocity(0) == pytest.approx(3.0, abs=0.011)
    run(f"<model name='m'>{spinning('a')}{motor('electric_moter')}</model>")
    assert "did you mean 'electric_motor'?" in caplog.text


# Joints --------------------------------------------------------------------------------------------------------------


def test_gimbal_tilts_to_the_angle_of_its_topic():
    with example("gimbal") as (core, world):
        heard = Heard("~/gimbal/gimbal_tilt_status")
        core.run(10.0)
        tilt = world.ModelByName("gimbal").GetJoint("tilt_joint")
        assert tilt.Position(0) == pytest.approx(math.pi / 2.0, abs=1e-3)
        assert len(heard) == 1 + 9999 // 101  # the first iteration, and then every 101st
        kept = send("~/gimbal/gimbal_tilt_cmd", msgs.GzString(data="0.3"))
        core.run(10.0)
        assert float(heard[-1].data) == pytest.approx(0.3, abs=1e-3)
        del kept


def test_gimbal_moves_as_in_gazebo(run):
    hinge = "<axis><xyz>0 1 0</xyz><dynamics><damping>0.1</damping></dynamics></axis>"
    core, world = run(
        f"<model name='g'><link name='b'>{INERTIAL.format(0.1)}</link><link name='eye'>{INERTIAL.format(0.1)}</link>"
        "<joint name='f' type='fixed'><parent>world</parent><child>b</child></joint>"
        f"<joint name='tilt_joint' type='revolute'><parent>b</parent><child>eye</child>{hinge}</joint>"
        f"{plugin('GimbalSmall2dPlugin')}</model>"
    )
    tilt = world.ModelByName("g").GetJoint("tilt_joint")
    core.step(1)
    for quarter_turn in (0.5039441, 0.9331394, 0.8118680, 0.5093726):  # sine of half the angle
        core.step(500)
        assert math.sin(tilt.Position(0) / 2.0) == pytest.approx(quarter_turn, abs=0.005)


def test_variable_gearbox_follows_its_curve():
    with example("gearbox") as (core, world):
        joints = [world.ModelByName("gears").GetJoint(f"turn_{side}") for side in ("input", "output")]
        core.run(1.5)
        x, y = (joint.Position(0) for joint in joints)
        assert 1.0 < x < 1.7
        assert y == pytest.approx(x * x, abs=0.02)
        core.run(1.5)
        x, y = (joint.Position(0) for joint in joints)
        assert 2.2 < x < 3.1
        assert y == pytest.approx(4.0 + 4.0 * (x - 2.0), abs=0.02)  # a line beyond the last point


def test_variable_gearbox_refuses_points_out_of_order_and_other_joints(caplog):
    swapped = "<x_y_dydx>2 4 4</x_y_dydx><x_y_dydx>0 0 0</x_y_dydx>"
    points = "<x_y_dydx>0 0 0</x_y_dydx>\n        <x_y_dydx>2 4 4</x_y_dydx>"
    with example("gearbox", lambda text: text.replace(points, swapped)):
        assert "Out of order x_y_dydx element detected: 2 should be less than 0" in caplog.text
    name = "<gearbox_joint_name>{}</gearbox_joint_name>"
    with example("gearbox", lambda text: text.replace(name.format("gearbox"), name.format("turn_input"))):
        assert "joint 'turn_input' is no gearbox" in caplog.text


CART = """<plugin name='p' filename='libCartDemoPlugin.so'>
<steer>s_j</steer><steer_pid>10 0 5</steer_pid><steer_ilim>-10 10</steer_ilim><steer_pos>0.5</steer_pos>
<steer_vel>0</steer_vel><steer_eff>3</steer_eff>
<right>r_j</right><right_pid>0.1 0 0.01</right_pid><right_ilim>-.1 .1</right_ilim><right_pos>7</right_pos>
<right_vel>2</right_vel><right_eff>0.2</right_eff>
<left>l_j</left><left_pid>0.1 0 0.01</left_pid><left_ilim>-.1 .1</left_ilim><left_pos>9</left_pos>
<left_vel>3</left_vel><left_eff>0.3</left_eff></plugin>"""


def test_cart_has_the_programme_of_gazebo(run):
    physics = "<physics type='ode'><max_step_size>0.01</max_step_size></physics>"
    core, world = run(physics, f"<model name='c'>{spinning('s', 'r', 'l', damping=0.01)}{CART}</model>")
    joints = [world.ModelByName("c").GetJoint(f"{name}_j") for name in "srl"]
    core.run(0.5)
    assert joints[0].Position(0) == pytest.approx(0.261, abs=0.015)
    # Gazebo's angles of both wheels modulo a turn, which it has at 10.5 s and so on.
    for time, right, left in ((10.5, 0.028, 0.041), (18.5, -5.501, -1.968), (28.5, 5.597, 2.111), (36.5, 0.235, -5.931),
                              (48.5, -3.113, -4.670), (56.5, 0.334, 0.502), (66.5, -1.124, 2.433)):  # fmt: skip
        core.run(time - core.GetSimTime())
        for joint, angle in zip(joints[1:], (right, left), strict=True):
            assert math.remainder(joint.Position(0) - angle, 2.0 * math.pi) == pytest.approx(0.0, abs=0.03)


CESSNA = ("left_aileron", "left_flap", "right_aileron", "right_flap", "elevators", "rudder", "propeller")


def test_cessna_moves_as_in_gazebo(run):
    joints = "".join(f"<{name}>{name}_j</{name}>" for name in CESSNA)
    rpm = "<propeller_max_rpm>2500</propeller_max_rpm>"
    element = f"<plugin name='p' filename='libCessnaPlugin.so'>{joints}{rpm}</plugin>"
    core, world = run(f"<model name='cs'>{spinning(*CESSNA, damping=1)}{element}</model>")
    heard = Heard("~/cs/state")
    command = msgs.Cessna(cmd_propeller_speed=0.5, cmd_left_aileron=0.3, cmd_elevators=0.25, cmd_rudder=-0.2)
    core.step(1)
    kept = send("~/cs/control", command)
    core.step(1)
    for aileron, elevators, rudder in ((0.2253, 0.1881, -0.1510), (0.4803, 0.4004, -0.3204), (0.4000, 0.3331, -0.2662)):
        core.step(200)
        model = world.ModelByName("cs")
        angles = [model.GetJoint(f"{name}_j").Position(0) for name in ("left_aileron", "elevators", "rudder")]
        assert angles == pytest.approx([aileron, elevators, rudder], abs=0.005)
    core.run(0.4)
    assert heard[-1].propeller_speed == pytest.approx(0.490196, abs=2e-4)
    assert (heard[-1].cmd_rudder, len(heard)) == (pytest.approx(-0.2), world.Iterations())
    del kept


def test_cessna_names_what_is_missing(run, caplog):
    run(f"<model name='cs'>{spinning('a')}{plugin('CessnaPlugin', propeller_max_rpm=0)}</model>")
    assert "Maximum propeller RPMs cannot be 0" in caplog.text
    run(f"<model name='cs'>{spinning('a')}{plugin('CessnaPlugin', propeller_max_rpm=10)}</model>")
    assert "<propeller> is missing and must name a joint" in caplog.text


def test_the_legs_of_atlas_stand_and_fall_without_the_plugin():
    with example("atlas") as (core, world):
        core.run(2.0)
        assert world.ModelByName("legs").GetLink("pelvis").WorldPose().Pos().Z() == pytest.approx(1.0, abs=0.01)
    with example("atlas", lambda text: text.replace('filename="libSphereAtlas', 'filename="libNo')) as (core, world):
        core.run(2.0)
        assert world.ModelByName("legs").GetLink("pelvis").WorldPose().Pos().Z() < 0.8


# Tracks --------------------------------------------------------------------------------------------------------------


def twist(model, speed, turn):
    message = msgs.Twist()
    msgs.Set(message.linear, (speed, 0.0, 0.0))
    msgs.Set(message.angular, (0.0, 0.0, turn))
    return send(f"~/{model}/cmd_vel_twist", message)


TRACKS = """<model name='t'>
<link name='base'><pose>0 0 .2 0 0 0</pose>
<inertial><mass>10</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>{}
<plugin name='t' filename='libSimpleTrackedVehiclePlugin.so'><body>base</body><left_track>left</left_track>
<right_track>right</right_track></plugin></model>"""
TRACK = (
    "<link name='{0}'><pose>0 {1} .1 0 0 0</pose>" + INERTIAL.format(0.01) + "<collision name='c'><geometry><box>"
    "<size>.5 .1 .2</size></box></geometry></collision></link>"
    "<joint name='{0}_j' type='fixed'><parent>base</parent><child>{0}</child></joint>"
)


def test_solid_tracks_drive_and_turn_as_in_gazebo(run):
    ground = "<include><uri>model://ground_plane</uri></include>"
    core, world = run(ground, TRACKS.format(TRACK.format("left", 0.2) + TRACK.format("right", -0.2)))
    vehicle, heard = world.ModelByName("t"), Heard("~/t/tracks_speed")
    core.run(0.5)
    kept = twist("t", 0.3, 0.0)
    core.run(2.0)
    assert vehicle.WorldPose().Pos().X() == pytest.approx(0.595, abs=0.005)
    kept = twist("t", 0.0, 0.5)
    core.run(2.0)
    assert vehicle.WorldPose().Yaw() == pytest.approx(-0.762, abs=0.08)
    kept = twist("t", 5.0, 5.0)
    core.step(2)
    assert [(m.x, m.y) for m in heard] == [(0.3, 0.3), (0.2, -0.2), (1.0, 0.6)]
    kept = twist("t", 0.0, 0.0)
    core.run(1.0)
    assert vehicle.WorldLinearVel().Length() < 1e-3
    del kept


def test_both_kinds_of_tracks_drive_and_solid_ones_climb_a_step():
    with example("tracked") as (core, world):
        kept = [twist(name, 0.4, 0.0) for name in ("solid", "wheels")]
        core.run(4.0)
        solid, wheels = (world.ModelByName(name).WorldPose().Pos() for name in ("solid", "wheels"))
        assert solid.X() > 1.2
        assert solid.Z() == pytest.approx(0.08, abs=0.02)
        assert (wheels.X(), wheels.Y()) == pytest.approx((1.6, 2.0), abs=0.03)
        kept = [twist("wheels", 0.0, 0.5)]
        yaw = world.ModelByName("wheels").WorldPose().Yaw()
        core.run(2.0)
        assert world.ModelByName("wheels").WorldPose().Yaw() - yaw < -0.9
        del kept


def test_tracks_report_wrong_elements(run, caplog):
    assert _limited(-3.0, 2.0) == -2.0
    both = TRACK.format("left", 0.2) + TRACK.format("right", -0.2)
    run(TRACKS.format(both).replace("<body>", "<tracks_separation>0</tracks_separation><body>"))
    assert "Tracks separation must be positive; it is 0" in caplog.text
    run(TRACKS.format(both).replace("<body>", "<left_flipper>fin</left_flipper><body>"))
    assert "<left_flipper> link 'fin' does not exist" in caplog.text


# Worlds --------------------------------------------------------------------------------------------------------------


def test_rubble_has_blocks_and_planks_in_its_region():
    with example("rubble", lambda text: text.replace("<count>30", "<count>60")) as (core, world):
        core.step(1)
        boxes = [model for model in world.Models() if model.GetName().startswith("rubble_")]
        assert len(boxes) == 60
        sizes = [tuple(box.GetLink("link").GetCollisions()[0].GetShape().Size()) for box in boxes]
        blocks = [size for size in sizes if size == pytest.approx((0.2032, 0.2032, 0.4064))]
        planks = [size for size in sizes if size[1:] == pytest.approx((0.1016, 0.0508))]
        assert len(blocks) + len(planks) == 60
        assert 15 < len(blocks) < 45
        assert all(0.6096 <= size[0] <= 2.4384 for size in planks)
        for box in boxes:
            x, y, _ = box.WorldPose().Pos()
            assert abs(x) < 0.65
            assert abs(y) < 1.15
            assert 0.5 <= box.GetLink("link").GetInertial().Mass() <= 2.0


@pytest.mark.parametrize("count", [-1, MOST_MODELS + 1])
def test_rubble_has_a_bound(count, caplog):
    with example("rubble", lambda text: text.replace("<count>30", f"<count>{count}")):
        assert f"<count> is {count}; it must be from 0 to {MOST_MODELS}" in caplog.text


def test_hydra_moves_the_ball_once_a_message():
    with example("hydra", lambda text: text.replace("model://ground_plane", "model://sun")) as (core, world):
        message = msgs.Hydra()
        message.right.joy_x, message.right.joy_y = 0.5, -0.3
        kept = send("~/hydra", message)
        core.step(2)
        velocity = world.ModelByName("ball").WorldLinearVel()
        assert (velocity.X(), velocity.Y()) == pytest.approx((-0.1, -0.06), abs=1e-9)
        world.ModelByName("ball").SetLinearVel((0.0, 0.0, 0.0))
        core.step(2)
        assert world.ModelByName("ball").WorldLinearVel().X() == 0.0
        del kept


def test_plugins_without_effect_say_so_with_their_line(caplog):
    with example("without_effect") as (core, _):
        core.run(0.2)
        for name in ("Joy", "StaticMap", "LensFlareSensor", "AmbientOcclusionVisual", "HeightmapLOD", "Reflectance"):
            (line,) = [r.getMessage() for r in caplog.records if r.getMessage().find(f"{name}Plugin has no") >= 0]
            assert ":" in line.split(f"{name}Plugin")[0]
        assert not [record for record in caplog.records if record.levelname == "ERROR"]


# The client ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def window():
    class Window:
        def width(self):
            return 800

        def height(self):
            return 600

        class scene:
            @staticmethod
            def Name():
                return "default"

    gui.set_main_window(Window())
    yield
    gui.set_main_window(None)


def load_gui(filename, text):
    from libgz.classic.gui.window import GUI
    from libgz.classic.sdf import readString  # noqa: F401
    from libgz.sdf.reader import SdfFile

    element = f"<plugin name='p' filename='{filename}'>{text}</plugin>"
    file = SdfFile.from_string(f"<sdf version='1.6'><world name='w'><gui>{element}</gui></world></sdf>")
    element = next(file.root.child("world").child("gui").named("plugin"))
    loaded = new_plugin("GUI", filename, "p", "System", None)
    place = GUI("p")
    loaded.prepare = lambda made: setattr(made, "gui", place)
    assert loaded.start(element)
    return loaded.plugin, place


def test_timer_runs_stops_and_counts_down(window, run, monkeypatch):
    from libgz.classic.common import timer

    now = [10**9]
    monkeypatch.setattr(timer.time, "monotonic_ns", lambda: now[0])
    core, _ = run()
    elements = "<pos>-10 20</pos><size>100 50</size><start_stop_button>1</start_stop_button>"
    elements += "<reset_button>1</reset_button>"
    made, place = load_gui("libTimerGUIPlugin.so", elements)
    assert (place.text, place.position, place.Buttons()) == ("00:00:00.00", (690, 20), ["Start/Stop", "Reset"])
    kept = send("~/timer_control", msgs.GzString(data="start"))
    core.step(2)
    now[0] += 3_723_450_000_000
    made.OnPreRender()
    assert place.text == "01:02:03.45"
    place.Press("Start/Stop")
    now[0] += 10**9
    made.OnPreRender()
    assert place.text == "01:02:03.45"
    place.Press("Reset")
    made.OnPreRender()
    assert place.text == "00:00:00.00"
    countdown = "<countdown_time>60 500000000</countdown_time>"
    made, place = load_gui("libTimerGUIPlugin.so", countdown)
    assert place.text == "00:01:00.50"
    del kept


def test_cessna_gui_sends_the_commands_of_keys(window, run):
    core, _ = run()
    heard = Heard("~/cessna_c172/control")
    _, place = load_gui("libCessnaGUIPlugin.so", "")
    for key in "wwad":
        gui.Events.keyPress(msgs.KeyEvent(text=key))
    core.step(2)
    assert heard[1].cmd_propeller_speed == pytest.approx(0.2)
    assert heard[2].cmd_left_aileron == pytest.approx(-math.radians(1.0))
    assert heard[3].cmd_left_aileron == pytest.approx(0.0)
    place.Press("Cruise")
    core.step(2)
    assert (heard[-1].cmd_propeller_speed, heard[-1].cmd_elevators) == (pytest.approx(0.6), 0.0)
