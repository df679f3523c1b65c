"""The built-in models: how they rest, drive, and see."""

import itertools
import logging
import math
import shutil

import numpy as np
import pytest

import libgz
from libgz.base.geometry import GzQuaternToEuler
from libgz.models import MODELS
from libgz.worldfile.attributes import attributes_of, installed_worlds

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"
GROUND = "<model:GroundPlane/>"


def world_of(body, **options):
    return libgz.World.from_string(f"{HEAD}{body}</gz:world>", **options)


def yaw_of(model):
    return GzQuaternToEuler(model.GetPose().rot).z


# What a model cannot do without.
NEEDED = {
    "MapExtruder": "<imageFile>example2.png</imageFile>",
    "Road": "<roadFile>road.txt</roadFile>",
    "Terrain": "<terrainFile>terrain.gzb</terrainFile>",
}


def test_every_model_loads_with_its_defaults():
    # With interfaces for 32-bit programs, whose places are others; nearly all other tests have those of this machine.
    for name in MODELS:
        text = f"<model:{name}><id>m</id><xyz>0 0 1</xyz>{NEEDED.get(name, '')}</model:{name}>"
        with world_of(text, abi="i386") as world:
            world.step(10)
            assert world.model("m").failed is None


def test_every_attribute_is_described():
    import dataclasses
    import importlib

    for target in MODELS.values():
        module = importlib.import_module(target.partition(":")[0])
        for value in vars(module).values():
            if dataclasses.is_dataclass(value) and isinstance(value, type) and value.__name__.endswith("Attributes"):
                assert all(attribute.help for attribute in attributes_of(value).values())


# Measured motion of the original server (ODE 0.16.2, dWorldStep, 20 ms) ------------------------------------------


def test_dropped_solids_move_as_measured():
    shapes = (("box", "0.3 0.3 0.3"), ("cylinder", "0.3 0.4"), ("sphere", "0.3"))
    solids = "".join(
        f"<model:SimpleSolid><id>{shape}</id><xyz>{2 * i} 0 0.5</xyz>"
        f"<shape>{shape}</shape><size>{size}</size></model:SimpleSolid>"
        for i, (shape, size) in enumerate(shapes)
    )
    with world_of(GROUND + solids) as world:
        for steps, height in ((5, 0.4412), (5, 0.2844), (5, 0.0296)):
            world.step(steps)
            for shape, _ in shapes:
                assert world.model(shape).GetPose().pos.z == pytest.approx(height, abs=1e-6)
        world.run(2.7)
        assert world.model("box").GetPose().pos.z == pytest.approx(-2.45e-6, abs=1e-7)
        assert world.model("sphere").GetPose().pos.z == pytest.approx(-9.8e-6, abs=1e-7)


def test_pioneer2at_drives_as_measured():
    with world_of(GROUND + "<model:Pioneer2AT><id>r</id></model:Pioneer2AT>") as world:
        robot, position = world.model("r"), world.interface("position", "r")
        turned = last = 0.0
        yaws, places = [], []
        for seconds, speed, turn in ((2, 0, 0), (10, 0.3, 0), (5, 0, 0.5), (5, 0.3, 0.3), (2, 0, 0)):
            position.command(vx=speed, vyaw=turn)
            for _ in range(round(seconds / 0.02)):
                world.step()
                turned += math.remainder(yaw_of(robot) - last, 2 * math.pi)
                last = yaw_of(robot)
            yaws.append(turned)
            places.append(tuple(robot.GetPose().pos))
        assert places[0][2] == pytest.approx(0.00132, abs=2e-5)
        assert places[1][0] == pytest.approx(2.994, abs=0.02)
        assert yaws[2] == pytest.approx(1.940, abs=0.03)
        assert yaws[3] - yaws[2] == pytest.approx(1.078, abs=0.03)
        assert places[4][:2] == pytest.approx((1.885, 0.923), abs=0.1)
        assert robot.odometry.pose[2] == pytest.approx(2.480 + 1.508 + 0.012, abs=0.03)
        assert robot.battery.level == pytest.approx(12.38666, abs=1e-4)


