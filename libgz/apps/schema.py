"""libgz schema: print a grammar of worldfiles or of SDF for editors."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from libgz.apps.console import writing
from libgz.reference.grammar import grammar
from libgz.reference.sdf_grammar import sdf_grammar
from libgz.sdf.description import NEWEST, VERSIONS

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("--rng", action="store_true", help="of worldfiles, as RELAX NG in XML syntax")
    which.add_argument(
        "--sdf",
        nargs="?",
        const=NEWEST,
        choices=VERSIONS,
        metavar="VERSION",
        help=f"of SDF (default {NEWEST}), likewise",
    )
    parser.add_argument("-o", dest="output", type=Path, metavar="FILE", help="the file to write (default: stdout)")


def run(options: argparse.Namespace) -> int:
    """Write the grammar.

    Raises:
        GazeboError: the file cannot be written.
    """
    text = sdf_grammar(options.sdf) if options.sdf is not None else grammar()
    if options.output is None:
        sys.stdout.buffer.write(text)
        return 0
    with writing():
        options.output.write_bytes(text)
    return 0
