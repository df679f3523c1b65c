"""libgz upgrade: convert a worldfile of Gazebo 0.3 or 0.4 to the format of 0.5 to 0.7, or SDF or URDF to SDF 1.6."""

from __future__ import annotations

import argparse
import contextlib
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from libgz.apps.console import Parser, say, writing
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.errors import Diagnostic, Remark, WorldFileError
from libgz.base.files import read_limited, write_whole
from libgz.base.visible import visible_xml
from libgz.sdf.conversion import upgrade_document
from libgz.sdf.recognition import is_sdf
from libgz.sdf.xml import ROBOT
from libgz.worldfile.file import WorldFile
from libgz.worldfile.upgrade import upgrade

__all__ = ["configure", "run"]


def configure(parser: Parser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    parser.add_macro_arguments()
    what = "the worldfile, SDF file or robot description (URDF) to convert"
    parser.add_argument("worldfile", type=Path, metavar="WORLDFILE", help=what)
    target = parser.add_mutually_exclusive_group()
    target.add_argument("-o", dest="output", type=Path, metavar="FILE", help="the file to write (default: stdout)")
    target.add_argument("--in-place", action="store_true", help="overwrite the file")


def run(options: argparse.Namespace) -> int:
    """Write the converted file, and list the changes on stderr.

    Raises:
        WorldFileError: the file cannot be read.
        GazeboError: the output cannot be written.
    """
    text, changes = _upgraded(options.worldfile, options.arguments)
    if options.in_place and any(change.element == ROBOT for change in changes):
        raise WorldFileError(f"{options.worldfile} is a robot description; name the SDF file to write with -o")
    for change in changes:
        say(change, file=sys.stderr)
    target = options.worldfile if options.in_place else options.output
    if target is None:
        with contextlib.suppress(UnicodeDecodeError):  # of another encoding
            text = visible_xml(text.decode()).encode()
        sys.stdout.buffer.write(text)
    elif changes or not options.in_place:
        with writing():
            write_whole(target, text)
    if not changes:
        say(f"{options.worldfile}: nothing to change", file=sys.stderr)
    return 0


def _upgraded(path: Path, arguments: Mapping[str, str]) -> tuple[bytes, Sequence[Remark | Diagnostic]]:
    """The bytes of the converted file, and what was changed."""
    if not is_sdf(path):
        return upgrade(WorldFile.from_file(path))
    try:
        return upgrade_document(read_limited(path), str(path), path, arguments)
    except OSError as error:
        raise WorldFileError(f"{path} cannot be read: {error.strerror}") from None
