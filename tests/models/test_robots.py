"""The robots whose original source is lost: resting, driving, turning, balancing, climbing, flying, moving arms."""

import logging
import math

import numpy as np
import pytest

import libgz
from libgz.base.files import installed_worlds
from libgz.base.geometry import GzCoordPoseSub, GzPose, GzQuaternFromAxis, GzQuaternMul, GzQuaternToEuler, GzVector
from libgz.ode.types import JointType, Surface

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"
LASER = "<model:SickLMS200><id>laser1</id><xyz>0 0 0.05</xyz><parentBody>topPlate</parentBody></model:SickLMS200>"
TICK = 0.1  # [s]; what an interface says is up to so old

# Height of the origin at rest [m].
HEIGHTS = {
    "PeopleBot": -0.0007,
    "B21R": -0.0030,
    "Atrv": -0.0012,
    "Roomba": -0.0011,
    "SegwayRMP": -0.0020,
    "ClodBuster": -0.0015,
    "Shrimp": 0.1991,
    "WheelChair": 1.1971,
    "CarChassis": -0.0050,
}
ON_GROUND = {"Shrimp": 0.2, "WheelChair": 1.2}
TURN_ON_THE_SPOT = ("PeopleBot", "B21R", "Atrv", "Roomba", "SegwayRMP", "Shrimp", "WheelChair")
POWERED = ("PeopleBot", "B21R", "Atrv", "Roomba")
ALL = (*HEIGHTS, "Blimp")


def world_of(model, inside="", around="", xyz=None, rpy="0 0 0", root=""):
    xyz = xyz or f"0 0 {10 if model == 'Blimp' else ON_GROUND.get(model, 0.0)}"
    return libgz.World.from_string(
        f"{HEAD[:-1]} {root}><model:GroundPlane/>{around}"
        f"<model:{model}><id>r</id><xyz>{xyz}</xyz><rpy>{rpy}</rpy>{inside}</model:{model}></gz:world>"
    )


def attitude(robot):
    return GzQuaternToEuler(robot.GetPose().rot)


def fastest(world):
    """The largest velocity of any body along an axis [m/s]."""
    return np.abs(world.engine.states[:, 10:13]).max()


def turned(world, seconds):
    """How far the robot turns in so many seconds [rad], full turns counted."""
    robot, total = world.model("r"), 0.0
    last = attitude(robot).z
    for _ in range(round(seconds / TICK)):
        world.run(TICK)
        yaw = attitude(robot).z
        total += math.remainder(yaw - last, 2 * math.pi)
        last = yaw
    return total


# Rest, straight, turn --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", HEIGHTS)
def test_rests_upright_at_its_height(model):
    with world_of(model) as world:
        world.run(5.0)
        robot = world.model("r")
        assert robot.GetPose().pos.z == pytest.approx(HEIGHTS[model], abs=3e-4)
        assert math.degrees(attitude(robot).x) == pytest.approx(0, abs=0.05)
        assert math.degrees(attitude(robot).y) == pytest.approx(0, abs=0.3)
        assert fastest(world) < 0.001
        assert math.hypot(robot.GetPose().pos.x, robot.GetPose().pos.y) < 0.01


@pytest.mark.parametrize("model", HEIGHTS)
@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_driving_straight(model, speed):
    with world_of(model, rpy="0 0 90") as world:
        robot, position = world.model("r"), world.interface("position", "r")
        world.run(2.0)
        start = robot.GetPose().pos.y
        position.command(vx=speed)
        world.run(10.0)
        assert robot.GetPose().pos.y - start == pytest.approx(10 * speed, rel=0.02)
        assert abs(robot.GetPose().pos.x) < 0.02
        assert position.pose[0] == pytest.approx(10 * speed, abs=0.05 + TICK * abs(speed))
        assert position.pose[1:] == pytest.approx((0, 0), abs=0.01)
        assert position.vel_pos[0] == pytest.approx(speed, rel=0.03)
        position.command()
        world.run(8.0)
        assert fastest(world) < 0.02


