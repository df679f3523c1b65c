"""WorldEnv: a world of either era as an environment of Gymnasium."""

from __future__ import annotations

import logging
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeAlias

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from libgz.base.errors import ClosedError, LibraryError, ParameterError, nearest
from libgz.base.extras import install
from libgz.base.geometry import GzPose
from libgz.front import World
from libgz.gym.outcome import Outcome
from libgz.ode.context import HeldEffort
from libgz.ode.crew import Task
from libgz.physics.check import finite
from libgz.simulation.updates import LawCall
from libgz.study.distribution import Distribution
from libgz.study.signals import Command, Reading, activate, commands_of, reading_of
from libgz.study.variant import Variant
from libgz.transport.server import on_free_server_id

if TYPE_CHECKING:
    from libgz.recording.images import FreeView

__all__ = ["Fields", "Observe", "Page", "WorldEnv"]

log = logging.getLogger("libgz.gym")

Fields: TypeAlias = "Sequence[str] | Mapping[str, tuple[float, float] | None]"
Observe: TypeAlias = "tuple[Callable[[World], Any], spaces.Space[Any]]"

PERIOD = 0.1  # [s]
EXAMPLES = {"actions": "'robot1::joint': ['effort']", "randomise": "'crate/mass': {'uniform': [1, 2]}"}
MOST_SETTLING = 200  # steps until all that is observed has measured
SEEDS = 2**31


class Page(Protocol):
    """What shows a world to a person."""

    def show(self) -> None:
        """Show the present state."""

    def close(self) -> None:
        """End."""


