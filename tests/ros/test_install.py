"""The packages for launch files, and spawn_model, which they start."""

import ast
import hashlib
import os
import py_compile
import re
import runpy
import shutil
import subprocess
import sys
import threading
import xml.etree.ElementTree as ET
from pathlib import Path
from unittest.mock import MagicMock, Mock

import pytest
from ros_peers import wait_for

from libgz.apps import gzclient
from libgz.apps.gzserver import make_parser
from libgz.apps.libgz import main
from libgz.apps.ros_option import ros_wanted, without_ros_words
from libgz.apps.spawn_model import _spawn, main as spawn_model, make_parser as spawn_parser
from libgz.base.errors import LibraryError, NotFoundError
from libgz.ros.environment import find_python
from libgz.ros.install import install, uninstall
from libgz.ros.packages import exported_folders
from libgz.ros.types import message_type, service_type
from libgz.ros.venv import definitions, make_environment
from libgz.sdf import paths
from libgz.sdf.paths import find_uri

ARGUMENTS = {
    "debug", "enable_ros_network", "extra_gazebo_args", "gui", "gui_required", "headless", "output", "paused",
    "physics", "pub_clock_frequency", "recording", "respawn_gazebo", "server_required", "use_clock_frequency",
    "use_sim_time", "verbose", "world_name",
}  # fmt: skip
URDF = (
    "<robot name='any'><link name='base'><inertial><mass value='1'/>"
    "<inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link></robot>"
)


# What the headers of messages use of roscpp's.
ROSCPP = """\
#ifndef STAND_IN
#define STAND_IN
#include <cstdint>
#include <iostream>
namespace ros {
struct Time { uint32_t sec = 0, nsec = 0; bool operator==(const Time &o) const { return sec == o.sec; } };
typedef Time Duration;
namespace message_traits {
struct TrueType { static const bool value = true; };
struct FalseType { static const bool value = false; };
template <class M> struct IsMessage : FalseType {};
template <class M> struct IsFixedSize : FalseType {};
template <class M> struct HasHeader : FalseType {};
template <class M> struct MD5Sum;
template <class M> struct DataType;
template <class M> struct Definition;
}
namespace service_traits { template <class M> struct MD5Sum; template <class M> struct DataType; }
namespace serialization { template <class M> struct Serializer; }
namespace message_operations {
template <class M> struct Printer
{
  template <class S> static void stream(S &s, const std::string &, const M &m) { s << m << "\\n"; }
};
template <> struct Printer<Time> { template <class S> static void stream(S &, const std::string &, const Time &) {} };
}
}
#define ROS_DECLARE_ALLINONE_SERIALIZER
#endif
"""
USER = """\
#include <gazebo_msgs/ContactsState.h>
#include <gazebo_msgs/SetModelState.h>
struct Counter { int count = 0; template <class T> void next(T &) { ++this->count; } };
int main()
{
  gazebo_msgs::ContactsState message;
  message.states.resize(1);
  message.states[0].info = "touch";
  message.states[0].depths.push_back(0.25);
  Counter counter;
  ros::serialization::Serializer<gazebo_msgs::ContactState>::allInOne<Counter, gazebo_msgs::ContactState &>(
      counter, message.states[0]);
  std::cout << message << counter.count << " " << (message == message) << " "
            << ros::message_traits::HasHeader<gazebo_msgs::ContactsState>::value
            << ros::message_traits::IsFixedSize<geometry_msgs::Wrench>::value
            << ros::message_traits::IsFixedSize<gazebo_msgs::ContactsState>::value << " "
            << ros::service_traits::MD5Sum<gazebo_msgs::SetModelState>::value() << " "
            << ros::message_traits::Definition<gazebo_msgs::ModelState>::value();
}
"""


def test_headers_of_messages_compile(tmp_path, monkeypatch):
    """roscpp itself is in the trial; here its place is taken by what the headers use of it."""
    if shutil.which("g++") is None or not Path("/usr/include/boost/array.hpp").exists():
        pytest.skip("needs g++ and libboost-dev")
    monkeypatch.setattr("libgz.ros.install.MESSAGES", ("gazebo_msgs", "geometry_msgs", "std_msgs"))
    install(tmp_path)
    (tmp_path / "include" / "ros").mkdir()
    for name in ("types", "serialization", "builtin_message_traits", "message_operations", "service_traits"):
        (tmp_path / "include" / "ros" / f"{name}.h").write_text(ROSCPP)
    (tmp_path / "user.cc").write_text(USER)
    command = ["g++", "-std=c++17", "-O0", "-Wall", "-Werror", f"-I{tmp_path}/include", "-o", "user", "user.cc"]
    subprocess.run(command, check=True, cwd=tmp_path)
    said = subprocess.run([tmp_path / "user"], capture_output=True, text=True, check=True).stdout
    kind, service = message_type("gazebo_msgs/ContactState"), service_type("gazebo_msgs/SetModelState")
    assert "info: touch" in said
    assert "depths[0]: 0.25" in said
    assert f"{len(kind.fields)} 1 110 {service.md5} {message_type('gazebo_msgs/ModelState').text}" in said


