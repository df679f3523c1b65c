"""Sensors of SDF worlds: Gazebo's own acceptance figures, rates, kinds, wrong values."""

import logging
import math
import re

import numpy as np
import pytest
from bone_files import two_bones
from sensor_worlds import GROUND, G, box, collision, get, imu, model, noise, ray, sensor, world_of

from libgz.base.errors import StateError, WorldFileError
from libgz.classic import physics, sensors
from libgz.classic.math import Pose3d, Quaterniond, Vector3d

# Gazebo's acceptance figures -----------------------------------------------------------------------------------------


def test_row_14_a_laser_in_an_empty_world_sees_nothing_then_a_box_then_the_ground():
    laser = sensor("ray", ray(640, (-2.27, 2.27), (0, 10)))
    with world_of(GROUND + model("laser", laser, "0 0 0.5 0 0 0")) as world:
        world.step(1)
        scan = get("s")
        assert len(scan.Ranges()) == 640
        assert all(r == math.inf for r in scan.Ranges())

        physics.get_world().InsertModelString(f"<sdf version='1.6'>{box('box', '2 0 0.5 0 0 0')}</sdf>")
        scan.Update(True)
        angles = np.linspace(-2.27, 2.27, 640)
        expected = np.where(np.abs(np.tan(angles)) * 1.5 <= 0.5, 1.5 / np.cos(angles), math.inf)
        expected[np.cos(angles) <= 0] = math.inf
        got = np.array(scan.Ranges())
        assert np.array_equal(np.isinf(got), np.isinf(expected))
        seen = np.isfinite(expected)
        assert np.abs(got[seen] - expected[seen]).max() < 2e-6

        physics.get_world().ModelByName("box").SetWorldPose(Pose3d(20, 0, 0.5, 0, 0, 0))
        physics.get_world().ModelByName("laser").SetWorldPose(Pose3d(0, 0, 1, 0, math.pi / 2, 0))
        scan.Update(True)
        down = np.where(np.cos(angles) > 0.1, 1.0 / np.maximum(np.cos(angles), 0.1), math.inf)
        seen = np.isfinite(down)
        assert np.abs(np.array(scan.Ranges())[seen] - down[seen]).max() < 1e-6


def test_row_15_a_laser_among_boxes_and_then_alone():
    scene = model("laser", sensor("ray", ray(320, (-math.pi / 2, math.pi / 2), (0.1, 5))))
    scene += box("a", "1 0 0 0 0 0", static=False) + box("b", "0 -1 0 0 0 0") + box("c", "0 6 0 0 0 0", static=False)
    with world_of(scene, gravity="0 0 0") as world:
        world.step(1)
        scan = get("s")
        assert scan.Range(160) == pytest.approx(0.5, abs=1e-5)
        assert scan.Range(0) == pytest.approx(0.5, abs=1e-5)
        assert scan.Range(319) == math.inf
        for name in "abc":
            physics.get_world().ModelByName(name).SetWorldPose(Pose3d(0, 0, 50, 0, 0, 0))
        world.step(1)
        assert all(r == math.inf for r in scan.Ranges())


def test_row_16_a_laser_with_rows():
    laser = sensor("ray", ray(640, (-2.27, 2.27), (0.1, 10), vertical=(3, -0.1, 0.1)))
    with world_of(model("laser", laser, "0.25 0 0.5 0 0 0") + box("box", "1 0 0.5 0 0 0")) as world:
        world.step(1)
        scan = get("s")
        assert (scan.RangeCount(), scan.VerticalRangeCount()) == (640, 3)
        step = scan.AngleResolution()
        for row, elevation in enumerate((-0.1, 0.0, 0.1)):
            expected = 0.25 / math.cos(elevation) / math.cos(step / 2)
            assert scan.Range(row * 640 + 320) == pytest.approx(expected, abs=1e-5)
            assert scan.Range(row * 640) == scan.Range(row * 640 + 639) == math.inf


