"""libgz: the toolbox command. Each subcommand is a module of this package, imported when it is asked for."""

from __future__ import annotations

import importlib
import signal
import sys
import threading
from collections.abc import Sequence
from typing import NoReturn

from libgz._version import __version__
from libgz.apps.console import Parser, as_command, set_up_messages
from libgz.errors import GazeboError

__all__ = ["main"]

# Subcommand -> what it does. Its module has configure(parser), which adds options, and run(options), the exit code.
COMMANDS = {
    "check": "tell what is wrong or unused in worldfiles",
    "clean": "remove what dead servers left behind",
    "config": "print what a C compiler needs for programs that speak libgazebo",
    "convert": "write a worldfile's world as SDF 1.6",
    "demo": "run a robot's world and drive it from a second process",
    "doctor": "show what this machine has of what libgz needs",
    "echo": "print what an interface of a running server says, live",
    "interfaces": "list what a running server offers",
    "joint": "push and steer joints of a running SDF world",
    "log": "read a log file of an SDF world, or switch recording on and off in a running server",
    "model": "look at, move, add and delete models of a running SDF world",
    "models": "list all models, or describe one",
    "picture": "save what a camera of a world sees",
    "schema": "print a grammar of worldfiles for editors",
    "sdf": "check an SDF file of Gazebo classic, or print it with its defaults",
    "set": "write fields of an interface of a running server",
    "stats": "print how fast a running SDF world goes",
    "topic": "list, print, measure and publish the topics of a running server of SDF worlds",
    "upgrade": "rewrite a worldfile of Gazebo 0.3 or 0.4 in the spelling of 0.5 to 0.7",
}


def make_parser(wanted: str | None) -> Parser:
    """The parser; options are added for the subcommand `wanted` only, so that the others need not be imported."""
    parser = Parser(prog="libgz", description="Tools around simulated worlds.")
    parser.add_argument("-v", "--version", action="version", version=f"libgz {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=Parser)
    for name, help_ in COMMANDS.items():
        command = commands.add_parser(name, help=help_, description=f"{help_[0].upper()}{help_[1:]}.")
        if name == wanted:
            importlib.import_module(f"libgz.apps.{name}").configure(command)
    return parser


def _terminated(number: int, _frame: object) -> NoReturn:
    """SIGTERM: end what was begun, the demonstration's server above all."""
    sys.exit(128 + number)


@as_command("libgz")
def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, 1 failed, 2 the command line is wrong."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    options = make_parser(words[0] if words else None).parse_args(words)
    set_up_messages(0, None)
    before = signal.getsignal(signal.SIGTERM)
    owned = threading.current_thread() is threading.main_thread()
    if owned:
        signal.signal(signal.SIGTERM, _terminated)
    try:
        return int(importlib.import_module(f"libgz.apps.{options.command}").run(options))
    except GazeboError as error:
        print(f"libgz: {error}", file=sys.stderr)
        return 1
    finally:
        if owned:
            signal.signal(signal.SIGTERM, before)


if __name__ == "__main__":
    sys.exit(main())