CONTROLLED = """\
#include <control_toolbox/pid.h>
#include <cstdio>
int main()
{
  control_toolbox::Pid pid(2, 3, 0.5, 0.25, -0.25), wound(2, 3, 0.5, 0.25, -0.25, true), unread;
  for (double error : {1.0, 0.5, -3.0})
    for (control_toolbox::Pid *one : {&pid, &wound})
      std::printf("%.9f ", one->computeCommand(error, ros::Duration(0.1)));
  double p, i, d;
  wound.getCurrentPIDErrors(&p, &i, &d);
  std::printf("%.9f %.9f %d ", i, d, unread.init(ros::NodeHandle("none"), true));
  std::printf("%d ", unread.init(ros::NodeHandle("arm")));
  std::printf("%.3f %.3f", unread.getGains().p_gain_, unread.getGains().i_min_);
}
"""
NODE_HANDLE = """\
#include <string>
#define ROS_ERROR(...)
namespace ros {
struct Duration
{
  double seconds;
  explicit Duration(double s) : seconds(s) {}
  double toSec() const { return seconds; }
};
struct NodeHandle
{
  std::string name;
  explicit NodeHandle(const std::string &n) : name(n) {}
  std::string getNamespace() const { return name; }
  bool getParam(const std::string &key, double &value) const { value = 7; return name == "arm" && key == "p"; }
  template <class T> void param(const std::string &key, T &value, T otherwise) const
  {
    value = key == "i_clamp" ? T(4) : otherwise;
  }
};
}
"""


def test_the_controller_of_plugins(tmp_path):
    """The integral's share is limited; with antiwindup the integral is."""
    if shutil.which("g++") is None:
        pytest.skip("needs g++")
    install(tmp_path)
    (tmp_path / "include" / "ros").mkdir()
    (tmp_path / "include" / "ros" / "ros.h").write_text(NODE_HANDLE)
    (tmp_path / "user.cc").write_text(CONTROLLED)
    command = ["g++", "-std=c++17", "-O0", "-Wall", "-Werror", f"-I{tmp_path}/include", "-o", "user", "user.cc"]
    subprocess.run(command, check=True, cwd=tmp_path)
    said = subprocess.run([tmp_path / "user"], capture_output=True, text=True, check=True).stdout.split()
    # 2 e + integral + 0.5 de/dt: 2 + 0.25 + 5, 1 + 0.25 - 2.5, -6 - 0.25 - 17.5
    expected = [7.25, 7.25, -1.25, -1.25, -23.75, -23.75]
    assert [float(word) for word in said[:6]] == pytest.approx(expected)
    assert [float(word) for word in said[6:8]] == pytest.approx([-0.25 / 3.0, -35.0])
    assert said[8:] == ["0", "1", "7.000", "-4.000"]


FINDS = """\
foreach(one ${PACKAGES})
  find_package(${one} REQUIRED CONFIG)
  message("${one} ${${one}_FOUND_CATKIN_PROJECT} ${${one}_INCLUDE_DIRS} ${${one}_LIBRARIES}")
endforeach()
message("flags =${CMAKE_CXX_FLAGS}")
"""


GAZEBO = ("gazebo_dev", "gazebo_plugins", "gazebo_ros", "gazebo_ros_control")
HEADERS = ("control_msgs", "control_toolbox", "controller_manager", "controller_manager_msgs", "gazebo_msgs")


def found_by_cmake(folder):
    """What cmake finds in a shell with the packages: by their names, and "flags"."""
    script = folder / "finds.cmake"
    script.write_text(FINDS)
    command = f". {folder}/setup.sh && cmake -D 'PACKAGES={';'.join((*GAZEBO, *HEADERS))}' -P {script}"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=True)
    return {words[0]: words[1:] for words in (line.split() for line in done.stderr.splitlines())}


