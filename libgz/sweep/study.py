"""Study: what is run: a world, over parameters, controllers and seeds, and what is measured. Read from a TOML file."""

from __future__ import annotations

import hashlib
import json
import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from libgz.base.errors import ParameterError, nearest
from libgz.base.files import is_file, read_limited, read_text
from libgz.ode.context import SOLVERS
from libgz.study.distribution import Distribution
from libgz.study.signals import split_signal
from libgz.study.variant import Variant

__all__ = ["NO_CONTROLLER", "REDUCTIONS", "Controller", "Limits", "Measure", "Run", "Study"]

NO_CONTROLLER = "none"
TO_CONTROLLER = "controller/"  # prefix of parameters that the controller is given
MOST_RUNS, MOST_SEEDS, MOST_MEASURES = 1_000_000_000, 1_000_000, 1000
REDUCTIONS = ("last", "first", "min", "max", "mean", "sum", "std")
RESERVED = (
    "run",
    "controller",
    "seed",
    "state",
    "message",
    "attempts",
    "sim_time",
    "wall_time",
    "host",
    "libgz",
    "python",
)
KEYS = {
    "world": "the worldfile, by its path beside the study or its name",
    "duration": "sim time of a run [s]",
    "start": "sim time that passes before the controller begins [s]; runs that differ only in it share that state",
    "seeds": "how many seeds, or a list of them",
    "repeats": "how many times distributions are sampled",
    "seed": "of the repeats",
    "period": "sim time between two calls of a controller [s]",
    "sample": "sim time between two samples of measures [s]",
    "solver": "world, quick or tree",
    "retries": "how often a failed run is repeated",
    "parameters": "path of an element, or controller/NAME -> a list of values, or a distribution",
    "list": "an array of tables of parameters, each one a case",
    "controller": "a controller",
    "controllers": "several controllers, by name",
    "measures": "what is recorded",
    "limits": "of a run: time [s] and memory [MB]",
}


@dataclass(frozen=True)
class Controller:
    """What drives the robots of a run.

    Attributes:
        name: of it in the results.
        function: ``FILE.py:NAME``; empty for none.
        command: the words of a client program; ``{server_id}`` in them is the server's id. Empty for none.
        speed: of a world with a client program, sim time per real time; 0: as fast as possible.
    """

    name: str = NO_CONTROLLER
    function: str = ""
    command: tuple[str, ...] = ()
    speed: float = 1.0


@dataclass(frozen=True)
class Measure:
    """A number that is recorded of a run.

    Attributes:
        name: its column.
        signal: ``KEY/FIELD``; see `libgz.study.signals`.
        reduce: one of `REDUCTIONS`, over the samples and the numbers of the signal.
        function: ``FILE.py:NAME`` instead of a signal.
    """

    name: str
    signal: str = ""
    reduce: str = "last"
    function: str = ""


@dataclass(frozen=True)
class Limits:
    """What a run may take: real time [s], and memory of its processes [MB]."""

    time: float = math.inf
    memory: float = math.inf


@dataclass(frozen=True)
class Run:
    """One run of a study.

    Attributes:
        number: from 0.
        parameters: all of them, by name.
        seed: of the world.
        controller: what drives.
    """

    number: int
    parameters: dict[str, Any]
    seed: int
    controller: Controller

    @property
    def changes(self) -> dict[str, Any]:
        """The parameters that are elements of the world's file."""
        return {name: value for name, value in self.parameters.items() if not name.startswith(TO_CONTROLLER)}

    @property
    def settings(self) -> dict[str, Any]:
        """The parameters that the controller is given."""
        cut = len(TO_CONTROLLER)
        return {name[cut:]: value for name, value in self.parameters.items() if name.startswith(TO_CONTROLLER)}