def test_masses_with_the_quirks():
    body = """<param:Global><legacyQuirks>true</legacyQuirks></param:Global>
    <model:Pioneer2AT><id>a</id><model:SickLMS200><id>l</id><xyz>0.1 0 0.32</xyz></model:SickLMS200></model:Pioneer2AT>
    <model:Pioneer2DX><id>b</id><xyz>0 5 .25</xyz><model:SonyVID30><id>c</id></model:SonyVID30></model:Pioneer2DX>
    <model:SimpleSolid><id>s</id><xyz>5 0 0</xyz><shape>cylinder</shape><size>0.3 0.4</size></model:SimpleSolid>"""
    # mass, I11, I22, I33, I13, centre x, centre z, as the original server gave them to ODE
    measured = {
        ("a", "canonical"): (10.0040645, 0.509866345, 0.603977873, 0.290177213, 0, 0, 0.195292569),
        ("a", "left_front"): (1, 0.004, 0.004, 0.004, 0, 0, 0),
        ("l", "canonical"): (7.00318086, 0.105025426, 0.105025426, 0.0262589462, 0.00875, -0.0124943225, 0.0933363614),
        ("b", "canonical"): (5.000855, 0.0785519569, 0.120849901, 0.103068521, -0.02125, -0.05, -0.0849854675),
        ("b", "caster"): (5, 0.0032, 0.0032, 0.0032, 0, 0, 0),
        ("c", "middle"): (0.1, 0.000175483333, 0.000110683333, 0.00011895, 0, 0, 0.028),
        ("c", "head"): (
            0.100018096,
            0.000574316179,
            0.000574390178,
            0.00024007921,
            -7.7041905e-08,
            1.17599949e-05,
            0.0655,
        ),
        ("s", "canonical"): (1, 0.0589583333, 0.0589583333, 0.01125, 0, 0, 0.2),
    }
    with world_of(body) as world:
        for (model, name), expected in measured.items():
            found = world.body(model, name)
            mass, com = found.GetMass(), found.com
            values = (mass.mass, mass.I[0], mass.I[5], mass.I[10], mass.I[2], com[0], com[2])
            assert values == pytest.approx(expected, rel=1e-6, abs=1e-9), (model, name)


def test_camera_head_pans_and_tilts_as_measured():
    text = (
        GROUND + "<model:Pioneer2AT><model:SonyVID30><id>c</id><xyz>.1 0 .34</xyz></model:SonyVID30></model:Pioneer2AT>"
    )
    with world_of(text) as world:
        world.run(1.0)
        ptz, camera = world.interface("ptz", "c"), world.model("c")
        ptz.command(pan=0.5, tilt=-0.3)
        errors = []
        for _ in range(30):
            errors.append(0.5 - camera.pan.GetAngle())
            world.step(5)
        # The error shrinks by a fifth every tenth of a second, without overshoot.
        assert [b / a for a, b in itertools.pairwise(errors[1:13])] == pytest.approx([0.8] * 11, abs=0.01)
        assert camera.pan.GetAngle() == pytest.approx(0.5, abs=2e-3)
        assert camera.tilt.GetAngle() == pytest.approx(-0.3, abs=2e-3)
        assert ptz.pan == pytest.approx(0.5, abs=5e-3)


# Robots ----------------------------------------------------------------------------------------------------------


def rest(model, xyz="0 0 0", extra="", seconds=5.0):
    world = world_of(f"{GROUND}<model:{model}><id>r</id><xyz>{xyz}</xyz>{extra}</model:{model}>")
    world.run(seconds)
    return world


LASER = "<model:SickLMS200><id>laser1</id><xyz>{}</xyz></model:SickLMS200>"


@pytest.mark.parametrize(
    ("model", "xyz", "extra", "height", "pitch"),
    [
        ("Pioneer2AT", "0 0 0", "", 0.0013, 0.0),
        ("Pioneer2AT", "0 0 0", LASER.format("0 0 0.31"), -0.0004, -0.07),
        ("Pioneer2DX", "0 0 0.25", "", 0.2376, -0.96),
        ("Pioneer2DX", "0 0 0.25", LASER.format("0 0 0"), 0.2344, -0.22),
    ],
)
def test_robots_rest_where_they_did(model, xyz, extra, height, pitch):
    with rest(model, xyz, extra) as world:
        robot = world.model("r")
        assert robot.GetPose().pos.z == pytest.approx(height, abs=3e-4)
        assert math.degrees(GzQuaternToEuler(robot.GetPose().rot).y) == pytest.approx(pitch, abs=0.06)
        assert np.abs(world.engine.states[:, 10:13]).max() < 0.01