@pytest.mark.parametrize("api", [True, False])
def test_catkin_finds_the_packages_that_plugins_name(tmp_path, monkeypatch, api):
    """With Gazebo's API by those that stand for it, as gazebo_dev has it; none of them needs it."""
    if shutil.which("cmake") is None:
        pytest.skip("needs cmake")
    monkeypatch.setenv("HOME", str(tmp_path))  # cmake knows packages of the user there
    install(tmp_path)
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"{tmp_path}/devel")
    if api:
        config = tmp_path / "devel" / "lib" / "cmake" / "gazebo" / "gazebo-config.cmake"
        config.parent.mkdir(parents=True)
        values = {"INCLUDE_DIRS": "/api", "LIBRARY_DIRS": "/lib", "LIBRARIES": "gazebo", "CXX_FLAGS": "-std=c++17"}
        config.write_text("".join(f'set(GAZEBO_{name} "{value}")\n' for name, value in values.items()))
    found = found_by_cmake(tmp_path)
    for package in GAZEBO:
        assert found[package] == ["TRUE", *(["/api", "gazebo"] if api else [])]
    for package in HEADERS:
        assert found[package] == ["TRUE", f"{tmp_path}/include"]
    assert ("-std=c++17" in found["flags"]) == api


def test_catkin_finds_what_users_have_compiled_first(tmp_path, monkeypatch):
    if shutil.which("cmake") is None:
        pytest.skip("needs cmake")
    install(tmp_path)
    for package in (*GAZEBO, *HEADERS):
        own = tmp_path / "devel" / "share" / package / "cmake" / f"{package}Config.cmake"
        own.parent.mkdir(parents=True)
        own.write_text(f"set({package}_FOUND_CATKIN_PROJECT own)\n")
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"{tmp_path}/devel")
    found = found_by_cmake(tmp_path)
    assert [found[package] for package in (*GAZEBO, *HEADERS)] == [["own"]] * len(GAZEBO + HEADERS)


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
    (tmp_path / "r.xacro").write_text(
        "<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'><link name='${1 + 1}'/></robot>"
    )
    done = subprocess.run(
        [prefix / "spare/xacro/xacro", "--inorder", tmp_path / "r.xacro"], capture_output=True, text=True, check=True
    )
    assert '<link name="2"/>' in done.stdout
    assert "publish_rate: 50" in (prefix / "spare/joint_state_controller/joint_state_controller.yaml").read_text()
    action = message_type("control_msgs/FollowJointTrajectoryAction")
    assert action.md5 == "bc4f9b743838566551c0390c65f1a248"  # which actionlib's clients compare
    assert "_action_goal_type" in (prefix / "include" / f"{action.name}.h").read_text()
    assert ast.parse((prefix / "python" / "gazebo_msgs" / "__init__.py").read_text())
    found = subprocess.run(
        ["sh", "-c", f". '{prefix}/setup.sh' && echo $PYTHONPATH && echo $ROS_PACKAGE_PATH && command -v xacro"],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "ROS_PACKAGE_PATH": "/mine"},
    )
    python, packages, xacro = found.stdout.splitlines()
    assert xacro.endswith("/xacro")  # which launch files also call by its plain name
    assert python.startswith(f"{prefix}/python")
    assert packages == f"{prefix}/share:/mine:{prefix}/spare"  # a xacro of ROS's own comes first
    (package / "mine.launch").touch()
    assert main(["ros", "install", "--uninstall", str(prefix)]) == 0
    assert [path for path in prefix.rglob("*") if path.is_file()] == [package / "mine.launch"]
    assert main(["ros", "install", "--uninstall", str(prefix)]) == 1
    assert "installed nothing there" in capsys.readouterr().err


