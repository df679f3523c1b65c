"""Shared by gazebo and gzserver: answers to `libgz snapshot`, and the option --rewind."""

from __future__ import annotations

import argparse
import logging
from types import TracebackType
from typing import TYPE_CHECKING

from libgz.apps.console import number_above_zero
from libgz.base.errors import GazeboError, PluginError, ServerError
from libgz.front import World
from libgz.transport.control import Control, Request
from libgz.transport.server import Server
from libgz.transport.tally import Tally

if TYPE_CHECKING:
    from libgz.apps.world_control import WorldControl

__all__ = ["SnapshotControl", "add_rewind_option"]

log = logging.getLogger("libgz.gazebo")
worlds_log = logging.getLogger("libgz.simulation")

RESTORING = {"restore": False, "restore_untrusted": True}  # requests: whether the state is of strangers


def add_rewind_option(parser: argparse.ArgumentParser) -> None:
    """Add --rewind."""
    parser.add_argument(
        "--rewind",
        type=number_above_zero("number of seconds"),
        metavar="SEC",
        help="keep the states of the last seconds of sim time, for `libgz snapshot rewind`",
    )


class SnapshotControl:
    """Saves, restores, rewinds and controls a world that runs, when other processes ask for it.

    Args:
        world: it is initialized.
        rewind: how many seconds of sim time are kept for rewinding [s]; None for none.
        watch_only: refuse what changes the world.
    """

    def __init__(self, world: World, rewind: float | None = None, watch_only: bool = False) -> None:
        self.world, self._watch_only = world, watch_only
        self._requests: WorldControl | None = None
        self._control: Control | None = None
        self._failures = Tally(100)
        if rewind is not None:
            world.keep_rewind(rewind)
        if isinstance(world.gz_server, Server):
            try:
                self._control = Control(world.gz_server.path)
            except ServerError as error:
                log.warning("`libgz snapshot` cannot reach this server: %s", error)

    def __enter__(self) -> SnapshotControl:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._control is not None:
            self._control.close()

    @property
    def requests(self) -> WorldControl:
        """What answers all other requests, made for the first one: most runs get none."""
        if self._requests is None:
            from libgz.apps.world_control import WorldControl

            self._requests = WorldControl(self.world, self._watch_only)
        return self._requests

    @property
    def follows(self) -> bool:
        """Whether `act` has something to do after each step."""
        return self._requests is not None and self._requests.follows

    @property
    def speed(self) -> float | None:
        """Simulated seconds per second of real time that was asked for; None before that."""
        return self._requests.speed if self._requests is not None else None

    def act(self) -> bool:
        """Answer what was asked for, after each step; whether that set another time, from which pacing begins anew."""
        if self._requests is not None:
            self._requests.stepped()
        if self._control is None or not self._control.waiting:
            return False
        before = self._time()
        while self._control.waiting:
            self._answer(self._control.waiting.popleft())
        return self._time() != before

    def _time(self) -> float:
        return self.world.GetSimTime() + self.world.GetPauseTime()

    def _answer(self, request: Request) -> None:
        try:
            request.answer(self._obey(request))
        except PluginError as error:
            request.answer(error=str(error))
            with self.world.lock:  # an error of this world, which ends a strict one
                worlds_log.error("%s: %s", request.verb, error)
        except GazeboError as error:
            request.answer(error=str(error))
        except Exception as error:
            kind = type(error).__name__
            if self._failures.due((request.verb, kind)):
                log.exception("request %r failed%s", request.verb, self._failures.times((request.verb, kind)))
            request.answer(error=f"the request failed, see the server's log: {kind}: {error}")
        except BaseException:
            request.answer(error="the server failed; its log says why")
            raise

    def _obey(self, request: Request) -> bytes:
        world = self.world
        if request.verb == "save":
            return world.get_state()
        if self._watch_only and request.verb in (*RESTORING, "rewind"):
            raise GazeboError(f"this server can only be watched (--watch-only): {request.verb} is refused")
        if request.verb in RESTORING:
            with self.requests.replaced():
                world.set_state(request.content, untrusted=RESTORING[request.verb])
        elif request.verb == "rewind":
            try:
                with self.requests.replaced():
                    world.rewind(float(request.argument))
            except ValueError as error:
                raise GazeboError(str(error)) from None
        else:
            return self.requests.obey(request)
        log.info("%s: sim time is %g s", request.verb, world.GetSimTime())
        return f"{world.GetSimTime():g}".encode()