def test_row_17_an_imu_at_rest_and_in_free_fall():
    turned = Quaterniond(0.5, -1.0, 0.2)
    still = model("still", imu("still"), "0 0 0.05 0.5 -1.0 0.2")
    falls = model("falls", imu("falls") + collision("<sphere><radius>0.5</radius></sphere>"), "0 0 50 0 0 0", False)
    with world_of(still + falls) as world:
        world.step(100)
        rest, fall = get("still"), get("falls")
        assert tuple(rest.AngularVelocity()) == pytest.approx((0, 0, 0), abs=8e-5)
        up = turned.RotateVectorReverse(Vector3d(0, 0, G))
        assert tuple(rest.LinearAcceleration()) == pytest.approx(tuple(up), abs=8e-5)
        assert tuple(rest.Orientation()) == pytest.approx((1, 0, 0, 0), abs=8e-5)
        assert tuple(fall.LinearAcceleration()) == pytest.approx((0, 0, 0), abs=8e-5)


def test_row_17_an_imu_on_a_frictionless_ramp():
    slip = "<friction><ode><mu>0</mu><mu2>0</mu2></ode></friction>"
    ramp = model("ramp", collision("<plane><normal>0 0 1</normal></plane>", slip), "0 0 0 0 0.5 0")
    ball = collision("<sphere><radius>0.5</radius></sphere>", slip) + imu()
    high = 0.5 / math.cos(0.5)
    with world_of(ramp + model("ball", ball, f"0 0 {high + 0.0} 0 0 0", False)) as world:
        world.step(1000)
        link = physics.get_world().ModelByName("ball").GetLink("link")
        world.step(100)
        assert get("s").LinearAcceleration().Length() == pytest.approx(G * math.cos(0.5), abs=8e-5)
        assert link.WorldLinearAccel().Length() == pytest.approx(G * math.sin(0.5), abs=8e-5)


def test_row_17_an_imu_on_a_pendulum():
    inertia = "<inertia><ixx>1e-3</ixx><iyy>1e-3</iyy><izz>1e-3</izz></inertia>"
    bob = imu() + f"<inertial><mass>1</mass>{inertia}</inertial>"
    hinge = (
        "<joint name='j' type='revolute'><parent>world</parent><child>link</child><pose>0 1 0 0 0 0</pose>"
        "<axis><xyz>1 0 0</xyz></axis></joint>"
    )
    with world_of(model("bob", bob, "0 -1 0 0 0 0", False, hinge)) as world:
        pulls = []
        for _ in range(700):  # 0.59 s to the lowest point
            world.step(1)
            pulls.append(get("s").LinearAcceleration().Length())
        # g + v^2 / r = 3 g at the lowest point, but for 1e-3 by its radius of gyration of 3 cm.
        assert max(pulls) == pytest.approx(3 * G, rel=5e-3)


def sonar(**options):
    return sensor("sonar", "<sonar><min>0</min><max>2</max><radius>0.3</radius></sonar>", **options)


def test_row_18_sonars():
    own = collision("<box><size>0.1 0.1 0.1</size></box>")
    wall = model("wall", own + sonar(name="wall"), "0 0 0.5 1.5707 0 0") + box("box", "0 2 0.5 0 0 0")
    down = model("down", sonar(name="down"), "10 0 1 0 0 0")
    with world_of(GROUND + wall + down) as world:
        world.step(100)
        assert get("wall").Range() == pytest.approx(1.4999, abs=1e-3)
        assert get("down").Range() == pytest.approx(1.0, abs=0.01)
        physics.get_world().ModelByName("down").SetWorldPose(Pose3d(10, 0, 1, 0, 1.5707, 0))
        world.step(100)
        assert get("down").Range() == pytest.approx(2.0, abs=0.01)
        physics.get_world().ModelByName("down").SetWorldPose(Pose3d(10, 0, 90, 0, 0, 0))
        world.step(100)
        assert get("down").Range() == 2.0
        assert (get("down").RangeMin(), get("down").RangeMax(), get("down").Radius()) == (0.0, 2.0, 0.3)


