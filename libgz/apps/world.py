"""libgz world: pause, step and reset a running SDF world."""

from __future__ import annotations

import argparse

from libgz.apps.server_link import add_world, publish, world_node
from libgz.base.errors import ParameterError
from libgz.classic import msgs

__all__ = ["configure", "run"]

MOST = 2**32 - 1  # of a message


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add = parser.add_argument
    add_world(parser)
    add("-p", "--pause", type=int, choices=(0, 1), help="pause the world (1), or let it run (0)")
    add("-s", "--step", action="store_true", help="run one iteration of the paused world")
    add("-m", "--multi-step", type=int, metavar="N", help="run N iterations, and pause the world")
    resets = parser.add_mutually_exclusive_group()
    resets.add_argument("-r", "--reset-all", action="store_true", help="reset time and models")
    resets.add_argument("-t", "--reset-time", action="store_true", help="reset the time only")
    resets.add_argument("-o", "--reset-models", action="store_true", help="reset the models only")


def run(options: argparse.Namespace) -> int:
    """Send the command.

    Raises:
        ServerError: there is no server.
        ParameterError: no action is given, or a number is out of range.
    """
    message = msgs.WorldControl()
    if options.pause is not None:
        message.pause = bool(options.pause)
    if options.step:
        message.step = True
    if options.multi_step is not None:
        if not 1 <= options.multi_step <= MOST:
            raise ParameterError(f"--multi-step is {options.multi_step}; it must be at least 1 and at most {MOST}")
        message.multi_step = options.multi_step
    for option, part in (("reset_all", "all"), ("reset_time", "time_only"), ("reset_models", "model_only")):
        if getattr(options, option):
            message.reset.all = False
            setattr(message.reset, part, True)
    if not message.ListFields():
        raise ParameterError("no action is given; use -p 0, -p 1, -s, -m N, -r, -t or -o")
    with world_node(options) as (node, _link):
        publish(node, "~/world_control", message)
    return 0
