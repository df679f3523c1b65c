"""gazebo: run a worldfile and serve its interfaces to other programs, or an SDF world as Gazebo classic does."""

from __future__ import annotations

import argparse
import contextlib
import logging
import re
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from libgz._version import __version__
from libgz.apps.console import (
    MACRO_ARGUMENT,
    STRICT,
    STRICT_HELP,
    USAGE_ERROR,
    Parser,
    as_command,
    number_from_zero,
    say,
    set_up_messages,
    whole_number,
    wire_version,
)
from libgz.apps.mcap_option import add_mcap_option, record_mcap
from libgz.apps.progress import show_loading
from libgz.apps.ros_option import add_ros_options, ros_wanted, start_ros, without_ros_words
from libgz.apps.server_option import add_server_options
from libgz.apps.snapshot_control import SnapshotControl, add_rewind_option
from libgz.apps.untrusted import add_untrusted_option, confined
from libgz.apps.view_options import GL_HELP
from libgz.apps.view_process import add_view_options, view_process
from libgz.base.errors import GazeboError, NotFoundError, ParameterError, PluginError, StrictError, WorldFileError
from libgz.base.files import exists, is_file
from libgz.front import World
from libgz.ode.context import SOLVERS
from libgz.rendering.choice import CHOICES, prefer
from libgz.sdf.paths import find_world
from libgz.sdf.recognition import is_sdf
from libgz.simulation.pacing import Pacer
from libgz.simulation.watchdog import Watchdog
from libgz.transport.layout import ABIS, LIBGAZEBO_VERSION, NATIVE
from libgz.transport.server import on_free_server_id
from libgz.worldfile.search import find_worldfile, why_missing

if TYPE_CHECKING:
    from libgz.apps.record import VideoRecorder
    from libgz.recording.capture import Capture

__all__ = ["main"]

log = logging.getLogger("libgz.gazebo")

STATUS_PERIOD = 0.2  # [s] of real time
MOST_STEPS = 1000  # at a time; World.step_on ends earlier, but for worlds at rest
# Options that Gazebo 1 to 11 did not have: with one of them, an SDF world runs as a worldfile does.
CLASSIC = ("--verbose", "-g", "--gui-plugin", "--gui-client-plugin")  # without a world, they mean the empty one
LEGACY = ("-d", "-f", "-l", "-n", "-t", "--abi", "--rate", "--render-thread", "--solver", "--wire-version")
CLASSIC_HELP = (
    "An SDF world runs as with the gazebo command of Gazebo 1 to 11, with the options of gzserver and a page in the "
    "browser, and with a gzclient where -g, --gui-client-plugin, the world's <gui> or gui.ini name plugins for it, "
    f"unless one of {', '.join(LEGACY)} or -s with a number is given. Then and only then -s names System plugins."
)


def _seconds(text: str) -> float | None:
    number = float(text)
    if not abs(number) < float("inf"):
        raise ValueError
    return number if number >= 0.0 else None


_seconds.__name__ = "number of seconds"


