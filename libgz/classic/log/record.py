"""LogRecord: writes a log of a world as it runs."""

from __future__ import annotations

import fnmatch
import logging
import os
import re
import time
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from libgz.classic.log.file import LogWriter
from libgz.classic.log.state import LogState
from libgz.classic.physics.light import Light
from libgz.classic.physics.state import world_text
from libgz.classic.physics.world import World
from libgz.classic.server import attach
from libgz.errors import ParameterError, WorldFileError
from libgz.geometry import GzPose, GzVector
from libgz.sdf.upgrade import NEWEST, upgraded

if TYPE_CHECKING:
    from libgz.classic.physics.model import Model
    from libgz.simulation.entity import Entity as CoreModel
    from libgz.simulation.world import World as CoreWorld

__all__ = ["LogRecord", "NamePattern", "default_log_path"]

log = logging.getLogger("libgz.classic")

_SLACK = 1e-9  # [s]; sums of step times are off by less


def default_log_path() -> Path:
    """Where logs go: ``<GAZEBO_LOG_PATH or ~/.gazebo>/log/<date and time>/gzserver/state.log``."""
    folder = Path(os.environ.get("GAZEBO_LOG_PATH") or "~/.gazebo").expanduser()
    now = time.time()
    stamp = time.strftime("%Y-%m-%dT%H:%M:%S", time.localtime(now)) + f".{int(now % 1.0 * 1e6):06d}"
    return folder / "log" / stamp / "gzserver" / "state.log"


class LogRecord:
    """Records a running SDF world from now on, until `Stop` or the world's end; a context manager.

        with World.from_file("x.world") as world, LogRecord(world, "run/state.log", period=0.01):
            world.run(5.0)

    A state tells of the links and lights that moved since the last one; the first tells of all.

    Args:
        world: the engine's world, or the view on it that plugins have.
        path: of the file; by default `default_log_path`.
        period: least sim time between two states [s]; 0: each iteration.
        encoding: zlib, bz2 or txt.
        filter: of models by name, as a pattern with ``*`` or a regular expression; empty: all.

    Attributes:
        path: of the file.

    Raises:
        ParameterError: an argument is not allowed.
        WorldFileError: the file cannot be written, or the world was not made from SDF.
    """

    def __init__(
        self,
        world: CoreWorld | World,
        path: str | os.PathLike[str] | None = None,
        *,
        period: float = 0.0,
        encoding: str = "zlib",
        filter: str = "",
    ) -> None:
        self._core = world.core if isinstance(world, World) else world
        if not period >= 0.0:
            raise ParameterError(f"bad log period {period!r} s; it must be 0 or more")
        self._wanted = NamePattern(filter)
        self._world = attach(self._core).world
        self.path = Path(path) if path is not None else default_log_path()
        first = world_text(self._world, self.path.parent)
        self._period, self._due = period, self._core.GetSimTime() + period
        self._last = self._core.iterations
        self._known: dict[str, tuple[GzPose, GzVector, GzVector]] = {}
        self._insertions: list[str] = []
        self._deletions: list[str] = []
        self._new: list[CoreModel] = []
        self._writer: LogWriter | None = LogWriter(self.path, encoding, self._core.seed)
        self._writer.add(first)
        self._add_state()
        self._core.companions = [*self._core.companions, self]  # a list of its own: see Stop

    @property
    def running(self) -> bool:
        """Whether it goes on."""
        return self._writer is not None

    def Stop(self) -> None:
        """Write the end. Can be called twice."""
        writer, self._writer = self._writer, None
        # A list of its own: the world may be going through the other one.
        self._core.companions = [companion for companion in self._core.companions if companion is not self]
        if writer is not None:
            try:
                writer.close()
            except WorldFileError as error:
                log.error("%s", error)

    def __enter__(self) -> LogRecord:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.Stop()

    # States ------------------------------------------------------------------------------------------------------

    def _add_state(self) -> None:
        """Write what has changed; the run goes on without a log where that fails."""
        core, writer = self._core, self._writer
        if writer is None:
            return
        self._tell_new()
        state = LogState(core.GetSimTime(), core.GetRealTime(), time.time(), core.iterations, world=core.name)
        state.insertions, self._insertions = self._insertions, []
        state.deletions, self._deletions = self._deletions, []
        for model in self._world.all_models():
            if self._wanted(model.GetScopedName()):
                self._add_model(model, state)
        for light in self._world.Lights():
            self._add_light(light, state)
        try:
            writer.add(state.text(NEWEST))
        except WorldFileError as error:
            log.error("%s; it ends here", error)
            self.Stop()

    def _add_model(self, model: Model, state: LogState) -> None:
        for link in model.GetLinks():
            name, body = link.GetScopedName(), link.body
            now = body.GetPose(), body.GetLinearVel(), body.GetAngularRate()
            if self._known.get(name) != now:
                self._known[name] = now
                state.poses[name], state.velocities[name] = now[0], now[1:]

    def _add_light(self, light: Light, state: LogState) -> None:
        name, pose = light.GetName(), light.pose()
        if self._known.get(name, (None,))[0] != pose:
            self._known[name] = pose, GzVector(), GzVector()
            state.poses[name] = pose

    def _tell_new(self) -> None:
        """Models and lights that have come, as they are now; those that came and went are not told."""
        new, self._new = self._new, []
        for core in new:
            if core not in self._core.entities or core.parent is not None:
                continue
            part = next((p for p in self._world.children() if getattr(p, "core", None) is core), None)
            sdf = part.GetSDF() if part is not None else None
            if part is not None and sdf is not None and (isinstance(part, Light) or self._wanted(part.GetName())):
                self._insertions.append(upgraded(sdf, self.path.parent).ToString())

    # Companion of the world --------------------------------------------------------------------------------------

    def start(self) -> None:
        """The world runs already."""

    def model_added(self, model: CoreModel) -> None:
        """It is told with the next state."""
        self._new.append(model)

    def model_removed(self, model: CoreModel) -> None:
        """The next state tells that it is gone."""
        if model in self._new:
            self._new.remove(model)
            return
        name = model.GetId()
        self._known = {key: v for key, v in self._known.items() if key != name and not key.startswith(f"{name}::")}
        if model.parent is None:
            self._deletions.append(name)

    def update(self) -> None:
        """States are those after a step."""

    def step(self, paused: bool) -> None:
        """Write a state if it is time."""
        now = self._core.GetSimTime()
        if paused or now < self._due - _SLACK or self._core.iterations == self._last:
            return
        self._due, self._last = now + self._period, self._core.iterations
        self._add_state()

    def reset(self) -> None:
        """Times begin anew."""
        self._due = -float("inf")

    def close(self) -> None:
        """The world ends."""
        self.Stop()


class NamePattern:
    """Whether a model's name is wanted: by its whole scoped name, or that of a model around it."""

    def __init__(self, words: str) -> None:
        self._words = words
        try:
            self._regular: re.Pattern[str] | None = re.compile(words)
        except re.error:
            self._regular = None

    def __call__(self, name: str) -> bool:
        """Whether a scoped name is."""
        scopes = name.split("::")
        return not self._words or any(self._fits("::".join(scopes[: i + 1])) for i in range(len(scopes)))

    def _fits(self, name: str) -> bool:
        regular = self._regular is not None and self._regular.fullmatch(name) is not None
        return regular or fnmatch.fnmatchcase(name, self._words)
