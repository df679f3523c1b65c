"""libgz xacro: print a robot description with its macros expanded, with the options of ROS's command."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from libgz.apps.console import Parser, say, writing
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.errors import Diagnostics, WorldFileError
from libgz.base.files import read_limited, write_whole
from libgz.base.visible import visible_xml
from libgz.sdf.xacro.expansion import expand
from libgz.sdf.xml import document_text, parse_document

__all__ = ["configure", "run"]


def configure(parser: Parser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    parser.add_macro_arguments()
    parser.add_argument("file", type=Path, metavar="FILE", help="the robot description (.xacro)")
    parser.add_argument("-o", dest="output", type=Path, metavar="FILE", help="the file to write (default: stdout)")
    parser.add_argument("-q", "--quiet", action="store_true", help="print no warnings")
    # Of other versions of the command: macros are always expanded in the order of the file.
    parser.add_argument("-i", "--inorder", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--verbosity", help=argparse.SUPPRESS)


def run(options: argparse.Namespace) -> int:
    """Write the expanded description, and its warnings to stderr.

    Raises:
        WorldFileError: the file cannot be read, or its macros cannot be expanded.
        GazeboError: the output cannot be written.
    """
    path, diagnostics = options.file, Diagnostics()
    try:
        data = read_limited(path)
    except OSError as error:
        raise WorldFileError(f"{path} cannot be read: {error.strerror}") from None
    root = parse_document(data, str(path), diagnostics)
    text = document_text(expand(root, str(path), diagnostics, path=path, arguments=options.arguments))
    diagnostics.raise_errors()
    if not options.quiet:
        for warning in diagnostics.warnings:
            say(warning, file=sys.stderr)
    if options.output is None:
        sys.stdout.buffer.write(visible_xml(text.decode()).encode())
    else:
        with writing():
            write_whole(options.output, text)
    return 0
