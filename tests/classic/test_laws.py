"""Laws of sensors and plugins: native code does as Python does, to the bit, and alone while nobody listens."""

from contextlib import contextmanager

import pytest
from plugin_worlds import GROUND, command, plugin, wheel

import libgz
from libgz.base.law import law, rarely, unrecorded
from libgz.base.records import Kind
from libgz.classic import transport
from libgz.classic.math import PID, Quaterniond, Vector3d
from libgz.classic.server import WorldServer, attach
from libgz.simulation.stepping import Stepping

IMU = (
    "<sensor name='imu' type='imu'><pose>.1 .2 .3 .4 .5 .6</pose><always_on>1</always_on><update_rate>{}</update_rate>"
    "</sensor>"
)
RATES = (0, 1000, 300, 77)  # [Hz]
WHEELS = {"left_joint": "left", "right_joint": "right"}


def tumbling(name, rate):
    return (
        f"<model name='{name}'><pose>{rate} 0 2 0.3 0.2 0.1</pose><link name='link'><collision name='c'><geometry><box>"
        f"<size>.4 .3 .2</size></box></geometry></collision>{IMU.format(rate)}</link></model>"
    )


BODIES = "".join(tumbling(f"b{rate}", rate) for rate in RATES)
TEXT = f"<sdf version='1.6'><world name='default'>{GROUND}{BODIES}</world></sdf>"


@contextmanager
def pair(text):
    """Two worlds of one text: native, and all in Python."""
    with libgz.World.from_string(text) as native, libgz.World.from_string(text) as plain:
        plain.rows.enabled = False
        yield native, plain


def readings(world):
    sensors = attach(world).sensors.sensors.values()
    return [
        (
            [*one.AngularVelocity()],
            [*one.LinearAcceleration()],
            [*one.Orientation()],
            one.LastMeasurementTime().Double(),
            one.LastUpdateTime().Double(),
        )
        for one in sensors
    ]


def imus(world):
    return list(attach(world).sensors.sensors.values())


def turn_gravity(world):
    world.engine.gravity = (0.0, 3.0, -5.0)


def set_reference(world):
    imus(world)[0].SetWorldToReferenceOrientation(Quaterniond(0.1, 0.2, 0.3))


def set_rate(world):
    imus(world)[1].SetUpdateRate(50.0)


def move_sensor(world):
    imus(world)[2].SetPose(libgz.GzPose(libgz.GzVector(1, 0, 0), libgz.GzQuatern(1, 0, 0, 0)))


def throw(world):
    attach(world).world.ModelByName("b0").GetLink("link").SetLinearVel(Vector3d(1, 2, 3))


def remove_one(world):
    attach(world).world.RemoveModel("b300")


def start_again(world):
    world.Reset()


@pytest.mark.parametrize(
    "change",
    [turn_gravity, set_reference, set_rate, move_sensor, throw, remove_one, start_again],
    ids=lambda c: c.__name__,
)
def test_imus_measure_the_same_natively(change):
    with pair(TEXT) as worlds:
        for world in worlds:
            world.step(457)
            change(world)
            world.step(391)
        native, plain = worlds
        assert readings(native) == readings(plain)
        assert native.get_state() == plain.get_state()


@pytest.fixture
def steps(monkeypatch):
    """The steps in which Python had to look at sensors."""
    made, step = [], WorldServer.step
    monkeypatch.setattr(WorldServer, "step", lambda server, paused: (made.append(paused), step(server, paused))[1])
    return made


def test_python_measures_only_while_somebody_listens(steps):
    with libgz.World.from_string(TEXT) as world:
        world.step(5)
        steps.clear()
        world.step(200)
        assert not steps
        seen = []
        imu = imus(world)[1]
        connection = imu.ConnectUpdated(lambda: seen.append(imu.LastMeasurementTime().Double()))
        world.step(100)
        assert len(seen) == 100
        assert seen == pytest.approx([0.205 + 0.001 * (i + 1) for i in range(100)])
        connection.Disconnect()
        world.step(5)
        steps.clear()
        world.step(100)
        assert not steps
        node = transport.Node()
        node.Init("default")
        messages = []
        kept = node.Subscribe(imu.Topic(), messages.append)
        world.step(100)
        assert len(messages) == pytest.approx(100, abs=1)
        del kept


