"""libgz schema: a grammar of worldfiles for editors."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from libgz.errors import GazeboError
from libgz.reference.grammar import grammar

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--rng", action="store_true", required=True, help="as RELAX NG, in its XML form")
    parser.add_argument("-o", dest="output", type=Path, metavar="FILE", help="where to; by default to the terminal")


def run(options: argparse.Namespace) -> int:
    """Write the grammar.

    Raises:
        GazeboError: the file cannot be written.
    """
    text = grammar()
    if options.output is None:
        sys.stdout.buffer.write(text)
        return 0
    try:
        options.output.write_bytes(text)
    except OSError as error:
        raise GazeboError(f"cannot write {str(options.output)!r}: {error.strerror}") from None
    return 0
