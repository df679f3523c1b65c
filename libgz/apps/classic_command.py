"""Shared by gzserver and gzclient: Gazebo classic's options, console, log file and System plugins."""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from libgz._version import __version__
from libgz.apps.console import Hints, LogFile
from libgz.apps.ros_option import ros_wanted, without_ros_words
from libgz.base.closing import Closing
from libgz.classic.common import ConsoleHandler, LogFormatter
from libgz.classic.loading import Missing, new_plugin
from libgz.classic.transport import Link, publicized_address
from libgz.classic.world_plugins import system_plugins
from libgz.classic_cxx.registration import register
from libgz.rendering.choice import prefer

__all__ = [
    "FAILED",
    "Parser",
    "SystemPlugins",
    "log_link",
    "open_log",
    "read_command_line",
]

log = logging.getLogger("libgz.classic")

FAILED = 255
WORLD_ENDINGS = (".world", ".sdf", ".xml")
BANNER = f"""Gazebo multi-robot simulator, version {__version__} (libgz)
Worlds and plugins of Gazebo classic, run from Python by libgz
Released under the Apache 2 License
"""


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_others: object) -> None:
        """Print the banner on stdout, and exit with 0."""
        sys.stdout.write(BANNER + "\n")
        parser.exit()


class Parser(Hints):
    """An argument parser with classic's error message and exit code, and the options -v, --verbose and -h.

    -h and -v exit with 0, as those of other programs do; classic's exited with 255.
    """

    def __init__(self, prog: str, description: str, usage: str | None = None) -> None:
        super().__init__(prog=prog, description=description, usage=usage, add_help=False)
        self.add_argument("-v", "--version", action=_Version, nargs=0, help="print the version and exit")
        self.add_argument(
            "--verbose", action="store_true", help="print all messages; errors and warnings are always printed"
        )
        self.add_argument("-h", "--help", action="help", help="print this help and exit")

    def error(self, message: str) -> NoReturn:
        """Report invalid arguments as classic does, with the reason, and exit with 255."""
        self.exit(FAILED, f"Error. Invalid arguments\n{self.prog}: {message}; {self.prog} -h lists what is allowed\n")


def read_command_line(
    parser: Parser, arguments: Sequence[str] | None, *, plugins: Sequence[str]
) -> tuple[list[str], argparse.Namespace]:
    """Set up console and OpenGL as the command line wants them; its words, and the options as `_parse` returns them.

    Args:
        parser: its options, --gl among them; it has no positional arguments.
        arguments: the command line; None for that of the process.
        plugins: the options by which System plugins are loaded.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    _set_up_console(verbose="--verbose" in words)
    options = _parse(parser, without_ros_words(words), plugins)
    if options.gl is not None:
        prefer(options.gl)
    if options.verbose:
        with contextlib.suppress(OSError):
            sys.stderr.write(BANNER + "\n")
    return words, options


def _parse(parser: Parser, words: Sequence[str], plugins: Sequence[str]) -> argparse.Namespace:
    """Parse the command line; unknown words are for System plugins, which get the whole command line.

    Args:
        parser: its options; it has no positional arguments.
        words: the command line.
        plugins: the options by which System plugins are loaded. Without any, unknown options are logged as warnings.

    Returns:
        The options; `unknown` holds unknown options and their values, `rest` the words that are neither.
    """
    options: argparse.Namespace
    options, unknown = parser.parse_known_args(list(words))
    options.rest, others = _split(unknown)
    if "server_plugin" not in plugins or ros_wanted(options):  # names and remappings, which roslaunch gives all nodes
        others = [word for word in others if ":=" not in word]
    options.unknown = others
    if others and not any(getattr(options, name) for name in plugins):
        log.warning("%s; there is no System plugin to use them", parser.unknown(others))
    elif others:
        log.info("options for System plugins: %s", " ".join(others))
    return options


def _split(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """(words that stand for themselves, unknown options and their values).

    The word after an unknown option is its value, unless it is the only one that names a world file.
    """
    free: list[str] = []
    others: list[str] = []
    after_option = False
    values = []
    for word in words:
        option = word.startswith("-") and len(word) > 1
        if option or after_option or ":=" in word:  # ROS adds words such as __name:=gazebo
            others.append(word)
            if after_option and not option:
                values.append(word)
        else:
            free.append(word)
        after_option = option and "=" not in word
    if not free:
        free = [word for word in values if word.endswith(WORLD_ENDINGS)][:1]
        others = [word for word in others if word not in free]
    return free, others


def _set_up_console(*, verbose: bool) -> None:
    """Send errors and warnings to stderr, and with `verbose` messages to stdout, in Gazebo classic's format."""
    root = logging.getLogger("libgz")
    root.setLevel(logging.DEBUG)
    root.propagate = False
    root.handlers[:] = [ConsoleHandler(verbose)]


def open_log(kind: str, port: int) -> None:
    """Write all messages also to ``<kind>-<port>/default.log`` in GAZEBO_LOG_PATH or ~/.gazebo."""
    folder = Path(os.environ.get("GAZEBO_LOG_PATH") or "~/.gazebo").expanduser() / f"{kind}-{port}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handler = LogFile(folder / "default.log")
    except OSError as error:
        log.warning("no log file in %s: %s", folder, error.strerror)
        return
    handler.setFormatter(LogFormatter())
    logging.getLogger("libgz").addHandler(handler)


def log_link(link: Link) -> None:
    """Log the address of the master, with classic's messages."""
    log.info("Connected to gazebo master @ %s", link.address.uri)
    log.info("Publicized address: %s", publicized_address())


class SystemPlugins(Closing):
    """The System plugins of this process, from `with` to its end.

    Args:
        filenames: as on the command line; plugins that cannot be loaded are logged and left out.
    """

    def __init__(self, filenames: Sequence[str]) -> None:
        register()
        missing = Missing()
        for filename in filter(None, filenames):
            plugin = new_plugin("System", filename, filename, "System", None, missing=missing)
            if plugin is not None:
                system_plugins.append(plugin)

    def load(self, words: Sequence[str]) -> None:
        """Call Load of all plugins, with the command line."""
        for plugin in system_plugins:
            plugin.load(len(words), words)

    def init(self) -> None:
        """Call Init of all plugins."""
        for plugin in system_plugins:
            plugin.init()

    def close(self) -> None:
        """Drop all plugins."""
        for plugin in system_plugins:
            plugin.drop()
        system_plugins.clear()
