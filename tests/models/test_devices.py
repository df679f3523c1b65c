"""Devices: the gripper, satellite navigation, truth, separate sonars, radios."""

import logging
import math

import numpy as np
import pytest

import libgz
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzQuatern, GzQuaternFromEuler, GzQuaternToEuler, GzVector
from libgz.interfaces import gripper as codes
from libgz.models.utm import utm_to_geodetic

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"
GROUND = "<model:GroundPlane/>"


def world_of(body, settings="", **options):
    return libgz.World.from_string(f"{HEAD}<param:Global>{settings}</param:Global>{body}</gz:world>", **options)


# Gripper ---------------------------------------------------------------------------------------------------------

GRIPPER = "<model:Pioneer2Gripper><id>g</id><xyz>0.14003 0 -0.0975</xyz></model:Pioneer2Gripper>"
ROBOT = f"<model:Pioneer2DX><id>r</id><xyz>0 0 .238</xyz>{GRIPPER}</model:Pioneer2DX>"


def cube(x=0.30, size="0.07 0.07 0.07", id="cube"):
    return (
        f"<model:SimpleSolid><id>{id}</id><xyz>{x} 0 0</xyz><size>{size}</size><mass>0.1</mass>"
        "<surfaceFriction>40 40</surfaceFriction><surfaceHardness>1e5 1000</surfaceHardness></model:SimpleSolid>"
    )


def flags(interface):
    names = [name for name, _ in interface.data_class._fields_ if name not in ("head", "time", "cmd")]
    return {name for name in names if getattr(interface.data, name)}


OPEN = {"left_paddle_open", "right_paddle_open", "paddles_opened"}
DOWN, UP = {"lift_down", "lift_limit_reach"}, {"lift_up", "lift_limit_reach"}


def test_gripper_lifts_a_cube_and_puts_it_down():
    with world_of(GROUND + ROBOT + cube(size="0.07 0.07 0.06")) as world:
        gripper, solid, model = world.interface("gripper", "g"), world.model("cube"), world.model("g")
        world.run(1.0)
        assert flags(gripper) == OPEN | DOWN | {"grip_limit_reach"}
        gripper.command(codes.CLOSE)
        world.step(7)  # 1 cm per step after the first two, published one step later
        assert model.left.position == pytest.approx(0.062, abs=1e-6)
        assert flags(gripper) == {"paddles_moving"} | DOWN
        world.run(1.0)
        assert (model.left.position, model.right.position) == pytest.approx((0.0703, 0.0703), abs=2e-4)
        assert flags(gripper) == {"paddles_closed"} | DOWN
        gripper.command(codes.LIFT_UP)
        world.step(3)
        assert "lift_moving" in flags(gripper)
        world.run(1.0)
        # The solid's origin is its bottom. It swings between the paddles when the lift stops.
        assert solid.GetPose().pos.z == pytest.approx(0.0625, abs=8e-3)
        assert flags(gripper) == {"paddles_closed"} | UP
        gripper.command(codes.STOP)
        world.run(1.0)
        assert flags(gripper) == {"paddles_closed"} | UP
        assert solid.GetPose().pos.z > 0.06
        gripper.command(codes.LIFT_DOWN)
        world.run(1.0)
        gripper.command(codes.OPEN)
        world.run(1.0)
        assert solid.GetPose().pos.z == pytest.approx(0.0, abs=1e-3)
        assert solid.GetPose().pos.x == pytest.approx(0.30, abs=5e-3)
        assert flags(gripper) == OPEN | DOWN | {"grip_limit_reach"}
        assert gripper.time == pytest.approx(world.GetSimTime() - 0.02)


def test_gripper_carries_a_held_object():
    with world_of(GROUND + ROBOT + cube()) as world:
        world.run(0.5)
        for code in (codes.CLOSE, codes.LIFT_UP):
            world.interface("gripper", "g").command(code)
            world.run(0.5)
        world.interface("position", "r").command(vx=0.2)
        world.run(5.0)
        robot, solid = world.model("r").GetPose().pos, world.model("cube").GetPose().pos
        assert robot.x > 0.8
        assert solid.x - robot.x == pytest.approx(0.30, abs=0.02)
        assert solid.z > 0.055
        # In a curve, too, it knows that it holds it, though ODE's rates of its slides are not zero then.
        world.interface("position", "r").command(vx=0.2, vyaw=0.3)
        world.run(4.0)
        assert abs(world.joint("g", "left_paddle").GetPositionRate()) > 0.02
        assert "paddles_closed" in flags(world.interface("gripper", "g"))


