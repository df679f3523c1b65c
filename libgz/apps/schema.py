"""libgz schema: print a grammar of worldfiles for editors."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from libgz.apps.console import writing
from libgz.reference.grammar import grammar

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--rng", action="store_true", required=True, help="RELAX NG in XML syntax, the only format")
    parser.add_argument("-o", dest="output", type=Path, metavar="FILE", help="the file to write (default: stdout)")


def run(options: argparse.Namespace) -> int:
    """Write the grammar.

    Raises:
        GazeboError: the file cannot be written.
    """
    text = grammar()
    if options.output is None:
        sys.stdout.buffer.write(text)
        return 0
    with writing():
        options.output.write_bytes(text)
    return 0