def test_row_18_a_sonar_with_a_sphere_sees_all_around():
    around = sensor("sonar", "<sonar><min>0</min><max>2</max><geometry>sphere</geometry></sonar>")
    with world_of(model("m", around) + box("b", "-1.2 0 0 0 0 0", "0.4 0.4 0.4")) as world:
        world.step(1)
        assert get("s").Range() == pytest.approx(1.0, abs=0.01)
        assert get("s").Geometry() == "sphere"


def test_row_18_readings_are_samples_times_resolution_and_names_are_scoped():
    laser = sensor("ray", ray(120, (-1, 1), (0.1, 5), (2, -0.1, 0.1, 3), resolution=2), "laser")
    ground = GROUND.replace("name='ground'", "name='ground_plane'").replace("</link>", laser + "</link>")
    with world_of(ground + box("b", "1 0 0 0 0 0")) as world:
        world.step(1)
        scan = get("default::ground_plane::link::laser")
        assert scan.ScopedName() == "default::ground_plane::link::laser"
        assert (scan.RayCount(), scan.RangeCount()) == (120, 240)
        assert (scan.VerticalRayCount(), scan.VerticalRangeCount()) == (2, 6)
        assert len(scan.Ranges()) == 240 * 6
        assert scan.Range(3 * 240 + 120) == pytest.approx(0.5, abs=0.01)


def test_row_18_a_gps_at_the_origin_and_elsewhere():
    gps = sensor("gps", "<gps/>")
    with world_of(model("m", gps, static=False), gravity="0 0 0") as world:
        get("s").Update(True)
        assert (get("s").Latitude().Radian(), get("s").Longitude().Radian(), get("s").Altitude()) == (0.0, 0.0, 0.0)
        physics.get_world().ModelByName("m").SetLinearVel(Vector3d(1, 2, 3))
        world.step(1000)
        one = get("s")
        assert tuple(one.VelocityENU()) == pytest.approx((1, 2, 3), abs=1e-6)
        assert one.Longitude().Degree() == pytest.approx(math.degrees(1 / 6378137.0), rel=1e-4)
        assert one.Latitude().Degree() == pytest.approx(math.degrees(2 / 6335439.0), rel=1e-3)
        assert one.Altitude() == pytest.approx(3.0, abs=1e-3)


CONTACT = "<contact><collision>top</collision></contact>"


def touching(on=False, rate=0):
    base = collision("<box><size>1 1 1</size></box>", name="top") + sensor("contact", CONTACT, rate=rate, on=on)
    ball = collision("<sphere><radius>0.5</radius></sphere>", name="skin")
    inertia = "<inertial><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial>"
    return GROUND + model("base", base, "0 0 0.5 0 0 0", False) + model("ball", ball + inertia, "0 0 1.5 0 0 0", False)


def test_row_21_a_contact_sensor_is_inactive_until_it_is_told_to_be():
    with world_of(touching()) as world:
        one = get("s")
        world.step(50)
        assert not one.IsActive()
        assert not world.engine.record_contacts
        assert len(one.Contacts().contact) == 0
        one.SetActive(True)
        world.step(950)
        found = one.Contacts("base::link::top")
        assert set(found) == {"ground::link::collision", "ball::link::skin"}
        contact = found["ball::link::skin"]
        assert contact.count == 1 == one.GetCollisionContactCount("ball::link::skin")
        point, normal = contact.positions[0], contact.normals[0]
        assert tuple(point)[:2] == pytest.approx((0, 0), abs=1e-4)
        assert abs(normal.z) == pytest.approx(1.0, abs=1e-4)
        assert tuple(normal)[:2] == pytest.approx((0, 0), abs=1e-4)
        on_base = contact.collision1.GetScopedName().startswith("base")
        force = contact.wrench[0].body1Force if on_base else contact.wrench[0].body2Force
        torque = contact.wrench[0].body1Torque if on_base else contact.wrench[0].body2Torque
        assert force.z == pytest.approx(-G, rel=0.05)
        assert torque.Length() < 2
        msg = one.Contacts()
        assert {msg.contact[0].collision1, msg.contact[1].collision1} & {"base::link::top", "ball::link::skin"}
        assert len(msg.contact[0].position) == len(msg.contact[0].wrench) == len(msg.contact[0].depth)
        assert (one.GetCollisionCount(), one.GetCollisionName(0)) == (1, "base::link::top")
        one.Update(True)
        assert one.Contacts() == msg  # no iteration since
        one.SetActive(False)
        world.step(2)
        assert not world.engine.record_contacts


