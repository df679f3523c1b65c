"""libgz upgrade: a worldfile of Gazebo 0.3 or 0.4 in the spelling of 0.5 to 0.7."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from libgz.errors import GazeboError
from libgz.files import write_whole
from libgz.worldfile.file import WorldFile
from libgz.worldfile.upgrade import upgrade

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("worldfile", type=Path, metavar="WORLDFILE", help="the worldfile to rewrite")
    target = parser.add_mutually_exclusive_group()
    target.add_argument("-o", dest="output", type=Path, metavar="FILE", help="where to; by default to the terminal")
    target.add_argument("--in-place", action="store_true", help="replace the file itself")


def run(options: argparse.Namespace) -> int:
    """Write the newer file, and say on stderr what was changed.

    Raises:
        WorldFileError: the file cannot be read.
        GazeboError: the new one cannot be written.
    """
    text, changes = upgrade(WorldFile.from_file(options.worldfile))
    for change in changes:
        print(change, file=sys.stderr)
    target = options.worldfile if options.in_place else options.output
    if target is None:
        sys.stdout.buffer.write(text)
    elif changes or not options.in_place:
        try:
            write_whole(target, text)
        except OSError as error:
            raise GazeboError(f"cannot write {str(target)!r}: {error.strerror}") from None
    if not changes:
        print(f"{options.worldfile}: nothing to change", file=sys.stderr)
    return 0