@pytest.mark.parametrize("model", TURN_ON_THE_SPOT)
def test_turning_left_on_the_spot(model):
    # Wheels that are dragged sideways, and the Segway's soft start, cost what they cost.
    share = {"Atrv": (0.55, 0.65), "Shrimp": (0.75, 0.88), "SegwayRMP": (0.80, 0.95)}.get(model, (0.98, 1.01))
    with world_of(model) as world:
        world.run(2.0)
        world.interface("position", "r").command(vyaw=0.5)
        assert share[0] < turned(world, 6.0) / 3.0 < share[1]
        assert world.interface("position", "r").pose[2] > 0.8 * 3.0
        assert world.interface("position", "r").vel_rot[2] == pytest.approx(0.5, rel=0.05)
        # It turns about its driven axle, which may lie behind its origin; the Shrimp's bogies skid.
        behind = 0.2 if model == "WheelChair" else 0.0
        axle = world.body("r", "canonical").global_pose(GzPose(GzVector(-behind))).pos
        assert math.hypot(axle.x + behind, axle.y) < (0.2 if model == "Shrimp" else 0.03)


@pytest.mark.parametrize("model", POWERED)
def test_battery_sinks(model):
    with world_of(model, "<batteryLevel>1</batteryLevel><batteryCurve>0.25 0</batteryCurve>") as world:
        world.run(2.0)
        assert world.interface("power", "r").level == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize(("model", "count"), [("PeopleBot", 16), ("B21R", 48), ("Atrv", 26)])
def test_sonars_see_a_wall_but_not_the_robot(model, count):
    wall = "<model:SimpleSolid><xyz>2.05 0 0</xyz><size>0.1 12 2</size><mass>500</mass></model:SimpleSolid>"
    with world_of(model) as world:
        world.step(2)
        sonar = world.interface("sonar", "r")
        assert len(sonar.ranges) == count
        assert (sonar.ranges == 5.0).all()
    with world_of(model, around=wall) as world:
        world.step(2)
        sonar = world.interface("sonar", "r")
        directions = sonar.directions
        for pos, direction, found in zip(sonar.positions, directions, sonar.ranges, strict=True):
            distance = (2.0 - pos[0]) / math.cos(direction) if math.cos(direction) > 1e-9 else math.inf
            assert found == pytest.approx(distance if distance < 5.0 else 5.0, abs=0.01)
        assert sorted(np.round(np.sin(directions), 6)) == sorted(np.round(-np.sin(directions), 6))  # left as right


# Motors and odd commands -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("model", [model for model in ALL if model != "SegwayRMP"])
def test_motors_are_on_and_can_be_switched_off_and_on(model):
    with world_of(model) as world:
        robot, position = world.model("r"), world.interface("position", "r")
        assert position.data.cmd_enable_motors == 1
        position.command(vx=0.3)
        world.run(4.0)
        position.enable_motors(False)
        world.run(20.0 if model == "Blimp" else 2.0)
        stopped = robot.GetPose().pos.x
        assert stopped > 0.5
        world.run(2.0)
        assert robot.GetPose().pos.x == pytest.approx(stopped, abs=5e-3)
        position.enable_motors()
        world.run(4.0)
        assert robot.GetPose().pos.x > stopped + 0.5


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300])
@pytest.mark.parametrize("model", ALL)
def test_invalid_commands_have_no_effect(model, bad, caplog):
    with world_of(model) as world:
        robot, position = world.model("r"), world.interface("position", "r")
        position.command(vx=0.2)
        world.run(0.5)
        position.cmd_vel_pos[:] = position.cmd_vel_rot[:] = bad
        with caplog.at_level(logging.WARNING):
            world.run(1.0)
        assert np.isfinite(world.engine.states).all()
        assert np.isfinite(position.pos).all()
        assert caplog.text.count("a client wrote position.r: cmd_vel_pos[0]") == 1
        if not math.isfinite(bad):
            assert robot.position.command[:2] == (0.2, 0.0)
            assert fastest(world) < 1.0
        assert robot.GetPose().pos.z < 12.0


# Robots that steer -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_clodbuster_drives_a_circle(speed):
    with world_of("ClodBuster") as world:
        world.run(1.0)
        position = world.interface("position", "r")
        position.command(vx=speed, vyaw=0.5)
        assert turned(world, 6.0) == pytest.approx(3.0, rel=0.06)
        assert position.pose[2] == pytest.approx(3.0, rel=0.05)
        front, rear = (world.model("r").GetJoint(f"left_{end}_steering").GetAngle() for end in ("front", "rear"))
        assert front == pytest.approx(math.atan(0.5 / speed * 0.2921 / 2), abs=0.01)
        assert rear == pytest.approx(-front, abs=0.01)
        position.command(vyaw=0.5)
        world.run(1.0)
        assert turned(world, 1.0) == pytest.approx(0, abs=0.01)