FOUR = {"left_front": (0.2, 0.2), "right_front": (0.2, -0.2), "left_rear": (-0.2, 0.2), "right_rear": (-0.2, -0.2)}
WHEELS = "".join(wheel(name, *place) for name, place in FOUR.items())
BASE = "<link name='base'><pose>0 0 0.15 0 0 0</pose><inertial><mass>5</mass></inertial></link>"
ROVER = f"<model name='rover'>{BASE}{WHEELS}{{}}</model>"
PAIR = {"left_joint": "left_front", "right_joint": "right_front"}
DRIVES = {
    "skid": plugin("SkidSteerDrivePlugin"),
    "two wheels": plugin("DiffDrivePlugin", **PAIR),
}


def double_separation(world, drive):
    drive.separation *= 2.0


def attach_anew(world, drive):
    joint = attach(world).world.ModelByName("rover").GetJoint("left_front").core
    parent, child = joint.parent, joint.child
    joint.detach()
    world.step(3)
    joint.attach(parent, child)


def set_motor(world, drive):
    attach(world).world.ModelByName("rover").GetJoint("left_front").SetParam("fmax", 0, 0.001)


def drive_off(text, native, change):
    """The states of a world on the way."""
    with libgz.World.from_string(text) as world:
        world.rows.enabled = native
        states = []
        for speed, turn in ((0.3, 0.0), (0.2, 0.7), (-0.4, 0.0)):
            kept = command("~/rover/vel_cmd", speed, turn)
            world.step(150)
            change(world, next(attach(world).plugins.running()).plugin)
            world.step(50)
            states.append(world.get_state())
            del kept
        return states


@pytest.mark.parametrize("change", [double_separation, attach_anew, set_motor], ids=lambda change: change.__name__)
@pytest.mark.parametrize("drive", DRIVES.values(), ids=DRIVES)
def test_drives_do_the_same_natively(drive, change):
    text = f"<sdf version='1.6'><world name='default'>{GROUND}{ROVER.format(drive)}</world></sdf>"
    assert drive_off(text, True, change) == drive_off(text, False, change)


def test_a_drive_runs_without_python(steps):
    drive = ROVER.format(DRIVES["two wheels"])
    text = f"<sdf version='1.6'><world name='default'>{GROUND}{drive}</world></sdf>"
    with libgz.World.from_string(text) as world:
        kept = command("~/rover/vel_cmd", 0.3)
        world.step(5)
        steps.clear()
        world.step(1000)
        assert not steps
        assert attach(world).world.ModelByName("rover").WorldPose().Pos().X() == pytest.approx(0.3, abs=0.02)
        del kept


WING = {"a0": 0.05, "cla": 4.75, "cda": 0.64, "alpha_stall": 0.2, "cla_stall": -3.8, "cp": "0.1 0.3 0", "area": 0.1}
WING |= {"link_name": "body"}
FLAP = {"control_joint_name": "flap", "control_joint_rad_to_cl": 2.0}
CONTROLS = "".join(
    f"<controller type='{kind}'><joint>{joint}</joint><target>{target}</target><pid_gains>3 2 .1</pid_gains>"
    "</controller>"
    for kind, joint, target in (("position", "flap", 0.4), ("velocity", "wheel", 3), ("force", "flap", 0.01))
)
ROS_DRIVE = {
    "leftJoint": "wheel",
    "rightJoint": "other",
    "updateRate": 50,
    "wheelSeparation": 0.4,
    "wheelDiameter": 0.2,
}
READY = {
    "wings": plugin("LiftDragPlugin", **WING) + plugin("LiftDragPlugin", **WING, **FLAP, radial_symmetry=1),
    "buoyancy": plugin("BuoyancyPlugin", fluid_density=1100),
    "controller": f"<plugin name='control' filename='libJointControlPlugin.so'>{CONTROLS}</plugin>",
    "drive of ROS": plugin("gazebo_ros_diff_drive", **ROS_DRIVE),
    "publishers of ROS": plugin("gazebo_ros_p3d", bodyName="body", updateRate=40)
    + plugin("gazebo_ros_joint_state_publisher", updateRate=30),
}


