#!/usr/bin/env python3
"""Spawns an entity in Gazebo, with the options of gazebo_ros's script of this name.

`libgz ros install` copies it: it runs with the user's own Python, and imports nothing of libgz.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import os
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import rclpy
from gazebo_msgs.msg import ModelStates
from gazebo_msgs.srv import DeleteEntity, SpawnEntity
from rclpy.executors import ExternalShutdownException
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.utilities import remove_ros_args
from std_msgs.msg import String
from std_srvs.srv import Empty

INCLUDE = '<sdf version="1.6"><world name="default"><include><uri>model://{}</uri></include></world></sdf>'


class SpawnError(Exception):
    """The entity cannot be spawned."""


def read_options(words: Sequence[str]) -> argparse.Namespace:
    """The options."""
    about = "Asks the server for a new entity."
    parser = argparse.ArgumentParser(prog="spawn_entity.py", description=about, allow_abbrev=False)
    add = parser.add_argument
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("-file", metavar="FILE_NAME", help="read the entity from a file")
    source.add_argument("-topic", metavar="TOPIC_NAME", help="take it from a topic")
    source.add_argument("-database", metavar="ENTITY_NAME", help="take it from GAZEBO_MODEL_PATH")
    source.add_argument("-stdin", action="store_true", help="read it from the standard input")
    add("-entity", required=True, metavar="ENTITY_NAME", help="its name")
    add("-reference_frame", default="", help="model or link that the pose is relative to; the world by default")
    add("-gazebo_namespace", default="", help="namespace of Gazebo's services")
    add("-robot_namespace", help="namespace of the entity's plugins; that of this node by default")
    add("-timeout", type=float, default=30.0, help="how long to wait for a service [s]")
    add("-unpause", action="store_true", help="end the pause of the world then")
    add("-wait", metavar="ENTITY_NAME", help="wait for an entity first")
    add("-spawn_service_timeout", type=float, metavar="TIMEOUT", help="as -timeout")
    for axis, what in {"x": "m", "y": "m", "z": "m", "R": "rad", "P": "rad", "Y": "rad"}.items():
        add(f"-{axis}", type=float, default=0.0, metavar="NUMBER", help=f"of the initial pose [{what}]")
    add("-package_to_model", action="store_true", help="replace package:// by model:// in names of meshes")
    add("-b", dest="bond", action="store_true", help="stay, and delete the entity at the end")
    return parser.parse_args(words)


def quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    """w, x, y, z of a rotation by angles [rad]."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a / 2), math.sin(a / 2)) for a in (roll, pitch, yaw))
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


class Spawner:
    """Spawns the entity of some options."""

    def __init__(self, node: Any, options: argparse.Namespace) -> None:
        self.node, self.options = node, options
        self.log = node.get_logger()

    def text(self) -> str:
        """The text of the entity."""
        options = self.options
        if options.file is not None:
            try:
                text = Path(options.file).read_text()
            except (OSError, UnicodeDecodeError) as error:
                raise SpawnError(f"file {options.file} cannot be read: {error}") from None
        elif options.topic is not None:
            text = self.heard(String, options.topic, lambda message: message.data, latched=True)
        elif options.database is not None:
            text = INCLUDE.format(options.database)
        else:
            text = sys.stdin.read()
        if not text.strip():
            raise SpawnError("the text of the entity is empty")
        try:
            root = ET.fromstring(text)
        except ET.ParseError as error:
            raise SpawnError(f"the text of the entity is no XML: {error}") from None
        if os.environ.get("LIBGZ_UNTRUSTED"):  # the server may load its plugins
            raise SpawnError(
                "files are untrusted (the variable LIBGZ_UNTRUSTED); libgz model sends them without plugins"
            )
        if not options.package_to_model:
            return text
        for mesh in root.iter("mesh"):
            name = mesh.get("filename", "")
            if name.startswith("package://"):
                mesh.set("filename", "model://" + name[len("package://") :])
        return ET.tostring(root, encoding="unicode")

    def heard(self, kind: Any, topic: str, good: Callable[[Any], Any], *, latched: bool = False) -> Any:
        """What a function makes of the first message for which that is anything."""
        found: list[Any] = []
        durability = DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE

        def take(message: Any) -> None:
            if value := good(message):
                found.append(value)

        subscription = self.node.create_subscription(kind, topic, take, QoSProfile(depth=1, durability=durability))
        self.log.info(f"waiting for {topic}")
        while rclpy.ok() and not found:
            rclpy.spin_once(self.node, timeout_sec=0.2)
        self.node.destroy_subscription(subscription)
        if not found:
            raise SpawnError("interrupted")
        return found[0]

    def call(self, kind: Any, service: str, **values: Any) -> Any:
        """The answer of a service."""
        options = self.options
        patience = options.timeout if options.spawn_service_timeout is None else options.spawn_service_timeout
        if patience < 0:
            raise SpawnError("-timeout must not be negative")
        full = f"{options.gazebo_namespace}/{service}"
        client = self.node.create_client(kind, full)
        self.log.info(f"waiting up to {patience:g} s for {full}")
        if not client.wait_for_service(timeout_sec=patience):
            raise SpawnError(f"nothing serves {full}; start the server with --ros2")
        answer = client.call_async(kind.Request(**values))
        while rclpy.ok() and not answer.done():
            rclpy.spin_once(self.node, timeout_sec=0.2)
        if not answer.done():
            raise SpawnError("interrupted")
        return answer.result()

    def run(self) -> None:
        """Spawn it, and what else the options ask for."""
        options = self.options
        if options.wait:
            topic = f"{options.gazebo_namespace}/model_states"
            self.heard(ModelStates, topic, lambda states: options.wait in states.name)
        request = SpawnEntity.Request()
        pose = request.initial_pose
        pose.position.x, pose.position.y, pose.position.z = options.x, options.y, options.z
        turn = pose.orientation
        turn.w, turn.x, turn.y, turn.z = quaternion(options.R, options.P, options.Y)
        space = options.robot_namespace
        answer = self.call(
            SpawnEntity,
            "spawn_entity",
            name=options.entity,
            xml=self.text(),
            robot_namespace=self.node.get_namespace() if space is None else space,
            initial_pose=pose,
            reference_frame=options.reference_frame,
        )
        if not answer.success:
            raise SpawnError(answer.status_message)
        self.log.info(answer.status_message)
        if options.unpause:
            self.call(Empty, "unpause_physics")
        if options.bond:
            self.log.info(f"{options.entity} is deleted when this program ends")
            with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
                rclpy.spin(self.node)
            if not rclpy.ok():
                rclpy.init()
                self.node = rclpy.create_node("spawn_entity")
            answer = self.call(DeleteEntity, "delete_entity", name=options.entity)
            self.log.info(answer.status_message)


def main() -> int:
    """The command. Exit codes: 0 done, 1 failed."""
    options = read_options(remove_ros_args(sys.argv)[1:])
    rclpy.init(args=sys.argv)
    spawner = Spawner(rclpy.create_node("spawn_entity"), options)
    try:
        spawner.run()
    except SpawnError as error:
        spawner.log.error(str(error))
        return 1
    except (KeyboardInterrupt, ExternalShutdownException):
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
