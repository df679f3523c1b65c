"""The parsers of all commands, for shell completion and the man pages, and what their exit codes mean."""

from __future__ import annotations

import argparse

from libgz.apps import gazebo, gzclient, gzserver, libgz
from libgz.apps.classic_command import FAILED
from libgz.apps.console import INTERRUPTED, NO_READER, STRICT, TERMINATED, USAGE_ERROR

__all__ = ["EXIT_CODES", "command_parsers"]

# Exit code -> meaning for (gazebo, libgz, gzserver and gzclient); empty where the command never has it.
EXIT_CODES: dict[int, tuple[str, str, str]] = {
    0: ("done; also after SIGINT or SIGTERM", "done", "done; also after SIGINT or SIGTERM"),
    1: ("the world cannot run", "failed, or `check` or `sdf` found an error, or `doctor` something missing", ""),
    USAGE_ERROR: ("the command line is wrong", "the command line is wrong", ""),
    STRICT: ("an error or warning ended it (`--strict`)", "", "an error or warning ended it (`--strict`)"),
    INTERRUPTED: (
        "SIGINT before the world ran, or a second one, ended it",
        "SIGINT ended it",
        "SIGINT before the world ran, or a second one, ended it",
    ),
    NO_READER: ("its output was closed", "its output was closed (`| head`)", "its output was closed"),
    TERMINATED: (
        "SIGTERM before the world ran, or a second one, ended it",
        "SIGTERM ended it",
        "SIGTERM before the world ran, or a second one, ended it",
    ),
    FAILED: ("", "", "failed, or the command line is wrong"),
}


def command_parsers() -> dict[str, argparse.ArgumentParser]:
    """The parser of each command by its name, those of all subcommands included."""
    server = gzserver.make_parser()
    # gzserver takes its world from the words that are no options.
    server.add_argument(
        "world", nargs="?", metavar="WORLD", help="the world to run, SDF or legacy, by its file or name"
    )
    return {
        "gazebo": gazebo.make_parser(),
        "gz": libgz.make_parser(everything=True, prog="gz"),
        "gzclient": gzclient.make_parser(),
        "gzserver": server,
        "libgz": libgz.make_parser(everything=True),
    }