def test_gripper_closes_empty():
    with world_of(GROUND + ROBOT) as world:
        gripper, model = world.interface("gripper", "g"), world.model("g")
        gripper.command(codes.STORE)
        world.run(1.0)
        assert (model.left.position, model.right.position) == pytest.approx((0.105, 0.105), abs=2e-4)
        assert flags(gripper) == {"paddles_closed", "grip_limit_reach"} | UP
        left, right = world.body("g", "left_paddle").GetPosition(), world.body("g", "right_paddle").GetPosition()
        assert right.y - left.y == pytest.approx(0.025, abs=5e-4)  # the thickness of one: they touch
        gripper.command(codes.DEPLOY)
        world.run(1.0)
        assert flags(gripper) == OPEN | DOWN | {"grip_limit_reach"}


@pytest.mark.parametrize(("x", "seen"), [(0.313, {"outer"}), (0.263, {"inner"}), (0.288, set()), (0.40, set())])
def test_gripper_beams_detect_objects_between_the_paddles(x, seen):
    with world_of(GROUND + ROBOT + cube(x, "0.03 0.05 0.12")) as world:
        world.run(0.5)
        found = {
            name
            for name in ("outer", "inner")
            if getattr(world.interface("gripper", "g").data, f"{name}_beam_obstruct")
        }
        assert found == seen


def test_gripper_beams_detect_a_held_object_and_not_the_gripper():
    with world_of(GROUND + ROBOT + cube(0.29, "0.08 0.08 0.12")) as world:
        gripper = world.interface("gripper", "g")
        gripper.command(codes.CLOSE)
        world.run(1.0)
        assert {"outer_beam_obstruct", "inner_beam_obstruct", "paddles_closed"} <= flags(gripper)
        world.SetModelPose(world.model("cube"), GzPose(GzVector(2, 0, 0)))
        world.run(1.0)
        assert not {"outer_beam_obstruct", "inner_beam_obstruct"} & flags(gripper)


def test_unknown_gripper_commands_do_nothing():
    with world_of(GROUND + ROBOT) as world:
        gripper = world.interface("gripper", "g")
        for command in (16, 17, 0, -1, 10**9):
            gripper.command(command)
            world.run(0.2)
        assert flags(gripper) == OPEN | DOWN | {"grip_limit_reach"}
        gripper.command(codes.CLOSE)
        world.step(5)
        gripper.command(codes.HALT)
        world.step(5)
        half = world.model("g").left.position
        assert 0.01 < half < 0.09
        world.run(1.0)
        assert world.model("g").left.position == pytest.approx(half, abs=1e-3)
        assert "paddles_moving" in flags(gripper)


@pytest.mark.parametrize("quirks", ["", "setMassZero", "true"])
def test_gripper_masses_are_those_that_the_old_server_gave_ode(quirks):
    with world_of(ROBOT, f"<legacyQuirks>{quirks}</legacyQuirks>") as world:
        base, *others = (body.GetMass() for body in world.model("g").bodies)
        moments = [base.I[i] for i in (0, 5, 10)]
        assert [base.mass, *moments] == pytest.approx([0.1, 0.000271041667, 0.000161666667, 0.000151041667], rel=1e-8)
        for mass in others:
            assert [mass.mass, *mass.I] == [1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]


def test_gripper_motors_are_plain():
    """A paddle of 1 kg gains 0.2 m/s in a step from 10 N, up to 0.5 m/s, which holds until its stop."""
    with world_of(GROUND + ROBOT, "<legacyQuirks>true</legacyQuirks>") as world:
        model = world.model("g")
        world.run(2.0)
        world.interface("gripper", "g").command(codes.CLOSE)
        expected = model.left.position
        for speed in (0.2, 0.4, *(0.5,) * 9):
            world.step()
            expected += 0.02 * speed
            assert (model.left.position, model.right.position) == pytest.approx((expected, expected), abs=1e-7)
        assert model.left.position > 0.101
        assert model.right.joint.GetPosition() == -model.right.position
        world.run(2.0)
        assert (model.left.position, model.right.position) == pytest.approx((0.105, 0.105), abs=1e-6)


