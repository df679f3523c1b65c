"""spawn_model: gazebo_ros's script, which inserts a model into a running world by the services of /gazebo."""

from __future__ import annotations

import argparse
import logging
import math
import os
import signal
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from libgz.apps.console import Parser, as_command, read_text, set_up_messages
from libgz.apps.model import text_without_plugins
from libgz.apps.untrusted import add_untrusted_option, confined
from libgz.base.errors import GazeboError, ParameterError
from libgz.base.files import exists
from libgz.base.trust import trusted
from libgz.classic.math import Quaterniond
from libgz.ros.client import RosClient
from libgz.ros.names import read_names
from libgz.ros.types import message_type
from libgz.sdf.reader import SdfFile

__all__ = ["main"]

log = logging.getLogger("libgz.ros")

AXES = {"x": "[m]", "y": "[m]", "z": "[m]", "R": "roll [rad]", "P": "pitch [rad]", "Y": "yaw [rad]"}
INCLUDE = "<sdf version='1.6'><include><uri>model://{}</uri></include></sdf>"


def make_parser() -> Parser:
    """The options of gazebo_ros's spawn_model."""
    parser = Parser(prog="spawn_model", description="Spawn a model in gazebo using the ROS API")
    kind = parser.add_mutually_exclusive_group(required=True)
    kind.add_argument("-urdf", action="store_true", help="the text is in URDF")
    kind.add_argument("-sdf", action="store_true", help="the text is in SDF")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("-file", metavar="FILE_NAME", help="read the model from a file")
    source.add_argument("-param", metavar="PARAM_NAME", help="read it from a parameter")
    source.add_argument("-database", metavar="MODEL_NAME", help="take a model of the model directories")
    source.add_argument("-stdin", action="store_true", help="read it from the standard input")
    add = parser.add_argument
    add("-model", required=True, metavar="MODEL_NAME", help="name of the model")
    add("-reference_frame", default="", help="model or link that the pose is relative to (default: the world)")
    add("-gazebo_namespace", default="/gazebo", help="namespace of Gazebo's services (default: /gazebo)")
    space = os.environ.get("ROS_NAMESPACE", "/")
    add("-robot_namespace", default=space, help="namespace of the model's plugins (default: ROS_NAMESPACE)")
    add("-unpause", action="store_true", help="unpause physics after spawning")
    add("-wait", metavar="MODEL_NAME", help="wait for a model first")
    for axis, what in {
        "x": "[m]",
        "y": "[m]",
        "z": "[m]",
        "R": "roll [rad]",
        "P": "pitch [rad]",
        "Y": "yaw [rad]",
    }.items():
        add(f"-{axis}", type=float, default=0.0, metavar="NUMBER", help=f"of the initial pose, {what}")
    add(
        "-J",
        dest="joints",
        nargs=2,
        action="append",
        default=[],
        metavar=("JOINT_NAME", "POSITION"),
        help="set a joint",
    )
    add("-package_to_model", action="store_true", help="replace package:// by model:// in the text")
    add_untrusted_option(parser)
    add("-b", dest="bond", action="store_true", help="delete the model when this program is interrupted")
    return parser


def _text(options: argparse.Namespace, client: RosClient) -> str:
    """The text of the model.

    Raises:
        ParameterError: it cannot be read.
    """
    if options.file is not None:
        if not exists(Path(options.file)):
            raise ParameterError(f"Error: file specified {options.file} does not exist")
        text = read_text(options.file, "Error: the model")
    elif options.param is not None:
        value = client.parameter(options.param)
        if not isinstance(value, str) or not value:
            raise ParameterError(f"Error: parameter {client.names.resolve(options.param)} is empty or no text")
        text = value
    elif options.stdin:
        text = read_text("/dev/stdin", "Error: the model")
    else:
        text = INCLUDE.format(options.database)
    text = text.replace("package://", "model://") if options.package_to_model else text
    return text if trusted() else text_without_plugins(SdfFile.from_string(text, "the model"))


def _wait_for(name: str, space: str, client: RosClient) -> None:
    """Wait until there is a model of a name."""
    kind, waiting = "gazebo_msgs/GetWorldProperties", threading.Event()
    while name not in client.call(f"{space}/get_world_properties", kind, waiting=log.info).model_names:
        waiting.wait(0.2)


def _spawn(options: argparse.Namespace, client: RosClient) -> None:
    """Spawn the model, and set its joints.

    Raises:
        GazeboError: that failed.
    """
    space, text = options.gazebo_namespace.rstrip("/"), _text(options, client)
    if options.wait is not None:
        _wait_for(options.wait, space, client)
    kind = "urdf" if options.urdf and trusted() else "sdf"  # files of strangers become SDF
    pose = message_type("geometry_msgs/Pose")()
    pose.position.x, pose.position.y, pose.position.z = options.x, options.y, options.z
    turn = pose.orientation
    turn.w, turn.x, turn.y, turn.z = Quaterniond(options.R, options.P, options.Y)
    answer = client.call(
        f"{space}/spawn_{kind}_model",
        "gazebo_msgs/SpawnModel",
        waiting=log.info,
        model_name=options.model,
        model_xml=text,
        robot_namespace=options.robot_namespace,
        initial_pose=pose,
        reference_frame=options.reference_frame,
    )
    log.info("Spawn status: %s", answer.status_message)
    if not answer.success:
        raise GazeboError(f"Spawn service failed. {answer.status_message}")
    if options.joints:
        positions = [float(position) for _, position in options.joints]
        if not all(map(math.isfinite, positions)):
            raise ParameterError("-J: a position is not finite")
        client.call(
            f"{space}/set_model_configuration",
            "gazebo_msgs/SetModelConfiguration",
            model_name=options.model,
            joint_names=[name for name, _ in options.joints],
            joint_positions=positions,
        )
    if options.unpause:
        client.call(f"{space}/unpause_physics", "std_srvs/Empty")


@as_command("spawn_model", failed=1)
def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, 1 failed."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    set_up_messages(1, None)
    options = make_parser().parse_args([word for word in words if ":=" not in word])
    try:
        with confined("spawn_model", options):
            client = RosClient(read_names(words, name=f"spawn_model_{os.getpid()}"))
            _spawn(options, client)
    except (GazeboError, ValueError) as error:
        log.error("%s", error)
        return 1
    if options.bond:
        ended = threading.Event()
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: ended.set())
        ended.wait()
        space = options.gazebo_namespace.rstrip("/")
        client.call(f"{space}/delete_model", "gazebo_msgs/DeleteModel", model_name=options.model)
    return 0


if __name__ == "__main__":
    sys.exit(main())
