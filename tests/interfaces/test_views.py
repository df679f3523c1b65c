"""Properties of interfaces that show the filled part of an array."""

import numpy as np
import pytest
from served import serve

import libgz
from libgz.transport.server import LocalServer


@pytest.mark.parametrize("kind", [libgz.Ir, libgz.Sonar], ids=["ir", "sonar"])
def test_range_sensors(kind):
    sensors = serve(LocalServer(), kind)
    sensors.data.time, sensors.data.max_range = 1.5, 5.0
    setattr(sensors.data, f"{kind.type}_count", 2)
    sensors.array(f"{kind.type}_ranges")[:3] = (1, 2, 3)
    sensors.array(f"{kind.type}_pos")[1] = (4, 5, 6)
    sensors.array(f"{kind.type}_rot")[1] = (7, 8, 9)
    assert (sensors.time, sensors.max_range, sensors.count) == (1.5, 5.0, 2)
    assert sensors.ranges.tolist() == [1, 2]
    assert sensors.positions.tolist() == [[0, 0, 0], [4, 5, 6]]
    assert sensors.directions.tolist() == [0, 9]


@pytest.mark.parametrize(("count", "shown"), [(-5, 0), (0, 0), (3, 3), (1 << 30, 401)])
def test_counts_are_clamped(count, shown):
    laser = serve(LocalServer(), libgz.Laser)
    laser.data.range_count = count
    laser.data.min_angle, laser.data.max_angle = -1.0, 1.0
    assert laser.ranges.shape == laser.intensities.shape == laser.angles.shape == (shown,)
    laser.ranges[:] = 2.0  # a view of the shared memory
    assert np.count_nonzero(laser.all_ranges) == shown


@pytest.mark.parametrize(("width", "height", "size"), [(0, 0, 0), (4, 2, 20), (4000, 2000, 24_000_000), (4, 0, 24)])
def test_images_that_do_not_fit_are_empty(width, height, size):
    camera = serve(LocalServer(), libgz.Camera)
    camera.data.width, camera.data.height, camera.data.image_size = width, height, size
    assert camera.image.shape == (0, 0, 3)
    camera.data.width, camera.data.height, camera.data.image_size = 4, 2, 24
    assert camera.image.shape == (2, 4, 3)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_commands_are_finite(bad):
    server = LocalServer()
    position, ptz = serve(server, libgz.Position), serve(server, libgz.Ptz)
    joints, truth, guicam = serve(server, libgz.Joints), serve(server, libgz.Truth), serve(server, libgz.Guicam)
    pose = libgz.GzPose(libgz.GzVector(0, 0, bad))
    for command in (
        lambda: position.command(vx=bad),
        lambda: position.command(0.1, bad),
        lambda: position.command(0.1, 0.2, vz=bad),
        lambda: ptz.command(pan=0.1, zoom=bad),
        lambda: joints.command(0, bad),
        lambda: joints.command(0, 0.1, bad),
        lambda: truth.move(pose),
        lambda: guicam.drag(0, (bad, 0), (0, 0)),
    ):
        with pytest.raises(libgz.ParameterError, match="finite"):
            command()
    assert list(position.cmd_vel_pos) == [0, 0, 0]  # nothing is written by a refused command
    assert ptz.data.cmd_pan == joints.data.joints[0].cmd_angle == truth.data.cmd_new == 0


def test_an_id_is_a_string():
    with pytest.raises(libgz.InterfaceError, match=r"interface \[position\] id is 1; it must be a string, such as '1'"):
        serve(LocalServer(), libgz.Position, 1)


def test_commands_of_another_kind_are_named():
    server = LocalServer()
    position, gripper, joints = serve(server, libgz.Position), serve(server, libgz.Gripper), serve(server, libgz.Joints)
    for command, message in (
        (lambda: position.command(vx="fast"), r"vx \[m/s\] is 'fast'; it must be a number"),
        (lambda: position.command(vyaw=None), r"vyaw \[rad/s\] is None; it must be a number"),
        (lambda: joints.command(0, [1]), r"angle \[rad\] is \[1\]; it must be a number"),
        (lambda: gripper.command("open"), "code is 'open'; it must be one of GAZEBO_GRIPPER_CMD"),
    ):
        with pytest.raises(libgz.ParameterError, match=message):
            command()
