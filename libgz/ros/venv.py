"""Environment of ROS 2 from its published wheels, with the packages of messages that have none."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

from libgz.base.errors import LibraryError, NotFoundError
from libgz.base.python import own_python
from libgz.ros.api2 import SERVICES2
from libgz.ros.types import MessageType, message_type, service_type

__all__ = ["DISTRIBUTIONS", "definitions", "make_environment"]

PROGRAM = Path(__file__).parent / "bridge" / "build_messages.py"

# Distributions with wheels -> the Pythons that they are made for.
DISTRIBUTIONS = {"kilted": ("3.11", "3.12", "3.10", "3.13"), "jazzy": ("3.12", "3.11", "3.10", "3.13")}
WHEELS = (
    "rclpy",
    "rmw-fastrtps-cpp",
    "geometry-msgs",
    "nav-msgs",
    "rosgraph-msgs",
    "rosidl-default-generators",
    "sensor-msgs",
    "std-srvs",
    "trajectory-msgs",
)
TOOLS = ("catkin_pkg", "empy<4", "lark")  # of the generators

# Types and actions whose packages have no wheels, beside those of SERVICES2.
ACTIONS = ("control_msgs/FollowJointTrajectory", "control_msgs/GripperCommand")
TYPES = (
    "control_msgs/DynamicJointState",
    "control_msgs/JointTrajectoryControllerState",
    "control_msgs/QueryTrajectoryState",
    "gazebo_msgs/ContactsState",
    "gazebo_msgs/LinkStates",
    "gazebo_msgs/ModelStates",
    "gazebo_msgs/PerformanceMetrics",
    "gazebo_msgs/WheelSlip",
    "tf2_msgs/TFMessage",
)


def definitions() -> dict[str, str]:
    """Paths of definitions, such as gazebo_msgs/srv/SpawnEntity.srv -> their texts in ROS 2."""
    found: dict[str, str] = {}
    built = {name.partition("/")[0] for name in TYPES}
    needed: list[MessageType] = []
    for name in ACTIONS:
        package, _, base = name.partition("/")
        parts = [message_type(f"{name}_{part}", 2) for part in ("Goal", "Result", "Feedback")]
        found[f"{package}/action/{base}.action"] = "---\n".join(_text(part) for part in parts)
        needed += (inner for part in parts for inner in part.parts)
    for name in (*TYPES, *SERVICES2.values()):
        package, _, base = name.partition("/")
        if package not in built:
            continue
        try:
            needed.append(message_type(name, 2))
        except NotFoundError:
            service = service_type(name, 2)
            found[f"{package}/srv/{base}.srv"] = f"{_text(service.request)}---\n{_text(service.response)}"
            needed += (*service.request.parts, *service.response.parts)
    for kind in (part for one in needed for part in (one, *one.parts)):
        owner, _, own = kind.name.partition("/")
        if owner in built:
            found[f"{owner}/msg/{own}.msg"] = _text(kind)
    return found


def _text(kind: MessageType) -> str:
    """A definition as ROS 2 writes it."""
    return re.sub(r"^(time|duration)\b", lambda m: f"builtin_interfaces/{m[1].title()}", kind.own_text, flags=re.M)


def make_environment(folder: Path, distribution: str, python: str | None, report: Callable[[str], object]) -> Path:
    """Make an environment; its Python.

    Args:
        folder: where; it is made, or brought up to date.
        distribution: one of DISTRIBUTIONS.
        python: the Python to make it with; None for one that the distribution has wheels for.
        report: takes a line for each step.

    Raises:
        NotFoundError: there is no such Python, or no compiler.
        LibraryError: a step fails.
    """
    missing = [name for name in ("cc", "c++") if shutil.which(name) is None]
    if missing:
        raise NotFoundError(
            f"{' and '.join(missing)} must be installed: messages are compiled; on Debian, apt install g++"
        )
    chosen = python or next(_pythons(distribution), None)
    if chosen is None:
        known = ", ".join(DISTRIBUTIONS[distribution])
        raise NotFoundError(f"the wheels of ROS 2 {distribution} need Python {known}; name one with --python")
    folder = folder.expanduser().absolute()
    own = folder / "bin" / "python3"
    report(f"making {folder} with {chosen}")
    _run([chosen, "-m", "venv", str(folder)])
    report(f"installing ROS 2 {distribution}")
    _run([str(own), "-m", "pip", "install", "-q", "--disable-pip-version-check",
          *(f"ros-{distribution}-{name}" for name in WHEELS), *TOOLS])  # fmt: skip
    with tempfile.TemporaryDirectory() as place:
        texts = definitions()
        for path, text in texts.items():
            target = Path(place) / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(text)
        packages = sorted({path.partition("/")[0] for path in texts}, reverse=True)  # tf2_msgs, which is small, first
        report(f"compiling {', '.join(packages)}: about a minute")
        _run([str(own), str(PROGRAM), place, *packages])
    return own


def _pythons(distribution: str) -> Iterator[str]:
    """Pythons on this computer that a distribution has wheels for; that of libgz first."""
    known = DISTRIBUTIONS[distribution]
    if f"{sys.version_info.major}.{sys.version_info.minor}" in known:
        yield own_python()
    for version in known:
        found = shutil.which(f"python{version}")
        if found is not None and _works(found):
            yield found


def _works(python: str) -> bool:
    """Whether it runs: the command may belong to a manager of versions that has none of this name."""
    return subprocess.run([python, "-c", ""], cwd="/", capture_output=True, check=False).returncode == 0


def _run(command: list[str]) -> None:
    try:
        done = subprocess.run(command, cwd="/", capture_output=True, text=True, check=False)
    except OSError as error:
        raise LibraryError(f"{command[0]} cannot be run: {error.strerror}") from None
    if done.returncode:
        lines = (done.stderr or done.stdout).strip()[-2000:]
        raise LibraryError(f"{' '.join(command)[:200]} failed:\n{lines}")