def make_parser() -> argparse.ArgumentParser:
    """The options of Gazebo 0.7, and those of libgz."""
    parser = Parser(
        prog="gazebo",
        description="Run a worldfile and serve the interfaces of its models to other programs.",
        epilog=CLASSIC_HELP,
    )
    add = parser.add_argument
    add("worldfile", help="the worldfile to run, or the name of a world of libgz, which `libgz worlds` lists")
    add_server_options(parser)
    add(
        "-d",
        dest="level",
        metavar="LEVEL",
        type=int,
        choices=range(-1, 10),
        default=1,
        help="message level, -1 none to 9 all (default 1); errors and warnings are always printed",
    )
    add(
        "-t",
        dest="seconds",
        metavar="SEC",
        type=_seconds,
        default=None,
        help="quit after a real time [s]; negative: never (default)",
    )
    add("-l", dest="logfile", metavar="FILE", help="also write all messages to a file")
    add("-n", dest="free", action="store_true", help="run as fast as possible, like --rate 0")
    add("-u", "--pause", action="store_true", help="start paused")
    add("-v", "--version", action="version", version=f"gazebo (libgz) {__version__}")
    add(
        "--rate",
        type=number_from_zero("rate"),
        default=None,
        metavar="R",
        help="simulated seconds per second of real time, 0 for as fast as possible (default: the world's speed)",
    )
    add(
        "--seed",
        type=whole_number("whole number from 0"),
        default=0,
        metavar="N",
        help="seed of all random numbers (default 0)",
    )
    add(
        "--wire-version",
        type=wire_version,
        default=LIBGAZEBO_VERSION,
        metavar="V",
        help="version of the interfaces: 0x060 (default), or 0x050 for clients of Gazebo 0.5 and Player 1.6.5",
    )
    add(
        "--abi",
        choices=ABIS,
        default=NATIVE,
        help="of the client programs: x86_64, those of this machine (default), or i386, 32-bit ones",
    )
    add(
        "--gl",
        choices=CHOICES,
        default=None,
        help=GL_HELP,
    )
    add(
        "--render-thread",
        action="store_true",
        help="render robots' cameras in a separate thread: the same images, served up to one camera period later",
    )
    add(
        "--record",
        action="append",
        default=[],
        metavar="ID=FILE",
        help="record a camera's images to a video file, or with view=FILE those of the whole world; may be repeated",
    )
    add_mcap_option(parser)
    add(
        "--shadows",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="videos show shadows (default), which clients' images do not",
    )
    add(
        "--solver",
        choices=SOLVERS,
        default="world",
        help="solver: world, ODE's exact one (default), quick, its iterative one, which holds stacks, or tree, "
        "exact and quicker for robots with many joints",
    )
    add("--strict", action="store_true", help=STRICT_HELP)
    add_untrusted_option(parser)
    parser.add_macro_arguments()
    add_rewind_option(parser)
    add_ros_options(parser)
    add_view_options(parser, optional=True)
    add("--steps", type=int, default=None, metavar="N", help="quit after a number of steps")
    return parser


class Run:
    """One run of a world: the loop, its end conditions, and the status line."""

    def __init__(self, options: argparse.Namespace) -> None:
        self.options = options
        self.steps: int | None = options.steps
        self.deadline: float | None = None
        self.stopped = False
        self.recorders: list[VideoRecorder] = []
        self.control: SnapshotControl | None = None
        self.capture: Capture | None = None
        self._next_status = 0.0 if sys.stdout.isatty() else float("inf")

    def stop(self, number: int) -> None:
        """Stop after the present step, because of a signal."""
        self.stopped = True
        log.info("ending: %s", signal.Signals(number).name)

    def loop(self, world: World) -> None:
        """Step until a signal, the time, or the number of steps ends the run."""
        options, done = self.options, 0
        if options.seconds is not None:
            self.deadline = time.monotonic() + options.seconds
        pacer = Pacer(0.0 if options.free else world.simSpeed if options.rate is None else options.rate)
        while not self.over(done):
            done += world.step_on(self._most(done), pacer)
            for recorder in self.recorders:
                recorder.take()
            if self.capture is not None:
                self.capture.take()
            if self.control is not None:
                moved, speed = self.control.act(), self.control.speed
                if moved or speed not in (None, pacer.speed):
                    pacer = Pacer(pacer.speed if speed is None else speed)
            while not self.over(done) and not pacer.sleep(world.GetSimTime() + world.GetPauseTime()):
                pass
            if self._next_status <= time.monotonic():
                self.print_status(world)
        if sys.stdout.isatty():
            self.print_status(world)
            say()

    def _most(self, done: int) -> int:
        """How many steps may follow each other, after a number of steps, without anything to do between them."""
        if self.recorders or self.capture is not None or (self.control is not None and self.control.follows):
            return 1
        return MOST_STEPS if self.steps is None else self.steps - done

    def over(self, done: int) -> bool:
        """Whether to stop, after a number of steps."""
        late = self.deadline is not None and time.monotonic() >= self.deadline
        return self.stopped or late or (self.steps is not None and done >= self.steps)

    def print_status(self, world: World) -> None:
        """Print real, sim and pause time, their ratio, and the processor load, over the previous status line."""
        self._next_status = time.monotonic() + STATUS_PERIOD
        real, simulated, paused = world.GetRealTime(), world.GetSimTime(), world.GetPauseTime()
        ratio, busy = (simulated + paused) / max(real, 1e-9), time.process_time()
        share = 100.0 * busy / max(real, 1e-9)
        line = f"Time {real:.3f} {simulated:.3f} {paused:.3f} [{ratio:.3f}] {busy:.3f} [{share:3.0f}%]"
        sys.stdout.write(f"\r{line} ")
        sys.stdout.flush()