def test_a_slow_contact_sensor_tells_of_every_iteration_in_between():
    with world_of(touching(on=True, rate=100)) as world:
        world.step(1000)
        assert len(get("s").Contacts().contact) == 20  # two pairs in each of ten iterations


def test_points_of_contacts_as_arrays_are_those_of_the_message():
    with world_of(touching(on=True, rate=100)) as world:
        world.engine.bodies[0].SetAngularVel((0.3, 0.2, 0.5))
        world.step(1000)
        arrays, message = get("s").points(), get("s").Contacts()
        assert len(arrays) == len(message.contact) == 20
        for found, said in zip(arrays, message.contact, strict=True):
            assert found.names == (said.collision1, said.collision2)
            assert divmod(found.time, 10**9) == (said.time.sec, said.time.nsec)
            assert found.depths.tolist() == list(said.depth)
            for row, point, normal, wrench in zip(range(9), said.position, said.normal, said.wrench, strict=False):
                assert found.positions[row].tolist() == [point.x, point.y, point.z]
                assert found.normals[row].tolist() == [normal.x, normal.y, normal.z]
                force, torque = wrench.body_1_wrench.force, wrench.body_1_wrench.torque
                values = force.x, force.y, force.z, torque.x, torque.y, torque.z
                assert found.wrenches[row].tolist() == pytest.approx(values, abs=1e-9)


def test_a_state_with_incomplete_contacts_is_refused_at_once():
    with world_of(touching(on=True, rate=100)) as world:
        world.step(100)
        one = get("s")
        waiting, taken = one.SaveState()
        for damaged in (([*waiting, b"12"], taken), (waiting, taken[:-1]), ([None], taken)):
            with pytest.raises(StateError, match="sensor 's' has incomplete records of contacts"):
                one.LoadState(damaged)
        assert one.SaveState() == (waiting, taken)
        assert len(one.Contacts().contact) == 20


@pytest.mark.parametrize(("rate", "seconds"), [(5, 6.0), (10, 3.0)])
def test_row_26_thirty_measurements_take_as_long_as_they_should(rate, seconds):
    with world_of(model("m", imu(rate=rate))) as world:
        times = []
        kept = get("s").ConnectUpdated(lambda: times.append(world.GetSimTime()))
        while len(times) < 30:
            world.step(1)
        assert times[-1] == pytest.approx(seconds, abs=1e-6)
        assert kept.connected


def test_a_rate_that_is_no_multiple_of_the_step_does_not_drift():
    with world_of(model("m", imu(rate=30))) as world:
        count = []
        kept = get("s").ConnectUpdated(lambda: count.append(1))
        world.step(10_000)
        assert len(count) in (299, 300)
        assert kept.connected


# Other kinds ---------------------------------------------------------------------------------------------------------


def test_readings_beyond_the_range_are_plus_and_below_it_minus_infinity():
    laser = sensor("ray", ray(1, reach=(0.5, 3)), pose="0.2 0 0 0 0 0")
    with world_of(model("m", laser) + box("b", "1.2 0 0 0 0 0", "1 1 1", True)) as world:
        world.step(1)
        assert get("s").Range(0) == -math.inf  # the box begins at 0.5 m
        physics.get_world().ModelByName("b").SetWorldPose(Pose3d(4.5, 0, 0, 0, 0, 0))
        world.step(1)
        assert get("s").Range(0) == math.inf
        assert get("s").LaserShape().GetRange(0) == 3.0
        physics.get_world().ModelByName("b").SetWorldPose(Pose3d(2.7, 0, 0, 0, 0, 0))
        world.step(1)
        assert get("s").Range(0) == pytest.approx(2.0)


