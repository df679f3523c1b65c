"""Older SDF as 1.6: its meaning stays."""

from itertools import combinations

import pytest
from sdf_worlds import collision, link, model, world

import libgz
from libgz.base.geometry import GzVector
from libgz.classic import physics
from libgz.classic.log import LogPlay, LogRecord
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
    assert not file.diagnostics.warnings
    file.diagnostics.raise_errors()
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
    assert old.child("world").child("physics").HasElement("gravity")  # the original is unchanged


def test_an_axis_keeps_its_direction(tmp_path):
    before = libgz.World.from_string(WORLD.format(version="1.4", imu=""))
    view = physics.get_world("w")
    view.Save(str(tmp_path / "w.world"))
    after = libgz.World.from_file(tmp_path / "w.world")
    for core in (before, after):
        axis = core.model("door").sdf_joints["hinge"].axis()
        assert tuple(axis) == pytest.approx((0, 0, 1), abs=1e-6)
        core.close()


def test_models_of_several_versions_are_saved_in_one_world(tmp_path):
    old = libgz.World.from_string(WORLD.format(version="1.4", imu=IMU))
    view = physics.get_world("w")
    view.InsertModelFile("model://pioneer2dx")
    old.step()
    view.Save(str(tmp_path / "w.world"))
    again((tmp_path / "w.world").read_text())
    old.close()


CORNERS = ("0 0 0", "1 0 0", "0 1 0", "0 0 1")


def facet(corners):
    lines = "\n".join(f"vertex {corner}" for corner in corners)
    return f"facet normal 0 0 0\nouter loop\n{lines}\nendloop\nendfacet\n"


@pytest.fixture
def with_mesh(tmp_path):
    """A world with a mesh in its folder."""
    home = tmp_path / "home"
    home.mkdir()
    (home / "solid.stl").write_text(f"solid tetrahedron\n{''.join(map(facet, combinations(CORNERS, 3)))}endsolid\n")
    solid = model("m", link("l", collision("<mesh><uri>solid.stl</uri></mesh>")), pose="0 0 3 0 0 0")
    (home / "w.world").write_text(f"<sdf version='1.5'>{world(solid)}</sdf>")
    return home / "w.world"


def triangles_of(core):
    return len(core.model("m").GetBody("l").geoms[0].triangles)


def test_relative_meshes_are_found_from_other_folders(with_mesh, tmp_path):
    core = libgz.World.from_file(with_mesh)
    view = physics.get_world("default")
    for folder, short in ((tmp_path, False), (with_mesh.parent, True)):
        view.Save(str(folder / "saved.world"))
        assert (">solid.stl<" in (folder / "saved.world").read_text()) == short
        with libgz.World.from_file(folder / "saved.world") as saved:
            assert triangles_of(saved) == 4
    with LogRecord(core, tmp_path / "logs" / "state.log"):
        core.step(10)
    with LogPlay(tmp_path / "logs" / "state.log") as play:
        assert triangles_of(play.core) == 4
    view.RemoveModel("m")
    view.InsertModelSDF(SdfFile.load(with_mesh))
    assert triangles_of(core) == 4
    core.close()
