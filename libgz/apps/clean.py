"""libgz clean: remove the files and semaphores of dead servers."""

from __future__ import annotations

import argparse
import json

from libgz.apps.console import say
from libgz.base.errors import ParameterError
from libgz.base.visible import one_line
from libgz.transport.stale_files import remove_stale

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "-s", dest="server_id", metavar="ID", type=int, default=None, help="remove those of one server only"
    )
    parser.add_argument("--json", action="store_true", help="print a JSON array of the names of what was removed")


def run(options: argparse.Namespace) -> int:
    """Remove stale files and semaphores, and print their names.

    Raises:
        ParameterError: the server id is negative.
    """
    if options.server_id is not None and options.server_id < 0:
        raise ParameterError(f"server id is {options.server_id}; it must not be negative")
    removed = []
    for item in remove_stale(options.server_id):
        removed.append(item.name)
        if not options.json:
            say(one_line(f"removed {item.name}"))
    if options.json:
        say(json.dumps(removed))
    elif not removed:
        say("no stale files of dead servers")
    return 0
