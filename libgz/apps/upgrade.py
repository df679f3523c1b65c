"""libgz upgrade: convert a worldfile of Gazebo 0.3 or 0.4 to the format of 0.5 to 0.7."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from libgz.apps.console import writing
from libgz.files import write_whole
from libgz.worldfile.file import WorldFile
from libgz.worldfile.upgrade import upgrade

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("worldfile", type=Path, metavar="WORLDFILE", help="the worldfile to convert")
    target = parser.add_mutually_exclusive_group()
    target.add_argument("-o", dest="output", type=Path, metavar="FILE", help="the file to write (default: stdout)")
    target.add_argument("--in-place", action="store_true", help="overwrite the worldfile")


def run(options: argparse.Namespace) -> int:
    """Write the converted file, and list the changes on stderr.

    Raises:
        WorldFileError: the file cannot be read.
        GazeboError: the output cannot be written.
    """
    text, changes = upgrade(WorldFile.from_file(options.worldfile))
    for change in changes:
        print(change, file=sys.stderr)
    target = options.worldfile if options.in_place else options.output
    if target is None:
        sys.stdout.buffer.write(text)
    elif changes or not options.in_place:
        with writing():
            write_whole(target, text)
    if not changes:
        print(f"{options.worldfile}: nothing to change", file=sys.stderr)
    return 0