def test_files_of_another_version_are_removed_if_they_are_as_they_were_written(tmp_path, monkeypatch):
    prefix, mine = tmp_path / "ros", tmp_path / "mine.txt"
    older = {"share/gone/package.xml": ("<a/>", False), "share/changed.launch": ("<launch/>", False)}
    monkeypatch.setattr("libgz.ros.install._contents", lambda _prefix: older)
    install(prefix)
    monkeypatch.undo()
    mine.write_text("<a/>")
    (prefix / "share/changed.launch").write_text("<launch>mine</launch>")
    (prefix / "share/link").symlink_to(tmp_path)
    (prefix / "share/circle").symlink_to("circle")
    with (prefix / "libgz-ros.manifest").open("a") as manifest:  # as nobody should trust it
        for path in ("../mine.txt", str(mine), "share/link/mine.txt", "share/circle/x", "share/nul\0"):
            manifest.write(f"{hashlib.sha256(b'<a/>').hexdigest()} {path}\n")
    install(prefix)
    assert not (prefix / "share/gone").exists()
    older["share/later.xml"] = "<b/>", False
    monkeypatch.setattr("libgz.ros.install._contents", lambda _prefix: older)
    assert uninstall(prefix) > 200  # those of this version, which that one does not know
    assert (prefix / "share/changed.launch").read_text() == "<launch>mine</launch>"
    assert {path.name for path in prefix.rglob("*") if path.is_file()} <= {"changed.launch", "mine.txt"}
    assert mine.exists()


def test_nothing_is_removed_behind_a_link(tmp_path):
    """Somebody else may have made the folder."""
    prefix, elsewhere = tmp_path / "ros", tmp_path / "share"
    install(prefix)
    (prefix / "share").rename(elsewhere)
    (prefix / "share").symlink_to(elsewhere)
    before = sorted(elsewhere.rglob("*"))
    uninstall(prefix)
    assert sorted(elsewhere.rglob("*")) == before
    assert not (prefix / "setup.sh").exists()


def test_no_compiled_file_is_removed_behind_a_link(tmp_path):
    prefix, elsewhere = tmp_path / "ros", tmp_path / "cache"
    install(prefix)
    source = next(prefix.rglob("*.py"))
    elsewhere.mkdir()
    mine = elsewhere / f"{source.stem}.mine.pyc"
    mine.touch()
    (source.parent / "__pycache__").symlink_to(elsewhere)
    uninstall(prefix)
    assert mine.exists()


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


@pytest.mark.parametrize("kind", ["urdf", "sdf"])
def test_spawn_model_sends_no_plugins_of_strangers(monkeypatch, tmp_path, kind):
    """The server may trust its clients, and find what they do not."""
    plugin = "<plugin name='p' filename='libp.so'/>"
    include = "<include><uri>model://of_the_server</uri></include>"
    texts = {
        "urdf": URDF.replace("</robot>", f"<gazebo>{plugin}</gazebo></robot>"),
        "sdf": f"<sdf version='1.6'><model name='m'>{plugin}{include}<link name='l'/></model>{include}</sdf>",
    }
    (tmp_path / "file").write_text(texts[kind])
    monkeypatch.setenv("LIBGZ_UNTRUSTED", "1")
    client = Mock()
    _spawn(spawn_parser().parse_args([f"-{kind}", "-file", str(tmp_path / "file"), "-model", "m"]), client)
    [call] = client.call.call_args_list
    assert call.args[0] == "/gazebo/spawn_sdf_model"
    assert "<link " in call.kwargs["model_xml"]
    assert "libp.so" not in call.kwargs["model_xml"]
    assert "of_the_server" not in call.kwargs["model_xml"]


def test_spawn_model_reads_no_endless_file(master, capsys):
    assert spawn_model(["-urdf", "-file", "/dev/zero", "-model", "x"]) == 1
    assert "is larger than 64 MiB" in capsys.readouterr().err
    program = (
        "import resource, sys; from libgz.apps.spawn_model import main; "
        "resource.setrlimit(resource.RLIMIT_DATA, (1 << 30, 1 << 30)); sys.exit(main(sys.argv[1:]))"
    )
    with Path("/dev/zero").open() as zero:
        words = [sys.executable, "-c", program, "-urdf", "-stdin", "-model", "x"]
        done = subprocess.run(words, stdin=zero, capture_output=True, text=True)
    assert done.returncode == 1
    assert "is larger than 64 MiB" in done.stderr


def test_spawn_model_says_what_is_wrong(master, capsys):
    assert spawn_model(["-urdf", "-file", "/none.urdf", "-model", "x", "-gazebo_namespace", "/gazebo"]) == 1
    assert "/none.urdf does not exist" in capsys.readouterr().err
    assert spawn_model(["-urdf", "-param", "nothing", "-model", "x"]) == 1
    assert "parameter /nothing is empty" in capsys.readouterr().err


