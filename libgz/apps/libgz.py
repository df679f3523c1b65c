"""libgz: the command with subcommands. Each subcommand is a module of this package, imported when it is used."""

from __future__ import annotations

import importlib
import signal
import sys
import threading
from collections.abc import Collection, Sequence
from typing import NoReturn

from libgz._version import __version__
from libgz.apps.console import USAGE_ERROR, Parser, as_command, say, set_up_messages
from libgz.apps.untrusted import confined
from libgz.base.errors import GazeboError

__all__ = ["main", "run_words"]

# Subcommand -> help text. The module of the same name has configure(parser), which adds the options, and run(options),
# which returns the exit code.
COMMANDS = {
    "check": "report errors and unused elements in worldfiles and SDF files",
    "clean": "remove stale files of dead servers",
    "completion": "print the completion of all commands for a shell",
    "config": "print compiler flags for C programs that use libgazebo, and for C++ plugins",
    "convert": "convert a worldfile to SDF 1.6",
    "cxx": "compile C++ plugins of both eras, and explain errors",
    "debug": "list the commands, or the options of one, as `gz debug` does for completion",
    "demo": "start a server with a robot, and drive the robot from a second process",
    "doctor": "check what libgz needs on this machine",
    "echo": "print the data of an interface of a running server, live",
    "edit": "edit a world in a browser, paused; an empty one if there is none",
    "export": "write the interfaces, states and topics of a log as CSV files",
    "interfaces": "list the interfaces of a running server",
    "joint": "apply forces to joints of a running SDF world, and set their targets",
    "log": "read a log file of an SDF world, or start and stop recording in a running server",
    "lsp": "serve editors: errors, completion and meanings in worldfiles and SDF files as they are typed",
    "model": "inspect, move, add and delete models of a running SDF world",
    "models": "list all models, or describe one",
    "physics": "change gravity, step, rate and solver of a running SDF world",
    "play": "serve a log of gazebo --mcap or gzserver --mcap as its server did",
    "new": "write a folder with a new model or plugin that runs at once",
    "picture": "run a world and save the image of one of its cameras",
    "player": "serve client programs of Player 1.6 to 3 from a running or started server",
    "plot": "plot fields of a log or of a running server over time",
    "plugin": "load an edited plugin file again while its world runs",
    "ros": "install the packages that launch files of ROS name",
    "schema": "print a RELAX NG grammar of worldfiles or of SDF for editors",
    "sdf": "check, print or convert an SDF file of Gazebo classic, or list the elements of SDF",
    "set": "write fields of an interface of a running server",
    "snapshot": "save and restore the state of a running server, or rewind it",
    "sweep": "run a study of many runs, here or on a cluster, and plot what they measure",
    "stats": "print the real-time factor of a running SDF world",
    "topic": "list, print, measure and publish topics of a running gzserver",
    "view": "show a running world in a browser, with controls",
    "upgrade": "convert a worldfile of 0.3 or 0.4 to the format of 0.5 to 0.7, or SDF 1.0 to 1.5 or URDF to SDF 1.6",
    "world": "pause, step and reset a running SDF world",
    "worlds": "list the worlds that are installed with libgz",
    "xacro": "print a robot description with its macros expanded, as ROS's command of this name does",
}

# Commands of Gazebo's `gz` that have no counterpart, and what serves instead.
WITHOUT = {
    "camera": "it moves the camera of Gazebo's window; the page of `gzclient` and `libgz view` has a button that "
    "follows a model, and cameras of a world follow one by Camera.AttachToVisual or TrackVisual in a plugin",
    "plugin": "`gz plugin` of Gazebo 11 describes a compiled plugin; `libgz plugin` loads an edited one again",
    "marker": "it needs the service of Gazebo's window; a plugin shows boxes, lines and points by "
    "Scene.CreateVisual, Visual.AttachMesh and CreateDynamicLine",
}


# Those of Gazebo 11's `gz`.
CLASSIC = ("debug", "joint", "log", "model", "physics", "sdf", "stats", "topic", "world")


def make_parser(wanted: str | None = None, *, everything: bool = False, prog: str = "libgz") -> Parser:
    """The parser, with options of the subcommand `wanted` only, so that the other modules are not imported.

    Args:
        wanted: the subcommand.
        everything: whether all subcommands have their options.
        prog: the command: ``libgz``, or ``gz`` with the subcommands of Gazebo classic.
    """
    parser = Parser(prog=prog, description="Tools for worldfiles, servers and SDF worlds.")
    parser.add_argument("-v", "--version", action="version", version=f"{prog} {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=Parser)
    for name in COMMANDS if prog == "libgz" else CLASSIC:
        help_ = COMMANDS[name]
        command = commands.add_parser(name, help=help_, description=f"{help_[0].upper()}{help_[1:]}.")
        if everything or name == wanted:
            importlib.import_module(f"libgz.apps.{name}").configure(command)
    about = "describe a command, a model, an interface or a class, or list all commands"
    commands.add_parser("help", help=about, description=f"{about[0].upper()}{about[1:]}.")
    return parser


def _help_words(words: list[str]) -> list[str]:
    """`libgz help` and `libgz help COMMAND` in the form that the parser knows."""
    return [*words[1:2], "-h"] if words[:1] == ["help"] else words


def _asks_for_reference(words: list[str], known: Collection[str]) -> bool:
    """Whether the words are `help NAME`, and the name is not that of a command."""
    return words[:1] == ["help"] and len(words) == 2 and words[1][:1] != "-" and words[1] not in {*known, *WITHOUT}


def _print_reference(prog: str, name: str) -> int:
    from libgz.apps.names import reference_of

    try:
        say(reference_of(name), end="")
    except GazeboError as error:
        say(f"{prog}: {error}", file=sys.stderr)
        return USAGE_ERROR
    return 0


def _terminated(number: int, _frame: object) -> NoReturn:
    """SIGTERM: exit with clean-up, such as ending the server of `libgz demo`."""
    sys.exit(128 + number)


@as_command("libgz")
def main(arguments: Sequence[str] | None = None) -> int:
    """The command libgz. Exit codes: 0 done, 1 failed, 2 the command line is wrong."""
    return run_words("libgz", list(sys.argv[1:] if arguments is None else arguments))


def run_words(prog: str, words: list[str]) -> int:
    """Run `libgz`, or `gz` with its fewer subcommands, with the words of its command line."""
    known = COMMANDS if prog == "libgz" else CLASSIC
    if _asks_for_reference(words, known):
        return _print_reference(prog, words[1])
    words = _help_words(words)
    if words and words[0] in WITHOUT and words[0] not in known:
        say(f"{prog}: there is no {words[0]!r}: {WITHOUT[words[0]]}", file=sys.stderr)
        return USAGE_ERROR
    options = make_parser(words[0] if words else None, prog=prog).parse_args(words)
    set_up_messages(0, None)
    before = signal.getsignal(signal.SIGTERM)
    owned = threading.current_thread() is threading.main_thread()
    if owned:
        signal.signal(signal.SIGTERM, _terminated)
    try:
        command = importlib.import_module(f"libgz.apps.{options.command}")
        with confined(prog, options):
            return int(command.run(options))
    except GazeboError as error:
        say(f"{prog}: {error}", file=sys.stderr)
        return 1
    finally:
        if owned:
            signal.signal(signal.SIGTERM, before)


if __name__ == "__main__":
    sys.exit(main())
