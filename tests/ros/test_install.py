"""The packages for launch files, and spawn_model, which they start."""

import ast
import subprocess
import threading
import xml.etree.ElementTree as ET

import pytest
from ros_peers import wait_for

from libgz.apps.libgz import main
from libgz.apps.spawn_model import main as spawn_model

ARGUMENTS = {
    "debug", "enable_ros_network", "extra_gazebo_args", "gui", "gui_required", "headless", "output", "paused",
    "physics", "pub_clock_frequency", "recording", "respawn_gazebo", "server_required", "use_clock_frequency",
    "use_sim_time", "verbose", "world_name",
}  # fmt: skip
URDF = (
    "<robot name='any'><link name='base'><inertial><mass value='1'/>"
    "<inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>"
)


def test_packages_are_installed_and_removed_by_their_manifest(tmp_path, capsys):
    prefix = tmp_path / "with space" / "ros"
    assert main(["ros", "install", str(prefix)]) == 0
    assert f". {prefix}/setup.sh" in capsys.readouterr().out
    package = prefix / "share" / "gazebo_ros"
    assert ET.parse(package / "package.xml").findtext("name") == "gazebo_ros"
    launch = ET.parse(package / "launch" / "empty_world.launch").getroot()
    assert {one.get("name") for one in launch.findall("arg") if one.get("default") is not None} == ARGUMENTS
    for name in ("gzserver", "gzclient", "gazebo", "debug", "spawn_model"):
        assert (package / "scripts" / name).stat().st_mode & 0o111 == 0o111
    done = subprocess.run([package / "scripts" / "spawn_model", "--help"], capture_output=True, text=True, check=True)
    assert "-param" in done.stdout
    assert ast.parse((prefix / "python" / "gazebo_msgs" / "__init__.py").read_text())
    found = subprocess.run(
        ["sh", "-c", f". '{prefix}/setup.sh' && echo $PYTHONPATH"], capture_output=True, text=True, check=True
    )
    assert found.stdout.startswith(f"{prefix}/python")
    (package / "mine.launch").touch()
    assert main(["ros", "install", "--uninstall", str(prefix)]) == 0
    assert [path for path in prefix.rglob("*") if path.is_file()] == [package / "mine.launch"]
    assert main(["ros", "install", "--uninstall", str(prefix)]) == 1
    assert "installed nothing there" in capsys.readouterr().err


@pytest.mark.parametrize("source", ["file", "param"])
def test_spawn_model_inserts_a_model(master, start, tmp_path, source):
    core, _ = start("<sdf version='1.6'><world name='default'/></sdf>")
    master.parameters["/robot_description"] = URDF
    (tmp_path / "r.urdf").write_text(URDF)
    words = ["-file", str(tmp_path / "r.urdf")] if source == "file" else ["-param", "robot_description"]
    words += ["-urdf", "-model", "mine", "-x", "1.5", "-Y", "0.5", "__name:=spawner", "__log:=x"]
    codes = []
    thread = threading.Thread(target=lambda: codes.append(spawn_model(words)))
    thread.start()
    wait_for(lambda: codes, core.Step)
    thread.join()
    assert codes == [0]
    pose = core.facade.ModelByName("mine").WorldPose()
    assert (round(pose.Pos().X(), 3), round(pose.Rot().Yaw(), 3)) == (1.5, 0.5)


def test_spawn_model_says_what_is_wrong(master, capsys):
    assert spawn_model(["-urdf", "-file", "/none.urdf", "-model", "x", "-gazebo_namespace", "/gazebo"]) == 1
    assert "/none.urdf does not exist" in capsys.readouterr().err
    assert spawn_model(["-urdf", "-param", "nothing", "-model", "x"]) == 1
    assert "parameter /nothing is empty" in capsys.readouterr().err