def test_a_laser_tells_how_much_comes_back_and_plugins_can_shape_its_scans():
    shape = "<geometry><box><size>1 1 1</size></box></geometry>"
    bright = f"<collision name='c'><laser_retro>2000</laser_retro>{shape}</collision><visual name='v'>{shape}</visual>"
    bright = model("b", bright, "1 0 0 0 0 0")
    with world_of(model("m", sensor("gpu_ray", ray(2, (0, 1.5), (0, 5)))) + bright) as world:
        one, frames, scans = get("s"), [], []
        kept = [
            one.ConnectNewLaserFrame(lambda *values: frames.append(values)),
            one.LaserShape().ConnectNewLaserScans(lambda: scans.append(1)),
        ]
        world.step(1)
        assert (one.Retro(0), one.Retro(1)) == (2000.0, 0.0)
        assert one.Fiducial(0) == -1
        data, width, height, depth, layout = frames[0]
        assert (width, height, depth, layout) == (2, 1, 3, "FLOAT32_RGB")
        assert data[0] == pytest.approx(0.5)
        assert data[1] == 2000.0
        assert len(scans) == 1
        assert len(kept) == 2
        assert one.HorzFOV() == pytest.approx(1.5)


BOX = "<geometry><box><size>0.2 0.2 2</size></box></geometry>"


def test_a_gpu_ray_sees_visuals_and_actors_and_no_collisions(tmp_path, caplog):
    (tmp_path / "arm.dae").write_text(two_bones())
    skin = f"<skin><filename>{tmp_path}/arm.dae</filename></skin>"
    still = "".join(f"<waypoint><time>{t}</time><pose>4 -1 0 1.57 0 1.57</pose></waypoint>" for t in (0, 100))
    script = f"<script><trajectory id='0' type='none'>{still}</trajectory></script>"
    actor = f"<actor name='a'>{skin}{script}</actor>"
    left = model("left", f"<visual name='v'>{BOX}</visual>", "5 1.5 0 0 0 0")
    right = model("right", f"<collision name='c'>{BOX}</collision>", "5 -1.5 0 0 0 0")
    for kind, seen in (("gpu_ray", [False, True, True]), ("ray", [True, False, False])):
        content = model("m", sensor(kind, ray(81, (-0.4, 0.4), (0.1, 30)))) + actor + left + right
        with world_of(content) as world:
            world.step(2)
            hit = np.isfinite(get("s").Ranges())
            yaws = np.linspace(-0.4, 0.4, 81)
            assert [bool(hit[np.abs(yaws - yaw) < 0.03].any()) for yaw in (-0.29, -0.1, 0.29)] == seen, kind
            if kind == "gpu_ray":
                nearest = np.min(np.array(get("s").Ranges())[yaws > 0.26])
                assert nearest == pytest.approx(math.hypot(4.9, 1.4), rel=1e-3)
    assert "instead of visuals" not in caplog.text


def test_a_gpu_ray_without_opengl_sees_collisions_and_says_so(monkeypatch, caplog):
    monkeypatch.setenv("LIBGZ_GL", "none")
    with world_of(model("m", sensor("gpu_ray", ray(1, (0, 0), (0.1, 30)))) + box("b", "3 0 0 0 0 0")) as world:
        world.step(1)
        assert get("s").Ranges() == [pytest.approx(2.5)]
    assert "sees collisions instead of visuals: OpenGL is switched off" in caplog.text


def test_what_is_nearer_than_the_minimum_range_stops_a_ray_but_not_the_laser_s_own_model():
    housing = collision("<sphere><radius>0.1</radius></sphere>", name="housing")
    mount = "<link name='mount'>" + collision("<box><size>0.3 0.3 0.3</size></box>") + "</link>"
    scan = sensor("ray", ray(3, (-0.8, 0.8), (0.5, 10)))
    thin = box("thin", "0.3 0 0 0 0 0", "0.02 0.2 1")
    with world_of(model("m", housing + scan, more=mount) + thin + box("wall", "3 0 0 0 0 0", "0.2 9 1")) as world:
        world.step(1)
        ranges = get("s").Ranges()
        assert ranges[1] == -math.inf
        assert ranges[0] == ranges[2] == pytest.approx(2.9 / math.cos(0.8))


