"""WorldVectorEnv: many environments whose worlds step beside each other, on all cores of one process."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from functools import partial
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array
from numpy.typing import NDArray

from libgz.base.errors import ClosedError, GazeboError, ParameterError
from libgz.gym.env import WorldEnv
from libgz.gym.tasks import TASKS
from libgz.ode.crew import Crew, Task

__all__ = ["KINDS", "WorldVectorEnv"]

_PLAIN = {bool, int, float}  # of which an array is made at once

Stepped = tuple[Any, bool, dict[str, Any]]  # what a step of one environment returns; see `WorldEnv.step_beside`


class WorldVectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """Environments of one kind, which act together: each on a core that is free.

    `gymnasium.make_vec("libgz/...", num_envs=64)` makes one. Actions, observations, rewards and ends are arrays, with a
    row for each environment. Each does what it would do alone with the same seed and actions, to the bit, with any
    number of threads.

    Args:
        kind: the class of the environments.
        num_envs: how many there are.
        threads: how many step, with the calling one; None for one a core.
        autoreset_mode: when an environment that has ended is reset: ``NextStep``, ``SameStep`` or ``Disabled``; see
            Gymnasium's documentation.
        copy: whether `reset` and `step` return new arrays of observations; else the same one each time.
        **options: of each environment.

    Attributes:
        envs: the environments.

    Raises:
        ParameterError: there is no environment, or the mode or the number of threads is not allowed.
        GazeboError: as the class of the environments.
    """

    def __init__(
        self,
        kind: Callable[..., WorldEnv],
        num_envs: int = 1,
        *,
        threads: int | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
        copy: bool = True,
        **options: Any,
    ) -> None:
        if num_envs < 1:
            raise ParameterError(f"num_envs is {num_envs}; there must be at least one environment")
        try:
            self.autoreset_mode = AutoresetMode(autoreset_mode)
        except ValueError:
            known = ", ".join(mode.value for mode in AutoresetMode)
            raise ParameterError(f"autoreset_mode is {autoreset_mode!r}; allowed are {known}") from None
        self._crew = Crew(threads, num_envs)
        self.envs: list[WorldEnv] = []
        try:
            self.envs += (kind(**options) for _ in range(num_envs))
        except BaseException:
            self.close_extras()
            raise
        first = self.envs[0]
        self.num_envs, self.copy = num_envs, copy
        self.metadata = {**first.metadata, "autoreset_mode": self.autoreset_mode}
        self.render_mode = first.render_mode
        self.single_action_space, self.single_observation_space = first.action_space, first.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._observations: Any = create_empty_array(self.single_observation_space, num_envs)
        self._seen: list[Any] = [None] * num_envs
        self._outcomes = np.zeros((num_envs, first.outcome.numbers.size))  # a row for that of each environment
        for env, row in zip(self.envs, self._outcomes, strict=True):
            env.move_outcome(row)
        # Where `measure` computes them, a view of all observations.
        self._measured: NDArray[np.float64] | None = None
        if first.measures and isinstance(self._observations, np.ndarray):
            self._measured = self._outcomes[:, first.outcome.action.size : -2].reshape(self._observations.shape)
        self._ended = np.zeros(num_envs, np.bool_)

    @property
    def threads(self) -> int:
        """How many threads step, with the calling one."""
        return self._crew.threads

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode in all environments.

        Args:
            seed: of the first environment, the others have those that follow; or one for each.
            options: of each environment's `reset`; ``reset_mask``: an array of which of them are reset.

        Raises:
            ParameterError: there are too many or too few seeds, or the mask is none.
            ClosedError: the environments are closed.
        """
        self._check_open()
        given = dict(options or {})
        mask = self._mask(given.pop("reset_mask", None))
        seeds: list[int | None] = [None] * self.num_envs
        if isinstance(seed, int):
            seeds = [seed + number for number in range(self.num_envs)]
        elif seed is not None:
            seeds = list(seed)
            if len(seeds) != self.num_envs:
                raise ParameterError(f"{len(seeds)} seeds were given for {self.num_envs} environments")
        infos: dict[str, Any] = {}
        for number in np.flatnonzero(mask).tolist():
            self._seen[number], info = self.envs[number].reset(seed=seeds[number], options=given or None)
            infos = self._add_info(infos, info, number)
        self._ended[mask] = False
        return self._collected(), infos

    def step(
        self, actions: Any
    ) -> tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Act for one period in all environments.

        Args:
            actions: a row for each environment; what is beyond `action_space` is clipped.

        Raises:
            ClosedError: the environments are closed.
            ParameterError: there are too many or too few actions.
            GazeboError: an environment failed; the message has its number, and the cause is its error.
        """
        self._check_open()
        rows = actions if isinstance(actions, np.ndarray) else np.asarray(actions)
        if len(rows) != self.num_envs:
            raise ParameterError(f"{len(rows)} actions were given for {self.num_envs} environments")
        modes = self.autoreset_mode
        again = self._ended if modes == AutoresetMode.NEXT_STEP else np.zeros_like(self._ended)
        if modes == AutoresetMode.DISABLED and self._ended.any():
            number = int(self._ended.argmax())
            raise ParameterError(f"environment {number} has ended; reset it by options={{'reset_mask': ...}}")
        clipped: Sequence[Any] = self.envs[0].clipped_rows(rows) or [None] * self.num_envs
        tasks = [
            _reset(env) if ended else env.step_beside(row, values)
            for env, row, values, ended in zip(self.envs, rows, clipped, again.tolist(), strict=True)
        ]
        # Resets last: Python does them while native code does the steps of the others.
        stepped = self._done(range(self.num_envs), tasks, np.argsort(again, kind="stable").tolist())
        self._seen, cut, infos = map(list, zip(*stepped, strict=True))
        rewards, ends, cuts = self._outcomes[:, -2].copy(), self._outcomes[:, -1] != 0.0, np.array(cut, np.bool_)
        rewards[again], ends[again] = 0.0, False
        self._ended = ends | cuts
        finals: dict[str, Any] = {}
        if modes == AutoresetMode.SAME_STEP and self._ended.any():
            over = np.flatnonzero(self._ended).tolist()
            for number in over:
                final = {"final_obs": self._observation(number), "final_info": infos[number]}
                finals = self._add_info(finals, final, number)
            begun = self._done(over, [_reset(self.envs[number]) for number in over])
            for number, (seen, _, info) in zip(over, begun, strict=True):
                self._seen[number], infos[number] = seen, info
        return self._collected(), rewards, ends, cuts, finals | self._joined(infos)

    def _done(
        self, numbers: Sequence[int], tasks: Sequence[Task[Stepped]], order: Sequence[int] | None = None
    ) -> list[Stepped]:
        """Run tasks of environments with these numbers.

        Raises:
            GazeboError: one failed.
        """
        done: list[Stepped] = []
        for number, outcome in zip(numbers, self._crew.run(tasks, order), strict=True):
            if isinstance(outcome, BaseException):
                raise GazeboError(f"environment {number} of {self.num_envs}: {outcome}") from outcome
            done.append(outcome)
        return done

    def _joined(self, infos: list[dict[str, Any]]) -> dict[str, Any]:
        """The infos of all environments as Gymnasium has them: an array of each entry, and a mask of who has it."""
        joined: dict[str, Any] = {}
        names = infos[0].keys()
        if all(info.keys() == names for info in infos):
            columns = {key: [info[key] for info in infos] for key in names}
            kinds = {key: {*map(type, column)} for key, column in columns.items()}
            if all(len(found) == 1 and _PLAIN.issuperset(found) for found in kinds.values()):
                for key, column in columns.items():
                    joined[key] = np.array(column, type(column[0]))
                    joined[f"_{key}"] = np.ones(len(infos), np.bool_)
                return joined
        for number, info in enumerate(infos):
            joined = self._add_info(joined, info, number)
        return joined

    def _collected(self) -> Any:
        """The observations of all environments."""
        space = self.single_observation_space
        if self._measured is not None:
            self._observations[...] = self._measured
        elif isinstance(space, spaces.Box):
            for number, seen in enumerate(self._seen):
                self._observations[number] = seen
        else:
            self._observations = concatenate(space, self._seen, self._observations)
        return deepcopy(self._observations) if self.copy else self._observations

    def _observation(self, number: int) -> Any:
        """The one of a single environment."""
        return self._seen[number] if self._measured is None else self._measured[number].astype(self._observations.dtype)

    def _mask(self, mask: Any) -> NDArray[np.bool_]:
        if mask is None:
            return np.ones(self.num_envs, np.bool_)
        if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
            raise ParameterError(f"reset_mask is {mask!r}; it must be an array of {self.num_envs} booleans")
        return mask

    def render(self) -> tuple[Any, ...]:
        """What `render` of each environment returns."""
        self._check_open()
        return tuple(env.render() for env in self.envs)

    def call(self, name: str, *arguments: Any, **options: Any) -> tuple[Any, ...]:
        """What a method or attribute of each environment returns or is."""
        found = [getattr(env, name) for env in self.envs]
        return tuple(one(*arguments, **options) if callable(one) else one for one in found)

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """An attribute of each environment."""
        return tuple(getattr(env, name) for env in self.envs)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of each environment: to one value, or to one of a list.

        Raises:
            ParameterError: there are too many or too few values.
        """
        each = list(values) if isinstance(values, (list, tuple)) else [values] * self.num_envs
        if len(each) != self.num_envs:
            raise ParameterError(f"{len(each)} values were given for {self.num_envs} environments")
        for env, value in zip(self.envs, each, strict=True):
            setattr(env, name, value)

    def close_extras(self, **_options: Any) -> None:
        """Close the environments, and end the threads."""
        self._crew.close()
        for env in self.envs:
            env.close()

    def _check_open(self) -> None:
        if self.closed:
            raise ClosedError("the environments are closed")


def _reset(env: WorldEnv) -> Task[Stepped]:
    """An episode that begins in place of a step."""
    seen, info = env.reset()
    return seen, False, info
    yield  # as a task, which has no job


# The name after "libgz/", without its version -> the class of single environments; and what makes many, by that name.
KINDS: dict[str, type[WorldEnv]] = {"World": WorldEnv, **TASKS}
globals().update({name: partial(WorldVectorEnv, kind) for name, kind in KINDS.items()})
