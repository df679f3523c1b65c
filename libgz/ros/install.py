"""Installation of what robots' launch files name: the packages gazebo_ros and gazebo_msgs for ROS 1, and for ROS 2."""

from __future__ import annotations

import shlex
from pathlib import Path

from libgz._version import __version__
from libgz.base.errors import LibraryError, NotFoundError
from libgz.base.files import write_whole
from libgz.base.manifest import Manifest
from libgz.base.python import run_module
from libgz.ros.cxx_headers import message_header, service_headers
from libgz.ros.install2 import ament_contents
from libgz.ros.pid_header import PID
from libgz.ros.types import message_type, service_type, type_names

__all__ = ["default_prefix", "install", "uninstall"]

MANIFEST = "libgz-ros.manifest"

PACKAGE = """\
<?xml version="1.0"?>
<package format="2">
  <name>{name}</name>
  <version>{version}</version>
  <description>{about}</description>
  <maintainer email="nobody@localhost">libgz</maintainer>
  <license>Apache 2.0</license>
</package>
"""

EMPTY_WORLD = """\
<?xml version="1.0"?>
<!-- A world, with the arguments of gazebo_ros's file of this name. -->
<launch>
  <arg name="world_name" default="worlds/empty.world"/>
  <arg name="paused" default="false"/>
  <arg name="use_sim_time" default="true"/>
  <arg name="gui" default="true"/>
  <arg name="headless" default="false"/>
  <arg name="recording" default="false"/>
  <arg name="debug" default="false"/>
  <arg name="physics" default="ode"/>
  <arg name="verbose" default="false"/>
  <arg name="output" default="screen"/>
  <arg name="extra_gazebo_args" default=""/>
  <arg name="respawn_gazebo" default="false"/>
  <arg name="use_clock_frequency" default="false"/>
  <arg name="pub_clock_frequency" default="100"/>
  <arg name="enable_ros_network" default="true"/>
  <arg name="server_required" default="false"/>
  <arg name="gui_required" default="false"/>

  <arg name="pause_word" value="$(eval '-u' if paused else '')"/>
  <arg name="record_word" value="$(eval '-r' if recording else '')"/>
  <arg name="verbose_word" value="$(eval '--verbose' if verbose else '')"/>
  <arg name="server" value="$(eval 'debug' if debug else 'gzserver')"/>

  <param name="/use_sim_time" value="$(arg use_sim_time)"/>
  <param name="gazebo/pub_clock_frequency" value="$(arg pub_clock_frequency)" if="$(arg use_clock_frequency)"/>
  <param name="gazebo/enable_ros_network" value="$(arg enable_ros_network)"/>

  <node name="gazebo" pkg="gazebo_ros" type="$(arg server)" output="$(arg output)" respawn="$(arg respawn_gazebo)"
    required="$(arg server_required)"
    args="$(arg pause_word) $(arg record_word) $(arg verbose_word) -e $(arg physics) $(arg extra_gazebo_args) \
$(arg world_name)"/>
  <node name="gazebo_gui" pkg="gazebo_ros" type="gzclient" output="$(arg output)" respawn="false" if="$(arg gui)"
    required="$(arg gui_required)" args="$(arg verbose_word)"/>
</launch>
"""

OTHER_WORLD = """\
<?xml version="1.0"?>
<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch" pass_all_args="true">
    <arg name="world_name" value="worlds/{name}.world"/>
  </include>
</launch>
"""
WORLDS = ("mud", "rubble", "shapes", "willowgarage")

SCRIPT = """\
#!/bin/sh
# of libgz; the paths of ROS's own Python are not those of this one
unset PYTHONPATH
exec {command} "$@"
"""
SCRIPTS = {
    "gazebo_ros/scripts/gzserver": ("gzserver", "--ros1"),
    "gazebo_ros/scripts/debug": ("gzserver", "--ros1", "--verbose"),
    "gazebo_ros/scripts/gazebo": ("gzserver", "--ros1", "--view"),
    "gazebo_ros/scripts/gzclient": ("gzclient",),
    "gazebo_ros/scripts/spawn_model": ("spawn_model",),
    "controller_manager/scripts/controller_manager": ("manage_controllers",),
    "controller_manager/scripts/spawner": ("spawn_controllers",),
}
# Found only where ROS has no package of this name itself, as in Debian.
SPARE_SCRIPTS = dict.fromkeys(("bin/xacro", "xacro/xacro", "xacro/xacro.py"), ("libgz", "xacro"))
PACKAGES = {
    "control_toolbox": "The PID controller of C++ plugins.",
    "controller_manager": "Starts controllers of robots in libgz.",
    "gazebo_dev": "Gazebo's C++ API, which libgz has.",
    "gazebo_plugins": "Plugins of Gazebo, which libgz has.",
    "gazebo_ros": "Starts libgz as Gazebo, and spawns models.",
    "gazebo_ros_control": "Controllers of robots, which libgz has.",
}
SPARE_PACKAGES = {
    "joint_state_controller": "Parameters of a controller, which libgz has.",
    "xacro": "Expands the macros of robot descriptions.",
}
JOINT_STATES = """\
joint_state_controller:
  type: joint_state_controller/JointStateController
  publish_rate: 50
"""
MESSAGES = ("control_msgs", "controller_manager_msgs", "gazebo_msgs")  # which Debian does not have