class WorldEnv(gymnasium.Env[Any, NDArray[np.float32]]):
    """A world that a learning program acts in and observes.

    One step of the environment writes the action, runs the world for `period`, and reads the observation. Names of
    actions and observations are those of `libgz.study.signals`: fields of interfaces, or of models, joints, links and
    sensors.

    Args:
        world: a worldfile by its path or name, or the text of one, which begins with ``<``.
        actions: key -> fields that the action writes, or a table of fields with their bounds: ``{"effort": (-2, 2)}``.
            Where no bounds are given, they are those that the world obeys. All of them together are one Box of float32.
        observations: key -> fields that are observed, or a table of fields with bounds, to which they are clipped. The
            observation is a Dict with a Box for each, named ``key/field``, with the type of the field, and its own
            bounds where none are given. Instead of fields, or of the whole table, a pair of a function of the world
            and the space of its values; or a Box, of a subclass whose `measure` computes observation, reward and end.
        reward: ``reward(world, observation, action)``, after each step; None for 0.
        terminated: ``terminated(world, observation)``: whether the episode has ended; None for never.
        start: ``start(world, random, options)``, called at each reset: it brings the world to where an episode begins,
            with
            numbers of the generator `random`; `options` are those of `reset`.
        update: ``update(world)``, called before the steps of each period, such as to move what no physics moves.
        info: ``info(world)``: more entries of the info table, which has ``sim_time`` [s].
        randomise: path of an element of the file -> its distribution, sampled at each reset; see
            `libgz.study.variant.Variant`
            and `libgz.study.distribution.Distribution`. The world is then built anew at each reset.
        period: sim time of one step of the environment [s]; a multiple of the world's step.
        settle: sim time that passes at a reset, before the first observation [s]; None for one period if interfaces or
            sensors are observed, which measure at their rates, else 0.
        time_limit: of an episode [s]; then it is truncated. None for no limit.
        flat: whether the observation is one Box of float64, of all numbers one after the other.
        solver: of the world: ``"world"``, ``"quick"`` or ``"tree"``; see `libgz.World`.
        render_mode: ``"rgb_array"`` for images, ``"human"`` for a page in the browser, which needs the extra `view`.
        width, height: of the images [px].
        camera: whose images: the name of one of the world's cameras, or the pose of a free one [m]; None for the
            world's
            own point of view.

    States of the world have the episode, too: a subclass lists in STATE what else changes in one, as a model does.

    Attributes:
        world: the present world; a reset may replace it where `randomise` is used.
        sampled: the values that `randomise` chose at the last reset.
        outcome: what `measure` computes; `make_vec` replaces it by one in an array of all environments.

    Raises:
        WorldFileError: there is no such world, or it has errors.
        InterfaceError, NotFoundError: it has nothing of a key.
        ParameterError: a field, a bound or another argument is not allowed.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 10}
    STATE: ClassVar[tuple[str, ...]] = ("outcome", "_steps", "_np_random")

    def __init__(
        self,
        world: str | os.PathLike[str],
        actions: Mapping[str, Fields],
        observations: Mapping[str, Fields | Observe] | Observe | spaces.Box,
        reward: Callable[[World, Any, NDArray[Any]], float] | None = None,
        terminated: Callable[[World, Any], bool] | None = None,
        *,
        start: Callable[[World, np.random.Generator, dict[str, Any]], object] | None = None,
        update: Callable[[World], object] | None = None,
        info: Callable[[World], dict[str, Any]] | None = None,
        randomise: Mapping[str, Any] | None = None,
        period: float = PERIOD,
        settle: float | None = None,
        time_limit: float | None = None,
        flat: bool = False,
        solver: str = "world",
        render_mode: str | None = None,
        width: int = 480,
        height: int = 360,
        camera: str | GzPose | None = None,
    ) -> None:
        modes = self.metadata["render_modes"]
        if render_mode is not None and render_mode not in modes:
            hint = nearest(render_mode, modes)
            raise ParameterError(f"render_mode is {render_mode!r}; allowed are {', '.join(modes)} and None{hint}")
        self.render_mode = render_mode
        functions = {"reward": reward, "terminated": terminated, "start": start, "update": update, "info": info}
        for name, function in functions.items():
            if function is not None and not callable(function):
                raise ParameterError(f"{name} is {function!r}; it must be a function, or None")
        for name, table in {"actions": actions, "randomise": randomise or {}}.items():
            if not isinstance(table, Mapping):
                raise ParameterError(f"{name} is {table!r}; it must be a table, such as {{{EXAMPLES[name]}}}")
        self._variant = Variant(world)
        self._actions, self._observations, self._flat = actions, observations, flat
        self._reward, self._terminated, self._start, self._update, self._info = reward, terminated, start, update, info
        self._randomise = {path: Distribution.of(given, path) for path, given in (randomise or {}).items()}
        self._solver = solver
        self._size, self._camera = (width, height), camera
        self._eye: Any = None
        self._view: FreeView | None = None
        self._page: Page | None = None
        self._closed = False
        self._started = False
        self._steps = 0  # of this episode
        self.sampled: dict[str, Any] = {}
        self.outcome = Outcome(0, 0)  # until its sizes are known
        self._law: LawCall | None = None
        self._bound: object = None  # the objects of the world among which commands were found
        self.world = self._load(self._sampled(np.random.default_rng(0)), 0)  # so that wrong paths fail here
        try:
            self._prepare(period, settle, time_limit)
        except BaseException:
            self.close()
            raise

    def _prepare(self, period: float, settle: float | None, time_limit: float | None) -> None:
        """Count steps, and make the spaces from the signals of a world that has measured."""
        self.period = finite(period, "period [s]")
        self._count = self._whole(self.period, "period")
        measured = self._measured()
        self._settling = self._whole(settle, "settle", 0) if settle is not None else self._count if measured else 0
        self._most = None if time_limit is None else max(1, round(finite(time_limit, "time_limit [s]") / self.period))
        self.metadata = {**self.metadata, "render_fps": max(1, round(1.0 / self.period))}
        if measured:
            self._settle(max(1, self._settling))
        self._bind(patience=MOST_SETTLING if measured else 0)
        low, high = (np.array([getattr(one, end) for one in self._commands], np.float32) for end in ("low", "high"))
        whole = [one.whole for one in self._commands]
        self._bounds = list(zip(low.tolist(), high.tolist(), whole, strict=True))
        self.action_space = spaces.Box(low, high, dtype=np.float32)
        self.observation_space = self._space()

    def _whole(self, seconds: float, what: str, least: int = 1) -> int:
        """How many steps of the world a time [s] is."""
        step = self.world.engine.step_time
        count = round(finite(seconds, f"{what} [s]") / step)
        if count < least or not math.isclose(count * step, seconds, rel_tol=1e-6, abs_tol=1e-9):
            raise ParameterError(f"{what} is {seconds:g} s; it must be a multiple of the world's step, {step:g} s")
        return count

    def _load(self, changes: Mapping[str, Any], seed: int) -> World:
        load = partial(self._variant.load, changes, seed=seed, solver=self._solver)
        return load() if self.render_mode != "human" else on_free_server_id(lambda number: load(server_id=number))

    def _sampled(self, random: np.random.Generator) -> dict[str, Any]:
        """A value for each path that is randomised."""
        return {path: one.sample(random) for path, one in self._randomise.items()}

    # Signals ---------------------------------------------------------------------------------------------------------

    def _tables(self) -> tuple[dict[tuple[str, str], tuple[float, float] | None], dict[str, Observe]]:
        """(key, field) of what is read by name, with bounds if some are given, and the functions by their names."""
        if isinstance(self._observations, spaces.Box):
            return {}, {"": (self._measure_now, self._observations)}
        if not isinstance(self._observations, Mapping):
            return {}, {"": _checked(self._observations, "observations")}
        named: dict[tuple[str, str], tuple[float, float] | None] = {}
        made: dict[str, Observe] = {}
        for key, fields in self._observations.items():
            if isinstance(fields, tuple) and fields and callable(fields[0]):
                made[key] = _checked(fields, f"observations[{key!r}]")
            else:
                listed = _listed(fields, f"observations[{key!r}]")
                named |= {(key, field): bounds for field, bounds in listed.items()}
        if not named and not made:
            raise ParameterError("observations is empty; name at least one field, such as {'position.robot1': ['pos']}")
        return named, made

    def _measured(self) -> bool:
        """Whether something is observed that measures at a rate of its own."""
        named, made = self._tables()
        interfaces = self.world.gz_server.interfaces
        served = any(tuple(key.split(".", 1)) in interfaces or "." in key for key, _ in named)
        return bool(served or (made and interfaces) or (self.world.sdf is not None and self.world.sdf.busy))

    def _settle(self, count: int) -> None:
        """Have sensors measure, and do some steps."""
        for key, field in self._tables()[0]:
            activate(self.world, key, field)
        self.world.step(count)

    def _bind(self, patience: int = 0) -> None:
        """Find what actions write and observations read, among the present objects of the world."""
        named, self._made = self._tables()
        for left in range(patience, -1, -1):
            try:
                self._readings = [_read(self.world, *signal, bounds) for signal, bounds in named.items()]
                break
            except ParameterError:  # a camera has no image yet
                if not left:
                    raise
                self.world.step()
        self._all_seen = {one.label: one.value for one in self._readings}
        self._bind_commands()
        if isinstance(self._observations, spaces.Box):
            self._bind_law(self._observations)

    def _bind_commands(self) -> None:
        """Find what actions write, if the world has other objects than when that was done last."""
        objects = (self.world, self.world.engine.tables.changes, [*self.world.entities])
        if objects == self._bound:
            return
        commands: list[Command] = []
        for key, fields in self._actions.items():
            for field, bounds in _listed(fields, f"actions[{key!r}]").items():
                commands += commands_of(self.world, key, field, bounds)
        if not commands:
            raise ParameterError(f"actions is empty; name at least one command, such as {{{EXAMPLES['actions']}}}")
        self._commands = commands
        self._writers = [one.write for one in commands]
        self._lasting = all(one.lasts for one in commands)
        joints = [one.joint for one in commands if one.joint is not None]
        held = joints if len(set(joints)) == len(commands) else []  # two commands on one joint add up, step by step
        self._efforts = (HeldEffort * len(held))()
        self._held = list(zip(held, self._efforts, strict=True))
        self._bound = objects

    def _bind_law(self, box: spaces.Box) -> None:
        """Have `measure` computed of the present world."""
        if type(self).measure is WorldEnv.measure:
            raise ParameterError(f"observations is a Box; {type(self).__name__} must have a method `measure` then")
        if self._law is None:
            self.outcome, self._kind = Outcome(len(self._commands), int(np.prod(box.shape, dtype=int))), box.dtype
        if self._law is None or self._law.world is not self.world:
            self._law = LawCall(self.world, self.measure)

    def move_outcome(self, numbers: NDArray[np.float64]) -> None:
        """Have `outcome` in other memory, of as many numbers, from now on."""
        former = self.outcome
        numbers[:] = former.numbers
        self.outcome = Outcome(former.action.size, former.seen.size, numbers)
        if self._law is not None:
            self._law = LawCall(self.world, self.measure)

    def measure(self) -> None:
        """Set `outcome`; for subclasses that observe a Box.

        It is called after the steps of a period, and at a reset for the observation alone. Where it is a law, see
        `libgz.base.law`, native code computes it, for the environments of `make_vec` beside each other.
        """

    def _measure_now(self, world: World) -> NDArray[Any]:
        """The observation that `measure` computes now."""
        if self._law is not None:
            with world.lock:
                self._law()
        return self._observation()

    def _observation(self) -> NDArray[Any]:
        """The one that `measure` computed last."""
        return self.outcome.seen.reshape(self._made[""][1].shape).astype(self._kind)

    def _space(self) -> spaces.Space[Any]:
        if "" in self._made:
            space = self._made[""][1]
        else:
            boxes: dict[str, spaces.Space[Any]] = {one.label: _box(one) for one in self._readings}
            space = spaces.Dict({**boxes, **{name: space for name, (_, space) in self._made.items()}})
        self._whole_space = space
        return spaces.flatten_space(space) if self._flat else space

    def _observe(self, measured: bool = False) -> Any:
        """What is observed; `measured`: the law has been computed since the last step."""
        seen: Any
        if measured:
            seen = self._observation()
        elif "" in self._made:
            seen = self._made[""][0](self.world)
        else:
            seen = {label: value() for label, value in self._all_seen.items()}
            space = self._whole_space
            if self._flat and not self._made and isinstance(space, spaces.Dict):  # as `flatten`, at half its cost
                return np.concatenate([seen[label].reshape(-1) for label in space])
            for name, (function, _) in self._made.items():
                seen[name] = function(self.world)
        return spaces.flatten(self._whole_space, seen) if self._flat else seen

    # Gymnasium -------------------------------------------------------------------------------------------------------

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode.

        With a seed, all that follows is equal to the bit whenever the same actions follow.

        Raises:
            ClosedError: the environment is closed.
        """
        self._check_open()
        super().reset(seed=seed)
        world_seed = int(self.np_random.integers(SEEDS))
        if self._randomise or self.world.spawned:
            self.sampled = self._sampled(self.np_random)
            self._replace(self._load(self.sampled, world_seed))
        else:
            self.world.Reset()
        self.world.reseed(world_seed)
        if self._start is not None:
            self._start(self.world, self.np_random, options or {})
        self.world.extension(self._extend)
        self._settle(self._settling)
        shapes = [one.shape for one in self._readings]
        self._bind(patience=MOST_SETTLING if self._settling else 0)
        for one, shape in zip(self._readings, shapes, strict=True):
            if one.shape != shape:
                raise ParameterError(f"{one.label!r} has the shape {one.shape} now, and had {shape} before")
        self._steps, self._started = 0, True
        if self.render_mode == "human":
            self.render()
        return self._observe(), self._information()

    def _extend(self, _world: object) -> WorldEnv:
        """What states of the world have of the episode."""
        return self

    def _replace(self, world: World) -> None:
        self._close_views()
        self.world.close()
        self.world = world

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Act for one period.

        Args:
            action: within the bounds of `action_space`; what is beyond is clipped.

        Raises:
            ClosedError: the environment is closed.
            ParameterError: the action has another shape, or is not finite.
            gymnasium.error.ResetNeeded: `reset` was not called.
        """
        world, law = self.world, None
        for count, law in self._act(self._clipped(action)):
            world.step(count, law)
        seen = self._observe(measured=law is not None)
        cut, now = self._end(action, seen), self.outcome
        return seen, now.reward, now.ended != 0.0, cut, self._information()

    def step_beside(self, action: Any, values: list[float] | None = None) -> Task[tuple[Any, bool, dict[str, Any]]]:
        """`step`, for environments whose worlds step beside each other in a `Crew`.

        Args:
            action: as of `step`.
            values: its numbers, if they are within their bounds, see `clipped_rows`.

        Returns:
            The observation, whether the episode is truncated, and the info; all else is in `outcome`, and where
            `measures`, so is the observation.
        """
        world, law = self.world, None
        for count, law in self._act(self._clipped(action) if values is None else values):
            yield from world.step_beside(count, law)
        seen = None if law is not None else self._observe()
        return seen, self._end(action, seen), self._information()

    @property
    def measures(self) -> bool:
        """Whether `measure` computes `outcome`."""
        return self._law is not None

    def _act(self, values: Sequence[Any]) -> Iterator[tuple[int, LawCall | None]]:
        """Write an action; gives numbers of steps that are then to be made, and the law that ends them, if any."""
        if not self._started:
            self._check_open()
            raise gymnasium.error.ResetNeeded("call reset() before the first step()")
        if self._update is not None:
            self._update(self.world)
        if self._law is not None:
            self.outcome.action[:] = values
        if self._lasting:
            for write, value in zip(self._writers, values, strict=True):
                write(value)
            yield self._count, self._law
        elif self._write_held(values):
            engine = self.world.engine
            engine.hold(self._efforts)
            try:
                yield self._count, self._law
            finally:
                engine.hold(None)
            for joint, record in self._held:
                joint.was_held(record.effort, self._count)
        else:
            for left in range(self._count, 0, -1):
                for write, value in zip(self._writers, values, strict=True):
                    write(value)
                yield 1, self._law if left == 1 else None

    def _end(self, action: Any, seen: Any) -> bool:
        """Count a step that is over, and set `outcome` where no law has; whether the episode is truncated."""
        self._steps += 1
        if self._law is None:
            world, now = self.world, self.outcome
            now.reward = 0.0 if self._reward is None else float(self._reward(world, seen, action))
            now.ended = float(self._terminated is not None and bool(self._terminated(world, seen)))
        if self.render_mode == "human":
            self.render()
        return self._most is not None and self._steps >= self._most

    def _write_held(self, values: Sequence[float]) -> bool:
        """Write the action as efforts that native code holds over the steps of a period; whether it can."""
        held = bool(self._held)
        for (joint, record), value in zip(self._held, values, strict=held):
            held = joint.write_held(record, value) and held
        return held

    def _clipped(self, action: Any) -> list[Any]:
        """The numbers of an action within their bounds; whole ones rounded."""
        try:
            values: list[Any] = action.tolist() if isinstance(action, np.ndarray) else list(map(float, action))
        except (TypeError, ValueError):
            raise ParameterError(f"action is {action!r}; it must be {len(self._bounds)} numbers") from None
        if not isinstance(values, list) or len(values) != len(self._bounds):
            raise ParameterError(f"action is {action!r}; it must have {len(self._bounds)} numbers")
        for index, (value, (low, high, whole)) in enumerate(zip(values, self._bounds, strict=True)):
            if not low <= value <= high:
                if not math.isfinite(value):
                    raise ParameterError(f"action is {values}; it must be finite")
                values[index] = min(max(value, low), high)
            if whole:
                values[index] = round(values[index])
        return values

    def clipped_rows(self, actions: NDArray[Any]) -> list[list[float]] | None:
        """The numbers of many actions, a row each, within their bounds; None where each has to be looked at."""
        space: Any = self.action_space
        floats = actions.dtype.kind == "f" and actions.shape[1:] == space.shape
        if not floats or any(whole for *_, whole in self._bounds) or not np.isfinite(actions).all():
            return None
        rows: list[list[float]] = np.clip(actions.astype(np.float64), space.low, space.high).tolist()
        return rows

    def _information(self) -> dict[str, Any]:
        found: dict[str, Any] = {"sim_time": self.world.clock.sim_time}
        if self.sampled:
            found["sampled"] = dict(self.sampled)
        if self._info is not None:
            found |= self._info(self.world)
        return found

    # Views -----------------------------------------------------------------------------------------------------------

    def render(self) -> NDArray[np.uint8] | None:
        """An image of shape (height, width, 3) in the mode ``rgb_array``; in the mode ``human``, show the page.

        Raises:
            LibraryError: rendering is disabled, OpenGL does not work here, or the viewer is not installed.
            NotFoundError: there is no such camera.
        """
        self._check_open()
        if self.render_mode == "rgb_array":
            return self._image()
        if self.render_mode == "human":
            if self._page is None:
                self._page = _open_page(self.world)
            self._page.show()
            return None
        gymnasium.logger.warn("render() without a render_mode; make the environment with render_mode='rgb_array'")
        return None

    def _image(self) -> NDArray[np.uint8]:
        if self._eye is None:
            self._eye = self._open_eye()
        image: NDArray[np.uint8] = self._eye()
        if not image.size:
            raise LibraryError("rendering is disabled (--gl none or LIBGZ_GL), so there are no images")
        return image.copy()

    def _open_eye(self) -> Callable[[], NDArray[np.uint8]]:
        from libgz.recording.images import FreeView, cameras_of  # only who renders loads OpenGL

        if isinstance(self._camera, str):
            cameras = cameras_of(self.world)
            if self._camera not in cameras:
                known = ", ".join(cameras) or "none"
                raise ParameterError(
                    f"there is no camera {self._camera!r}; there are {known}{nearest(self._camera, cameras)}"
                )
            return cameras[self._camera].image
        pose = self._camera if self._camera is not None else self.world.start_pose(*self._size)
        self._view = FreeView(self.world, pose, self._size, shadows=True)
        return self._view.image

    def _close_views(self) -> None:
        if self._view is not None:
            self._view.close()
        self._view = self._eye = None
        if self._page is not None:
            self._page.close()
            self._page = None

    def close(self) -> None:
        """End the world and free everything. Can be called twice."""
        if self._closed:
            return
        self._closed, self._started = True, False
        self._close_views()
        self.world.close()

    def _check_open(self) -> None:
        if self._closed:
            raise ClosedError("the environment is closed")


def _listed(fields: Any, what: str) -> dict[str, tuple[float, float] | None]:
    """Fields with their bounds, if any are given."""
    if isinstance(fields, Mapping):
        return {str(name): _pair(bounds, f"{what}[{name!r}]") for name, bounds in fields.items()}
    if isinstance(fields, str) or not isinstance(fields, Sequence) or not all(isinstance(one, str) for one in fields):
        raise ParameterError(f"{what} is {fields!r}; it must be a list of fields, such as ['pos', 'rot[2]']")
    return dict.fromkeys(fields)


def _pair(bounds: Any, what: str) -> tuple[float, float] | None:
    if bounds is None:
        return None
    try:
        low, high = (float(bound) for bound in bounds)
    except (TypeError, ValueError):
        raise ParameterError(f"{what} is {bounds!r}; it must be a pair of bounds, (low, high)") from None
    return low, high


def _checked(pair: Any, what: str) -> Observe:
    if isinstance(pair, tuple) and len(pair) == 2 and callable(pair[0]) and isinstance(pair[1], spaces.Space):
        return pair
    raise ParameterError(f"{what} is {pair!r}; it must be a table of fields, or a pair (function, space)")


def _read(world: World, key: str, field: str, bounds: tuple[float, float] | None) -> Reading:
    reading = reading_of(world, key, field)
    return reading if bounds is None else reading.within(bounds)


def _box(reading: Reading) -> spaces.Box:
    return spaces.Box(reading.low, reading.high, dtype=reading.dtype.type)


def _open_page(world: World) -> Page:
    try:
        from libgz.gym.page import BrowserPage
    except ImportError as error:
        raise LibraryError(f"render_mode 'human' needs the extra `view`: {install('view')} ({error})") from None
    return BrowserPage(world)