def test_clodbuster_publishes_raw_encoders():
    with world_of("ClodBuster", "<rawEncoder>true</rawEncoder>") as world:
        position = world.interface("position", "r")
        position.command(vx=0.3)
        world.run(10.0)
        left, right = position.pos[:2]
        assert (left, right) == (math.floor(left), math.floor(right))
        assert left == right == pytest.approx(3.0 / (2 * math.pi * 0.076) * 408, rel=0.02)


@pytest.mark.parametrize("angle", [0.3, -0.3])
def test_carchassis_steers_by_the_angle_of_its_wheels(angle):
    with world_of("CarChassis") as world:
        world.run(1.0)
        robot, position = world.model("r"), world.interface("position", "r")
        position.command(vx=1.0, vyaw=angle)
        world.run(1.0)
        assert [s.angle() for s in robot.front] == pytest.approx([angle] * 2, abs=0.02)
        start = position.pose[2]
        yaw = turned(world, 5.0)
        bicycle = 5.0 * math.tan(angle) / 1.4
        assert position.pose[2] - start == pytest.approx(bicycle, rel=0.1)
        # Both rear wheels run at one speed, and slip.
        assert 0.7 < yaw / bicycle < 1.0
        position.command(vx=1.0, vyaw=2.0)
        world.run(1.0)
        assert robot.front[0].angle() == pytest.approx(math.radians(30), abs=0.03)


def test_carchassis_has_its_colour():
    with world_of("CarChassis", "<color>0.1 0.2 0.3</color>") as world:
        assert world.body("r", "canonical").geoms[0].GetDiffuseColor() == libgz.GzColor(0.1, 0.2, 0.3)


@pytest.mark.parametrize(("model", "height"), [("CarChassis", 0.40), ("AvatarHeli", -0.15)])
def test_skins_are_placed_from_the_origin(model, height, tmp_path, monkeypatch):
    (tmp_path / "mesh.3ds").write_bytes(b"")
    monkeypatch.chdir(tmp_path)
    skin = (
        "<skinFile>mesh.3ds</skinFile><skinXyz>0.1 0.2 0.3</skinXyz>"
        "<skinRpy>0 0 90</skinRpy><skinScale>2 2 3</skinScale>"
    )
    with world_of(model, skin) as world:
        first, *others = (geom for body in world.model("r").bodies for geom in body.geoms)
        assert first.HasSkin()
        assert tuple(first.appearance.skin_pose.pos) == pytest.approx((0.1, 0.2, 0.3 - height))
        assert tuple(first.appearance.skin_scale) == (2, 2, 3)
        assert GzQuaternToEuler(first.appearance.skin_pose.rot).z == pytest.approx(math.pi / 2)
        assert all(geom.HasSkinNull() for geom in others)
    with world_of(model) as world:
        assert not any(geom.HasSkin() or geom.HasSkinNull() for b in world.model("r").bodies for geom in b.geoms)


# SegwayRMP -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("load", ["", LASER], ids=["alone", "with a laser on top"])
def test_segway_stands_drives_two_metres_and_stands_again(load):
    with world_of("SegwayRMP", load) as world:
        robot, position = world.model("r"), world.interface("position", "r")
        world.run(60.0)
        assert math.hypot(robot.GetPose().pos.x, robot.GetPose().pos.y) < 0.15
        assert fastest(world) < 0.02
        start, leaning = robot.GetPose().pos.x, 0.0
        position.command(vx=0.5)
        for _ in range(40):
            world.run(TICK)
            leaning = max(leaning, abs(math.degrees(attitude(robot).y)))
        position.command()
        world.run(15.0)
        assert robot.GetPose().pos.x - start == pytest.approx(2.0, abs=0.1)
        assert fastest(world) < 0.02
        assert leaning < 20.0
        assert position.rot[1] == pytest.approx(attitude(robot).y, abs=1e-3)