def _is_classic(words: Sequence[str]) -> bool:
    """Whether a command line is one of Gazebo 1 to 11: for an SDF world, or no world but such options."""
    options = {word.partition("=")[0] if word.startswith("--") else word[:2] for word in words if word[:1] == "-"}
    ids = re.findall(r"(?m)^-s\n?(?:\d+|auto)$", "\n".join(words))
    if ids or options & {*LEGACY, "-h", "--help"}:
        return False
    worlds = [path for word in words if word[:1] != "-" and (path := _world_file(word)) is not None]
    return all(map(is_sdf, worlds)) if worlds else not options.isdisjoint(CLASSIC)


def _world_file(name: str) -> Path | None:
    """The file that a word of the command line means to one of the eras, if it is one."""
    for find in (find_worldfile, find_world):
        with contextlib.suppress(WorldFileError, NotFoundError):
            if is_file(path := Path(find(name))):
                return path
    return None


@as_command("gazebo")
def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, 1 the world cannot run, 2 the command line is wrong, 3 ended by --strict.

    After a SIGINT or SIGTERM before the world runs, and after a second one, 130 or 143.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    if _is_classic(words):
        from libgz.apps.gzserver import main_of_gazebo  # it loads all of classic

        return main_of_gazebo(words)
    parser = make_parser()
    own = without_ros_words(words)
    names = [word for word in own if ":=" in word and MACRO_ARGUMENT.fullmatch(word) is None]
    options = parser.parse_args([word for word in own if word not in names])
    options.words = ["gazebo", *words]
    if names and not ros_wanted(options):
        parser.error(f"{names[0]!r} is a name for ROS, which needs --ros1 or --ros2")
    try:
        set_up_messages(options.level, options.logfile)
    except ParameterError as error:
        return _report(str(error), USAGE_ERROR)
    if options.steps is not None and options.steps < 0:
        return _report(f"--steps is {options.steps}; it must not be negative", USAGE_ERROR)
    try:
        path = find_worldfile(options.worldfile)
    except WorldFileError as error:
        return _report(str(error), USAGE_ERROR)
    if not is_file(path):
        missing = f"does not exist{why_missing(path)}"
        what = "is a directory" if path.is_dir() else "is not a plain file" if exists(path) else missing
        return _report(f"worldfile {str(path)!r} {what}", USAGE_ERROR)
    try:
        with confined("gazebo", options):
            return _run(path, options)
    except GazeboError as error:
        strict = options.strict and isinstance(error, StrictError | PluginError | WorldFileError)
        return _report(str(error), STRICT if strict else 1)


def _run(path: Path, options: argparse.Namespace) -> int:
    if options.gl is not None:
        prefer(options.gl)
    if options.server_id is not None:
        return _serve(path, options, options.server_id)
    return on_free_server_id(lambda server_id: _serve(path, options, server_id))


def _serve(path: Path, options: argparse.Namespace, server_id: int) -> int:
    run = Run(options)
    with Watchdog(run.stop) as watchdog, start_ros(options, options.words, watchdog) as ros:
        watchdog.world = world = World(
            server_id,
            options.force,
            seed=options.seed,
            wire_version=options.wire_version,
            abi=options.abi,
            solver=options.solver,
            strict=options.strict,
        )
        try:
            world.backdrop.threaded = options.render_thread
            with watchdog.loading(), show_loading(path, world):
                world.LoadFile(path, options.arguments)
            world.starts_paused = world.starts_paused or options.pause
            if ros is not None:
                ros.attach(world)
            world.Initialize()
            if options.record:
                from libgz.apps.record import new_recorder  # it needs OpenGL, which other runs may do without

                run.recorders += [new_recorder(world, request, shadows=options.shadows) for request in options.record]
            if options.server_id is None:
                say(f"server id {server_id}", flush=True)
            with (
                record_mcap(world, options) as run.capture,
                SnapshotControl(world, options.rewind) as run.control,
                view_process(options, server_id),
            ):
                run.loop(world)
        finally:
            try:
                for recorder in run.recorders:
                    recorder.close()
            finally:
                watchdog.close()
    return 0


def _report(message: str, code: int) -> int:
    for line in message.splitlines():
        log.error("%s", line)
    return code


if __name__ == "__main__":
    sys.exit(main())
