"""libgz play: serve a log as its server did, or control one that is being played."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import select
import sys
import termios
import tty
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from libgz.apps.console import number_above_zero, number_from_zero, say, whole_number
from libgz.apps.server_option import add_server_options
from libgz.apps.untrusted import add_untrusted_option
from libgz.apps.view import make_viewer
from libgz.apps.view_process import add_view_options, view_process
from libgz.base.errors import GazeboError, ParameterError, ServerError
from libgz.base.files import write_whole
from libgz.base.visible import one_line, visible
from libgz.classic.transport import serve
from libgz.recording.capture import check_packages
from libgz.transport.control import ask
from libgz.transport.observer import Observer
from libgz.transport.server import free_server_id

if TYPE_CHECKING:  # needs the extra `log`
    from libgz.recording.player import Player


__all__ = ["configure", "run"]

KEYS_HELP = "keys: space pauses and continues, left and right go 1 s back and on, + and - change the speed, q ends"
# Bytes of a key -> what it does.
KEYS = {
    b" ": "pause",
    b"\x1b[D": "back",
    b"\x1b[C": "on",
    b"+": "faster",
    b"=": "faster",
    b"-": "slower",
    b".": "step",
    b"q": "quit",
    b"0": "start",
}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    seconds, add = number_from_zero("number of seconds"), parser.add_argument
    add("log", nargs="?", metavar="LOG", help="a log that gazebo --mcap or gzserver --mcap recorded")
    add_server_options(parser)
    add("--speed", type=number_from_zero("speed"), metavar="X", help="times real time; 0: as fast as possible")
    add("--from", dest="begin", type=seconds, metavar="SEC", help="begin at this time of the log [s]")
    add("--to", dest="end", type=seconds, metavar="SEC", help="end at this time of the log [s]")
    add("--loop", action="store_true", help="begin again at the end")
    add("--hold", action="store_true", help="stay at the end, paused, until interrupted; --view does, too")
    add("--pause", action="store_true", help="begin paused")
    add("--info", action="store_true", help="print what is in the log, and play nothing")
    add_view_options(parser, optional=True)
    page = parser.add_argument_group("a page instead of a server")
    page.add_argument("--html", metavar="FILE", help="write the replay as one file that any browser shows, and exit")
    page.add_argument(
        "--frames", type=number_above_zero("rate"), default=20.0, metavar="R", help="its frames per second (default 20)"
    )
    page.add_argument(
        "--show",
        action="append",
        default=[],
        choices=("lasers", "sonars", "frusta", "joints", "masses", "boxes", "trails"),
        help="show these, too, frusta with the images of the cameras; may be repeated",
    )
    group = parser.add_argument_group("control of a log that another process plays, without LOG")
    group.add_argument("--seek", type=seconds, metavar="SEC", help="go to this time of the log [s]")
    group.add_argument("--resume", action="store_true", help="continue")
    group.add_argument("--step", type=whole_number("number of steps"), metavar="N", help="play N moments, then pause")
    group.add_argument("--status", action="store_true", help="print where it is")
    parser.epilog = KEYS_HELP


def run(options: argparse.Namespace) -> int:
    """Play a log, or control one.

    Raises:
        ParameterError: the command line is incomplete, or the file is no log of libgz.
        LibraryError: a package of the extra [log] is not installed.
        ServerError: the server id is in use; or there is no server to control.
    """
    if options.log is None:
        return _control(options)
    check_packages()
    from libgz.recording.player import Player  # needs the extra `log`

    if options.info:
        return _print_info(options.log)
    if options.html is not None:
        return _write_page(options)
    server_id = free_server_id() if options.server_id is None else options.server_id
    speed = 1.0 if options.speed is None else options.speed
    with contextlib.ExitStack() as stack:
        topics = _topics(options.log, stack)
        player = stack.enter_context(Player(options.log, server_id, options.force, speed, topics))
        if options.server_id is None:
            say(f"server id {server_id}", flush=True)
        if not player.reader.complete:
            say(
                f"libgz: {options.log} has no end; it is played as far as it goes, {player.reader.end:g} s",
                file=sys.stderr,
            )
        player.paused = options.pause
        if options.begin is not None:
            player.seek(options.begin)
        stack.enter_context(view_process(options, server_id))
        with contextlib.suppress(KeyboardInterrupt), _Keys(player) as keys:
            for _ in player.moments(options.end, options.hold or options.view, options.loop):
                if keys.act():
                    break
    return 0


def _topics(path: str, stack: contextlib.ExitStack) -> Any:
    """What publishes the topics of a classic world; None if the log has none."""
    from libgz.recording.reader import LogReader  # needs the extra `log`

    with LogReader(path) as reader:
        if not any(channel.kind == "topic" for channel in reader.channels.values()):
            return None
        world = reader.about.get("world", "default")
    from libgz.recording.topic_player import TopicPlayer  # legacy worlds have no topics

    stack.enter_context(serve())
    return TopicPlayer(world)


def _write_page(options: argparse.Namespace) -> int:
    """Show the log to a viewer, and write what that one shows."""
    from libgz.recording.own_messages import understood
    from libgz.recording.player import Player  # needs the extra `log`

    speed = options.speed or 1.0
    server_id, out = free_server_id(), Path(options.html)
    with contextlib.ExitStack() as stack:
        player = stack.enter_context(Player(options.log, server_id))
        observer = stack.enter_context(Observer(server_id))
        from libgz.view.server import ServerControls  # loads what only pages need

        controls = ServerControls(server_id, frozenset())
        stack.callback(controls.close)
        viewer = stack.enter_context(make_viewer(observer, _LogControls(player, controls), options, wait=True))
        from libgz.view.replay import replay_page  # the extra is there

        title = visible(f"{player.reader.about.get('world', 'default')} - {out.stem}")
        with understood("a scene"):  # by what shows it
            text = replay_page(viewer, _moments(player, options, speed), title, options.show)
    try:
        write_whole(out, text.encode())
    except OSError as error:
        raise ParameterError(f"{options.html!r} cannot be written: {error.strerror}") from None
    say(f"{out}: {len(text) / 1e6:.1f} MB")
    return 0


class _LogControls:
    """Controls of a log that is written as a page: what sensors measured, and nothing to act with."""

    abilities = frozenset({"readings"})

    def __init__(self, player: Player, served: Any) -> None:
        self._player, self._served = player, served

    def ask(self, _verb: str, _argument: str = "-", **content: Any) -> Any:
        """Last images and ranges."""
        return self._player.readings.answer(content["names"])

    def interface(self, kind: str, id: str) -> Any:
        """An open interface of the log's server.

        Raises:
            GazeboError: there is none.
        """
        return self._served.interface(kind, id)

    def reconnect(self) -> None:
        """Nothing to do: a log does not come back."""


def _moments(player: Player, options: argparse.Namespace, speed: float) -> Iterator[float]:
    """Play the log in frames; the real time of each in the page [s]."""
    begin = player.reader.begin if options.begin is None else options.begin
    end = player.reader.end if options.end is None else min(options.end, player.reader.end)
    player.seek(begin)
    begin, count = player.time, 0
    yield 0.0
    while player.time < end - 1e-9 and not player.at_end:
        count += 1
        target = min(begin + count * speed / options.frames, end)
        while player.time < target - 1e-9 and player.step():
            pass
        yield (player.time - begin) / speed


# Control ------------------------------------------------------------------------------------------------------------


def _control(options: argparse.Namespace) -> int:
    requests = [
        *([("seek", str(options.seek))] if options.seek is not None else []),
        *([("speed", str(options.speed))] if options.speed is not None else []),
        *([("step", str(options.step))] if options.step is not None else []),
        *([("pause", "-")] if options.pause else []),
        *([("resume", "-")] if options.resume else []),
    ]
    if not requests and not options.status:
        raise ParameterError("no log is given; without one, --seek, --speed, --pause, --resume, --step or --status is")
    if options.server_id is None:
        raise ParameterError("-s auto is for a log to play; name the server to control")
    status: dict[str, Any] = {}
    for verb, argument in [*requests, ("status", "-")]:
        status = json.loads(ask(options.server_id, verb, argument))
    if not isinstance(status, dict):
        raise ServerError(f"server {options.server_id} plays no log")
    paused = ", paused" if status["paused"] else ""
    place = f"{status['time']:.3f} s of {status['end']:.3f} s, speed {status['speed']:g}"
    say(f"{status['path']}: {place}{paused}")
    return 0


def _print_info(path: str) -> int:
    from libgz.recording.reader import LogReader  # needs the extra `log`

    with LogReader(path) as reader:
        about = reader.about
        end = "" if reader.complete else ", without an end"
        say(f"{path}: {reader.end - reader.begin:.3f} s{end}")
        if about:
            text = f"world {about.get('world')}, {about.get('era')}, recorded by libgz {about.get('libgz')}"
            say(one_line(text))
        counts: dict[str, int] = {}
        for message in reader.messages():
            counts[message.channel.topic] = counts.get(message.channel.topic, 0) + 1
        width = max((len(topic) for topic in counts), default=0) + 2
        for channel in reader.channels.values():
            say(one_line(f"{channel.topic:{width}}{counts.get(channel.topic, 0):8d}  {channel.schema}"))
    return 0


class _Keys:
    """Keys of the terminal, and a status line on it; without a terminal nothing."""

    def __init__(self, player: Player) -> None:
        self._player = player
        self._active = sys.stdin.isatty() and sys.stdout.isatty()
        self._former: list[Any] = []
        self._shown = -1.0

    def __enter__(self) -> _Keys:
        if self._active:
            self._former = termios.tcgetattr(sys.stdin)
            tty.setcbreak(sys.stdin)
            say(KEYS_HELP)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._active:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._former)
            say()

    def _pressed(self) -> Iterator[str]:
        while select.select([sys.stdin], [], [], 0.0)[0]:
            data = os.read(sys.stdin.fileno(), 16)
            if not data:
                return
            yield KEYS.get(data, "")

    def act(self) -> bool:
        """Obey the keys that were pressed, and show where the log is; whether to end."""
        if not self._active:
            return False
        player = self._player
        for action in self._pressed():
            if action == "quit":
                return True
            if action == "pause":
                player.paused = not player.paused
            elif action in ("back", "on", "start"):
                player.seek({"back": player.time - 1.0, "on": player.time + 1.0, "start": 0.0}[action])
            elif action in ("faster", "slower"):
                player.speed *= 2.0 if action == "faster" else 0.5
            elif action == "step":
                with contextlib.suppress(GazeboError):
                    player.paused = True
                    player.step()
            self._shown = -1.0
        if abs(player.time - self._shown) >= 0.1:
            self._shown = player.time
            state = "paused" if player.paused else f"x {player.speed:g}"
            sys.stdout.write(f"\r{player.time:9.2f} s of {player.reader.end:.2f} s  {state:8}")
            sys.stdout.flush()
        return False