def test_segway_turns_while_it_drives_and_keeps_its_limits():
    with world_of("SegwayRMP") as world:
        position = world.interface("position", "r")
        position.command(vx=0.8, vyaw=-0.5)
        world.run(8.0)
        assert position.vel_pos[0] == pytest.approx(0.8, rel=0.03)
        assert turned(world, 2.0) == pytest.approx(-1.0, rel=0.03)
        position.command(vx=9.0, vyaw=9.0)
        world.run(8.0)
        assert position.vel_pos[0] == pytest.approx(1.5, rel=0.05)
        assert position.vel_rot[2] == pytest.approx(1.4, rel=0.05)


def test_segway_falls_when_its_motors_are_off_and_lies_still():
    with world_of("SegwayRMP", rpy="0 3 0") as world:
        position = world.interface("position", "r")
        position.enable_motors(False)
        world.run(10.0)
        assert abs(position.rot[1]) > math.radians(60)
        position.enable_motors()
        position.command(vx=1.0)
        world.run(10.0)
        assert fastest(world) < 0.02  # fallen over, it gives up


@pytest.mark.parametrize("step", [0.02, 0.01, 0.005])
@pytest.mark.parametrize("drop", [0.1, 0.2, 0.3])
@pytest.mark.parametrize(
    ("x", "box"), [(0.0, "<mass>100</mass>"), (0.1, "<mass>10</mass><cfm>0.01</cfm>"), (0.1, None)]
)
def test_segway_of_a_04_file_survives_a_drop(step, drop, x, box):
    laser = f"<model:SickLMS200><id>laser1</id><xyz>{x} 0 0.85</xyz></model:SickLMS200>"
    around = f"<param:Global><stepTime>{step}</stepTime></param:Global>"
    if box:
        around += f"<model:SimpleSolid><xyz>0 0 0.25</xyz><size>9 9 0.5</size>{box}</model:SimpleSolid>"
    place = f"0 0 {0.5 * bool(box) + drop}"
    with world_of("SegwayRMP", laser, around, place, root="version='0.4'") as world:
        robot, leaning = world.model("r"), 0.0
        for _ in range(100):
            world.run(0.1)
            leaning = max(leaning, abs(math.degrees(attitude(robot).y)))
        assert leaning < 15.0
        world.interface("position", "r").command(vx=0.5)
        world.run(4.0)
        assert abs(math.degrees(attitude(robot).y)) < 15.0
        assert world.interface("position", "r").vel_pos[0] == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("root", ["", "version='0.5'"])
def test_segway_of_a_05_file_has_undamped_tires(root):
    with world_of("SegwayRMP", root=root) as world:
        tires = world.model("r").bodies[2:]
        assert [geom.surface(Surface.KD) for body in tires for geom in body.geoms] == [0.0, 0.0]


# Shrimp ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("height", "yaw"), [(0.05, 0), (0.05, 25), (0.10, 0)])
def test_shrimp_climbs_a_step_up_and_down(height, yaw):
    step = f"<model:SimpleSolid><xyz>1 0 0</xyz><size>1 4 {height}</size><mass>500</mass></model:SimpleSolid>"
    with world_of("Shrimp", around=step, rpy=f"0 0 {yaw}") as world:
        robot = world.model("r")
        world.interface("position", "r").command(vx=0.2)
        highest = 0.0
        for _ in range(170):
            world.run(TICK)
            highest = max(highest, robot.GetPose().pos.z)
        assert highest == pytest.approx(0.199 + height, abs=3e-3)
        assert robot.GetPose().pos.x > 2.0
        assert robot.GetPose().pos.z == pytest.approx(0.199, abs=2e-3)


# Flyers ----------------------------------------------------------------------------------------------------------


def test_blimp_hovers_and_flies_in_three_dimensions():
    with world_of("Blimp", "<is3d>true</is3d>", rpy="0 0 90") as world:
        robot, position = world.model("r"), world.interface("position", "r")
        world.run(5.0)
        assert tuple(robot.GetPose().pos) == pytest.approx((0, 0, 10), abs=1e-9)
        position.command(vx=1.0, vz=0.5)
        world.run(20.0)
        x, y, z = robot.GetPose().pos
        assert position.vel_pos == pytest.approx((1.0, 0.0, 0.5), abs=0.01)
        assert position.pos == pytest.approx((y, -x, z - 10), abs=0.2)  # counted from where it started, facing +y
        assert position.pos[0] == pytest.approx(18, abs=0.5)
        position.command(vyaw=0.2)
        world.run(30.0)
        assert position.vel_rot == pytest.approx((0, 0, 0.2), abs=0.01)
        assert math.degrees(abs(attitude(robot).x)) < 1