@dataclass(frozen=True)
class Study:
    """A study. Every run of it is given by its number alone, so that nothing has to be listed.

    Runs are numbered over cases, the grid, repeats, controllers and seeds, the last one fastest.
    """

    folder: Path  # of relative paths
    world: str
    duration: float
    measures: tuple[Measure, ...]
    cases: tuple[dict[str, Any], ...] = ({},)
    grid: dict[str, list[Any]] = field(default_factory=dict)
    random: dict[str, Distribution] = field(default_factory=dict)
    repeats: int = 1
    seed: int = 0
    seeds: tuple[int, ...] = (0,)
    controllers: tuple[Controller, ...] = (Controller(),)
    start: float = 0.0
    period: float = 0.1
    sample: float = 0.1
    solver: str = "world"
    retries: int = 1
    limits: Limits = field(default_factory=Limits)

    @classmethod
    def load(cls, filename: str | Path) -> Study:
        """Read a study.

        Raises:
            ParameterError: it cannot be read, or has an error; the message names the file and the key.
        """
        path = Path(filename)
        try:
            table = tomllib.loads(read_limited(path).decode())
        except OSError as error:
            raise ParameterError(f"cannot read study {str(path)!r}: {error.strerror}") from None
        except RecursionError:
            raise ParameterError(f"{path}: it is nested too deeply") from None
        except ValueError as error:  # no TOML, no UTF-8, or a number of thousands of digits
            raise ParameterError(f"{path}: {error}") from None
        try:
            return cls.of(table, path.absolute().parent)
        except ParameterError as error:
            raise ParameterError(f"{path}: {error}") from None
        except RecursionError:  # a key of thousands of names, which the parser does not recur for
            raise ParameterError(f"{path}: it is nested too deeply") from None

    @classmethod
    def of(cls, table: Mapping[str, Any], folder: Path) -> Study:
        """The study that a table describes; see `KEYS`.

        Raises:
            ParameterError: a key or value is not allowed.
        """
        _check_whole_numbers(table)
        _check_keys(table, KEYS, "a study")
        for key in ("world", "duration", "measures"):
            if key not in table:
                raise ParameterError(f"{key} is missing: {KEYS[key]}")
        parameters = _table(table, "parameters")
        random = {name: Distribution.of(given, name) for name, given in parameters.items() if isinstance(given, dict)}
        grid = {name: _values(given) for name, given in parameters.items() if name not in random}
        cases = _cases(table.get("list", [{}]))
        names = [*(name for case in cases for name in case), *grid, *random]
        for name in dict.fromkeys(names):
            if not name or name in RESERVED:
                raise ParameterError(f"parameter {name!r} is not allowed; it is the name of another column")
        for name in {**grid, **random}:
            if any(name in case for case in cases):
                raise ParameterError(f"parameter {name!r} is in [parameters] and in the list; give it once")
        repeats = _whole(table, "repeats", 1, 1)
        if repeats > 1 and not random:
            raise ParameterError(
                f"repeats is {repeats}, but no parameter is a distribution, such as {{uniform = [1, 2]}}"
            )
        measures = tuple(_measure(name, given, folder) for name, given in _table(table, "measures").items())
        if not measures:
            raise ParameterError("measures is empty; name at least one, such as distance = 'position.robot1/pos[0]'")
        if len(measures) > MOST_MEASURES:
            raise ParameterError(f"it has {len(measures)} measures; at most {MOST_MEASURES} are allowed")
        for one in measures:
            if one.name in RESERVED or one.name in names:
                raise ParameterError(f"measure {one.name!r} has the name of another column")
        world = table["world"]
        if not isinstance(world, str):
            raise ParameterError(f"world is {world!r}; it must be {KEYS['world']}")
        limits = _table(table, "limits")
        _check_keys(limits, {"time": "", "memory": ""}, "limits")
        solver = table.get("solver", "world")
        if solver not in SOLVERS:
            raise ParameterError(f"solver is {solver!r}; allowed are {', '.join(SOLVERS)}")
        study = cls(
            folder,
            world if world.lstrip().startswith("<") else _beside(folder, world),
            _number(table, "duration", above=0.0),
            measures,
            cases,
            grid,
            random,
            repeats,
            _whole(table, "seed", 0, 0),
            _seeds(table.get("seeds", 1)),
            _controllers(table, folder),
            _number(table, "start", 0.0),
            _number(table, "period", 0.1, above=0.0),
            _number(table, "sample", 0.1, above=0.0),
            solver,
            _whole(table, "retries", 1, 0),
            Limits(
                _number(limits, "time", math.inf, above=0.0, finite=False),
                _number(limits, "memory", math.inf, above=0.0, finite=False),
            ),
        )
        if study.start >= study.duration:
            raise ParameterError(f"start is {study.start:g} s; it must be before the end, {study.duration:g} s")
        if math.prod(study._sizes) > MOST_RUNS:
            raise ParameterError(f"it has more than {MOST_RUNS} runs")
        for name in names:
            if name.startswith(TO_CONTROLLER) and not all(one.function for one in study.controllers):
                raise ParameterError(f"parameter {name!r} is given to controllers in Python, and one of these is none")
        return study

    # Runs ------------------------------------------------------------------------------------------------------------

    def __len__(self) -> int:
        return math.prod(self._sizes)

    @property
    def _sizes(self) -> tuple[int, ...]:
        grid = (len(values) for values in self.grid.values())
        return (len(self.cases), *grid, self.repeats, len(self.controllers), len(self.seeds))

    def run(self, number: int) -> Run:
        """A run by its number.

        Raises:
            ParameterError: there is none of this number.
        """
        if not 0 <= number < len(self):
            raise ParameterError(f"there is no run {number}; there are {len(self)}")
        rest, places = number, []
        for size in reversed(self._sizes):
            rest, place = divmod(rest, size)
            places.append(place)
        case, *grid, repeat, controller, seed = reversed(places)
        parameters = dict(self.cases[case])
        for (name, values), place in zip(self.grid.items(), grid, strict=True):
            parameters[name] = values[place]
        generator = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(repeat,)))
        for name, distribution in self.random.items():
            parameters[name] = distribution.sample(generator)
        return Run(number, parameters, self.seeds[seed], self.controllers[controller])

    def runs(self) -> Iterator[Run]:
        """All runs, in order."""
        return map(self.run, range(len(self)))

    @property
    def parameters(self) -> list[str]:
        """The names of all parameters."""
        return list(dict.fromkeys([*(name for case in self.cases for name in case), *self.grid, *self.random]))

    def digest(self) -> str:
        """A number that differs between studies, and with the text of their worlds and Python files."""
        text = {
            "world": _content(Variant(self.world)),
            "measures": [(one.name, one.signal, one.reduce, self._text_of(one.function)) for one in self.measures],
            "controllers": [
                (one.name, one.command, one.speed, self._text_of(one.function)) for one in self.controllers
            ],
            "numbers": [
                self.duration,
                self.start,
                self.period,
                self.sample,
                self.repeats,
                self.seed,
                self.seeds,
                self.solver,
            ],
            "parameters": [self.cases, self.grid, {name: repr(one) for name, one in self.random.items()}],
        }
        return hashlib.blake2b(json.dumps(text, sort_keys=False, default=str).encode(), digest_size=16).hexdigest()

    def _text_of(self, function: str) -> str:
        if not function:
            return ""
        path, _, name = function.rpartition(":")
        try:
            return f"{name}:{read_text(path)}"
        except OSError as error:
            raise ParameterError(f"{function!r} cannot be read: {error}") from None


