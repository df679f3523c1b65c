"""Older SDF in the words of 1.6: it means what it meant."""

import pytest

import libgz
from libgz.classic import physics
from libgz.geometry import GzVector
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import upgraded

IMU = (
    "<sensor name='s' type='imu'><imu><noise><type>gaussian</type><rate><stddev>0.1</stddev></rate>"
    "<accel><mean>0.2</mean></accel></noise></imu></sensor>"
)
DOOR = """
<model name='door'><pose>0 0 1 0 0 0</pose>
  <link name='leaf'><pose>0 0 0 1.5707963 0 0</pose>{imu}</link>
  <joint name='hinge' type='revolute'><parent>world</parent><child>leaf</child><axis><xyz>0 0 1</xyz></axis></joint>
</model>
"""
WORLD = (
    "<sdf version='{version}'><world name='w'><physics type='ode'><gravity>0 0 -1.5</gravity></physics>"
    + DOOR
    + "</world></sdf>"
)


def again(text):
    file = SdfFile.from_string(text)
    assert not file.faults.warnings
    file.faults.raise_errors()
    return file.root


@pytest.mark.parametrize("version", ["1.4", "1.5"])
def test_gravity_moves_to_the_world_and_noise_to_each_axis(version):
    old = SdfFile.from_string(WORLD.format(version=version, imu=IMU)).root
    root = again(f"<sdf version='1.6'>{upgraded(old.child('world')).ToString()}</sdf>")
    assert tuple(root.child("world").Get(GzVector, "gravity")) == (0, 0, -1.5)
    imu = next(root.find("imu"))
    for axis in "xyz":
        assert imu.child("angular_velocity").child(axis).child("noise").Get(float, "stddev") == 0.1
        assert imu.child("linear_acceleration").child(axis).child("noise").Get(float, "mean") == 0.2
    assert old.child("world").child("physics").HasElement("gravity")  # the old one is as it was


def test_an_axis_keeps_its_direction(tmp_path):
    before = libgz.World.from_string(WORLD.format(version="1.4", imu=""))
    view = physics.get_world("w")
    view.Save(str(tmp_path / "w.world"))
    after = libgz.World.from_file(tmp_path / "w.world")
    for world in (before, after):
        axis = world.model("door").sdf_joints["hinge"].axis()
        assert tuple(axis) == pytest.approx((0, 0, 1), abs=1e-6)
        world.close()


def test_models_of_several_versions_stand_in_one_saved_world(tmp_path):
    old = libgz.World.from_string(WORLD.format(version="1.4", imu=IMU))
    view = physics.get_world("w")
    view.InsertModelFile("model://pioneer2dx")
    old.step()
    view.Save(str(tmp_path / "w.world"))
    again((tmp_path / "w.world").read_text())
    old.close()