def test_blimp_sinks_slowly_with_a_camera_below():
    # 0.98 N against a drag of 15 N s/m.
    camera = "<model:MonoCam><id>camera1</id><xyz>0 0 -2</xyz></model:MonoCam>"
    with world_of("Blimp", camera) as world:
        world.run(20.0)
        assert world.interface("position", "r").vel_pos[2] == pytest.approx(-0.98 / 15, rel=0.05)


def test_avatarheli_falls_and_lands_on_its_skids():
    with world_of("AvatarHeli", xyz="0 0 1") as world:
        world.run(5.0)
        robot = world.model("r")
        assert robot.GetPose().pos.z == pytest.approx(0.49, abs=2e-3)
        assert fastest(world) < 0.02
        assert math.degrees(abs(attitude(robot).y)) < 0.5


# Bandit ----------------------------------------------------------------------------------------------------------

ORDER = [f"{s}_{j}" for s in "LR" for j in ("SHOULDER", "UPPERARM", "ELBOW", "LOWERARM", "WRIST")] + ["HEAD"]


def test_bandit_moves_its_joints_to_the_commands():
    with world_of("Bandit", xyz="1 2 0.8", rpy="0 0 90") as world:
        robot, joints = world.model("r"), world.interface("joint", "r")
        world.run(2.0)
        assert tuple(robot.GetPose().pos) == pytest.approx((1, 2, 0.8), abs=1e-6)
        assert fastest(world) < 1e-6
        assert [servo.joint.name for servo in robot.servos] == ORDER
        kinds = [int(joint["type"]) for joint in joints.joints]
        two = {4, 9, 10}
        assert kinds == [JointType.UNIVERSAL if i in two else JointType.HINGE for i in range(11)]
        for i in range(11):
            joints.command(i, 0.1 * i - 0.5, 0.3)
        world.run(0.5)
        assert joints.joints["angular_velocity"][0] < -0.05
        world.run(4.0)
        assert joints.joints["angle"] == pytest.approx(0.1 * np.arange(11) - 0.5, abs=1e-3)
        assert joints.joints["angle2"] == pytest.approx([0.3 * (i in two) for i in range(11)], abs=1e-3)
        assert tuple(robot.GetPose().pos) == pytest.approx((1, 2, 0.8), abs=1e-6)


def test_bandit_publishes_the_axes_of_its_joints():
    with world_of("Bandit", xyz="0 0 0.8") as world:
        joints = world.interface("joint", "r")
        joints.command(10, 0.4, 0.3)
        joints.command(0, -0.5)
        world.run(4.0)
        torso, head, shoulder = (world.body("r", name).GetPose() for name in ("canonical", "head", "leftShoulder"))
        look, lift = joints.joints[10], joints.joints[0]
        assert look["axis"] == pytest.approx((0, 0, 1), abs=1e-3)
        assert look["axis2"] == pytest.approx((-math.sin(0.4), math.cos(0.4), 0), abs=1e-3)
        assert look["anchor"] == pytest.approx((0, 0, 0.8 + 0.42), abs=1e-3)
        assert lift["axis"] == pytest.approx((0, 1, 0), abs=1e-3)
        turn = GzQuaternMul(GzQuaternFromAxis(0, 0, 1, 0.4), GzQuaternFromAxis(0, 1, 0, 0.3))
        assert tuple(GzCoordPoseSub(head, torso).rot) == pytest.approx(tuple(turn), abs=1e-3)
        assert GzQuaternToEuler(GzCoordPoseSub(shoulder, torso).rot).y == pytest.approx(-0.5, abs=1e-3)


def test_bandit_stays_at_its_pose_and_moves_with_a_robot():
    with world_of("Bandit", xyz="0 0 0.8") as world:
        robot = world.model("r")
        world.run(0.5)
        pose = robot.GetPose()
        pose.pos.x = 3.0
        world.SetModelPose(robot, pose)
        world.run(1.0)
        assert tuple(robot.GetPose().pos) == pytest.approx((3, 0, 0.8), abs=1e-6)
    with world_of("Atrv", "<model:Bandit><id>b</id><xyz>0 0 0.8</xyz></model:Bandit>") as world:
        world.interface("position", "r").command(vx=0.3)
        world.run(5.0)
        x, y, z = GzCoordPoseSub(world.model("b").GetPose(), world.model("r").GetPose()).pos
        assert (x, y, z) == pytest.approx((0, 0, 0.8), abs=0.01)
        assert world.model("r").GetPose().pos.x > 1.3


