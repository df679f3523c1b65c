"""libgz model: inspect, move, add and delete models of a running SDF world."""

from __future__ import annotations

import argparse
import itertools
import json
import sys
from collections.abc import Mapping
from typing import Any

from libgz.apps.console import Parser, finite_number, read_text, say
from libgz.apps.server_link import add_world, ask, publish, world_node
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.errors import NotFoundError, ParameterError
from libgz.base.trust import trusted
from libgz.classic import msgs
from libgz.classic.math import Pose3d, Quaterniond
from libgz.classic.transport import Node
from libgz.sdf.paths import find_model
from libgz.sdf.reader import SdfFile
from libgz.sdf.recognition import is_robot_text, is_sdf_text
from libgz.sdf.upgrade import NEWEST, upgraded

__all__ = ["configure", "run", "text_without_plugins"]

# Option -> what it sets.
AXES = {
    "pose-x": "x [m]",
    "pose-y": "y [m]",
    "pose-z": "z [m]",
    "pose-R": "roll [rad]",
    "pose-P": "pitch [rad]",
    "pose-Y": "yaw [rad]",
}


def configure(parser: Parser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    parser.add_macro_arguments()
    add = parser.add_argument
    add_world(parser)
    add("-m", "--model-name", default="", metavar="NAME", help="name of the model")
    add("-i", "--info", action="store_true", help="print all data of the model")
    add("-p", "--pose", action="store_true", help="print its pose: x y z [m] roll pitch yaw [rad]")
    add("--json", action="store_true", help="with -i and -p: print a JSON object")
    add("-d", "--delete", action="store_true", help="delete the model")
    add("-f", "--spawn-file", metavar="FILE", help="add a model from an SDF or URDF file, or model://name")
    add("-s", "--spawn-string", metavar="SDF", help="add a model from an SDF string")
    for word, coordinate in AXES.items():
        add(
            f"-{word[-1]}",
            f"--{word}",
            type=finite_number("coordinate"),
            default=None,
            metavar="N",
            help=f"new {coordinate}",
        )


def run(options: argparse.Namespace) -> int:
    """Inspect, move, add or delete a model.

    Raises:
        ServerError: there is no server.
        NotFoundError: there is no such model.
        ParameterError: the command line is incomplete.
    """
    place = [getattr(options, word.replace("-", "_")) for word in AXES]
    moved = any(value is not None for value in place)
    spawned = options.spawn_file or options.spawn_string
    if not (options.model_name or spawned):
        raise ParameterError("no model is given; use -m NAME, or -f FILE for a new model")
    if not (spawned or moved or options.info or options.pose or options.delete):
        raise ParameterError("no action is given; use -i, -p, -d, a coordinate such as -x 1, or -f FILE")
    with world_node(options) as (node, _link):
        if spawned:
            publish(node, "~/factory", _factory(node, options, place if moved else None))
            return 0
        model = ask(node, "entity_info", options.model_name)
        pose = msgs.ConvertIgn(model.pose)
        if options.delete:
            ask(node, "entity_delete", options.model_name)
        elif options.info:
            say(json.dumps(model.ToDict()) if options.json else model.DebugString(), end="\n" if options.json else "")
        elif moved:
            now = (*pose.pos, *pose.rot.Euler())
            target = Pose3d(*(new if new is not None else old for new, old in zip(place, now, strict=True)))
            publish(node, "~/model/modify", msgs.Model(name=options.model_name, pose=msgs.Convert(target)))
        elif options.json:
            numbers = (*pose.pos, *Quaterniond(pose.rot).Euler())
            say(json.dumps(dict(zip(("x", "y", "z", "roll", "pitch", "yaw"), numbers, strict=True))))
        else:
            say(*(f"{value:.6f}" for value in (*pose.pos, *Quaterniond(pose.rot).Euler())))
    return 0


def _model_text(filename: str, arguments: Mapping[str, str]) -> str:
    """The text of a model's file; a robot description is sent as SDF, with its macros expanded and meshes found."""
    text = read_text(filename, "the model")
    if not is_robot_text(text):
        _check_inserted(text, filename)
        return text
    return _whole_text(SdfFile.load(filename, arguments=arguments))


def _whole_text(file: SdfFile) -> str:
    """The text of a file, of which a server reads no other files."""
    file.diagnostics.raise_errors()
    for warning in file.diagnostics.warnings:
        say(warning, file=sys.stderr)
    return f"<sdf version='{NEWEST}'>{''.join(upgraded(part).ToString() for part in file.root.children)}</sdf>"


def _untrusted_text(options: argparse.Namespace) -> str:
    """The text of a model of strangers without plugins."""
    if options.spawn_string:
        file = SdfFile.from_string(options.spawn_string, "the SDF string")
    else:
        known = "://" in options.spawn_file
        path = find_model(options.spawn_file) if known else options.spawn_file
        file = SdfFile.load(path, arguments=options.arguments)
    return text_without_plugins(file)


def text_without_plugins(file: SdfFile) -> str:
    """The text of a file without its plugins, nor those of what it includes: a server would load them.

    What was not found to include is left out, too: the server may find it, with its plugins.

    Raises:
        WorldFileError: the file has errors.
    """
    for plugin in list(file.root.find("plugin")):
        name = plugin.Get(str, "filename")
        say(f"warning : {plugin.where}: plugin {name!r} is left out: files are untrusted", file=sys.stderr)
        plugin.RemoveFromParent()
    for include in list(file.root.find("include")):
        include.RemoveFromParent()
    return _whole_text(file)


def _check_inserted(text: str, what: str) -> None:
    if not is_sdf_text(text):
        raise ParameterError(f"{what} is no model: its root must be <sdf version='...'>, or <robot> in a URDF file")


def _factory(node: Node, options: argparse.Namespace, place: list[float | None] | None) -> Any:
    message = msgs.Factory()
    if not trusted():
        message.sdf = _untrusted_text(options)
    elif options.spawn_string:
        _check_inserted(options.spawn_string, "the SDF string")
        message.sdf = options.spawn_string
    elif "://" in options.spawn_file:
        message.sdf_filename = options.spawn_file
    else:
        message.sdf = _model_text(options.spawn_file, options.arguments)
    if options.model_name:
        message.edit_name = _free_name(node, options.model_name)
    if place is not None:
        msgs.Set(message.pose, Pose3d(*(value or 0.0 for value in place)))
    return message


def _free_name(node: Node, name: str) -> str:
    """The name itself, or with a number, if the world has something of this name: that is not to be replaced."""
    for one in itertools.chain([name], (f"{name}_{i}" for i in itertools.count())):
        try:
            ask(node, "entity_info", one)
        except NotFoundError:
            break
    return one
