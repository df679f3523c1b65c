"""Documents of SDF 1.0 to 1.5 as 1.6: the values are the same, comments and layout stay."""

from pathlib import Path

import pytest
from commands import run_libgz
from lxml import etree

import libgz
from libgz.base.errors import WorldFileError
from libgz.sdf.conversion import upgrade_document
from libgz.sdf.reader import SdfFile

WORLDS = Path(__file__).parent.parent / "data" / "sdf"
OLD = sorted(WORLDS.glob("old_*.world"))

TABLE = b"""<?xml version="1.0"?>
<!-- licence -->
<gazebo version="1.0">
  <!-- one table -->
  <model name="table" static="true">
    <origin pose="1 2 3 0 0 0"/>
    <link name="l" kinematic="true">
      <damping linear="0.1" angular="0.2"/>
      <inertial mass="3" density="9"><inertia ixx="1" ixy="0" ixz="0" iyy="2" iyz="0" izz="3"/></inertial>
      <visual name="v"><geometry><mesh filename="t.dae" scale="1 1 2"/></geometry>
        <material script="Gazebo/Red"/></visual>
      <sensor name="s" type="contact"><contact><collision name="c"/></contact></sensor>
    </link>
    <plugin name="p" filename="p.so"><link name="untouched" gravity="1"/></plugin>
  </model>
</gazebo>
"""


def upgraded(data):
    text, changes = upgrade_document(data, "t.sdf")
    return text, etree.fromstring(text), [str(change) for change in changes]


def test_attributes_become_elements_and_the_rest_stays():
    text, root, changes = upgraded(TABLE)
    assert (root.tag, root.get("version")) == ("sdf", "1.6")
    assert b"<!-- licence -->" in text
    assert b"  <!-- one table -->\n  <model name" in text
    link = root.find("model/link")
    assert root.findtext("model/pose") == "1 2 3 0 0 0"
    assert root.findtext("model/static") == link.findtext("kinematic") == "true"
    assert (link.findtext("velocity_decay/linear"), link.findtext("velocity_decay/angular")) == ("0.1", "0.2")
    assert (link.findtext("inertial/mass"), link.findtext("inertial/inertia/iyy")) == ("3", "2")
    assert link.findtext("visual/geometry/mesh/uri") == "t.dae"
    assert link.findtext("visual/material/script/name") == "Gazebo/Red"
    assert link.findtext("sensor/contact/collision") == "c"
    assert root.find("model/plugin/link").get("gravity") == "1"
    assert "t.sdf:5: <model>: attribute 'static' became <static>" in changes
    assert "t.sdf:3: <gazebo>: became <sdf>" in changes


def test_later_steps_move_elements():
    old = b"""<sdf version='1.3'><world name='w'><physics type='ode'><gravity>0 0 -1</gravity>
    <update_rate>50</update_rate><ode><solver><dt>0.02</dt></solver></ode></physics>
    <model name='m'><link name='l'><sensor name='s' type='imu'><imu><noise><type>gaussian</type>
    <rate><mean>1</mean></rate><accel><stddev>2</stddev></accel></noise></imu></sensor></link>
    <joint name='j' type='revolute'><parent>world</parent><child>l</child><axis><xyz>0 0 1</xyz></axis></joint>
    </model></world></sdf>"""
    _, root, _ = upgraded(old)
    world = root.find("world")
    assert world.findtext("gravity") == "0 0 -1"
    assert world.findtext("physics/max_step_size") == "0.02"
    assert world.findtext("physics/real_time_update_rate") == "50"
    assert world.find("physics/ode/solver/dt") is None
    assert world.findtext("model/joint/axis/use_parent_model_frame") == "true"
    imu = world.find("model/link/sensor/imu")
    assert imu.find("noise") is None
    assert [imu.findtext(f"angular_velocity/{axis}/noise/mean") for axis in "xyz"] == ["1", "1", "1"]
    assert imu.find("linear_acceleration/y/noise").get("type") == "gaussian"
    assert SdfFile.from_string(upgraded(old)[0]).diagnostics.found == {}


@pytest.mark.parametrize("path", OLD, ids=lambda path: path.stem)
def test_an_upgraded_world_runs_as_the_old_one(path, tmp_path):
    new = tmp_path / "new.world"
    new.write_bytes(upgrade_document(path.read_bytes())[0])
    with libgz.World.from_file(path) as old, libgz.World.from_file(new) as again:
        assert (old.engine.step_time, old.engine.gravity) == (again.engine.step_time, again.engine.gravity)
        for world in (old, again):
            world.step(100)
        poses = [[tuple(body.GetPosition()) for entity in w.entities for body in entity.bodies] for w in (old, again)]
        assert poses[0] == poses[1]


def test_a_value_that_is_there_already_is_kept():
    _, root, changes = upgraded(b"<gazebo version='1.0'><model name='m' static='1'><static>0</static></model></gazebo>")
    assert root.findtext("model/static") == "0"
    assert any("was dropped, for there is a <static>" in change for change in changes)


@pytest.mark.parametrize("version", ["1.6", "1.9", "1.11"])
def test_newer_documents_stay_as_they_are(version):
    data = f"<sdf version='{version}'>  <model name='m'/></sdf>".encode()
    assert upgrade_document(data) == (data, [])


@pytest.mark.parametrize("text", [b"<sdf/>", b"<sdf version='x'/>", b"<html version='1.0'/>"])
def test_what_has_no_known_version_is_refused(text):
    with pytest.raises(WorldFileError):
        upgrade_document(text)


def test_the_command_writes_them(tmp_path):
    old, new = tmp_path / "old.sdf", tmp_path / "new.sdf"
    old.write_bytes(TABLE)
    done = run_libgz("upgrade", old, "-o", new)
    assert done.returncode == 0
    assert "<static>" in done.stderr
    assert SdfFile.load(new).version == "1.6"
    assert run_libgz("upgrade", new, "--in-place").stderr.endswith("nothing to change\n")


def test_the_command_writes_robots_as_sdf(tmp_path):
    robot = tmp_path / "r.urdf"
    robot.write_text("<robot name='r'><link name='world'/></robot>")
    new = tmp_path / "new.sdf"
    done = run_libgz("upgrade", robot, "-o", new)
    assert (done.returncode, done.stderr) == (0, f"{robot}:1: <robot>: became <sdf version='1.6'>\n")
    assert SdfFile.load(new).root.child("model").Get(str, "name") == "r"
    done = run_libgz("upgrade", robot, "--in-place")
    assert done.returncode == 1
    assert "name the SDF file to write with -o" in done.stderr