def limb(name, kind, limit):
    inertia = "<inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia>"
    return (
        f"<link name='{name}_link'><pose>{len(name) / 10} 0.3 0 0 0 0</pose><inertial><mass>0.2</mass>{inertia}"
        f"</inertial></link><joint name='{name}' type='{kind}'><parent>body</parent><child>{name}_link</child><axis>"
        f"<xyz>0 1 0</xyz><limit>{limit}</limit></axis></joint>"
    )


LIMBS = limb("flap", "revolute", "<lower>-1</lower><upper>1</upper><effort>0.2</effort><velocity>2</velocity>")
LIMBS += limb("wheel", "revolute", "<velocity>-1</velocity>") + limb("other", "prismatic", "<effort>3</effort>")
BOX = "<collision name='c'><geometry><box><size>.4 .3 .1</size></box></geometry></collision>"
BODY = f"<link name='body'><inertial><mass>2</mass></inertial>{BOX}</link>"


def glider(part):
    """A world in which a body with three limbs falls, lies down, and sleeps."""
    model = f"<model name='glider'><pose>0 0 1.2 0.1 0.2 0.3</pose>{BODY}{LIMBS}{part}</model>"
    return f"<sdf version='1.6'><world name='default'>{GROUND}{model}</world></sdf>"


def retarget(model):
    controller = model.GetJointController()
    controller.SetPositionTarget("flap", -0.3)
    controller.SetVelocityTarget("other", 0.5)
    controller.GetVelocityPIDs()["glider::wheel"].SetPGain(0.5)
    controller.SetVelocityPID("other", PID(4.0, 1.0, 0.0, 0.1, -0.1, 2.0, -2.0))


def limit_effort(model):
    model.GetJoint("flap").SetEffortLimit(0, 0.05)
    model.GetJoint("wheel").SetVelocityLimit(0, 1.0)


def throw_it(model):
    model.SetLinearVel(Vector3d(6.0, 1.0, 2.0))


def break_it(model):
    model.GetJoint("flap").Detach()
    model.GetJointController().SetForce("wheel", 0.3)


def drive_it(model):
    for loaded in attach(model.GetWorld().core).plugins.running():
        if hasattr(loaded.plugin, "order"):
            loaded.plugin.order(0.2, 0.3)


CHANGES = (retarget, limit_effort, throw_it, break_it, drive_it)


@pytest.mark.parametrize("part", READY.values(), ids=READY)
def test_ready_plugins_do_the_same_natively(part):
    with pair(glider(part)) as worlds:
        for world in worlds:
            for change in CHANGES:
                world.step(130)
                change(attach(world).world.ModelByName("glider"))
            world.step(130)
        native, plain = worlds
        assert native.get_state() == plain.get_state()


@pytest.mark.parametrize("part", READY.values(), ids=READY)
def test_ready_plugins_run_without_python(part, steps):
    with libgz.World.from_string(glider(part)) as world:
        world.step(5)
        steps.clear()
        world.step(200)
        assert not steps
        assert all(row.kind != Kind.PYTHON for row in world.rows._rows)


class Undecided:
    """A callback that is marked as a law, and cannot be recorded."""

    height = 1.0

    @law
    def OnUpdate(self):
        return 1.0 if self.world.clock.sim_time > 0.5 else 0.0


def test_a_law_that_cannot_be_recorded_is_reported_with_its_line(caplog):
    with libgz.World.from_string(TEXT) as world:
        other = Undecided()
        other.world = world
        connection = world.events["WorldUpdateBegin"].Connect(other.OnUpdate)
        world.step(3)
        assert "test_laws.py" in caplog.text
        assert "the law OnUpdate decides by a number" in caplog.text
        assert not connection.connected
        assert world.GetSimTime() == pytest.approx(0.003)


class Pushing:
    """A callback that gives a controller its first target, in a step that native code leaves to Python."""

    @law
    def OnUpdate(self):
        if rarely(self.world.clock.sim_time > 0.005):
            self.push()

    @unrecorded
    def push(self):
        attach(self.world).world.ModelByName("glider").GetJointController().SetForce("wheel", 0.3)