@pytest.mark.parametrize(("model", "z"), [("Pioneer2AT", "0"), ("Pioneer2DX", "0.238")])
def test_driving_straight(model, z):
    with rest(model, f"0 0 {z}", seconds=2.0) as world:
        robot, position = world.model("r"), world.interface("position", "r")
        start = robot.GetPose().pos.x
        position.command(vx=0.3)
        world.run(10.0)
        # The last sample is up to a tenth of a second old.
        assert robot.odometry.pose[0] == pytest.approx(3.0, rel=0.02)
        assert position.pose[0] == pytest.approx(3.0, abs=0.06 + 0.03)
        assert robot.GetPose().pos.x - start == pytest.approx(robot.odometry.pose[0], rel=0.03)
        assert abs(robot.GetPose().pos.y) < 0.02
        assert position.vel_pos[0] == pytest.approx(0.3, rel=0.02)


@pytest.mark.parametrize(("model", "z", "turned"), [("Pioneer2AT", "0", 63), ("Pioneer2DX", "0.238", 85)])
def test_turning_left(model, z, turned):
    wall = "<model:SimpleSolid><xyz>0 1.6 0</xyz><size>8 0.2 1</size><mass>500</mass></model:SimpleSolid>"
    with rest(model, f"0 0 {z}", seconds=2.0) as world:
        world.interface("position", "r").command(vyaw=0.5)
        world.run(3.0)
        assert math.degrees(yaw_of(world.model("r"))) == pytest.approx(turned, abs=4)
        assert world.interface("position", "r").pose[2] == pytest.approx(1.5, abs=0.07)
    with world_of(f"{GROUND}{wall}<model:{model}><id>r</id><xyz>0 0 {z}</xyz></model:{model}>") as world:
        sonar = world.interface("sonar", "r")
        world.run(1.0)
        assert int(np.argmin(sonar.ranges)) in (0, 15)  # the wall is on the left: sonars at +90 degrees
        assert sonar.ranges[0] == pytest.approx(1.5 - 0.135, abs=5e-3)
        world.interface("position", "r").command(vyaw=0.5)
        world.run(2.0)
        assert int(np.argmin(sonar.ranges)) in range(1, 8)  # turned left, the wall is now more to the front or right


def test_yaw_runs_on_or_wraps():
    for model, z, wraps in (("Pioneer2AT", "0", False), ("Pioneer2DX", "0.238", True)):
        with rest(model, f"0 0 {z}", seconds=1.0) as world:
            world.interface("position", "r").command(vyaw=2.0)
            world.run(4.0)
            yaw = world.interface("position", "r").pose[2]
            assert (abs(yaw) <= math.pi) == wraps
            assert math.remainder(yaw - 8.0, 2 * math.pi) == pytest.approx(0, abs=0.7)


def test_motors_can_be_switched_off_and_on():
    with rest("Pioneer2AT", seconds=0.5) as world:
        position = world.interface("position", "r")
        position.command(vx=0.3)
        world.run(1.0)
        position.enable_motors(False)
        world.run(0.5)
        stopped = world.model("r").GetPose().pos.x
        world.run(1.0)
        assert world.model("r").GetPose().pos.x == pytest.approx(stopped, abs=2e-3)
        position.enable_motors()
        world.run(1.0)
        assert world.model("r").GetPose().pos.x > stopped + 0.2


def test_a_command_holds_until_the_next():
    with rest("Pioneer2AT", seconds=0.5) as world:
        world.interface("position", "r").command(vx=0.2)
        world.run(5.0)
        assert world.interface("position", "r").vel_pos[0] == pytest.approx(0.2, rel=0.02)


def test_battery_sinks_by_its_curve_and_stops_at_zero():
    curve = "<batteryLevel>1.0</batteryLevel><batteryCurve>0.25 0</batteryCurve>"
    with rest("Pioneer2AT", extra=curve, seconds=2.0) as world:
        power = world.interface("power", "r")
        assert power.level == pytest.approx(0.5, abs=0.03)
        world.run(4.0)
        assert power.level == 0.0


