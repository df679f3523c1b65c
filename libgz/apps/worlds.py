"""libgz worlds: list the worlds that are installed with libgz, each with a line about it."""

from __future__ import annotations

import argparse
import json

from libgz.apps.console import say
from libgz.base.errors import NotFoundError
from libgz.base.files import is_file
from libgz.worldfile.search import find_worldfile, ready_worlds, why_missing

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "name", nargs="?", metavar="WORLD", help="print the path of the file that `gazebo WORLD` would run"
    )
    parser.add_argument("--json", action="store_true", help="print a JSON array with name, file and summary of each")


def run(options: argparse.Namespace) -> int:
    """Print a line for each world, or the path of one.

    Raises:
        NotFoundError: there is no world of this name.
    """
    if options.name is not None:
        path = find_worldfile(options.name)
        if not is_file(path):
            raise NotFoundError(f"there is no world {options.name!r}{why_missing(options.name)}")
        say(json.dumps(str(path)) if options.json else path)
        return 0
    worlds = ready_worlds()
    if options.json:
        rows = [{"name": world.name, "file": str(world.path), "summary": world.summary} for world in worlds]
        say(json.dumps(rows, indent=2))
        return 0
    width = max(len(world.name) for world in worlds)
    for world in worlds:
        first, stop, _ = world.summary.partition(". ")
        say(f"{world.name:{width}}  {first}{stop.rstrip()}")
    return 0
