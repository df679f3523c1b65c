"""What launch files of ROS 2 name, for `libgz ros install`: an ament prefix with the package gazebo_ros."""

from __future__ import annotations

import shlex
from pathlib import Path

from libgz.base.python import run_module

__all__ = ["PREFIX", "ament_contents"]

SPAWN = Path(__file__).parent / "bridge" / "spawn_entity.py"
PREFIX = "ros2"  # folder in that of the installation

PACKAGES = {
    "gazebo_plugins": "Plugins of Gazebo, which libgz has.",
    "gazebo_ros": "Starts libgz as Gazebo, and spawns entities.",
    "gazebo_ros2_control": "Controllers of robots, which libgz has.",
    "gazebo_ros_pkgs": "The packages of gazebo_ros.",
}

# Programs; they keep PYTHONPATH for the bridge, and do not read it themselves.
SCRIPT = """\
#!/bin/sh
exec {command} "$@"
"""
PROGRAMS = {
    "gazebo": ("gzserver", "--ros2", "--view"),
    "gzclient": ("gzclient",),
    "gzserver": ("gzserver", "--ros2"),
}

SETUP = """\
# Read by a shell, after ROS 2's own: . {prefix}/{folder}/setup.sh
export AMENT_PREFIX_PATH={prefix}/{folder}${{AMENT_PREFIX_PATH:+:$AMENT_PREFIX_PATH}}
export PATH={prefix}/{folder}/bin:$PATH
"""

WORLD = """\
<?xml version="1.0"?>
<sdf version="1.6">
  <world name="default">
    <include><uri>model://ground_plane</uri></include>
    <include><uri>model://sun</uri></include>
  </world>
</sdf>
"""

# Arguments of gzserver.launch.py that are options of the same name: switches, and those with a value.
SWITCHES = ("version", "verbose", "lockstep", "help", "pause", "record", "minimal_comms")
VALUES = (
    "initial_sim_time", "physics", "play", "record_encoding", "record_path", "record_period", "record_filter", "seed",
    "iters", "profile",
)  # fmt: skip
SYSTEMS = ("init", "factory", "force_system")

LAUNCH_PART = '''\
"""{about}"""

from pathlib import Path

from launch import LaunchDescription
{imports}

PACKAGE = Path(__file__).absolute().parents[1]
'''

PROCESS = "from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown"
PROCESS_PART = """\
PROGRAMS = PACKAGE.parents[1] / "bin"
TRUE = ("true", "1", "yes", "on")
"""

SERVER = (
    LAUNCH_PART.format(
        about="Starts the server, with the arguments of gazebo_ros's file of this name.",
        imports=PROCESS,
    )
    + PROCESS_PART
    + '''
SWITCHES = {switches!r}
VALUES = {values!r}
SYSTEMS = {systems!r}
OTHERS = {{
    "world": (str(PACKAGE / "worlds" / "empty.world"), "world file"),
    "params_file": ("", "file of parameters of nodes"),
    "extra_gazebo_args": ("", "further words for the server"),
    "gdb": ("false", "run it in gdb"),
    "valgrind": ("false", "run it in valgrind"),
    "server_required": ("false", "end all when the server ends"),
}}


def start(context):
    """The process of the server."""
    given = context.launch_configurations
    command = [str(PROGRAMS / "gzserver"), given["world"]]
    command += [f"--{{name}}" for name in SWITCHES if given[name].lower() in TRUE]
    command += [f"--{{name}}={{given[name]}}" for name in VALUES if given[name]]
    for name in SYSTEMS:
        if given[name].lower() in TRUE:
            command += ["-s", f"libgazebo_ros_{{name}}.so"]
    if given["params_file"]:
        command += ["--ros-args", "--params-file", given["params_file"], "--"]
    command += given["extra_gazebo_args"].split()
    words = {{"gdb": "gdb -ex run --args", "valgrind": "valgrind"}}
    prefix = next((line for name, line in words.items() if given[name].lower() in TRUE), None)
    more = {{"on_exit": Shutdown()}} if given["server_required"].lower() in TRUE else {{}}
    return [ExecuteProcess(cmd=command, output="both", prefix=prefix, **more)]


def generate_launch_description():
    """The arguments, and the server."""
    arguments = [(name, "false", f"--{{name}}") for name in SWITCHES]
    arguments += [(name, "", f"--{{name}}") for name in VALUES]
    arguments += [(name, "true", f"load libgazebo_ros_{{name}}.so") for name in SYSTEMS]
    arguments += [(name, *values) for name, values in OTHERS.items()]
    declared = [DeclareLaunchArgument(name, default_value=value, description=text) for name, value, text in arguments]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])
'''
).format(switches=SWITCHES, values=VALUES, systems=SYSTEMS)