def test_update_rate_is_of_sim_time():
    with rest("Pioneer2AT", extra="<updateRate>5</updateRate>", seconds=0) as world:
        times = []
        for _ in range(50):
            world.step()
            times.append(world.interface("position", "r").time)
        assert sorted(set(times)) == pytest.approx([0.0, 0.2, 0.4, 0.6, 0.8])


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e300])
def test_invalid_commands_have_no_effect(bad, caplog):
    with rest("Pioneer2AT", seconds=0.5) as world:
        position = world.interface("position", "r")
        position.command(vx=0.2)
        world.run(0.5)
        position.cmd_vel_pos[0] = bad
        position.cmd_vel_rot[2] = bad
        with caplog.at_level(logging.WARNING):
            world.run(0.5)
        assert np.isfinite(world.engine.states).all()
        assert caplog.text.count("a client wrote position.r: cmd_vel_pos[0]") == 1
        if not math.isfinite(bad):
            assert world.model("r").position.command == (0.2, 0.0)


# Laser -----------------------------------------------------------------------------------------------------------


def scanner(things, attributes="", quirks=""):
    world = world_of(
        f"<param:Global>{quirks}<gravity>0 0 0</gravity></param:Global>{GROUND}{things}"
        f"<model:SickLMS200><id>laser1</id><xyz>0 0 1</xyz>{attributes}</model:SickLMS200>"
    )
    world.step(6)
    return world


def beam(laser, degrees):
    return laser.ranges[int(np.argmin(np.abs(laser.angles - math.radians(degrees))))]


def test_laser_ranges_match_the_formulas():
    things = (
        "<model:SimpleSolid><xyz>3 0 0.5</xyz><size>1 2 2</size></model:SimpleSolid>"
        "<model:SimpleSolid><xyz>0 4 0</xyz><shape>cylinder</shape><size>1 2</size></model:SimpleSolid>"
        "<model:SimpleSolid><xyz>0 -4 0.57</xyz><shape>sphere</shape><size>1</size></model:SimpleSolid>"
    )
    with scanner(things) as world:
        laser = world.interface("laser", "laser1")
        assert len(laser.ranges) == 181
        for angle in (-20, -10, 0, 10, 20):  # on a ray; the face of the box is 2.5 m away
            assert beam(laser, angle) == pytest.approx(2.5 / math.cos(math.radians(angle)), abs=1e-5)
        for angle in (86, 88, 90):
            offset = 4.0 * math.cos(math.radians(angle))
            along = 4.0 * math.sin(math.radians(angle))
            assert beam(laser, angle) == pytest.approx(along - math.sqrt(0.25 - offset**2), abs=1e-5)
            assert beam(laser, -angle) == pytest.approx(along - math.sqrt(0.25 - offset**2), abs=1e-5)
        assert beam(laser, 45) == 8.192


def test_laser_sees_the_ground_where_it_is():
    with scanner("", "<rpy>0 20 0</rpy>") as world:
        tilt = math.radians(20)
        eye = 1.0 + 0.07 * math.cos(tilt)
        laser = world.interface("laser", "laser1")
        assert beam(laser, 0) == pytest.approx(eye / math.sin(tilt), abs=1e-5)
        assert beam(laser, 30) == pytest.approx(eye / (math.sin(tilt) * math.cos(math.radians(30))), abs=1e-5)


def test_readings_between_rays():
    step = "<model:SimpleSolid><xyz>3 1.5 0.5</xyz><size>1 3 2</size></model:SimpleSolid>"
    with scanner(step) as world:
        laser = world.interface("laser", "laser1")
        rays = world.model("laser1").rays
        left, right = rays.ranges[45] + 0.2, rays.ranges[46] + 0.2  # 0 and 2 degrees
        assert beam(laser, 1) == pytest.approx((left + right) / 2, abs=1e-9)
        assert rays.ranges[44] > 1e9  # -2 degrees passes the box
        assert beam(laser, -1) == pytest.approx(min(left, 8.192), abs=1e-9)


def test_reading_without_a_hit_with_and_without_the_quirk():
    with scanner("") as world:
        assert beam(world.interface("laser", "laser1"), 0) == 8.192
    with scanner("", quirks="<legacyQuirks>laserNoHitOffset</legacyQuirks>") as world:
        assert beam(world.interface("laser", "laser1"), 0) == pytest.approx(8.392)