def test_an_altimeter_and_a_magnetometer():
    both = sensor("altimeter", "<altimeter/>", "alt") + sensor("magnetometer", "<magnetometer/>", "mag")
    with world_of(model("m", both, f"0 0 2 0 0 {math.pi / 2}", False), gravity="0 0 0") as world:
        physics.get_world().ModelByName("m").SetLinearVel(Vector3d(0, 0, 0.5))
        world.step(1000)
        altimeter = get("alt")
        assert altimeter.Altitude() == pytest.approx(0.5, abs=1e-6)
        assert altimeter.VerticalVelocity() == pytest.approx(0.5, abs=1e-6)
        assert altimeter.ReferenceAltitude() == 2.0
        assert altimeter.Topic() == "~/m/link/alt"
        field = physics.get_world().MagneticField()
        assert tuple(get("mag").MagneticField()) == pytest.approx((field.y, -field.x, field.z), abs=1e-12)


def test_orientations_are_told_in_the_frame_that_the_file_names():
    def framed(name, more=""):
        frame = f"<orientation_reference_frame><localization>{name}</localization>{more}</orientation_reference_frame>"
        return sensor("imu", f"<imu>{frame}</imu>", name)

    custom = framed("CUSTOM", "<custom_rpy>0 0 0.5</custom_rpy>")
    link = framed("ENU") + framed("NED") + framed("NWU") + framed("GRAV_UP") + custom + imu("own")
    with world_of(model("m", link, "0 0 0 0 0 0.5")) as world:
        world.step(1)
        expected = {
            "ENU": Quaterniond(0, 0, 0.5),
            "GRAV_UP": Quaterniond(0, 0, 0.5),
            "NWU": Quaterniond(0, 0, 0.5 - math.pi / 2),
            "NED": Quaterniond(math.pi, 0, math.pi / 2).Inverse() * Quaterniond(0, 0, 0.5),
            "CUSTOM": Quaterniond(0, 0, 0),
            "own": Quaterniond(0, 0, 0),
        }
        for name, orientation in expected.items():
            assert abs(get(name).Orientation().Dot(orientation)) == pytest.approx(1.0, abs=1e-9), name
        get("own").SetWorldToReferenceOrientation(Quaterniond(0, 0, 0.2))
        world.step(1)
        assert get("own").Orientation().Yaw() == pytest.approx(0.3)


def test_a_logical_camera_names_what_is_in_sight():
    camera = (
        "<logical_camera><near>0.5</near><far>5</far><aspect_ratio>2</aspect_ratio>"
        "<horizontal_fov>1.5707963</horizontal_fov></logical_camera>"
    )
    scene = model("eye", sensor("logical_camera", camera, pose="0 0 1 0 0 0")) + GROUND
    scene += box("ahead", "3 0 1 0 0 0") + box("edge", "3 3.4 1 0 0 0") + box("aside", "3 3.6 1 0 0 0", "1 0.2 1")
    scene += box("above", "3 0 3.5 0 0 0") + box("far", "5.4 0 1 0 0 0") + box("farther", "5.6 0 1 0 0 0")
    scene += box("near", "0.3 0 1 0 0 0", "0.2 0.2 0.2") + box("behind", "-3 0 1 0 0 0")
    with world_of(scene) as world:
        world.step(1)
        seen = {one.name: one.pose.position for one in get("s").Image().model}
        assert set(seen) == {"ahead", "edge", "far", "ground"}
        assert (seen["ahead"].x, seen["ahead"].y, seen["ahead"].z) == (3.0, 0.0, 0.0)
        assert get("s").Topic() == "~/eye/link/s/models"
        assert (get("s").Near(), get("s").Far(), get("s").AspectRatio()) == (0.5, 5.0, 2.0)


