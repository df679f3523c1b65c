"""libgz check: report errors and unused elements in worldfiles."""

from __future__ import annotations

import argparse
import json
import sys

from libgz.apps.console import Parser, say
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.errors import Diagnostic, ParameterError
from libgz.reference.check import check

__all__ = ["configure", "run"]

MOST = 64 << 20  # [byte] of a text on standard input


def configure(parser: Parser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    parser.add_macro_arguments()
    parser.add_argument(
        "worldfiles", nargs="+", metavar="WORLDFILE", help="a worldfile of Gazebo 0.3 to 0.7, or an SDF file"
    )
    parser.add_argument("--strict", action="store_true", help="treat warnings as errors")
    parser.add_argument("--json", action="store_true", help="print a JSON array instead of lines")
    parser.add_argument(
        "--stdin", action="store_true", help="check the text on standard input, as if the one WORLDFILE had it"
    )


def run(options: argparse.Namespace) -> int:
    """Print the diagnostics of all files; return 1 if there is an error.

    Raises:
        ParameterError: there is one text and not one file.
    """
    text = None
    if options.stdin:
        if len(options.worldfiles) != 1:
            raise ParameterError(f"--stdin is the text of one WORLDFILE, not of {len(options.worldfiles)}")
        text = sys.stdin.buffer.read(MOST)
    diagnostics = [error for name in options.worldfiles for error in check(name, options.arguments, text)]
    if options.strict:
        diagnostics = [error._replace(severity="error") for error in diagnostics]
    if options.json:
        say(json.dumps([error._asdict() for error in diagnostics], indent=2))
    else:
        for error in diagnostics:
            say(_line(error))
    return int(any(error.severity == "error" for error in diagnostics))


def _line(error: Diagnostic) -> str:
    """`file:line: <element>: message`, with `warning:` before the message of a warning."""
    place = f"{error.file}:{error.line}" if error.line else error.file
    element = f"<{error.element}>: " if error.element else ""
    return f"{place}: {element}{'warning: ' if error.severity == 'warning' else ''}{error.message}"
