"""libgz sdf: check, print or convert an SDF file, or describe the format, with the options of `gz sdf`."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from libgz.apps import upgrade
from libgz.apps.console import Parser, say
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.errors import Diagnostic, ParameterError, WorldFileError, nearest
from libgz.base.visible import visible_xml
from libgz.reference.check import check_sdf
from libgz.reference.sdf_elements import sdf_block, sdf_blocks
from libgz.reference.sdf_format import sdf_page, sdf_text
from libgz.sdf.description import NEWEST, VERSIONS
from libgz.sdf.reader import SdfFile

__all__ = ["configure", "run"]


def configure(parser: Parser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    parser.add_macro_arguments()
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument(
        "-k",
        "--check",
        metavar="FILE",
        help="report all that a run would report of an SDF file; exit code 1 if there are errors",
    )
    help_ = "print the file with includes resolved and defaults filled in"
    what.add_argument("-p", "--print", metavar="FILE", help=help_)
    what.add_argument("-c", "--convert", type=Path, metavar="FILE", help=f"convert the file to SDF {NEWEST}, in place")
    what.add_argument("-d", "--describe", action="store_true", help="print all elements with types and defaults")
    what.add_argument("-o", "--doc", action="store_true", help="print them as a page of HTML")
    what.add_argument(
        "--elements",
        nargs="?",
        const="all",
        metavar="BLOCK",
        help="list the blocks of SDF, or the elements of one (`joint`)",
    )
    parser.add_argument("-v", "--version", choices=VERSIONS, help=f"with -d and -o: of SDF (default {NEWEST})")
    parser.add_argument("--json", action="store_true", help="with --check: print the errors as a JSON array")


def run(options: argparse.Namespace) -> int:
    """Check, print or convert a file, or describe the format; return 1 if a file has errors.

    Raises:
        ParameterError: there is a version without what it is for.
        WorldFileError: the file to convert cannot be read.
        GazeboError: it cannot be written.
    """
    if options.describe or options.doc:
        version = options.version or NEWEST
        say(sdf_text(version) if options.describe else sdf_page(version), end="")
        return 0
    if options.elements is not None:
        return _elements(options.elements)
    if options.version is not None:
        raise ParameterError(f"-v goes with -d and -o; -c FILE converts a file to SDF {NEWEST}")
    if options.convert is not None:
        upgrade.run(
            argparse.Namespace(worldfile=options.convert, output=None, in_place=True, arguments=options.arguments)
        )
        say("Success")
        return 0
    return _check(options) if options.check else _print(options.print, options.arguments)


def _elements(block: str) -> int:
    """List the blocks, or print the elements of one: type, default, versions, and whether libgz acts on each.

    Raises:
        ParameterError: there is no such block.
    """
    blocks = sdf_blocks()
    if block != "all" and block not in blocks:
        raise ParameterError(f"SDF has no block {block!r}{nearest(block, blocks)}")
    say("\n".join(blocks) + "\n" if block == "all" else sdf_block(block), end="")
    return 0


def _check(options: argparse.Namespace) -> int:
    found = check_sdf(options.check, options.arguments)
    if options.json:
        say(json.dumps([error._asdict() for error in found], indent=2))
    else:
        _report(found)
    wrong = any(error.severity == "error" for error in found)
    if not wrong and not options.json:
        say("Check complete")
    return int(wrong)


def _print(filename: str, arguments: Mapping[str, str]) -> int:
    try:
        file = SdfFile.load(filename, arguments=arguments)
    except WorldFileError as unreadable:
        say(f"error   : {unreadable}", file=sys.stderr)
        return 1
    _report([*file.diagnostics.errors, *file.diagnostics.warnings])
    say("<?xml version='1.0'?>")
    say(visible_xml(file.root.ToString()), end="")
    return 1 if file.diagnostics.errors else 0


def _report(found: Iterable[Diagnostic]) -> None:
    for error in found:
        say(f"{'error   ' if error.severity == 'error' else 'warning '}: {error}", file=sys.stderr)
