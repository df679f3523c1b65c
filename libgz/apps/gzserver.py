"""gzserver: run a world as Gazebo classic's server did, with its options, messages and exit codes."""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from libgz._version import __version__
from libgz.apps.console import LogFile, as_command, set_up_classic_console, whole_number
from libgz.apps.server_log import add_log_options, keep_log
from libgz.classic.common import LogFormatter, gzlog
from libgz.classic.loading import new_plugin
from libgz.classic.log import LogPlay, PlaybackControl
from libgz.classic.physics.world import World as WorldView
from libgz.classic.server import WorldServer, attach, system_plugins
from libgz.classic.transport import Link, publicized_address, serve
from libgz.errors import GazeboError, NotFoundError
from libgz.front import World
from libgz.sdf.paths import find_world
from libgz.simulation.pacing import Pacer

__all__ = [
    "BANNER",
    "FAILED",
    "Help",
    "Parser",
    "Version",
    "construct_system_plugins",
    "drop_system_plugins",
    "init_system_plugins",
    "load_system_plugins",
    "main",
    "open_log",
    "system_options",
    "tell_link",
]

log = logging.getLogger("libgz.classic")

FAILED = 255
BANNER = f"""Gazebo multi-robot simulator, version {__version__} (libgz)
Worlds and plugins of Gazebo classic, run from Python by libgz
Released under the Apache 2 License
"""
# Options of Gazebo's that have nothing to act on here: they are taken, and one warning says so.
WITHOUT_EFFECT = {
    "--lockstep": "physics and sensors always keep step",
    "--record_resources": "models and meshes stay where they are",
    "--minimal_comms": "nothing is published that nobody listens to",
    "--gui-plugin": "the server has no window; gzclient has",
    "--gui-client-plugin": "the server has no window; gzclient has",
}
FLAGS = ("--lockstep", "--record_resources", "--minimal_comms")
SHORT = {"--gui-plugin": "-g"}


class Parser(argparse.ArgumentParser):
    """Says what is wrong in classic's words, too."""

    def error(self, message: str) -> NoReturn:
        """Say that the arguments are wrong, in classic's words and in ours, and end with 255."""
        self.exit(FAILED, f"Error. Invalid arguments\n{self.prog}: {message}; {self.prog} -h lists what is allowed\n")


class Help(argparse.Action):
    """-h, --help."""

    def __call__(self, parser: argparse.ArgumentParser, *_others: object) -> None:
        """Print the options on stderr, and end with 255."""
        parser.print_help(sys.stderr)
        parser.exit(FAILED)


class Version(argparse.Action):
    """-v, --version."""

    def __call__(self, parser: argparse.ArgumentParser, *_others: object) -> None:
        """Print the banner on stdout, and end with 255."""
        sys.stdout.write(BANNER + "\n")
        parser.exit(FAILED)


def make_parser() -> argparse.ArgumentParser:
    """The options of Gazebo 11's gzserver."""
    parser = Parser(prog="gzserver", description="gzserver -- Run the Gazebo server.", add_help=False)
    add = parser.add_argument
    add("world", nargs="?", default="worlds/empty.world", help="world to run (default worlds/empty.world)")
    add("-v", "--version", action=Version, nargs=0, help="print the version and end")
    add("--verbose", action="store_true", help="show all messages; errors and warnings are always shown")
    add("-h", "--help", action=Help, nargs=0, help="print this and end")
    add("-u", "--pause", action="store_true", help="start paused")
    add("-e", "--physics", default="ode", help="physics engine; there is ode")
    add("-o", "--profile", help="name of the <physics> element to use")
    add("-s", "--server-plugin", action="append", default=[], help="System plugin to load; may be given several times")
    add("--seed", type=whole_number("number"), help="seed of everything random (default: the process's number)")
    add("--iters", type=whole_number("number"), help="end after so many iterations, or with the log")
    add("--server-id", type=whole_number("number"), help="serve the interfaces of old client programs under this id")
    add_log_options(parser)
    for option, why in WITHOUT_EFFECT.items():
        names = [SHORT[option], option] if option in SHORT else [option]
        if option in FLAGS:
            add(*names, action="store_true", help=f"taken without effect: {why}")
        else:
            add(*names, action="append", help=f"taken without effect: {why}")
    return parser


def system_options(parser: argparse.ArgumentParser, words: Sequence[str]) -> argparse.Namespace:
    """Read the command line; what is unknown is left to System plugins."""
    options, unknown = parser.parse_known_args(list(words))
    if unknown:
        log.info("left to System plugins: %s", " ".join(unknown))
    for option, why in WITHOUT_EFFECT.items():
        if getattr(options, option.lstrip("-").replace("-", "_"), None):
            log.warning("%s has no effect: %s", option, why)
    return options


def construct_system_plugins(filenames: Sequence[str]) -> None:
    """Find System plugins, and construct them."""
    for filename in filter(None, filenames):
        plugin = new_plugin("System", filename, filename, "System", None)
        if plugin is not None:
            system_plugins.append(plugin)