def test_intensity_and_fiducials():
    things = (
        "<model:SimpleSolid><xyz>3 0 0.5</xyz><size>1 2 2</size><fiducial>7</fiducial><retro>1.0</retro>"
        "</model:SimpleSolid>"
        "<model:SimpleSolid><xyz>0 4 0.5</xyz><size>0.2 0.1 2</size><fiducial>0</fiducial></model:SimpleSolid>"
    )
    with scanner(things) as world:
        laser, finder = world.interface("laser", "laser1"), world.interface("fiducial", "laser1")
        assert laser.intensities[90] == 1
        assert laser.intensities[0] == 0
        assert [int(f["id"]) for f in finder.fids] == [7, 0]
        wall, post = finder.fids
        assert wall["pos"][0] == pytest.approx(2.5, abs=1e-5)
        assert wall["pos"][1] == pytest.approx(0.0, abs=1e-5)
        assert math.remainder(wall["rot"][2] - math.pi, 2 * math.pi) == pytest.approx(0, abs=1e-5)
        assert post["pos"][1] == pytest.approx(3.95, abs=0.01)
        assert math.remainder(post["rot"][2] + math.pi / 2, 2 * math.pi) == pytest.approx(0, abs=0.05)


def test_a_client_lays_the_scan_out_anew():
    wall = "<model:SimpleSolid><xyz>3 0 0.5</xyz><size>1 8 2</size></model:SimpleSolid>"
    with scanner(wall) as world:
        laser = world.interface("laser", "laser1")
        laser.configure(-0.5, 0.5, 2.8, 101)
        world.step(10)
        assert (laser.data.cmd_new_angle, laser.data.cmd_new_length) == (0, 0)
        assert len(laser.ranges) == 101
        assert laser.data.res_angle == pytest.approx(0.01)
        assert beam(laser, 0) == pytest.approx(2.5, abs=1e-5)
        assert laser.ranges[0] == pytest.approx(2.8)  # 2.5 / cos(0.5) is beyond the new range


def test_what_a_client_never_wrote_stays():
    with scanner("") as world:
        data = world.interface("laser", "laser1").data
        data.cmd_min_angle, data.cmd_max_angle, data.cmd_range_count, data.cmd_new_angle = -0.5, 0.5, 11, 1
        world.step(10)
        assert (data.min_angle, data.max_angle, data.range_count, data.max_range) == (-0.5, 0.5, 11, 8.192)
    with scanner("") as world:
        data = world.interface("laser", "laser1").data
        data.cmd_max_range, data.cmd_new_length = 4.0, 1
        world.step(10)
        assert (data.min_angle, data.max_angle, data.range_count, data.max_range) == (
            -math.pi / 2,
            math.pi / 2,
            181,
            4.0,
        )


@pytest.mark.parametrize(
    "wish",
    [(math.nan, 1, 8, 100), (1, -1, 8, 100), (-1, 1, 0.1, 100), (-1, 1, 8, -1), (-1, 1, 8, 10**9), (-9, 9, 1e30, -5)],
)
def test_invalid_scans_are_ignored(wish, caplog):
    with scanner("") as world:
        laser = world.interface("laser", "laser1")
        laser.configure(*wish)
        world.step(20)
        assert 1 <= len(laser.ranges) <= 400
        assert np.isfinite(laser.ranges).all()
        assert "a client wrote laser.laser1" in caplog.text


def test_laser_does_not_see_itself_but_sees_its_robot():
    mast = "<model:SimpleSolid><id>mast</id><xyz>0.4 0 0.3</xyz><size>.05 .05 .5</size></model:SimpleSolid>"
    robot = f"<model:Pioneer2AT><id>r</id>{LASER.format('0 0 .311')}{mast}</model:Pioneer2AT>"
    with world_of(GROUND + robot) as world:
        world.step(6)
        laser = world.interface("laser", "laser1")
        assert beam(laser, 0) == pytest.approx(0.375, abs=0.01)
        assert beam(laser, 90) == 8.192


def test_bad_laser_attributes_are_refused():
    for attributes, message in (
        ("<rangeCount>500</rangeCount>", "rangeCount must be at least 1 and at most 400"),
        ("<rangeMin>9</rangeMin>", "must be below rangeMax"),
        ("<rayCount>0</rayCount>", "rayCount must be at least 1"),
    ):
        with pytest.raises(libgz.WorldFileError, match=message):
            scanner("", attributes)


def test_one_ray_is_enough():
    with scanner("", "<rayCount>1</rayCount><rangeCount>1</rangeCount>") as world:
        assert len(world.interface("laser", "laser1").ranges) == 1


# Solids ----------------------------------------------------------------------------------------------------------