def test_a_first_target_that_a_law_sets_acts_in_the_same_iteration():
    with pair(glider("")) as worlds:
        for world in worlds:
            attach(world).world.ModelByName("glider").GetJointController()
            other = Pushing()
            other.world = world
            connection = world.events["WorldUpdateBegin"].Connect(other.OnUpdate)
            world.step(7)
            del connection
        native, plain = (attach(world).world.ModelByName("glider").GetJoint("wheel") for world in worlds)
        assert native.GetVelocity(0) == plain.GetVelocity(0) != 0.0


class Constant(PID):
    """A controller of a user's own."""

    def Update(self, error, dt):
        return 0.2


def test_a_pid_of_ones_own_is_asked():
    with libgz.World.from_string(glider("")) as world:
        controller = attach(world).world.ModelByName("glider").GetJointController()
        controller.SetVelocityPID("wheel", Constant())
        controller.SetVelocityTarget("wheel", 1.0)
        world.step(3)
        assert attach(world).world.ModelByName("glider").GetJoint("wheel").GetForce(0) == 0.2


def hinge(name, x, inside=""):
    inertia = "<inertial><mass>1</mass><inertia><ixx>.1</ixx><iyy>.1</iyy><izz>.1</izz></inertia></inertial>"
    return (
        f"<link name='{name}_link'><pose>{x} 0 1 0 0 0</pose>{inertia}</link><joint name='{name}' type='revolute'>"
        f"<parent>world</parent><child>{name}_link</child><axis><xyz>1 0 0</xyz>"
        f"<limit><lower>-1</lower><upper>1</upper><effort>30</effort><velocity>2</velocity></limit>{inside}</axis></joint>"
    )


FOLLOW = "<mimic joint='a'><multiplier>-2</multiplier><offset>.1</offset><reference>0</reference></mimic>"
MIMIC = plugin("gazebo_mimic_joint_plugin", joint="a", mimicJoint="b", multiplier=-0.7, maxEffort=5)
PLANAR = plugin("gazebo_ros_planar_move", cmdTimeout=0.3)
DRIVEN = {
    "mimic": f"<model name='m'>{hinge('a', 0)}{hinge('b', 2, FOLLOW)}</model>",
    "plugin": f"<model name='m'>{hinge('a', 0)}{hinge('b', 2)}{MIMIC}</model>",
    "planar": f"<model name='m'>{tumbling('m', 0).partition('>')[2].replace('</model>', '')}{PLANAR}</model>",
}


@pytest.mark.parametrize("name", DRIVEN)
def test_what_drives_a_model_in_each_iteration_does_so_natively(name, python_steps):
    text = f"<sdf version='1.11'><world name='default'>{GROUND}{DRIVEN[name]}</world></sdf>"
    with pair(text) as worlds:
        for world in worlds:
            world.step(5)
            model = attach(world).world.ModelByName("m")
            if name != "planar":
                model.GetJoint("a").SetVelocity(0, 0.3)
            else:
                (loaded,) = world.facade.server.plugins.of_model(model)
                loaded.plugin.motion.command(0.4, 0.1, 0.7, world.GetSimTime())
        for world in worlds:
            world.step(20)
            python_steps.clear()
            world.step(200)
            assert (world is worlds[1]) == (len(python_steps) > 20), len(python_steps)  # 20 Hz of odometry
            world.step(400)  # beyond the last command, and the stops
        native, plain = worlds
        states = [[[*link.WorldPose().Pos(), *link.WorldPose().Rot()] for link in links(world)] for world in worlds]
        assert states[0] == states[1]
        assert native.get_state() == plain.get_state()


def links(world):
    return attach(world).world.ModelByName("m").GetLinks()


@pytest.fixture
def python_steps(monkeypatch):
    """The steps that Python makes."""
    made, run = [], Stepping.run_in_python
    monkeypatch.setattr(Stepping, "run_in_python", lambda stepping: (made.append(1), run(stepping))[1])
    return made