def test_gripper_state_follows_the_command_with_the_quirk():
    with world_of(GROUND + ROBOT + cube(0.263, "0.03 0.05 0.12"), "<legacyQuirks>gripperState</legacyQuirks>") as world:
        gripper = world.interface("gripper", "g")
        both = OPEN | {"lift_up", "lift_down"}
        assert flags(gripper) == both, "before the first step"
        gripper.command(codes.STOP)
        world.step(3)
        assert flags(gripper) == both, "before the first command that moves something"
        gripper.command(codes.LIFT_UP)
        world.step()
        assert flags(gripper) == OPEN | {"lift_up"}
        gripper.command(codes.STORE)
        world.step()
        assert flags(gripper) == {"paddles_closed", "lift_up"}
        gripper.command(codes.DEPLOY)
        world.step()
        assert flags(gripper) == OPEN | {"lift_down"}


def test_gripper_outer_beam_detects_the_shut_paddle_with_the_quirk():
    with world_of(GROUND + ROBOT, "<legacyQuirks>gripperState</legacyQuirks>") as world:
        gripper = world.interface("gripper", "g")
        world.run(1.0)
        assert not gripper.data.outer_beam_obstruct
        gripper.command(codes.CLOSE)
        world.run(1.0)
        assert flags(gripper) == {"paddles_closed", "lift_up", "lift_down", "outer_beam_obstruct"}
        gripper.command(codes.OPEN)
        world.run(1.0)
        assert flags(gripper) == OPEN | {"lift_up", "lift_down"}


@pytest.mark.parametrize(("quirks", "opened", "moving", "closed"), [("", 1, 3, 2), ("gripperState", 0, 1, 1)])
def test_gripper_serves_the_struct_that_came_later(quirks, opened, moving, closed):
    robot = ROBOT.replace("<id>g</id>", "<id>g</id><laterInterface>true</laterInterface>")
    with world_of(GROUND + robot, f"<legacyQuirks>{quirks}</legacyQuirks>") as world:
        gripper = world.interface("gripper", "g")
        assert gripper.size == 200
        gripper.command(codes.OPEN)
        world.step(3)
        assert (gripper.data.state, gripper.data.left_paddle_open) == (opened, 1)
        gripper.command(codes.CLOSE)
        world.step(3)
        assert gripper.data.state == moving
        world.run(1.0)
        assert (gripper.data.state, gripper.data.left_paddle_open) == (closed, 0)


# GPS -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("easting", "northing", "zone", "latitude", "longitude"),
    [
        (448251.795, 5411932.678, 31, 48.858200, 2.294500),
        (499015.29, 3846508.76, 11, 34.760723, -117.010760),
        (500000.0, 0.0, 31, 0.0, 3.0),
        (500000.0, 10000000.0, -1, 0.0, -177.0),
    ],
)
def test_utm_of_known_points(easting, northing, zone, latitude, longitude):
    assert utm_to_geodetic(easting, northing, zone) == pytest.approx((latitude, longitude), abs=6e-7)


@pytest.mark.parametrize("latitude", [1.0, 23.0, 48.0, 66.5, 83.0])
def test_northing_on_the_central_meridian_is_the_length_of_the_meridian(latitude):
    a, f = 6378137.0, 1.0 / 298.257223563
    e2 = f * (2.0 - f)
    phi = np.linspace(0.0, math.radians(latitude), 20001)
    radius = a * (1 - e2) / (1 - e2 * np.sin(phi) ** 2) ** 1.5
    arc = float(np.sum((radius[1:] + radius[:-1]) / 2.0 * np.diff(phi)))
    found = utm_to_geodetic(500000.0, 0.9996 * arc, 33)
    assert found == pytest.approx((latitude, 15.0), abs=1e-8)
    south = utm_to_geodetic(500000.0, 10000000.0 - 0.9996 * arc, -33)
    assert south == pytest.approx((-latitude, 15.0), abs=1e-8)