def test_definitions_of_ros2_are_whole():
    texts = definitions()
    assert {path.partition("/")[0] for path in texts} == {"control_msgs", "gazebo_msgs", "tf2_msgs"}
    assert texts["gazebo_msgs/srv/DeleteEntity.srv"] == "string name\n---\nbool success\nstring status_message\n"
    assert "builtin_interfaces/Duration duration\n" in texts["gazebo_msgs/srv/ApplyLinkWrench.srv"]
    assert texts["control_msgs/action/GripperCommand.action"].startswith("control_msgs/GripperCommand command\n---\n")
    action = texts["control_msgs/action/FollowJointTrajectory.action"]
    assert action.startswith("trajectory_msgs/JointTrajectory trajectory\n")
    assert action.count("---\n") == 2
    own = {path.replace("/msg/", "/").removesuffix(".msg") for path in texts if path.endswith(".msg")}
    for path, text in texts.items():
        used = set(re.findall(r"^((?:control|gazebo|tf2)_msgs/\w+)", text, re.M))
        assert used <= own, path


def test_an_environment_needs_a_compiler_and_a_python(tmp_path, monkeypatch):
    with pytest.raises(LibraryError, match="cannot be run"):
        make_environment(tmp_path / "env", "kilted", str(tmp_path / "none"), print)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(NotFoundError, match=r"cc and c\+\+ must be installed"):
        make_environment(tmp_path / "env", "kilted", None, print)


class Declared:
    """Stands for what launch files of ROS 2 import of launch; keeps the arguments that they declare."""

    found: dict = {}

    def __init__(self, *values, **options):
        self.values, self.options = values, options

    @classmethod
    def argument(cls, name, default_value, description=""):
        cls.found[name] = default_value


ARGUMENTS2 = {
    "extra_gazebo_args", "factory", "force_system", "gdb", "help", "init", "initial_sim_time", "iters", "lockstep",
    "minimal_comms", "params_file", "pause", "physics", "play", "profile", "record", "record_encoding", "record_filter",
    "record_path", "record_period", "seed", "server_required", "valgrind", "verbose", "version", "world",
}  # fmt: skip


def launch_file(path, monkeypatch):
    """What a launch file of ROS 2 defines, and the arguments that it declares."""
    Declared.found = {}
    stand_in = MagicMock(DeclareLaunchArgument=Declared.argument, ExecuteProcess=Declared)
    for name in ("launch", "launch.actions", "launch.conditions", "launch.substitutions"):
        monkeypatch.setitem(sys.modules, name, stand_in)
    monkeypatch.setitem(sys.modules, "launch.launch_description_sources", stand_in)
    found = runpy.run_path(str(path))
    found["generate_launch_description"]()
    return found, Declared.found


def test_launch_files_of_ros2_start_the_server_with_their_arguments(tmp_path, monkeypatch):
    install(tmp_path / "p")
    prefix = tmp_path / "p" / "ros2"
    package = prefix / "share" / "gazebo_ros"
    found, arguments = launch_file(package / "launch" / "gzserver.launch.py", monkeypatch)
    assert set(arguments) == ARGUMENTS2
    assert [name for name, value in arguments.items() if value == "true"] == ["init", "factory", "force_system"]
    given = arguments | {"pause": "true", "seed": "7", "params_file": "p.yaml", "extra_gazebo_args": "--gl none"}
    given |= {"force_system": "false", "server_required": "True"}
    (process,) = found["start"](MagicMock(launch_configurations=given))
    program, world, *words = process.options["cmd"]
    assert Path(program) == prefix / "bin" / "gzserver"
    assert Path(world) == package / "worlds" / "empty.world"
    systems = ["-s", "libgazebo_ros_init.so", "-s", "libgazebo_ros_factory.so"]
    assert words == ["--pause", "--seed=7", *systems, "--ros-args", "--params-file", "p.yaml", "--", "--gl", "none"]
    assert "on_exit" in process.options
    assert make_parser().parse_known_args(without_ros_words([*words, world]))[1] == [world]
    for name, wanted in {
        "gazebo": {"server", "gui"},
        "gzclient": {"verbose", "gui_required", "extra_gazebo_args"},
    }.items():
        assert wanted <= set(launch_file(package / "launch" / f"{name}.launch.py", monkeypatch)[1])
    assert (prefix / "share/ament_index/resource_index/packages/gazebo_ros").exists()
    environment = {"PATH": "/usr/bin:/bin", "AMENT_PREFIX_PATH": "/opt/ros/any"}
    command = ["sh", "-c", f". {prefix}/setup.sh; gzserver --version; echo $AMENT_PREFIX_PATH"]
    said = subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout
    assert "Gazebo multi-robot simulator" in said
    assert said.endswith(f"{prefix}:/opt/ros/any\n")
    for path in (package / "launch").glob("*.py"):
        py_compile.compile(str(path), doraise=True)  # as ros2 launch does
    uninstall(tmp_path / "p")
    assert not (tmp_path / "p").exists()


