"""What libgz writes is read by Debian's sdformat 12, a strict reader of SDF."""

import shutil
import subprocess
from pathlib import Path

import pytest
from commands import run_libgz
from lxml import etree

import libgz
from libgz.classic import physics
from libgz.classic.log import LogReader, LogRecord
from libgz.classic.server import attach

pytestmark = pytest.mark.skipif(
    shutil.which("ign") is None, reason="Debian's packages ignition-tools and libsdformat-dev are not installed"
)
ROOT = Path(__file__).parents[2]
SENSOR = """<sensor name='ray' type='ray'><ray><scan><horizontal><samples>3</samples></horizontal></scan><range>
<min>0.1</min><max>3</max></range><noise><mean>0</mean></noise></ray></sensor>"""
WORLD = f"""<sdf version='1.6'><world name='default'><include><uri>model://sun</uri></include><include>
<uri>model://ground_plane</uri></include><light name='lamp'/>
<model name='box'><pose>0 0 3 0 0 0</pose><link name='link'>
<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>{SENSOR}</link><link name='other'/>
<joint name='joint' type='revolute'><parent>link</parent><child>other</child><axis><xyz>0 0 1</xyz></axis></joint>
</model>
<road name='road'><width>1</width><point>0 0 0</point><point>1 0 0</point></road></world></sdf>"""
ROBOT = """<robot name="r"><link name="a">{0}</link><link name="b">{0}</link>
<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
</robot>"""
INERTIAL = "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>"


def check(path):
    """Fail with what sdformat says, unless it reads the file."""
    ended = subprocess.run(["ign", "sdf", "-k", str(path)], capture_output=True, text=True, timeout=60)
    said = ended.stdout + ended.stderr
    assert "Error Code" not in said, said
    assert "Valid." in said, said


@pytest.fixture
def world():
    with libgz.World.from_string(WORLD) as world:
        attach(world)
        world.step(3)
        yield world


@pytest.mark.parametrize("text", [WORLD, ROBOT.format(INERTIAL)], ids=["world", "robot"])
def test_printed_files(tmp_path, text):
    (tmp_path / "given.sdf").write_text(text)
    ended = run_libgz("sdf", "--print", tmp_path / "given.sdf")
    assert ended.returncode == 0, ended.stderr
    (tmp_path / "printed.sdf").write_text(ended.stdout)
    check(tmp_path / "printed.sdf")


def test_the_worlds_of_libgz(tmp_path):
    for path in (ROOT / "libgz/sdf/worlds").glob("*.world"):
        (tmp_path / path.name).write_text(run_libgz("sdf", "--print", path).stdout)
        check(tmp_path / path.name)


def test_saved_worlds(world, tmp_path):
    physics.get_world("default").Save(str(tmp_path / "saved.sdf"))
    check(tmp_path / "saved.sdf")


def test_the_documents_of_logs(world, tmp_path):
    with LogRecord(world, tmp_path / "state.log") as record:
        world.step(5)
        physics.get_world("default").InsertModelString(
            "<sdf version='1.6'><model name='new'><link name='l'/></model></sdf>"
        )
        world.step(5)
    documents = list(LogReader(record.path).documents())
    assert len(documents) > 5
    for number in (0, 1, -1):
        path = tmp_path / "document.sdf"
        # A state is read inside of a world only.
        path.write_bytes(etree.tostring(documents[number]))
        check(path)


@pytest.mark.parametrize("name", ["pioneer2at", "pioneer2dx", "simplesolids"])
def test_converted_worldfiles(tmp_path, name):
    ended = run_libgz("convert", ROOT / "worlds" / f"{name}.world", "-o", tmp_path / "converted.sdf")
    assert ended.returncode == 0, ended.stderr
    check(tmp_path / "converted.sdf")