def test_gps_publishes_the_position_of_its_robot():
    settings = "<utmZone>31</utmZone><utmOffset>448241.795 5411902.678 35</utmOffset><utcOffset>1000</utcOffset>"
    gps = "<model:GarminGPS><id>gps1</id><xyz>0 0 .32</xyz></model:GarminGPS>"
    robot = f"<model:Pioneer2AT><id>r</id><xyz>10 30 0</xyz>{gps}</model:Pioneer2AT>"
    with world_of(GROUND + robot, settings) as world:
        fix, times = world.interface("gps", "gps1"), set()
        for _ in range(110):
            world.step()
            times.add(round(fix.time, 6))
        assert sorted(times) == [0.0, 1.0, 2.0]
        assert fix.data.utc_time == pytest.approx(1002.0)
        assert fix.latitude == pytest.approx(48.8582, abs=1e-6)
        assert fix.longitude == pytest.approx(2.2945, abs=1e-6)
        assert fix.utm == pytest.approx((448251.795, 5411932.678, 35.32), abs=5e-3)
        data = fix.data
        assert (data.satellites, data.quality, data.hdop, data.vdop, data.err_horz) == (10, 2, 1.0, 1.0, 0.0)
        assert world.body("gps1").mass == pytest.approx(1.0)


def test_gps_without_a_zone_has_no_latitude_and_warns(caplog):
    with world_of("<model:GarminGPS><id>a</id><size>.1 .2</size><xyz>1 2 3</xyz></model:GarminGPS>") as world:
        world.step()
        fix = world.interface("gps", "a")
        assert (fix.latitude, fix.longitude) == (0.0, 0.0)
        assert fix.utm == pytest.approx((1, 2, 3))
        assert world.body("a").GetCoMPose().pos.z == pytest.approx(3.1, abs=0.01)
    assert caplog.text.count("<utmZone>") == 1


# Truth -----------------------------------------------------------------------------------------------------------

TRUTH = "<model:TruthWidget><id>t</id><xyz>0.1 0.2 0.3</xyz></model:TruthWidget>"


def poses_agree(a, b):
    return tuple(a.pos) == pytest.approx(tuple(b.pos), abs=1e-9) and tuple(a.rot) == pytest.approx(tuple(b.rot))


def test_truth_is_the_pose_of_the_model_it_sits_in():
    robot = f"<model:Pioneer2DX><id>r</id><xyz>1 2 .238</xyz><rpy>0 0 70</rpy>{TRUTH}</model:Pioneer2DX>"
    with world_of(GROUND + robot) as world:
        truth = world.interface("truth", "t")
        assert poses_agree(truth.pose, world.model("r").GetPose())
        world.interface("position", "r").command(vx=0.3, vyaw=0.4)
        for _ in range(50):
            before = world.model("r").GetPose()
            world.step()
            assert poses_agree(truth.pose, before)
            assert truth.time == pytest.approx(world.GetSimTime() - 0.02)


def test_truth_moves_a_model_at_rest_and_all_that_is_on_it():
    laser = "<model:SickLMS200><id>l</id><xyz>0 0 .01</xyz></model:SickLMS200>"
    robot = f"<model:Pioneer2DX><id>r</id><xyz>1 2 .238</xyz>{laser}{TRUTH}</model:Pioneer2DX>"
    with world_of(robot, "<gravity>0 0 0</gravity>") as world:
        truth, model = world.interface("truth", "t"), world.model("r")
        model.GetBody().SetLinearVel((1, 0, 0))
        there = GzPose(GzVector(-3, 4, 5), GzQuaternFromEuler(0.1, -0.2, 2.5))
        truth.move(there)
        world.step()
        assert truth.data.cmd_new == 0
        assert poses_agree(truth.pose, there)
        assert poses_agree(model.GetPose(), there)
        assert tuple(model.GetBody().GetLinearVel()) == pytest.approx((0, 0, 0), abs=1e-9)
        on_top = GzCoordPoseAdd(GzPose(GzVector(0, 0, 0.01)), there)
        assert tuple(world.model("l").GetPose().pos) == pytest.approx(tuple(on_top.pos), abs=1e-6)


def test_truth_moves_a_model_that_sits_on_another():
    box = f"<model:SimpleSolid><id>box</id><xyz>0 0 .4</xyz>{TRUTH}</model:SimpleSolid>"
    with world_of(f"<model:Pioneer2AT><id>r</id><xyz>1 1 0</xyz><rpy>0 0 90</rpy>{box}</model:Pioneer2AT>") as world:
        there = GzPose(GzVector(1.5, 1.5, 0.5), GzQuaternFromEuler(0, 0, 0.3))
        world.interface("truth", "t").move(there)
        world.sim.data.pause = 1  # moving goes on while the world stands still
        world.step()
        assert poses_agree(world.model("box").GetPose(), there)


