"""libgz: the toolbox command."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from libgz._version import __version__
from libgz.apps.console import Parser, set_up_messages
from libgz.errors import GazeboError

__all__ = ["main"]


def make_parser() -> Parser:
    """One subcommand each."""
    parser = Parser(prog="libgz", description="Tools around simulated worlds.")
    parser.add_argument("-v", "--version", action="version", version=f"libgz {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=Parser)
    commands.add_parser("doctor", help="show what this machine has of what libgz needs")
    demo = commands.add_parser("demo", help="run a robot's world and drive it from a second process")
    demo.add_argument("--seconds", type=float, default=16.0, metavar="S", help="of sim time (default 16)")
    demo.add_argument("--rate", type=float, default=2.0, metavar="R", help="times real time (default 2)")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, 1 failed, 2 the command line is wrong."""
    options = make_parser().parse_args(arguments)
    set_up_messages(0, None)
    try:
        if options.command == "doctor":
            return _doctor()
        from libgz.apps.demo import run_demo

        return run_demo(options.seconds, options.rate)
    except GazeboError as fault:
        print(f"libgz: {fault}", file=sys.stderr)
        return 1


def _doctor() -> int:
    from libgz.apps.doctor import examine

    findings = list(examine())
    for finding in findings:
        print(finding)
    return 0 if all(f.good for f in findings if f.needed) else 1


if __name__ == "__main__":
    sys.exit(main())
