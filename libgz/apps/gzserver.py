"""gzserver: run a world with the options, messages and exit codes of Gazebo classic's server."""

from __future__ import annotations

import argparse
import contextlib
import logging
import os
import re
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from libgz.apps.classic_command import FAILED, Parser, SystemPlugins, log_link, open_log, read_command_line
from libgz.apps.console import STRICT, STRICT_HELP, as_command, whole_number
from libgz.apps.mcap_option import add_mcap_option, record_mcap
from libgz.apps.progress import show_loading
from libgz.apps.record import VideoRecorder, record_videos
from libgz.apps.ros_option import add_ros_options, start_ros
from libgz.apps.server_log import add_log_options, keep_log
from libgz.apps.snapshot_control import SnapshotControl, add_rewind_option
from libgz.apps.untrusted import add_untrusted_option, confined
from libgz.apps.view_options import GL_HELP
from libgz.apps.view_process import add_view_options, view_process
from libgz.base.errors import GazeboError, NotFoundError, PluginError, ServerError, StrictError, WorldFileError, nearest
from libgz.base.files import is_file
from libgz.classic.common import gzlog
from libgz.classic.physics.world import World as WorldView
from libgz.classic.server import WorldServer, attach
from libgz.classic.transport import get_master_uri, serve
from libgz.classic_cxx.registration import start_ignition
from libgz.front import World
from libgz.rendering.choice import CHOICES
from libgz.sdf.paths import find_world
from libgz.simulation.pacing import Pacer
from libgz.simulation.problems import Problems
from libgz.simulation.watchdog import Watchdog
from libgz.transport.server import free_server_id
from libgz.worldfile.search import find_worldfile, ready_worlds

if TYPE_CHECKING:
    from libgz.classic.log import LogPlay, PlaybackControl
    from libgz.recording.capture import Capture
    from libgz.ros.server import Ros1, Ros2

__all__ = ["main"]

log = logging.getLogger("libgz.classic")

EMPTY_WORLD = "worlds/empty.world"
MOST_STEPS = 1000  # at a time; World.step_on ends earlier
LONGEST_WAIT = 1.0  # [s] that a message waits for a step
FIRST_ID, SPREAD = 100, 800  # of the ids that servers take by themselves; two that start together take different ones

# Options of Gazebo that are accepted without effect, with a warning: option -> reason.
WITHOUT_EFFECT = {
    "--lockstep": "physics and sensors always run in lockstep",
    "--record_resources": "models and meshes are not copied",
    "--minimal_comms": "topics without subscribers are never published",
    "--gui-plugin": "the server runs no plugins of a client; use gazebo or gzclient",
    "--gui-client-plugin": "the server runs no plugins of a client; use gazebo or gzclient",
}
OF_CLIENT = ("gui_plugin", "gui_client_plugin")
VIDEO = re.compile(r"[^=/]+=.+")  # ID=FILE
FLAGS = ("--lockstep", "--record_resources", "--minimal_comms")
SHORT = {"--gui-plugin": "-g"}


def make_parser() -> Parser:
    """The options of Gazebo 11's gzserver, and --server-id, --gl and --steps."""
    usage = "gzserver [options] [WORLD]"
    parser = Parser("gzserver", f"gzserver -- Run the Gazebo server. WORLD is {EMPTY_WORLD} by default.", usage)
    add = parser.add_argument
    add("-u", "--pause", action="store_true", help="start paused")
    add("-e", "--physics", default="ode", help="physics engine; only ode is available")
    add("-o", "--profile", help="name of the <physics> element to use (default: the default one)")
    add("-s", "--server-plugin", action="append", default=[], help="load a System plugin; may be repeated")
    add("--seed", type=whole_number("number"), help="seed of all random numbers (default: the process id)")
    iters = "number of iterations to run (default: until interrupted)"
    add("--iters", "--steps", type=whole_number("number"), metavar="N", help=iters)
    add("--server-id", type=whole_number("number"), help="serve the interfaces of legacy models under this server id")
    add("--watch-only", action="store_true", help="refuse all that clients and pages do to change the world")
    add("--strict", action="store_true", help=STRICT_HELP)
    add("--gl", choices=CHOICES, default=None, help=GL_HELP)
    add_untrusted_option(parser)
    parser.add_macro_arguments()
    add_rewind_option(parser)
    add_mcap_option(parser)
    add_ros_options(parser)
    about = "obey joint commands of ignition-transport; without it, if a C++ plugin uses ignition-transport"
    add("--ignition", action="store_true", help=about)
    add_view_options(parser, optional=True)
    add_log_options(parser)
    for option, why in WITHOUT_EFFECT.items():
        names = [SHORT[option], option] if option in SHORT else [option]
        if option in FLAGS:
            add(*names, action="store_true", help=f"accepted without effect: {why}")
        else:
            add(*names, action="append", help=f"accepted without effect: {why}")
    return parser