def load_system_plugins(words: list[str]) -> None:
    """Call Load of all System plugins, with the command line."""
    for plugin in system_plugins:
        plugin.load(len(words), words)


def init_system_plugins() -> None:
    """Call Init of all System plugins."""
    for plugin in system_plugins:
        plugin.init()


def drop_system_plugins() -> None:
    """Let all System plugins go."""
    for plugin in system_plugins:
        plugin.drop()
    system_plugins.clear()


def tell_link(link: Link) -> None:
    """Say where the master is, in classic's words."""
    log.info("Connected to gazebo master @ %s", link.address.uri)
    log.info("Publicized address: %s", publicized_address())


class Server:
    """A run of gzserver."""

    def __init__(self, options: argparse.Namespace, words: Sequence[str]) -> None:
        self.options, self.words = options, ["gzserver", *words]
        self._stopped = False
        self._play: LogPlay | None = None

    def run(self) -> int:
        """Everything, in classic's order; the exit code."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._interrupted)
        construct_system_plugins(self.options.server_plugin)
        try:
            with serve() as link:
                open_log("server", link.address.port)
                load_system_plugins(self.words)
                log.info("Waiting for master.")
                tell_link(link)
                init_system_plugins()
                with self._open_world() as core, keep_log(self.options, core, self._play) as control:
                    self._loop(core, control)
            return 0
        finally:
            drop_system_plugins()

    def _interrupted(self, _number: int, _frame: object) -> None:
        self._stopped = True

    def _open_world(self) -> World:
        options = self.options
        if options.play is not None:
            return self._open_log(options.play)
        path = _find_world(options.world)
        if options.physics != "ode":
            log.error("Unregistered physics engine [%s], the default will be used instead.", options.physics)
        seed = os.getpid() if options.seed is None else options.seed
        gzlog(f"Loading world file [{path}]")
        core = World(options.server_id, seed=seed)
        try:
            core.LoadFile(path)
            if options.pause:
                core.starts_paused = True
            if core.sdf is not None:
                self._choose_profile(attach(core).world)
            core.Initialize()
        except BaseException:
            core.close()
            raise
        return core

    def _open_log(self, path: str) -> World:
        core = World(self.options.server_id)
        self._play = LogPlay(path, core)
        log.info("playing [%s], recorded by %s", path, self._play.reader.header.gazebo_version)
        core.paused = self.options.pause
        return core

    def _choose_profile(self, world: WorldView) -> None:
        name = self.options.profile
        if name is None:
            return
        try:
            world.PresetMgr().CurrentProfile(name)
            log.info("Setting physics profile to [%s].", name)
        except NotFoundError as error:
            log.error("%s", error)

    def _loop(self, core: World, control: PlaybackControl | None) -> None:
        """Step until a signal, World.Stop, or the number of iterations ends it."""
        server = next((c for c in core.companions if isinstance(c, WorldServer)), None)
        pacer, done = Pacer(core.simSpeed), 0
        while not self._over(server, done):
            done += self._step(core, control)
            if pacer.speed != core.simSpeed:
                pacer = Pacer(core.simSpeed)
            while not self._over(server, done) and not pacer.sleep(core.GetSimTime() + core.GetPauseTime()):
                pass
        core.events["Stop"]()
        if self._stopped:
            core.events["SigInt"]()

    def _step(self, core: World, control: PlaybackControl | None) -> int:
        """One step; how many iterations it was: none of a paused world."""
        if control is not None:
            control.update()
        if self._play is not None and not core.paused:
            return int(self._play.Step())
        core.Step()
        return 0 if core.paused else 1

    def _over(self, server: WorldServer | None, done: int) -> bool:
        limit = self.options.iters
        enough = limit is not None and (done >= limit or (self._play is not None and self._play.at_end))
        return self._stopped or (server is not None and server.stopped) or enough


def open_log(kind: str, port: int) -> None:
    """Write all messages to ``<kind>-<port>/default.log`` in GAZEBO_LOG_PATH or ~/.gazebo, too."""
    folder = Path(os.environ.get("GAZEBO_LOG_PATH") or "~/.gazebo").expanduser() / f"{kind}-{port}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handler = LogFile(folder / "default.log", mode="w")
    except OSError as error:
        log.warning("no log file in %s: %s", folder, error.strerror)
        return
    handler.setFormatter(LogFormatter())
    logging.getLogger("libgz").addHandler(handler)


def _find_world(name: str) -> Path:
    try:
        return find_world(name)
    except NotFoundError as error:
        raise NotFoundError(f"Could not open file[{name}]: {error}") from None


@as_command("gzserver", interrupted=0, failed=FAILED)
def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, SIGINT and SIGTERM included; 255 it could not run."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    parser = make_parser()
    set_up_classic_console(verbose="--verbose" in words)
    options = system_options(parser, words)
    if options.verbose:
        with contextlib.suppress(OSError):
            sys.stderr.write(BANNER + "\n")
    try:
        return Server(options, words).run()
    except GazeboError as error:
        log.error("%s", error)
        return FAILED


if __name__ == "__main__":
    sys.exit(main())