def _content(world: Variant) -> str:
    return world.path.read_text(errors="replace") if world.path is not None else str(world.world)


def _check_keys(table: Mapping[str, Any], known: Mapping[str, Any], what: str) -> None:
    for key in table:
        if key not in known:
            raise ParameterError(f"{what} has no {key!r}; it has {', '.join(known)}{nearest(key, known)}")


def _check_whole_numbers(value: Any) -> None:
    """Refuse whole numbers that TOML does not have: those beyond 64 bits are neither floats nor numpy's integers."""
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise ParameterError("a whole number is beyond 64 bits")
    if isinstance(value, Mapping | list | tuple):
        for one in value.values() if isinstance(value, Mapping) else value:
            _check_whole_numbers(one)


def _table(table: Mapping[str, Any], key: str) -> dict[str, Any]:
    found = table.get(key, {})
    if not isinstance(found, dict):
        raise ParameterError(f"{key} is {found!r}; it must be a table")
    return found


def _values(given: Any) -> list[Any]:
    values = given if isinstance(given, list) else [given]
    if not values:
        raise ParameterError("a list of values is empty")
    return values


def _number(
    table: Mapping[str, Any], key: str, default: float | None = None, *, above: float | None = None, finite: bool = True
) -> float:
    value = table.get(key, default)
    right = isinstance(value, int | float) and not isinstance(value, bool) and not math.isnan(value)
    if not right or (finite and math.isinf(value)) or (value <= above if above is not None else value < 0.0):
        raise ParameterError(f"{key} is {value!r}; it must be a number {'above 0' if above is not None else 'from 0'}")
    return float(value)