# Packages of messages in Python, made by the user's own genpy from the texts of the types when they are imported.
MODULE = '''\
"""Messages and services, made by genpy from their definitions."""

import genpy.dynamic

MESSAGES = {messages!r}
SERVICES = {services!r}


def message(name, text):
    """The class of a message."""
    return genpy.dynamic.generate_dynamic(name, text)[name]


def service(name, md5, request, response):
    """The class of a service."""
    values = {{"_type": name, "_md5sum": md5}}
    values["_request_class"] = message(name + "Request", request)
    values["_response_class"] = message(name + "Response", response)
    return type(name.partition("/")[2], (object,), values)
'''
MESSAGE_MODULE = '''\
"""Messages."""

from {package} import MESSAGES, message

for _name, _text in MESSAGES.items():
    globals()[_name.partition("/")[2]] = message(_name, _text)
'''
SERVICE_MODULE = '''\
"""Services."""

from {package} import SERVICES, service

for _name, _values in SERVICES.items():
    _class = globals()[_name.partition("/")[2]] = service(_name, *_values)
    globals()[_class.__name__ + "Request"] = _class._request_class
    globals()[_class.__name__ + "Response"] = _class._response_class
'''

SETUP = """\
# Read by a shell: . {prefix}/setup.sh
export ROS_PACKAGE_PATH={prefix}/share${{ROS_PACKAGE_PATH:+:$ROS_PACKAGE_PATH}}:{prefix}/spare
export PYTHONPATH={prefix}/python${{PYTHONPATH:+:$PYTHONPATH}}
export CMAKE_PREFIX_PATH=${{CMAKE_PREFIX_PATH:+$CMAKE_PREFIX_PATH:}}{prefix}/spare
export CPATH={prefix}/include${{CPATH:+:$CPATH}}
export PATH=$PATH:{prefix}/spare/bin
"""

# What find_package(catkin COMPONENTS ...) reads where there are no others of these names; messages are headers alone.
CMAKE = """\
get_filename_component(_prefix "${{CMAKE_CURRENT_LIST_DIR}}/../../../.." ABSOLUTE)
set({package}_FOUND TRUE)
set({package}_FOUND_CATKIN_PROJECT TRUE)
set({package}_INCLUDE_DIRS "${{_prefix}}/include")
set({package}_LIBRARIES "")
set({package}_LIBRARY_DIRS "")
set({package}_EXPORTED_TARGETS "")
"""
# The same of packages that hand on the API of Gazebo, if it is installed: many plugins need nothing else of them.
CMAKE_GAZEBO = """\
find_package(gazebo QUIET)
set({package}_FOUND TRUE)
set({package}_FOUND_CATKIN_PROJECT TRUE)
set({package}_INCLUDE_DIRS "${{GAZEBO_INCLUDE_DIRS}}")
set({package}_LIBRARIES "${{GAZEBO_LIBRARIES}}")
set({package}_LIBRARY_DIRS "${{GAZEBO_LIBRARY_DIRS}}")
set({package}_EXPORTED_TARGETS "")
set(CMAKE_CXX_FLAGS "${{CMAKE_CXX_FLAGS}} ${{GAZEBO_CXX_FLAGS}}")
"""


def default_prefix() -> Path:
    """Where the packages are installed, unless another folder is given."""
    return Path.home() / ".local" / "share" / "libgz" / "ros"