def test_a_bandit_checks_a_command_once(monkeypatch):
    """What is refused may stand for ever; it must not cost anything in each tick."""
    with world_of("Bandit", xyz="0 0 0.8") as world:
        robot, checked = world.model("r"), []
        number = robot.guard.number
        monkeypatch.setattr(robot.guard, "number", lambda name, *values: checked.append(name) or number(name, *values))
        joints = world.interface("joint", "r").data.joints
        world.step(10)
        checked.clear()
        for value in (math.nan, 1e9, 0.5):
            joints[2].cmd_angle = value
            world.step(100)
            assert checked == ["joints[2].cmd_angle", "joints[2].cmd_angle2"]
            checked.clear()
        assert robot.servos[2].command == (0.5, 0.0)
        robot.servos[2].command = (0.1, 0.0)  # the client's command holds
        world.step(100)
        assert robot.servos[2].command == (0.5, 0.0)


def test_a_robot_checks_a_command_once(monkeypatch):
    with world_of("Pioneer2AT", xyz="0 0 0.3") as world:
        server, checked = world.model("r").position, []
        number = server._guard.number
        monkeypatch.setattr(
            server._guard, "number", lambda name, *values: checked.append(name) or number(name, *values)
        )
        data = world.interface("position", "r").data
        world.step(10)
        for value in (math.nan, 1e9, 0.5):
            data.cmd_vel_pos[0] = value
            world.step(100)
            assert checked == ["cmd_vel_pos[0]", "cmd_vel_rot[2]"]
            checked.clear()
        assert server.command == (0.5, 0.0)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300])
def test_bandit_ignores_invalid_angles(bad, caplog):
    with world_of("Bandit", xyz="0 0 0.8") as world:
        joints = world.interface("joint", "r")
        for i in range(11):  # as a C program may write
            joints.data.joints[i].cmd_angle = joints.data.joints[i].cmd_angle2 = bad
        with caplog.at_level(logging.WARNING):
            world.run(3.0)
        assert np.isfinite(world.engine.states).all()
        assert fastest(world) < 5.0
        assert caplog.text.count("joint.r: joints[0].cmd_angle ") == 1


# The ready worlds ------------------------------------------------------------------------------------------------


def test_the_shrimp_climbs_the_steps_of_its_world():
    with libgz.World.from_file(installed_worlds() / "shrimp.world") as world:
        world.run(1.0)
        assert world.model("robot1").GetPose().pos.z == pytest.approx(0.199, abs=2e-3)
        world.interface("position", "robot1").command(vx=0.2)
        world.run(11.0)
        assert world.model("robot1").GetPose().pos.z == pytest.approx(0.199 + 0.15, abs=4e-3)


@pytest.mark.parametrize("model", [*HEIGHTS, "Blimp", "AvatarHeli", "Bandit"])
def test_each_ready_world_has_an_observer_and_can_be_driven_reset_and_driven_again(model, monkeypatch):
    monkeypatch.setenv("LIBGZ_GL", "none")
    with libgz.World.from_file(installed_worlds() / f"{model.lower()}.world") as world:
        robot = world.model("robot1")
        assert robot.GetName() == model
        # The observer looks at the robot: it lies within 15 degrees of the axis.
        eye = world.model("observer").GetPose()
        x, y, z = GzCoordPoseSub(robot.GetPose(), eye).pos
        assert math.degrees(math.atan2(math.hypot(y, z), x)) < 15
        start = tuple(robot.GetPose().pos)
        driven = model not in ("AvatarHeli", "Bandit")
        for _ in range(2):
            if driven:
                world.interface("position", "robot1").command(vx=0.4, vyaw=0.1)
            world.run(2.0)
            assert (robot.GetPose().pos.x - start[0] > 0.2) == driven
            assert math.degrees(abs(attitude(robot).x)) < 3
            world.sim.data.reset = 1
            world.step()
            assert tuple(robot.GetPose().pos) == pytest.approx(start, abs=0.02)
        if driven:
            world.interface("position", "robot1").command()
        world.run(6.0)
        assert model == "Blimp" or fastest(world) < (0.2 if model == "SegwayRMP" else 0.02)