def test_top_level_truth_publishes_and_moves_itself():
    with world_of("<model:TruthWidget><id>t</id><xyz>1 2 3</xyz></model:TruthWidget>") as world:
        truth = world.interface("truth", "t")
        assert tuple(truth.pose.pos) == (1, 2, 3)
        truth.move(GzPose(GzVector(4, 5, 6), GzQuatern(2.0, 0, 0, 0)))  # any length will do
        world.step()
        assert tuple(truth.pose.pos) == (4, 5, 6)
        assert tuple(truth.pose.rot) == (1, 0, 0, 0)


@pytest.mark.parametrize(
    ("position", "rotation"),
    [
        ((math.nan, 0, 0), (1, 0, 0, 0)),
        ((1e300, 0, 0), (1, 0, 0, 0)),
        ((0, 0, 0), (0, 0, 0, 0)),
        ((0, 0, 0), (math.inf, 0, 0, 0)),
    ],
)
def test_invalid_poses_are_ignored(position, rotation, caplog):
    with world_of(f"<model:SimpleSolid><id>s</id>{TRUTH}</model:SimpleSolid>", "<gravity>0 0 0</gravity>") as world:
        truth = world.interface("truth", "t")
        with caplog.at_level(logging.WARNING):
            for _ in range(3):
                truth.data.cmd_pos[:], truth.data.cmd_rot[:] = position, rotation  # as a C program may write
                truth.data.cmd_new = 1
                world.step()
        assert tuple(world.model("s").GetPose().pos) == (0, 0, 0)
        assert truth.data.cmd_new == 0
        assert caplog.text.count("a client wrote truth.t") == 1


def test_truth_of_0x050_has_angles(caplog):
    with world_of("<model:TruthWidget><id>t</id><rpy>10 20 30</rpy></model:TruthWidget>", wire_version=0x050) as world:
        truth = world.interface("truth", "t")
        assert tuple(truth.data.rot) == pytest.approx(np.radians((10, 20, 30)))
        truth.data.cmd_pos[:], truth.data.cmd_rot[:], truth.data.cmd_new = (1, 2, 3), (0.1, 0.2, 0.3), 1
        world.step()
        assert tuple(truth.data.pos) == (1, 2, 3)
        assert tuple(truth.data.rot) == pytest.approx((0.1, 0.2, 0.3))
        truth.data.cmd_rot[:], truth.data.cmd_new = (math.inf, 0, 0), 1
        world.step()
        assert tuple(truth.data.rot) == pytest.approx((0.1, 0.2, 0.3))
        assert "not a valid pose" in caplog.text


# Sonars ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("model", "z", "front", "rear"), [("Pioneer2AT", "0", 0.24103, 0.24103), ("Pioneer2DX", ".335", 0.14103, 0.24103)]
)
def test_separate_sonars_have_the_ranges_of_the_robots_own(model, z, front, rear):
    walls = "".join(
        f"<model:SimpleSolid><xyz>{x} {y} 0.5</xyz><size>{size}</size></model:SimpleSolid>"
        for x, y, size in ((2.5, 0, "1 5 1"), (-2.5, 0, "1 5 1"), (0, 3.5, "9 1 1"))
    )
    sonars = "<model:Pioneer2Sonars><id>s</id></model:Pioneer2Sonars>"
    robot = f"<model:{model}><id>r</id><xyz>0 0 {z}</xyz>{sonars}</model:{model}>"
    with world_of(robot + walls, "<gravity>0 0 0</gravity>") as world:
        world.step(6)
        own, other = world.interface("sonar", "r"), world.interface("sonar", "s")
        assert other.data.sonar_count == 16
        assert np.array_equal(other.ranges, own.ranges)
        assert np.array_equal(other.sonar_pos, own.sonar_pos)
        assert other.max_range == 5.0
        ten = math.cos(math.radians(10))
        assert other.ranges[3] == pytest.approx((2.0 - front) / ten, abs=1e-6)
        assert other.ranges[11] == pytest.approx((2.0 - rear) / ten, abs=1e-6)
        assert other.ranges[0] == pytest.approx(3.0 - 0.135, abs=1e-6)
        assert other.ranges[7] == 5.0


def test_sonars_without_a_robot_hear_from_where_they_are():
    wall = "<model:SimpleSolid><xyz>2.5 0 0.5</xyz><size>1 9 1</size></model:SimpleSolid>"
    with world_of(
        f"{wall}<model:Pioneer2Sonars><id>s</id><xyz>0 0 .5</xyz></model:Pioneer2Sonars>", "<gravity>0 0 0</gravity>"
    ) as world:
        world.step()
        assert world.interface("sonar", "s").ranges[3] == pytest.approx((2.0 - 0.14103) / math.cos(math.radians(10)))


