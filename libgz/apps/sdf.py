"""libgz sdf: check an SDF file, or print it with includes resolved and defaults filled in."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys

from libgz.errors import WorldFileError
from libgz.sdf.reader import SdfFile

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--check", metavar="FILE", help="report all errors of an SDF file; exit code 1 if there are any")
    what.add_argument("--print", metavar="FILE", help="print the file with includes resolved and defaults filled in")
    parser.add_argument("--json", action="store_true", help="with --check: print the errors as a JSON array")


def run(options: argparse.Namespace) -> int:
    """Check or print a file; return 1 if it has errors."""
    try:
        file = SdfFile.load(options.check or options.print)
    except WorldFileError as unreadable:
        print(f"error   : {unreadable}", file=sys.stderr)
        return 1
    if options.json and options.check:
        found = [*file.diagnostics.errors, *file.diagnostics.warnings]
        print(json.dumps([dataclasses.asdict(error) for error in found], indent=2))
        return 1 if file.diagnostics.errors else 0
    for error in [*file.diagnostics.errors, *file.diagnostics.warnings]:
        print(f"{'error   ' if error.severity == 'error' else 'warning '}: {error}", file=sys.stderr)
    if options.print:
        print("<?xml version='1.0'?>")
        print(file.root.ToString(), end="")
    elif not file.diagnostics.errors:
        print("Check complete")
    return 1 if file.diagnostics.errors else 0
