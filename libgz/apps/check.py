"""libgz check: what is wrong or unused in worldfiles."""

from __future__ import annotations

import argparse
import dataclasses
import json

from libgz.fault import Fault
from libgz.reference.check import check

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("worldfiles", nargs="+", metavar="WORLDFILE", help="a worldfile of Gazebo 0.3 to 0.7")
    parser.add_argument("--strict", action="store_true", help="make warnings errors")
    parser.add_argument("--json", action="store_true", help="print a list of objects instead of lines")


def run(options: argparse.Namespace) -> int:
    """Print all faults of all files; 1 if there is an error."""
    faults = [fault for name in options.worldfiles for fault in check(name)]
    if options.strict:
        faults = [dataclasses.replace(fault, severity="error") for fault in faults]
    if options.json:
        print(json.dumps([dataclasses.asdict(fault) for fault in faults], indent=2))
    else:
        for fault in faults:
            print(_line(fault))
    return int(any(fault.severity == "error" for fault in faults))


def _line(fault: Fault) -> str:
    """`file:line: <element>: message`, with a word where it is only a warning."""
    place = f"{fault.file}:{fault.line}" if fault.line else fault.file
    element = f"<{fault.element}>: " if fault.element else ""
    return f"{place}: {element}{'warning: ' if fault.severity == 'warning' else ''}{fault.message}"