def _contents(prefix: Path) -> dict[str, tuple[str, bool]]:
    """Paths below the prefix -> (text, whether it is a program)."""
    share, found = "share/gazebo_ros", {}
    messages = dict.fromkeys(MESSAGES, "Messages and services.")
    for folder, packages in (("share", {**PACKAGES, **messages}), ("spare", SPARE_PACKAGES)):
        for name, text in packages.items():
            found[f"{folder}/{name}/package.xml"] = PACKAGE.format(name=name, version=_release(), about=text), False
    found["spare/joint_state_controller/joint_state_controller.yaml"] = JOINT_STATES, False
    found[f"{share}/launch/empty_world.launch"] = EMPTY_WORLD, False
    for name in WORLDS:
        found[f"{share}/launch/{name}_world.launch"] = OTHER_WORLD.format(name=name), False
    for folder, scripts in (("share", SCRIPTS), ("spare", SPARE_SCRIPTS)):
        for name, (module, *words) in scripts.items():
            command = shlex.join(run_module(f"libgz.apps.{module}", *words))
            found[f"{folder}/{name}"] = SCRIPT.format(command=command), True
    for package in MESSAGES:
        found |= _messages(package)
    found["include/control_toolbox/pid.h"] = PID, False
    for package in (*PACKAGES, *MESSAGES):
        text = CMAKE_GAZEBO if package in PACKAGES and package.startswith("gazebo_") else CMAKE
        found[f"spare/share/{package}/cmake/{package}Config.cmake"] = text.format(package=package), False
    place = shlex.quote(str(prefix))
    found["setup.sh"] = SETUP.format(prefix=place), False
    found["setup.bash"] = f". {place}/setup.sh\n", False
    return found | ament_contents(place, PACKAGE, _release())


def _release() -> str:
    """A version as package.xml needs it: three numbers."""
    numbers = [part for part in __version__.replace("+", ".").split(".") if part.isdigit()]
    return ".".join([*numbers, "0", "0", "0"][:3])


def _messages(package: str) -> dict[str, tuple[str, bool]]:
    """The files of a package of messages: definitions, and its Python package."""
    messages, services, found = {}, {}, {}
    for name in type_names():
        owner, _, base = name.partition("/")
        if owner != package:
            continue
        try:
            kind = message_type(name)
        except NotFoundError:
            service = service_type(name)
            services[name] = service.md5, service.request.text, service.response.text
            text = f"{service.request.own_text}---\n{service.response.own_text}"
            found[f"share/{package}/srv/{base}.srv"] = text, False
            for part, header in service_headers(service):
                found[f"include/{package}/{part}.h"] = header, False
        else:
            messages[name] = kind.text
            found[f"share/{package}/msg/{base}.msg"] = kind.own_text, False
            found[f"include/{package}/{base}.h"] = message_header(kind), False
    own = MODULE.format(messages=messages, services=services)
    parts = {"msg/": MESSAGE_MODULE.format(package=package), "srv/": SERVICE_MODULE.format(package=package)}
    for path, text in {"": own, **parts}.items():
        found[f"python/{package}/{path}__init__.py"] = text, False
    return found


def install(prefix: Path) -> list[Path]:
    """Write the packages below a folder, which is made; the paths of their files.

    Raises:
        LibraryError: the folder cannot be written.
    """
    prefix = prefix.expanduser().absolute()
    contents, manifest = _contents(prefix), Manifest(prefix, MANIFEST)
    old = manifest.paths()
    try:
        for path, (text, program) in contents.items():
            target = prefix / path
            target.parent.mkdir(parents=True, exist_ok=True)
            write_whole(target, text.encode())
            if program:
                target.chmod(0o755)
        manifest.remove(path for path in old if path not in contents)
        manifest.write(contents)
    except OSError as error:
        raise LibraryError(f"the packages for ROS cannot be installed in {prefix}: {error.strerror}") from None
    return [prefix / path for path in contents]


def uninstall(prefix: Path) -> int:
    """Remove what `install` wrote, by its manifest, of this version or another; how many files.

    Files stay if they are not as they were written. Folders that are empty then are removed.

    Raises:
        NotFoundError: there is no manifest.
        LibraryError: a file cannot be removed.
    """
    prefix = prefix.expanduser().absolute()
    manifest = Manifest(prefix, MANIFEST)
    if not manifest.file.is_file():
        raise NotFoundError(f"{prefix} has no {MANIFEST}: libgz installed nothing there")
    try:
        return len(manifest.remove_all()) - 1
    except OSError as error:
        raise LibraryError(f"the packages for ROS cannot be removed from {prefix}: {error.strerror}") from None
