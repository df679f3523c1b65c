"""LogPlay: plays a log in a world."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from types import TracebackType

from lxml import etree

from libgz.base.budget import Budget
from libgz.base.errors import GazeboError, ParameterError, WorldFileError
from libgz.classic.log.file import LogReader
from libgz.classic.physics.base import Entity
from libgz.classic.physics.light import Light
from libgz.classic.physics.link import Link
from libgz.classic.physics.world import World
from libgz.classic.server import attach
from libgz.sdf.reader import SdfFile
from libgz.sdf.state import SdfState
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.companion import Stateless
from libgz.simulation.entity import Entity as CoreModel
from libgz.simulation.rate import TIME_SLACK
from libgz.simulation.world import World as CoreWorld

__all__ = ["LogPlay", "LogState", "read_states"]

log = logging.getLogger("libgz.classic")

LogState = SdfState
MOST_NAMES = 100_000  # whose parts are remembered: a log may name any number that its world has not


def read_states(reader: LogReader) -> Iterator[SdfState]:
    """Yield the states of a log, in order.

    Raises:
        WorldFileError: the log is damaged.
    """
    for document in reader.documents():
        for element in document.iterchildren("state"):
            try:
                yield SdfState.parse(element)
            except ParameterError as error:
                raise WorldFileError(f"{reader.path}: <state>: {error}") from None


class LogPlay(Stateless):
    """The world of a log; each step sets it to the next state. A context manager.

        with LogPlay("run/state.log") as play:
            while play.Step():
                print(play.world.SimTime(), play.world.ModelByName("box").WorldPose())

    The log sets all poses: there is no physics, and only Visual plugins are loaded. Sensors measure in the played
    world. Relative paths in the world start at the log's folder. At the end of the log the world pauses.

    Args:
        path: of the log.
        core: an empty world of the engine; by default a new one.

    Attributes:
        core, world: the engine's world, and the view that plugins get.
        reader: of the file.

    Raises:
        WorldFileError: the log is damaged, or has no world.
    """

    def __init__(self, path: str | os.PathLike[str], core: CoreWorld | None = None) -> None:
        self.reader = LogReader(path)
        self.core = CoreWorld() if core is None else core
        self._next: SdfState | None = None
        self._index, self._time, self._iterations = 0, 0.0, 0
        self._inserted = Budget()  # of what was inserted and not deleted since
        self._costs: dict[str, int] = {}  # of each, by its name
        self._parts: dict[str, Entity | None] = {}  # by scoped name
        try:
            self.core.extension(SdfWorld).load(self._first())
            self.core.physics_enabled = False
            self.world: World = attach(self.core).world
            self.core.companions.append(self)
            self.core.Initialize()
        except BaseException:
            self.core.close()
            raise
        self._at_start = {part.GetName(): part.GetSDF() for part in self.world.children()}
        self._span: tuple[float, float] | None = None  # [s]
        self.world.played = self.Span
        self.Rewind()

    def Span(self) -> tuple[float, float]:
        """The first and the last sim time of the log [s]; the first call reads the whole log."""
        if self._span is None:
            first, last = None, 0.0
            for state in read_states(self.reader):
                last = state.sim_time
                first = last if first is None else first
            self._span = first or 0.0, last
        return self._span

    def _first(self) -> SdfFile:
        document = next(self.reader.documents(), None)
        if document is None or document.find("world") is None:
            raise WorldFileError(f"log {self.reader.path} begins with no world")
        text = etree.tostring(document, encoding="unicode")
        return self._read(text, "world")

    def _read(self, text: str, what: str) -> SdfFile:
        """Read SDF of the log, without the plugins that could change the world."""
        file = SdfFile.from_string(text, f"{self.reader.path}: <{what}>", self.reader.path.parent)
        for element in list(file.root.find("plugin")):
            if element.parent is not None and element.parent.name != "visual":
                element.parent.RemoveChild(element)
        return file

    @property
    def at_end(self) -> bool:
        """Whether there is no further state."""
        return self._next is None

    # Playing -----------------------------------------------------------------------------------------------------

    def Step(self) -> bool:
        """Go to the next state; if there is none, pause the world and return False."""
        if self._next is None:
            self.core.paused = True
            return False
        self.core.paused = False
        self._apply_next()  # before the step: within it, models are added and removed only at its end
        self.core.step()
        if self._next is None:
            log.info("the log %s ends at %g s", self.reader.path, self.core.GetSimTime())
            self.core.paused = True
        return True

    def Seek(self, sim_time: float) -> None:
        """Go to the last state up to a sim time [s], forwards or backwards, without steps."""
        if sim_time < self.core.GetSimTime() - TIME_SLACK:
            self._rewind()
        while self._next is not None and self._next.sim_time <= sim_time + TIME_SLACK:
            self._apply_next()

    def Rewind(self) -> None:
        """Go back to the first state."""
        self._rewind()
        self._apply_next()

    def StepBack(self, count: int = 1) -> None:
        """Go back by `count` states, at most to the first one."""
        index = max(self._index - count, 1)
        self._rewind()
        while self._next is not None and self._index < index:
            self._apply_next()

    def Forward(self) -> None:
        """Go to the last state."""
        self.Seek(float("inf"))

    def _rewind(self) -> None:
        """Return to before the first state, with the models and lights of the start."""
        self._states, self._index, self._inserted = read_states(self.reader), 0, Budget()
        self._next = next(self._states, None)
        self._costs.clear()
        self._parts.clear()
        here = {part.GetName() for part in self.world.children()}
        for name in here - self._at_start.keys():
            self.world.RemoveModel(name)
        for name in self._at_start.keys() - here:
            element = self._at_start[name]
            if element is not None:
                self.world.InsertModelSDF(element)

    def _insert(self, text: str) -> None:
        before = self._inserted.used
        self._inserted.take_xml(text)
        version = file.version if (file := self.core.extension(SdfWorld).file) is not None else "1.6"
        made = self._read(f"<sdf version='{version}'>{text}</sdf>", "insertions")
        self.world.InsertModelSDF(made)
        for part in made.root.children[:1]:
            self._costs[part.Get(str, "name")] = self._inserted.used - before

    def _apply_next(self) -> None:
        state = self._next
        if state is None:
            return
        self._next = next(self._states, None)
        self._index += 1
        try:
            self._apply(state)
        except GazeboError as error:
            if str(self.reader.path) in str(error):
                raise
            raise WorldFileError(f"{self.reader.path}: state {self._index}: {error}") from error

    def _apply(self, state: SdfState) -> None:
        """Set the world to a state.

        Raises:
            GazeboError: it has something that no world can have.
        """
        for name in state.deletions:
            if self.world.BaseByName(name) is not None:
                self.world.RemoveModel(name)
                self._inserted.used -= self._costs.pop(name, 0)
        for text in state.insertions:
            self._insert(text)
        if state.deletions or state.insertions:
            self._parts.clear()
        for name, pose in state.poses.items():
            part = self._part(name)
            if isinstance(part, Link):
                part.body.SetPose(pose)
            elif isinstance(part, Light):
                part.SetWorldPose(pose)
        for name, (linear, angular) in state.velocities.items():
            part = self._part(name)
            if isinstance(part, Link):
                part.body.SetLinearVel(linear)
                part.body.SetAngularVel(angular)
        self._time, self._iterations = state.sim_time, state.iterations
        self.update()

    def _part(self, name: str) -> Entity | None:
        if name not in self._parts:
            if len(self._parts) >= MOST_NAMES:
                self._parts.clear()
            self._parts[name] = self.world.EntityByName(name)
        return self._parts[name]

    # Companion of the world --------------------------------------------------------------------------------------

    def start(self) -> None:
        """Nothing to do: the world runs."""

    def model_added(self, model: CoreModel) -> None:
        """Nothing to do: the log added it."""

    def model_removed(self, model: CoreModel) -> None:
        """Nothing to do: the log removed it."""

    def update(self) -> None:
        """Set the time and iterations of the log."""
        self.core.set_sim_time(self._time)
        self.core.clock.iterations = self._iterations

    def step(self, paused: bool) -> None:
        """Nothing to do."""

    def reset(self) -> None:
        """Go back to the first state."""
        self.Rewind()

    def close(self) -> None:
        """Stop reading."""
        self._states, self._next = iter(()), None

    def __enter__(self) -> LogPlay:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.core.close()