def test_size_mass_and_friction_of_solids():
    body = """<model:SimpleSolid><id>a</id><size>1 2</size><mass>3</mass><surfaceFriction>.5 .5</surfaceFriction>
    <surfaceHardness>1e5 20</surfaceHardness><color>1 0 0 0.5</color><transparent>1</transparent></model:SimpleSolid>
    <model:SimpleSolid><id>b</id><shape>cylinder</shape><size>0.50 0.50 0.50</size></model:SimpleSolid>"""
    with world_of(body) as world:
        a, b = world.model("a"), world.model("b")
        assert a.geom.size == (1, 2, 0.5)
        assert a.GetBody().mass == pytest.approx(3)
        assert world.engine.tables.geoms.surface[a.geom.row, :4].tolist() == [1e5, 20, 0.5, 0]
        assert a.geom.GetTransparency()
        assert a.geom.GetDiffuseColor() == libgz.GzColor(1, 0, 0, 0.5)
        assert (b.geom.radius, b.geom.length) == (0.25, 0.5)
        assert b.GetBody().GetCoMPose().pos.z == pytest.approx(0.25)


def test_the_ground_may_be_tilted_and_high():
    with world_of(
        "<model:GroundPlane><height>1</height></model:GroundPlane>"
        "<model:SimpleSolid><id>s</id><xyz>0 0 1</xyz></model:SimpleSolid>"
    ) as world:
        world.run(2.0)
        assert world.model("s").GetPose().pos.z == pytest.approx(1.0, abs=1e-3)


def test_a_place_that_the_ground_cannot_have_is_a_warning(caplog):
    with world_of("<model:GroundPlane><xyz>1 2 0</xyz><rpy>0 0 9</rpy></model:GroundPlane>"):
        assert caplog.text == ""
    with world_of("<model:GroundPlane>\n<xyz>0 0 1</xyz>\n<rpy>0 9 0</rpy></model:GroundPlane>"):
        assert ":2: <xyz>: has no effect on a GroundPlane; <height> and <normal> place it" in caplog.text
        assert ":3: <rpy>: has no effect on a GroundPlane" in caplog.text


def test_surfaces_may_be_rigid_and_never_slip():
    surface = "<surfaceHardness>inf 0</surfaceHardness><surfaceFriction>inf inf</surfaceFriction>"
    with world_of(f"{GROUND}<model:SimpleSolid><id>s</id>{surface}</model:SimpleSolid>") as world:
        world.run(2.0)
        assert world.model("s").GetPose().pos.z == pytest.approx(0.0, abs=5e-3)
    with pytest.raises(libgz.WorldFileError, match="surfaceHardness must be finite"):
        world_of("<model:SimpleSolid><surfaceHardness>1e4 inf</surfaceHardness></model:SimpleSolid>")


def test_missing_images_are_a_warning(caplog):
    with world_of("<model:SimpleSolid><textureFile>gone.ppm</textureFile></model:SimpleSolid>") as world:
        world.step()
    assert "file 'gone.ppm' was not found" in caplog.text


def test_zoom_limits_may_be_angles():
    for text, limits in (("1 10", (1, 10)), ("10 60", (1, 6))):
        with world_of(f"<model:SonyVID30><id>c</id><zoomLimits>{text}</zoomLimits></model:SonyVID30>") as world:
            assert world.model("c").zoomLimits == pytest.approx(limits)


# Ready worlds ----------------------------------------------------------------------------------------------------


RESTLESS = {("blimp", "robot1"), ("blimp", "camera1"), ("terrain", "ball")}  # one floats, one rolls down a hill


@pytest.mark.parametrize("name", sorted(path.name for path in installed_worlds().glob("*.world")))
def test_ready_worlds_run_without_a_complaint_and_rest(name, caplog, tmp_path):
    worlds = shutil.copytree(installed_worlds(), tmp_path / "worlds")
    with caplog.at_level(logging.WARNING), libgz.World.from_file(worlds / name) as world:
        world.run(5.0 if name == "segwayrmp.world" else 2.0)  # it balances
        states = world.engine.states
        assert np.isfinite(states).all()
        assert states[:, 2].min() > -0.02  # nothing falls through the floor
        at_rest = [m for m in world.GetModels() if (name.removesuffix(".world"), m.GetId()) not in RESTLESS]
        for _ in range(5):
            world.run(0.1)
            for model in at_rest:
                assert all(np.linalg.norm(body.GetLinearVel()) < 0.02 for body in model.bodies), model.GetId()
        assert world.Save() == 0
        saved = (worlds / name).read_bytes()
        assert world.Save() == 0
        assert (worlds / name).read_bytes() == saved
    assert [r.getMessage() for r in caplog.records] == []
