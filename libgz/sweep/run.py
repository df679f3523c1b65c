"""One run of a study in this process: load, control, step, measure."""

from __future__ import annotations

import importlib.util
import inspect
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from libgz.base.errors import GazeboError, NotFoundError, ParameterError, nearest
from libgz.front import World
from libgz.study.signals import Reading, activate, reading_of, split_signal
from libgz.study.variant import Variant
from libgz.sweep.parent import end_with_parent
from libgz.sweep.study import Controller, Measure, Run, Study
from libgz.transport.server import on_free_server_id

__all__ = ["check", "function_of", "simulate"]

MOST_BEHIND = 0.1  # [s] that a world with a client program may catch up
PATIENCE = 5.0  # [s] for a client program to end after its run
SETTLING = 200  # steps until all that is measured has a value


def simulate(study: Study, run: Run, state: bytes | None, keep: Callable[[bytes], object]) -> dict[str, float]:
    """Do a run; its measures, and ``sim_time`` [s].

    Args:
        study: the study.
        run: one of its runs.
        state: of the world at `study.start`; None to run until there.
        keep: is given that state, if it was None and other runs share it.

    Raises:
        GazeboError: the world, the controller or a measure failed.
    """
    with ExitStack() as stack:
        world = stack.enter_context(_loaded(study, run))
        if study.start > 0.0 and state is None:
            world.run(study.start)
            _check_errors(world)
            keep(world.get_state())
        elif state is not None:
            world.set_state(state)
        recorder = Recorder(study, world)
        controller = stack.enter_context(_controlled(world, run))
        _run(study, world, controller, recorder)
        _check_errors(world)
        values = recorder.values(getattr(controller, "function", None))
        return {"sim_time": world.GetSimTime(), **values}


def check(study: Study) -> None:
    """Load the first run's world of each case, and find all parameters, measures and controllers.

    Raises:
        GazeboError: something is missing; the message names it.
    """
    variant = Variant(study.world)
    for run in _first_runs(study):
        with variant.load(run.changes, seed=run.seed, solver=study.solver) as world:
            Recorder(study, world).find()
    for controller in study.controllers:
        if controller.function:
            function_of(controller.function)


def _first_runs(study: Study) -> Iterator[Run]:
    each = len(study) // len(study.cases)
    return (study.run(number * each) for number in range(len(study.cases)))


def _loaded(study: Study, run: Run) -> World:
    load = partial(Variant(study.world).load, run.changes, seed=run.seed, solver=study.solver)
    served = bool(run.controller.command)
    world = on_free_server_id(lambda server_id: load(server_id=server_id)) if served else load()
    world.reseed(run.seed)  # of what is random in a process, too
    return world


def _check_errors(world: World) -> None:
    for problem in world.errors:
        raise GazeboError(str(problem))


def _run(study: Study, world: World, controller: _Driver, recorder: Recorder) -> None:
    """Step until the end, with the controller and the samples at their times."""
    step = world.engine.step_time
    end = round(study.duration / step)
    control, sample = (max(1, round(period / step)) for period in (study.period, study.sample))
    now = begin = round(world.GetSimTime() / step)
    while now < end and not controller.ended:
        if controller.period and (now - begin) % control == 0 and controller.act():
            break
        until = min(end, now + sample - now % sample) if recorder.samples else end
        if controller.period:
            until = min(until, now + control - (now - begin) % control)
        controller.step(world, until - now)
        now = until
        if now % sample == 0 and recorder.samples:
            recorder.take()
    recorder.take()
    controller.finish()


# Controllers ----------------------------------------------------------------------------------------------------------


class _Driver:
    """No controller."""

    period = False  # whether `act` is called at the study's period
    ended = False

    def act(self) -> bool:
        """Control for one period; whether the run is to end."""
        return False

    def step(self, world: World, count: int) -> None:
        """Step the world."""
        world.step(count)

    def finish(self) -> None:
        """The run is over.

        Raises:
            GazeboError: the controller failed.
        """


class _Function(_Driver):
    """A function that is called with the world, or an object of a class that is made with it."""

    period = True

    def __init__(self, world: World, spec: Controller, settings: dict[str, Any]) -> None:
        self._world = world
        found: Any = function_of(spec.function)
        is_class = inspect.isclass(found)
        self.function: Callable[[World], Any] = found(world, **settings) if is_class else partial(found, **settings)

    def act(self) -> bool:
        return self.function(self._world) is True