def _whole(table: Mapping[str, Any], key: str, default: int, least: int) -> int:
    value = table.get(key, default)
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise ParameterError(f"{key} is {value!r}; it must be a whole number from {least}")
    return value


def _seeds(given: Any) -> tuple[int, ...]:
    if isinstance(given, int) and not isinstance(given, bool) and 0 < given <= MOST_SEEDS:
        return tuple(range(given))
    right = isinstance(given, list) and given and all(type(one) is int and one >= 0 for one in given)
    if not right or len(set(given)) != len(given):
        raise ParameterError(
            f"seeds is {given!r}; it must be a number from 1 to {MOST_SEEDS}, or a list of different whole numbers "
            "from 0"
        )
    return tuple(given)


def _cases(given: Any) -> tuple[dict[str, Any], ...]:
    if not isinstance(given, list) or not given or not all(isinstance(case, dict) for case in given):
        raise ParameterError("list must be an array of tables: [[list]], then a line 'PATH' = VALUE for each parameter")
    names = set(given[0])
    for number, case in enumerate(given):
        if set(case) != names:
            different = ", ".join(sorted(names ^ set(case)))
            raise ParameterError(f"case {number} of the list has other parameters than the first one: {different}")
    return tuple(given)


def _beside(folder: Path, name: str) -> str:
    """A file beside the study, or the name as given, of a world of libgz."""
    for path in (folder / name, folder / f"{name}.world"):
        if is_file(path):
            return str(path)
    return name


def _function(text: str, folder: Path) -> str:
    path, colon, name = text.rpartition(":")
    if not colon or not path.endswith(".py") or not name.isidentifier():
        raise ParameterError(f"{text!r} names no function; write FILE.py:NAME")
    if not is_file(folder / path):
        raise ParameterError(f"{text!r}: there is no file {str(folder / path)!r}")
    return f"{folder / path}:{name}"


def _controllers(table: Mapping[str, Any], folder: Path) -> tuple[Controller, ...]:
    several = _table(table, "controllers")
    if "controller" in table and several:
        raise ParameterError("give either controller or controllers")
    if "controller" in table:
        given = table["controller"]
        name = given.rpartition(":")[2] if isinstance(given, str) else "program"
        several = {name: given}
    return tuple(_controller(name, given, folder) for name, given in several.items()) or (Controller(),)


def _controller(name: str, given: Any, folder: Path) -> Controller:
    what = f"controller {name!r}"
    try:
        if given == NO_CONTROLLER:
            return Controller(name)
        if isinstance(given, str):
            return Controller(name, _function(given, folder))
        if isinstance(given, dict):
            _check_keys(given, {"command": "", "speed": ""}, what)
            words = given.get("command")
            if isinstance(words, list) and words and all(isinstance(word, str) for word in words):
                return Controller(name, command=tuple(words), speed=_number(given, "speed", 1.0))
    except ParameterError as error:
        raise ParameterError(f"{what}: {error}") from None
    forms = f"'FILE.py:NAME', {{command = ['program', '{{server_id}}']}} or '{NO_CONTROLLER}'"
    raise ParameterError(f"{what} is {given!r}; it must be {forms}")


def _measure(name: str, given: Any, folder: Path) -> Measure:
    what = f"measure {name!r}"
    try:
        if isinstance(given, str):
            given = {"function": given} if ".py:" in given else {"of": given}
        if isinstance(given, dict):
            _check_keys(given, {"of": "", "reduce": "", "function": ""}, what)
            if isinstance(given.get("function"), str) and len(given) == 1:
                return Measure(name, function=_function(given["function"], folder))
            if isinstance(given.get("of"), str) and "function" not in given:
                reduce = given.get("reduce", "last")
                if reduce not in REDUCTIONS:
                    raise ParameterError(f"reduce is {reduce!r}; allowed are {', '.join(REDUCTIONS)}")
                split_signal(given["of"])
                return Measure(name, given["of"], reduce)
    except ParameterError as error:
        raise ParameterError(f"{what}: {error}") from None
    raise ParameterError(
        f"{what} is {given!r}; it must be 'KEY/FIELD', {{of = 'KEY/FIELD', reduce = 'min'}} or 'FILE.py:NAME'"
    )
