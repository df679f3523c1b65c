"""libgz sdf: check an SDF file, or print it with includes resolved and defaults filled in."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from collections.abc import Iterable

from libgz.errors import Diagnostic, WorldFileError
from libgz.reference.check import check_sdf
from libgz.sdf.reader import SdfFile

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "--check",
        metavar="FILE",
        help="report all that a run would report of an SDF file; exit code 1 if there are errors",
    )
    what.add_argument("--print", metavar="FILE", help="print the file with includes resolved and defaults filled in")
    parser.add_argument("--json", action="store_true", help="with --check: print the errors as a JSON array")


def run(options: argparse.Namespace) -> int:
    """Check or print a file; return 1 if it has errors."""
    return _check(options) if options.check else _print(options.print)


def _check(options: argparse.Namespace) -> int:
    found = check_sdf(options.check)
    if options.json:
        print(json.dumps([dataclasses.asdict(error) for error in found], indent=2))
    else:
        _report(found)
    wrong = any(error.severity == "error" for error in found)
    if not wrong and not options.json:
        print("Check complete")
    return int(wrong)


def _print(filename: str) -> int:
    try:
        file = SdfFile.load(filename)
    except WorldFileError as unreadable:
        print(f"error   : {unreadable}", file=sys.stderr)
        return 1
    _report([*file.diagnostics.errors, *file.diagnostics.warnings])
    print("<?xml version='1.0'?>")
    print(file.root.ToString(), end="")
    return 1 if file.diagnostics.errors else 0


def _report(found: Iterable[Diagnostic]) -> None:
    for error in found:
        print(f"{'error   ' if error.severity == 'error' else 'warning '}: {error}", file=sys.stderr)
