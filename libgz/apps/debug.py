"""libgz debug: list the commands, or the options of one, as `gz debug` does for completion."""

from __future__ import annotations

import argparse

from libgz.apps import libgz
from libgz.apps.console import Hints, say

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("-o", "--option", metavar="COMMAND", help="list the options of this command")


def run(options: argparse.Namespace) -> int:
    """Print commands or options, one a line; nothing for an unknown command, as Gazebo does."""
    if options.option is None:
        say("\n".join(sorted((*libgz.COMMANDS, "help"))))
        return 0
    commands = next(a for a in libgz.make_parser(options.option)._actions if isinstance(a, argparse._SubParsersAction))
    found = commands.choices.get(options.option)
    for name in found.option_names() if isinstance(found, Hints) else ():
        say(name)
    return 0