def split_videos(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """(the words without videos, the videos): those of ``--record ID=FILE``, which without one is classic's option."""
    rest: list[str] = []
    videos: list[str] = []
    for word in words:
        if word.startswith("--record=") and VIDEO.fullmatch(word.removeprefix("--record=")):
            videos.append(word.removeprefix("--record="))
        elif rest and rest[-1] == "--record" and VIDEO.fullmatch(word):
            rest.pop()
            videos.append(word)
        else:
            rest.append(word)
    return rest, videos


def warn_without_effect(options: argparse.Namespace) -> None:
    """Warn of options that have no effect here; with a client, those of its plugins have."""
    for option, why in WITHOUT_EFFECT.items():
        name = option.lstrip("-").replace("-", "_")
        if getattr(options, name, None) and not (options.with_client and name in OF_CLIENT):
            log.warning("%s has no effect: %s", option, why)


class Server:
    """A run of gzserver."""

    def __init__(self, options: argparse.Namespace, words: Sequence[str]) -> None:
        self.options, self.words = options, ["gzserver", *words]
        self._stopped = False
        self._play: LogPlay | None = None
        self._ros: Ros1 | Ros2 | None = None

    def run(self) -> int:
        """Run the world, with classic's order of events; return the exit code."""
        with Watchdog(self._interrupted) as self._watchdog:
            self._run()
        return 0

    def _run(self) -> None:
        # Of System plugins, which belong to no world.
        problems = Problems(lambda: True, self.options.strict, warnings=False)
        with (
            start_ros(self.options, self.words, self._watchdog) as self._ros,
            SystemPlugins(self.options.server_plugin) as plugins,
            serve(watch_only=self.options.watch_only) as link,
        ):
            if get_master_uri().port == 0:
                sys.stdout.write(f"GAZEBO_MASTER_URI={link.address.uri}\n")
                sys.stdout.flush()
            self._uri = link.address.uri
            open_log("server", link.address.port)
            if self.options.ignition:
                start_ignition()
            plugins.load(self.words)
            log.info("Waiting for master.")
            log_link(link)
            plugins.init()
            problems.check()
            del problems
            with self._open_world() as core, keep_log(self.options, core, self._play) as control:
                self._loop(core, control)

    def _interrupted(self, _number: int) -> None:
        self._stopped = True

    def _open_world(self) -> World:
        options = self.options
        if options.play is not None:
            return self._open_log(options.play)
        if len(options.rest) > 1:
            log.warning("only the first world is run: %s", options.rest[0])
        path = _find_world(options.rest[0] if options.rest else EMPTY_WORLD)
        if options.physics != "ode":
            log.error("Unregistered physics engine [%s], the default will be used instead.", options.physics)
        seed = os.getpid() if options.seed is None else options.seed
        gzlog(f"Loading world file [{path}]")
        core = self._watchdog.world = World(self._server_id(), seed=seed, strict=options.strict)
        try:
            with self._watchdog.loading(), show_loading(Path(path), core):
                core.LoadFile(path, self.options.arguments)
            if options.pause:
                core.starts_paused = True
            if core.sdf is not None:
                self._choose_profile(attach(core).world)
            if self._ros is not None:
                self._ros.attach(core)
            core.Initialize()
        except BaseException:
            self._watchdog.close()
            raise
        return core

    def _server_id(self) -> int | None:
        """The id of the command line, else a free one of those that legacy servers seldom use, for viewers.

        None if no id is free.
        """
        if self.options.server_id is not None:
            return int(self.options.server_id)
        logging.getLogger("libgz.transport").setLevel(logging.INFO)  # classic has no such files
        try:
            return free_server_id(FIRST_ID + os.getpid() % SPREAD)
        except ServerError as error:
            log.warning("viewers cannot see this world: %s", error)
            return None

    def _open_log(self, path: str) -> World:
        core = self._watchdog.world = World(self._server_id(), strict=self.options.strict)
        from libgz.classic.log.play import LogPlay

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
        """Step until a signal, World.Stop, or the number of iterations ends the run."""
        server = next((c for c in core.companions if isinstance(c, WorldServer)), None)
        with (
            record_videos(core, self.options.videos) as recorders,
            record_mcap(core, self.options) as capture,
            SnapshotControl(core, self.options.rewind, self.options.watch_only) as snapshots,
            self._window(core, server),
        ):
            self._steps(core, control, server, snapshots, [*recorders, *([capture] if capture is not None else [])])
        # Not errors of the world, whose lock is not held: a plugin may wait for its threads here, which use the world.
        problems = Problems(lambda: True, self.options.strict, warnings=False)
        core.events["Stop"]()
        if self._stopped:
            core.events["SigInt"]()
        problems.check()

    def _window(self, core: World, server: WorldServer | None) -> contextlib.AbstractContextManager[object]:
        """What shows the world: for `gazebo` a client if there are plugins for it, else the viewer if it is wanted."""
        if self.options.with_client:
            from libgz.apps.client_process import ClientProcess, client_words, wants_client

            if wants_client(self.options, server.element if server is not None else None):
                return ClientProcess(client_words(self.options), self._uri, self._client_ended)
        return view_process(self.options, core.server_id)

    def _client_ended(self) -> None:
        self._stopped = True

    def _steps(
        self,
        core: World,
        control: PlaybackControl | None,
        server: WorldServer | None,
        snapshots: SnapshotControl,
        recorders: Sequence[Capture | VideoRecorder],
    ) -> None:
        pacer, done = Pacer(core.simSpeed), 0
        while not self._over(server, done):
            watched = self._play is not None or control is not None or recorders or snapshots.follows
            done += self._step(core, control, 1 if watched else self._most(done), pacer)
            for recorder in recorders:
                recorder.take()
            if snapshots.act() or pacer.speed != core.simSpeed:
                pacer = Pacer(core.simSpeed)
            self._wait(core, server, done, pacer)

    def _wait(self, core: World, server: WorldServer | None, done: int, pacer: Pacer) -> None:
        """Sleep until the next step is due; after a second, a message makes it due: it may set the rate."""
        begin = time.monotonic()
        while not self._over(server, done) and not pacer.sleep(core.GetSimTime() + core.GetPauseTime()):
            if core.lock.wanted.value and time.monotonic() > begin + LONGEST_WAIT:
                break

    def _step(self, core: World, control: PlaybackControl | None, most: int, pacer: Pacer) -> int:
        """One step, or more where nothing has to be done between them; how many iterations, 0 while it is paused."""
        core.lock.wanted.value = 0  # what comes from now on is not handled in this step
        if control is not None:
            control.update()
        if self._play is not None and not core.paused:
            return int(self._play.Step())
        return core.step_on(most, pacer) - int(core.paused)

    def _most(self, done: int) -> int:
        """How many iterations may follow each other, after a number of them."""
        return MOST_STEPS if self.options.iters is None else self.options.iters - done

    def _over(self, server: WorldServer | None, done: int) -> bool:
        limit = self.options.iters
        enough = limit is not None and (done >= limit or (self._play is not None and self._play.at_end))
        return self._stopped or (server is not None and server.stopped) or enough


def _find_world(name: str) -> Path:
    try:
        return find_world(name)
    except NotFoundError as error:
        if not name:
            raise NotFoundError("Could not open file[]: the name is empty") from None
        found = find_worldfile(name)  # a legacy world, or one of libgz by its name
        if is_file(found):
            return found
        if found.is_dir():
            raise NotFoundError(f"Could not open file[{name}]: it is a folder") from None
        names = [world.name for world in ready_worlds()]
        near = nearest(Path(name).name.removesuffix(".world"), names)
        raise NotFoundError(f"Could not open file[{name}]: {error}{near}") from None


@as_command("gzserver", failed=FAILED)
def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, also after SIGINT or SIGTERM; 3 ended by --strict; 255 failed.

    After a SIGINT or SIGTERM before the world runs, and after a second one, 130 or 143.
    """
    return _run(arguments)


@as_command("gazebo", failed=FAILED)
def main_of_gazebo(arguments: Sequence[str] | None = None) -> int:
    """The command gazebo of Gazebo 1 to 11: the same with a page, or a client if there are plugins for it."""
    return _run(arguments, with_client=True)


def _run(arguments: Sequence[str] | None, *, with_client: bool = False) -> int:
    given, videos = split_videos(list(sys.argv[1:] if arguments is None else arguments))
    plugins = ("server_plugin", "gui_plugin") if with_client else ("server_plugin",)
    words, options = read_command_line(make_parser(), given, plugins=plugins)
    options.videos, options.with_client, options.view = videos, with_client, options.view or with_client
    warn_without_effect(options)
    try:
        with confined("gzserver", options):
            return Server(options, words).run()
    except GazeboError as error:
        log.error("%s", error)
        strict = options.strict and isinstance(error, StrictError | PluginError | WorldFileError)
        return STRICT if strict else FAILED


if __name__ == "__main__":
    sys.exit(main())