class _Program(_Driver):
    """A client program of the world's server."""

    def __init__(self, world: World, spec: Controller) -> None:
        names = {"server_id": str(world.server_id)}
        words = [word.replace("{server_id}", names["server_id"]) for word in spec.command]
        environment = {**os.environ, "LIBGZ_SERVER_ID": names["server_id"]}
        try:
            self._process = subprocess.Popen(
                words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, env=environment, preexec_fn=end_with_parent
            )
        except OSError as error:
            raise GazeboError(f"cannot start {words[0]!r}: {error.strerror}") from None
        self._words, self._speed, self._due = words, spec.speed, time.monotonic()

    @property
    def ended(self) -> bool:  # type: ignore[override]
        return self._process.poll() is not None

    def step(self, world: World, count: int) -> None:
        for _ in range(count):
            if self.ended:
                return
            world.Step()
            if self._speed > 0.0:
                self._due += world.engine.step_time / self._speed
                time.sleep(max(0.0, self._due - time.monotonic()))
                self._due = max(self._due, time.monotonic() - MOST_BEHIND)

    def finish(self) -> None:
        code = self._process.poll()
        if code:
            raise GazeboError(f"the program {self._words[0]!r} ended with exit code {code}")

    def close(self) -> None:
        """End the program."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()


@contextmanager
def _controlled(world: World, run: Run) -> Iterator[_Driver]:
    if run.controller.command:
        program = _Program(world, run.controller)
        try:
            yield program
        finally:
            program.close()
    elif run.controller.function:
        yield _Function(world, run.controller, run.settings)
    else:
        yield _Driver()


def function_of(text: str) -> Callable[..., Any]:
    """What ``FILE.py:NAME`` names; the file is run once in a process.

    Raises:
        GazeboError: the file cannot be run, or has nothing of this name that can be called.
    """
    path, _, name = text.rpartition(":")
    known = f"libgz_sweep_{Path(path).stem}_{abs(hash(path))}"
    module = sys.modules.get(known)
    if module is None:
        spec = importlib.util.spec_from_file_location(known, path)
        if spec is None or spec.loader is None:
            raise ParameterError(f"{path!r} is no Python file")
        module = sys.modules[known] = importlib.util.module_from_spec(spec)
        sys.path.insert(0, str(Path(path).parent))
        try:
            spec.loader.exec_module(module)
        except Exception as error:
            del sys.modules[known]
            raise GazeboError(f"{path}: {type(error).__name__}: {error}") from error
        finally:
            sys.path.pop(0)
    found = getattr(module, name, None)
    if not callable(found):
        names = [one for one, value in vars(module).items() if callable(value) and not one.startswith("_")]
        raise NotFoundError(f"{path} has no function or class {name!r}{nearest(name, names)}")
    called: Callable[..., Any] = found
    return called


# Measures -------------------------------------------------------------------------------------------------------------


class Recorder:
    """Samples what a study measures, and reduces it to one number each."""

    def __init__(self, study: Study, world: World) -> None:
        self._measures, self._world = study.measures, world
        self._taken: dict[str, list[tuple[float, float, float, float, int]]] = {}
        self._readings: dict[str, Reading] | None = None
        self._last: dict[str, float] = {}
        self._first: dict[str, float] = {}
        self._at = -1.0  # sim time of the last sample [s]
        for measure in self._measures:
            if measure.signal:
                activate(world, *split_signal(measure.signal))

    @property
    def samples(self) -> bool:
        """Whether samples during the run matter, and not only its end."""
        return any(one.signal and one.reduce != "last" for one in self._measures)

    def find(self) -> None:
        """Find all signals and functions, and step the world until all have a value.

        Raises:
            GazeboError: one is missing.
        """
        for left in range(SETTLING, -1, -1):
            try:
                self._bind()
                return
            except ParameterError:
                if not left:
                    raise
                self._world.Step()

    def _bind(self) -> dict[str, Reading]:
        if self._readings is None:
            found = {}
            for measure in self._measures:
                if measure.function:
                    function_of(measure.function)
                    continue
                reading = reading_of(self._world, *split_signal(measure.signal))
                if measure.reduce in ("last", "first") and reading.shape != (1,):
                    raise ParameterError(
                        f"measure {measure.name!r}: {measure.signal} has the shape {reading.shape}; "
                        "choose one number, such as [0], or reduce it by min, max, mean, sum or std"
                    )
                found[measure.name] = reading
            self._readings = found
        return self._readings

    def take(self) -> None:
        """Take a sample of each signal, once at a time."""
        now = self._world.GetSimTime()
        if now == self._at:
            return
        self._at = now
        for name, reading in self._bind().items():
            values = np.asarray(reading.value(), float)
            self._first.setdefault(name, float(values.flat[0]))
            self._last[name] = float(values.flat[0])
            row = (
                float(values.min()),
                float(values.max()),
                float(values.sum()),
                float(np.square(values).sum()),
                values.size,
            )
            self._taken.setdefault(name, []).append(row)

    def values(self, controller: Any) -> dict[str, float]:
        """Each measure's number; functions are called now.

        Raises:
            GazeboError: a function failed, or returned no number.
        """
        return {
            one.name: self._of_function(one, controller) if one.function else self._reduced(one)
            for one in self._measures
        }

    def _of_function(self, measure: Measure, controller: Any) -> float:
        function = function_of(measure.function)
        wanted = len(inspect.signature(function).parameters)
        value = function(*(self._world, controller)[:wanted])
        try:
            return float(value)
        except (TypeError, ValueError):
            raise GazeboError(f"measure {measure.name!r} returned {value!r}, which is no number") from None

    def _reduced(self, measure: Measure) -> float:
        if measure.reduce in ("last", "first"):
            return (self._last if measure.reduce == "last" else self._first)[measure.name]
        columns: list[tuple[float, ...]] = list(zip(*self._taken[measure.name], strict=True))
        low, high, total, squares, count = columns
        if measure.reduce in ("min", "max"):
            return min(low) if measure.reduce == "min" else max(high)
        if measure.reduce == "sum":
            return math.fsum(total)
        mean = math.fsum(total) / sum(count)
        if measure.reduce == "mean":
            return mean
        return math.sqrt(max(0.0, math.fsum(squares) / sum(count) - mean * mean))
