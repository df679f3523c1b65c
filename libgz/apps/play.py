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
from types import TracebackType
from typing import TYPE_CHECKING, Any

from libgz.apps.console import number_from_zero, whole_number
from libgz.classic.transport import serve
from libgz.errors import GazeboError, ParameterError, ServerError
from libgz.recording.capture import check_packages
from libgz.transport.control import ask
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


def _server_id(text: str) -> int | None:
    return None if text == "auto" else whole_number("server id")(text)


_server_id.__name__ = "server id"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    seconds, add = number_from_zero("number of seconds"), parser.add_argument
    add("log", nargs="?", metavar="LOG", help="a log that gazebo --mcap or gzserver --mcap recorded")
    add(
        "-s",
        dest="server_id",
        metavar="ID",
        type=_server_id,
        default=0,
        help="server id; `auto` selects a free id and prints it (default 0)",
    )
    add("-f", dest="force", action="store_true", help="take over a stale server id")
    add("--speed", type=number_from_zero("speed"), metavar="X", help="times real time; 0: as fast as possible")
    add("--from", dest="begin", type=seconds, metavar="SEC", help="begin at this time of the log [s]")
    add("--to", dest="end", type=seconds, metavar="SEC", help="end at this time of the log [s]")
    add("--loop", action="store_true", help="begin again at the end")
    add("--hold", action="store_true", help="stay at the end, paused, until interrupted")
    add("--pause", action="store_true", help="begin paused")
    add("--info", action="store_true", help="print what is in the log, and play nothing")
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
    server_id = free_server_id() if options.server_id is None else options.server_id
    speed = 1.0 if options.speed is None else options.speed
    with contextlib.ExitStack() as stack:
        topics = _topics(options.log, stack)
        player = stack.enter_context(Player(options.log, server_id, options.force, speed, topics))
        if options.server_id is None:
            print(f"server id {server_id}", flush=True)
        if not player.reader.complete:
            print(
                f"libgz: {options.log} has no end; it is played as far as it goes, {player.reader.end:g} s",
                file=sys.stderr,
            )
        player.paused = options.pause
        if options.begin is not None:
            player.seek(options.begin)
        with contextlib.suppress(KeyboardInterrupt), _Keys(player) as keys:
            for _ in player.moments(options.end, options.hold, options.loop):
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
    print(
        f"{status['path']}: {status['time']:.3f} s of {status['end']:.3f} s, speed {status['speed']:g}"
        f"{', paused' if status['paused'] else ''}"
    )
    return 0


def _print_info(path: str) -> int:
    from libgz.recording.reader import LogReader  # needs the extra `log`

    with LogReader(path) as reader:
        about = reader.about
        print(f"{path}: {reader.end - reader.begin:.3f} s" + ("" if reader.complete else ", without an end"))
        if about:
            print(f"world {about.get('world')}, {about.get('era')}, recorded by libgz {about.get('libgz')}")
        counts: dict[str, int] = {}
        for message in reader.messages():
            counts[message.channel.topic] = counts.get(message.channel.topic, 0) + 1
        width = max((len(topic) for topic in counts), default=0) + 2
        for channel in reader.channels.values():
            print(f"{channel.topic:{width}}{counts.get(channel.topic, 0):8d}  {channel.schema}")
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
            print(KEYS_HELP)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._active:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self._former)
            print()

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
