"""libgz physics: change gravity, step, rate, iterations and profile of a running SDF world."""

from __future__ import annotations

import argparse
import contextlib
import math

from libgz.apps.console import number_above_zero, number_from_zero
from libgz.apps.server_link import add_world, publish, world_node
from libgz.base.errors import ParameterError
from libgz.classic import msgs
from libgz.classic.math import Vector3d

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add = parser.add_argument
    add_world(parser)
    add("-g", "--gravity", type=_vector, metavar="X,Y,Z", help="gravity [m/s^2], such as 0,0,-9.8")
    add("-s", "--step-size", type=number_above_zero("step size"), metavar="S", help="size of a step [s]")
    add("-i", "--iters", type=int, metavar="N", help="iterations of the solver")
    add(
        "-u",
        "--update-rate",
        type=number_from_zero("update rate"),
        metavar="HZ",
        help="steps per second of real time; 0: as many as possible",
    )
    add("-o", "--profile", metavar="NAME", help="name of the <physics> of the world to use")


def _vector(text: str) -> Vector3d:
    with contextlib.suppress(ValueError):
        x, y, z = (float(part) for part in text.replace(",", " ").split())
        if all(map(math.isfinite, (x, y, z))):
            return Vector3d(x, y, z)
    raise argparse.ArgumentTypeError(f"{text!r} is not three finite numbers, such as 0,0,-9.8")


def run(options: argparse.Namespace) -> int:
    """Send the command.

    Raises:
        ServerError: there is no server.
        ParameterError: no parameter is given, or one is out of range.
    """
    message = msgs.Physics()
    if options.profile is not None:
        message.profile_name = options.profile
    if options.gravity is not None:
        msgs.Set(message.gravity, options.gravity)
    if options.step_size is not None:
        message.max_step_size = options.step_size
    if options.iters is not None:
        if options.iters < 1:
            raise ParameterError(f"--iters is {options.iters}; it must be at least 1")
        message.iters = options.iters
    if options.update_rate is not None:
        message.real_time_update_rate = options.update_rate
    if not message.ListFields():
        raise ParameterError("no parameter is given; use -g X,Y,Z, -s S, -i N, -u HZ or -o NAME")
    with world_node(options) as (node, _link):
        publish(node, "~/physics", message)
    return 0