CLIENT = (
    LAUNCH_PART.format(
        about="Shows the world in a page, with the arguments of gazebo_ros's file of this name.",
        imports=PROCESS,
    )
    + PROCESS_PART
    + '''
SWITCHES = ("version", "verbose", "help")
ARGUMENTS = {**dict.fromkeys((*SWITCHES, "gdb", "valgrind", "gui_required"), "false"), "extra_gazebo_args": ""}


def start(context):
    """The process of the client."""
    given = context.launch_configurations
    command = [str(PROGRAMS / "gzclient"), *(f"--{name}" for name in SWITCHES if given[name].lower() in TRUE)]
    command += given["extra_gazebo_args"].split()
    more = {"on_exit": Shutdown()} if given["gui_required"].lower() in TRUE else {}
    return [ExecuteProcess(cmd=command, output="screen", **more)]


def generate_launch_description():
    """The arguments, and the client."""
    declared = [DeclareLaunchArgument(name, default_value=value) for name, value in ARGUMENTS.items()]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])
'''
)

BOTH = (
    LAUNCH_PART.format(
        about="Starts server and client, with the arguments of gazebo_ros's file of this name.",
        imports="""\
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration""",
    )
    + '''

def generate_launch_description():
    """Server and client."""
    parts = []
    for name, program in (("server", "gzserver"), ("gui", "gzclient")):
        source = PythonLaunchDescriptionSource(str(PACKAGE / "launch" / f"{program}.launch.py"))
        condition = IfCondition(LaunchConfiguration(name))
        parts += [
            DeclareLaunchArgument(name, default_value="true", description=f"whether to start {program}"),
            IncludeLaunchDescription(source, condition=condition),
        ]
    return LaunchDescription(parts)
'''
)


def ament_contents(prefix: str, package: str, release: str) -> dict[str, tuple[str, bool]]:
    """Paths below the prefix of the installation -> (text, whether it is a program).

    Args:
        prefix: of the installation, quoted for a shell.
        package: the template of package.xml.
        release: the version in it.
    """
    found = {}
    for name, text in PACKAGES.items():
        found[f"share/ament_index/resource_index/packages/{name}"] = "", False
        found[f"share/{name}/package.xml"] = package.format(name=name, version=release, about=text), False
    share = "share/gazebo_ros"
    for name, text in {"gzserver": SERVER, "gzclient": CLIENT, "gazebo": BOTH}.items():
        found[f"{share}/launch/{name}.launch.py"] = text, False
    found[f"{share}/worlds/empty.world"] = WORLD, False
    found["lib/gazebo_ros/spawn_entity.py"] = SPAWN.read_text(), True
    for name, (module, *words) in PROGRAMS.items():
        python, *rest = run_module(f"libgz.apps.{module}", *words)
        found[f"bin/{name}"] = SCRIPT.format(command=shlex.join([python, "-E", *rest])), True
    found["setup.sh"] = SETUP.format(prefix=prefix, folder=PREFIX), False
    found["setup.bash"] = f". {prefix}/{PREFIX}/setup.sh\n", False
    return {f"{PREFIX}/{path}": content for path, content in found.items()}
