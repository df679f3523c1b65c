"""NAME:=VALUE of commands that read robot descriptions: arguments of their macros, as the command xacro takes them."""

import pytest
from lxml import etree

from libgz import World
from libgz.apps import gazebo, gzserver
from libgz.apps.libgz import make_parser, run_words

ROBOT = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="mass" default="1"/>
<link name="base"><inertial><mass value="$(arg mass)"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


@pytest.fixture
def robot(tmp_path):
    path = tmp_path / "robot.xacro"
    path.write_text(ROBOT)
    return path


@pytest.mark.parametrize("place", [1, 3], ids=["before", "after"])
def test_arguments_stand_anywhere(robot, capfd, place):
    words = ["sdf", "--print", str(robot)]
    words.insert(place, "mass:=7")
    assert run_words("libgz", words) == 0
    assert "<mass>7</mass>" in capfd.readouterr().out


def test_upgrade_check_and_worlds_take_them(robot, tmp_path, capfd):
    assert run_words("libgz", ["upgrade", str(robot), "-o", str(tmp_path / "out.sdf"), "mass:=3"]) == 0
    assert "<mass>3</mass>" in (tmp_path / "out.sdf").read_text()
    assert run_words("libgz", ["check", str(robot), "mass:=heavy"]) == 1
    assert "value is 'heavy'" in capfd.readouterr().out
    with World.from_file(robot, arguments={"mass": "5"}) as world:
        assert world.engine.bodies[0].GetMass().mass == 5.0


def test_what_has_no_macros_says_so(tmp_path, capfd, caplog):
    (tmp_path / "plain.urdf").write_text(ROBOT.replace("xacro:arg", "note").replace("$(arg mass)", "1"))
    assert run_words("libgz", ["check", str(tmp_path / "plain.urdf"), "mass:=1"]) == 0
    assert "there are no macros: mass has no effect" in capfd.readouterr().out


def test_servers_take_them_and_leave_those_of_ros():
    words = ["robot.xacro", "mass:=a:=b", "__name:=gazebo"]
    for options, unknown in (
        gzserver.make_parser().parse_known_args(words),
        gazebo.make_parser().parse_known_args(words),
    ):
        assert options.arguments == {"mass": "a:=b"}
        assert "__name:=gazebo" in unknown
    assert make_parser("model").parse_args(["model", "-f", "r.xacro", "a:="]).arguments == {"a": ""}


def test_xacro_prints_the_expanded_description(robot, tmp_path, capfdbinary):
    assert run_words("libgz", ["xacro", "--inorder", str(robot), "mass:=7"]) == 0
    found = etree.fromstring(capfdbinary.readouterr().out)
    assert found.find("link/inertial/mass").attrib == {"value": "7"}
    assert [element.tag for element in found] == ["link"]
    assert not found.nsmap
    assert run_words("libgz", ["xacro", str(robot), "-o", str(tmp_path / "out.urdf")]) == 0
    assert '<mass value="1"/>' in (tmp_path / "out.urdf").read_text()


def test_xacro_refuses_what_is_wrong_and_warns_of_what_is_left_out(tmp_path, capfd):
    (tmp_path / "wrong.xacro").write_text(ROBOT.replace("$(arg mass)", "${1 +}"))
    assert run_words("libgz", ["xacro", str(tmp_path / "wrong.xacro")]) == 1
    assert "wrong.xacro:2: <mass>: " in capfd.readouterr().err
    (tmp_path / "wrong.urdf").write_text(ROBOT.replace("<link", "<xacro:none/><link"))
    assert run_words("libgz", ["xacro", str(tmp_path / "wrong.urdf")]) == 0
    assert "wrong.urdf:2: <xacro:none>: " in capfd.readouterr().err
    assert run_words("libgz", ["xacro", "-q", str(tmp_path / "wrong.urdf")]) == 0
    assert capfd.readouterr().err == ""