# WiFi ------------------------------------------------------------------------------------------------------------


def radio(id, x, extra=""):
    return f"<model:WiFi><id>{id}</id><xyz>{x} 0 1</xyz>{extra}</model:WiFi>"


def heard(world, id):
    wifi = world.interface("wifi", id)
    return [
        (b"".join(link["ip"]).decode(), int(np.int16(link["level"])), int(np.int16(link["noise"])))
        for link in wifi.links
    ]


def level(power, distance, exponent=2.0):
    return round(power - 20 * math.log10(4 * math.pi * 2.437e9 / 299792458) - 10 * exponent * math.log10(distance))


def test_radios_hear_each_other_by_distance():
    body = radio("a", 0) + radio("b", 10) + radio("c", 40, "<ip>10.1.2.3</ip><power>20</power>")
    with world_of(body) as world:
        world.step()
        assert heard(world, "a") == [("192.168.0.2", level(15, 10), -95), ("10.1.2.3", level(20, 40), -95)]
        assert heard(world, "b") == [("192.168.0.1", level(15, 10), -95), ("10.1.2.3", level(20, 30), -95)]
        assert all(link["qual"] == 1 for link in world.interface("wifi", "a").links)
        world.SetModelPose(world.model("b"), GzPose(GzVector(0.2, 0, 1)))
        world.run(0.2)
        assert heard(world, "a")[0] == ("192.168.0.2", level(15, 1), -95)  # the formula begins at 1 m


def test_radios_out_of_reach_are_not_heard():
    losses = "<pathLoss>4</pathLoss><noise>-80</noise><sensitivity>-70</sensitivity>"
    with world_of(radio("a", 0, losses) + radio("b", 10) + radio("c", 20)) as world:
        world.step()
        assert heard(world, "a") == [("192.168.0.2", level(15, 10, 4), -80)]
        assert len(heard(world, "b")) == 2


def test_a_radio_has_at_most_sixteen_links_the_strongest():
    with world_of("".join(radio(f"r{i}", 3 * i) for i in range(20))) as world:
        world.step()
        links = heard(world, "r0")
        assert len(links) == 16
        assert [ip for ip, *_ in links] == [f"192.168.0.{i + 1}" for i in range(1, 17)]
        assert "r0" not in {ip for ip, *_ in links}


def test_radio_addresses_are_checked(caplog):
    with world_of(radio("a", 0, "<ip>10.0.0.1</ip>") + radio("b", 1, "<ip>10.0.0.1</ip>")):
        assert "the address 10.0.0.1 is already used by 'a'" in caplog.text
    with pytest.raises(libgz.WorldFileError, match="at most 31 bytes"):
        world_of(radio("a", 0, f"<ip>{'1' * 32}</ip>"))


# Known by name only ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["TotemPole", "PointSet"])
def test_models_known_by_name_only_are_skipped_with_a_warning(name, caplog):
    solid = "<model:SimpleSolid><id>s</id><xyz>0 0 1</xyz></model:SimpleSolid>"
    with world_of(f"<model:{name}><id>p</id><xyz>1 0 0</xyz><colors><c>1</c></colors>{solid}</model:{name}>") as world:
        assert world.GetNumModels() == 0
    assert [r.getMessage().count("its attributes are not documented") for r in caplog.records] == [1]


def test_a_gripper_over_the_wire(gazebo, wire, tmp_path):
    path = tmp_path / "g.world"
    path.write_text(f"{HEAD}{GROUND}{ROBOT}</gz:world>")
    gazebo(path)
    with libgz.Client(wire) as client:
        gripper = client.gripper("g")
        gripper.command(codes.CLOSE)
        for _ in range(1000):
            client.wait(timeout=5.0)
            if gripper.closed:
                break
        assert gripper.closed
        gripper.close()


def test_yaw_of_a_moved_robot():
    with world_of(f"<model:SimpleSolid><id>s</id>{TRUTH}</model:SimpleSolid>", "<gravity>0 0 0</gravity>") as world:
        world.interface("truth", "t").move(GzPose(GzVector(), GzQuaternFromEuler(0, 0, 1.2)))
        world.step()
        assert GzQuaternToEuler(world.model("s").GetPose().rot).z == pytest.approx(1.2)