def test_sensors_describe_themselves():
    from libgz.classic import msgs

    with world_of(model("m", imu(rate=20, pose="0 0 1 0 0 0"))):
        msg = msgs.Sensor()
        get("s").FillMsg(msg)
        assert (msg.name, msg.type, msg.parent, msg.update_rate, msg.pose.position.z) == ("s", "imu", "m::link", 20, 1)
        assert get("s").GetTopic() == "~/m/link/s/imu"


def test_rays_of_one_s_own():
    with world_of(box("b", "0 0 2 0 0 0")) as world:
        world.step(1)
        ray_shape = physics.get_world().Physics().CreateShape("ray", None)
        ray_shape.SetPoints(Vector3d(0, 0, 0), Vector3d(0, 0, 10))
        assert ray_shape.GetIntersection() == (pytest.approx(1.5), "b::link::collision")
        assert ray_shape.GetLength() == pytest.approx(1.5)
        ray_shape.SetPoints(Vector3d(5, 0, 0), Vector3d(5, 0, 10))
        assert ray_shape.GetIntersection() == (1000.0, "")


# Wrong values --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (sensor("ray", ray(0)), r":\d+: <samples>: is 0; it must be at least 1"),
        (sensor("ray", ray(5, reach=(3, 2))), "<max>: is 2 m; it must be beyond <min>, 3 m"),
        (sensor("ray", ray(5, resolution=-1)), "<resolution>: is -1; it must be at least 0"),
        (sensor("sonar", "<sonar><min>2</min><max>1</max></sonar>"), "<max>: is 1 m"),
        (sensor("logical_camera", "<logical_camera><near>5</near></logical_camera>"), "<far>: is 1 m"),
        (
            sensor("altimeter", f"<altimeter><vertical_position>{noise('pink')}</vertical_position></altimeter>"),
            "'pink'",
        ),
        (
            sensor("imu", f"<imu><angular_velocity><x>{noise(stddev=-1)}</x></angular_velocity></imu>"),
            "<stddev>: is -1; it must be at least 0",
        ),
    ],
)
def test_values_beyond_their_bounds_are_replaced_with_a_warning(text, message, caplog):
    with world_of("\n" + model("m", text)) as world:
        world.step(100)
    assert re.search(message, caplog.text)
    assert ":2: <" in caplog.text


def test_scans_may_go_round_more_than_once_and_backwards():
    def ranges(first, last, vertical=""):
        scan = f"<scan><horizontal><samples>5</samples><min_angle>{first}</min_angle><max_angle>{last}</max_angle>"
        content = f"<ray>{scan}</horizontal>{vertical}</scan><range><min>0.1</min><max>10</max></range></ray>"
        with world_of(model("m", sensor("ray", content)) + box("b", "3 0.4 0 0 0 0.3")) as world:
            world.step(200)
            return get("s").Ranges()

    forwards = ranges(-0.2, 0.3)
    assert len(set(forwards)) == 4
    assert math.isfinite(forwards[2])
    assert ranges(0.3, -0.2) == pytest.approx(forwards[::-1], abs=1e-12)
    around = ranges(0.0, 6.28319)
    assert around[0] == pytest.approx(around[4], abs=1e-4)
    assert around[1:4] == [math.inf] * 3
    rows = "<vertical><samples>3</samples><min_angle>{}</min_angle><max_angle>{}</max_angle></vertical>"
    up, down = ranges(-0.2, 0.3, rows.format(-0.1, 0.1)), ranges(-0.2, 0.3, rows.format(0.1, -0.1))
    assert down[:5] == pytest.approx(up[10:], abs=1e-12)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (sensor("ray", ray(20_000_000)), r":\d+: <samples>: is 20000000; it must be at most"),
        (
            sensor("camera", "<camera><image><width>99999</width></image></camera>"),
            "<width>: is 99999; it must be at most",
        ),
    ],
)
def test_sensors_that_are_larger_than_libgz_holds_are_errors(text, message):
    with pytest.raises(WorldFileError, match=message):
        world_of("\n" + model("m", text))


