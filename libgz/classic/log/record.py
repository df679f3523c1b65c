"""LogRecord: records a running world."""

from __future__ import annotations

import fnmatch
import logging
import os
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType

from libgz.base.errors import ParameterError, WorldFileError
from libgz.base.geometry import GzPose, GzVector
from libgz.base.pattern import Pattern
from libgz.classic.log.file import LogWriter, log_folder
from libgz.classic.physics.light import Light
from libgz.classic.physics.model import Model
from libgz.classic.physics.state import world_text
from libgz.classic.physics.world import World
from libgz.classic.server import attach
from libgz.sdf.state import SdfState
from libgz.sdf.upgrade import NEWEST, upgraded
from libgz.simulation.companion import Stateless
from libgz.simulation.entity import Entity as CoreModel
from libgz.simulation.rate import TIME_SLACK
from libgz.simulation.world import World as CoreWorld

__all__ = ["LogRecord", "NamePattern", "default_log_path"]

log = logging.getLogger("libgz.classic")


def default_log_path() -> Path:
    """Return the default path of a log: ``<date and time>/gzserver/state.log`` in the folder of logs."""
    now = time.time()
    stamp = time.strftime("%Y-%m-%dT%H:%M:%S", time.localtime(now)) + f".{int(now % 1.0 * 1e6):06d}"
    return log_folder() / stamp / "gzserver" / "state.log"


class LogRecord(Stateless):
    """Records a running SDF world from now on, until `Stop` or the world's end; a context manager.

        with World.from_file("x.world") as world, LogRecord(world, "run/state.log", period=0.01):
            world.run(5.0)

    A state has the links and lights that moved since the previous one; the first has all.

    Args:
        world: the engine's world, or the view that plugins get.
        path: of the file; by default `default_log_path`.
        period: shortest sim time between two states [s]; 0 for each iteration.
        encoding: zlib, bz2 or txt.
        filter: names of models, as a pattern with ``*`` or a regular expression; empty for all.

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
        self.paused = False
        self.on_step: Callable[[], object] = lambda: None
        self._period, self._due = period, self._core.GetSimTime() + period
        self._last = self._core.iterations
        self._known: dict[str, tuple[GzPose, GzVector, GzVector]] = {}
        self._insertions: list[str] = []
        self._deletions: list[str] = []
        self._new: list[CoreModel] = []
        self._writer: LogWriter | None = LogWriter(self.path, encoding, self._core.seed)
        self._writer.add(first)
        self._add_state()
        self._core.companions = [*self._core.companions, self]  # a new list: see Stop

    @property
    def running(self) -> bool:
        """Whether it is recording."""
        return self._writer is not None

    def Stop(self) -> None:
        """End the log. Can be called twice."""
        writer, self._writer = self._writer, None
        # A new list: the world may be iterating over the old one.
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
        """Write the changes; if this fails, end the log, and the run continues."""
        core, writer = self._core, self._writer
        if writer is None:
            return
        self._add_new()
        state = SdfState(core.GetSimTime(), core.GetRealTime(), time.time(), core.iterations, world=core.name)
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

    def _add_model(self, model: Model, state: SdfState) -> None:
        for link in model.GetLinks():
            name, body = link.GetScopedName(), link.body
            now = body.GetPose(), body.GetLinearVel(), body.GetAngularRate()
            if self._known.get(name) != now:
                self._known[name] = now
                state.poses[name], state.velocities[name] = now[0], now[1:]

    def _add_light(self, light: Light, state: SdfState) -> None:
        name, pose = light.GetName(), light.pose()
        if self._known.get(name, (None,))[0] != pose:
            self._known[name] = pose, GzVector(), GzVector()
            state.poses[name] = pose

    def _add_new(self) -> None:
        """Add insertions of new models and lights that still exist, in their present state."""
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
        """Nothing to do: the world runs."""

    def model_added(self, model: CoreModel) -> None:
        """Add it to the next state."""
        self._new.append(model)

    def model_removed(self, model: CoreModel) -> None:
        """Add its deletion to the next state."""
        if model in self._new:
            self._new.remove(model)
            return
        name = model.GetId()
        self._known = {key: v for key, v in self._known.items() if key != name and not key.startswith(f"{name}::")}
        if model.parent is None:
            self._deletions.append(name)

    def update(self) -> None:
        """Nothing to do: states are written after a step."""

    def step(self, paused: bool) -> None:
        """Write a state if it is due."""
        self.on_step()
        now = self._core.GetSimTime()
        if paused or self.paused or now < self._due - TIME_SLACK or self._core.iterations == self._last:
            return
        self._due, self._last = now + self._period, self._core.iterations
        self._add_state()

    def reset(self) -> None:
        """Make the next state due, for the sim time restarts."""
        self._due = -float("inf")

    def close(self) -> None:
        """End the log."""
        self.Stop()


class NamePattern:
    """Selects models by scoped name; a name that matches selects the nested models, too."""

    def __init__(self, words: str) -> None:
        self._words = words
        try:
            self._regular: Pattern | None = Pattern(words)
        except ParameterError:
            self._regular = None

    def __call__(self, name: str) -> bool:
        """Whether a scoped name is selected."""
        scopes = name.split("::")
        return not self._words or any(self._fits("::".join(scopes[: i + 1])) for i in range(len(scopes)))

    def _fits(self, name: str) -> bool:
        regular = self._regular is not None and self._regular.matches(name)
        return regular or fnmatch.fnmatchcase(name, self._words)