@pytest.fixture
def spawner(tmp_path, monkeypatch):
    """Makes a spawner of spawn_entity.py, without ROS 2."""
    install(tmp_path)
    ros = ("gazebo_msgs.msg", "gazebo_msgs.srv", "rclpy.executors", "rclpy.qos", "rclpy.utilities", "std_msgs.msg")
    for name in ("rclpy", *ros, "std_srvs.srv"):
        monkeypatch.setitem(sys.modules, name, MagicMock())
    found = runpy.run_path(str(tmp_path / "ros2" / "lib" / "gazebo_ros" / "spawn_entity.py"))
    (tmp_path / "r.urdf").write_text(URDF)

    def make(*words):
        options = found["read_options"](["-file", str(tmp_path / "r.urdf"), "-entity", "r", *words])
        one = found["Spawner"](MagicMock(**{"get_namespace.return_value": "/fleet"}), options)
        one.call = MagicMock()
        return one

    return make


@pytest.mark.parametrize(("words", "space"), [([], "/fleet"), (["-robot_namespace", "mine"], "mine")])
def test_spawn_entity_gives_plugins_the_namespace_of_its_node(spawner, words, space):
    one = spawner(*words)
    one.run()
    request = one.call.call_args.kwargs
    assert (request["robot_namespace"], request["xml"]) == (space, URDF)


def test_spawn_entity_sends_nothing_of_strangers(spawner, monkeypatch):
    monkeypatch.setenv("LIBGZ_UNTRUSTED", "1")
    one = spawner()
    with pytest.raises(Exception, match="files are untrusted"):
        one.run()
    one.call.assert_not_called()


def test_folders_that_packages_export_are_searched(tmp_path, monkeypatch):
    package = tmp_path / "share" / "worlds"
    (package / "models" / "crate").mkdir(parents=True)
    exports = "<gazebo_ros gazebo_model_path='${prefix}/models:relative'/><gazebo_ros plugin_path='/no'/>"
    (package / "package.xml").write_text(f"<package><name>worlds</name><export>{exports}</export></package>")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    monkeypatch.delenv("ROS_PACKAGE_PATH", raising=False)
    assert exported_folders() == {"gazebo_model_path": [package / "models"], "gazebo_media_path": []}
    monkeypatch.setattr(paths, "added_models", [])
    with pytest.raises(NotFoundError):
        find_uri("model://crate")
    gzclient.main(["--no-view", "--timeout", "0.1"])  # also a client, whose world may have meshes there
    assert find_uri("model://crate") == package / "models" / "crate"


@pytest.mark.parametrize(
    ("words", "found", "wanted"),
    [
        ("-s libgazebo_ros_init.so -s libgazebo_ros_factory.so", True, True),
        ("-s libgazebo_ros_factory.so", False, False),
        ("-s libgazebo_ros_factory.so --no-ros1", True, False),
        ("-s libgazebo_ros_factory.so --watch-only", True, False),
        ("-s libgazebo_ros_api_plugin.so", True, False),
        ("--ros2", False, True),
    ],
)
def test_system_plugins_of_ros2_ask_for_it_where_it_is(words, found, wanted, monkeypatch):
    def python():
        if not found:
            raise LibraryError("there is no ROS 2")
        return Path("python3")

    monkeypatch.setattr("libgz.ros.environment.find_python", python)
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    options, _ = make_parser().parse_known_args(words.split())
    assert ros_wanted(options) == wanted


def test_the_environment_of_libgz_is_found_beside_its_launch_files(monkeypatch, tmp_path):
    made = tmp_path / ".local/share/libgz/ros2/bin/python3"
    made.parent.mkdir(parents=True)
    made.touch()
    ros = tmp_path / "opt/ros/any/share/ament_index/resource_index/packages"
    monkeypatch.delenv("LIBGZ_ROS2_PYTHON", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path}/mine:{tmp_path}/opt/ros/any")
    assert find_python() == made  # these are no prefixes of a ROS 2
    ros.mkdir(parents=True)
    (ros / "rclpy").touch()
    assert find_python() != made
    monkeypatch.setenv("PATH", str(tmp_path))  # without any python3
    assert find_python() == made