def test_a_sensor_of_joints_in_a_link_is_left_out(caplog):
    with world_of(model("m", "<sensor name='f' type='force_torque'/>" + imu())) as world:
        world.step(10)
        assert list(world.facade.server.sensors.sensors) == ["default::m::link::s"]
    said = ":1: <sensor>: type 'force_torque' stands in a <joint>, not in a <link>; the sensor is left out"
    assert caplog.text.count(said) == 1


def test_of_sensors_of_one_name_the_first_is_made(caplog):
    with world_of(model("m", imu() + imu())) as world:
        world.step(10)
        assert list(world.facade.server.sensors.sensors) == ["default::m::link::s"]
    assert caplog.text.count("<sensor>: there is a 'default::m::link::s' already; this one is left out") == 1


def test_a_wrong_sensor_of_a_model_that_joins_later_is_told_and_left_out(caplog):
    with world_of(model("m", imu())) as world:
        wrong = model("n", sensor("ray", ray(20_000_000), "bad") + imu("fine"))
        with caplog.at_level(logging.ERROR):
            physics.get_world().InsertModelString(f"<sdf version='1.6'>{wrong}</sdf>")
        assert "<samples>: is 20000000" in caplog.text
        world.step(1)
        assert sensors.get_sensor("bad") is None
        assert get("fine").IsActive()


def test_sensors_that_are_not_simulated_are_left_out_with_a_word(caplog):
    with world_of(model("m", sensor("rfid", "") + imu())):
        assert "type 'rfid' is not simulated" in caplog.text
        assert len(sensors.SensorManager.Instance().GetSensors()) == 1


LENIENT = [
    (sensor("ray", ray(1, (0, 0), resolution=0.5)), "<resolution>: is 0.5; .* 1 is used instead"),
    (sensor("rai", ""), "type 'rai' is not simulated; the sensor is left out; .*did you mean 'ray'"),
    (
        sensor("camera", "<camera><image><format>RGB_FOO</format></image></camera>"),
        "'RGB_FOO'.* the camera uses R8G8B8",
    ),
    (sensor("camera", "<camera><save enabled='0'/></camera>"), "<save>: <path> is missing"),
]


@pytest.mark.parametrize(("text", "message"), LENIENT)
def test_what_classic_let_pass_is_a_warning(text, message, caplog):
    with world_of(model("m", text)) as world:
        world.step(1)
    assert re.search(rf":\d+: .*{message}", caplog.text)


def test_later_names_of_sensors_are_those_of_classic():
    lidar = ray(3, (-0.5, 0.5)).replace("ray>", "lidar>")
    with world_of(model("m", sensor("lidar", lidar)), "1.8") as world:
        world.step(1)
        assert get("s").Type() == "ray"
        assert len(get("s").Ranges()) == 3


def test_a_camera_has_the_pinhole_of_its_file(caplog):
    pinhole = "<intrinsics><fx>100</fx><fy>80</fy><cx>30</cx><cy>50</cy><s>0</s></intrinsics>"
    content = f"<camera><image><width>120</width><height>90</height></image><lens>{pinhole}</lens></camera>"
    red = "<material><ambient>1 0 0 1</ambient><diffuse>1 0 0 1</diffuse></material>"
    shape = f"<visual name='v'><geometry><box><size>0.2 0.2 0.2</size></box></geometry>{red}</visual>"
    with world_of(model("m", sensor("camera", content)) + model("b", shape, "1.1 0 0 0 0 0")) as world:
        world.step(2)
        image = np.frombuffer(get("s").ImageData(), np.uint8).reshape(90, 120, 3).astype(int)
    rows, columns = np.nonzero(image[..., 0] > image[..., 1] + 40)
    assert (columns.mean() + 0.5, rows.mean() + 0.5) == (pytest.approx(30, abs=0.6), pytest.approx(50, abs=0.6))
    assert (np.ptp(columns) + 1, np.ptp(rows) + 1) == (pytest.approx(20, abs=1.1), pytest.approx(16, abs=1.1))
    assert "intrinsics" not in caplog.text
