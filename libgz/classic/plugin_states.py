"""PluginStates: which plugins a state of a world has, and their own states."""

from __future__ import annotations

import contextlib
import logging
import math
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Sequence
from operator import attrgetter, itemgetter
from typing import Any

from libgz.base.errors import PluginError, StateError
from libgz.classic.loading import LoadedPlugin, is_ready
from libgz.classic.world_plugins import WorldPlugins
from libgz.simulation.state import decode, encode, undeclared
from libgz.simulation.world import World as CoreWorld

__all__ = ["PluginStates"]

log = logging.getLogger("libgz.classic")

KINDS = ("World", "Model", "Sensor", "Visual")  # of plugins that belong to a world


class PluginStates:
    """Saves which plugins run in a world, in which order, and their states; makes them so again.

    Args:
        core: the engine's world.
        plugins: its plugins.
    """

    def __init__(self, core: CoreWorld, plugins: WorldPlugins) -> None:
        self._core, self._plugins = core, plugins
        self._first: dict[tuple[str, str, str, str], int] = {}  # the numbers of plugins at the start
        self._seen: set[type] = set()  # classes of plugins; those without a declared state were reported

    def note_start(self) -> None:
        """The plugins of the world's start are loaded."""
        self._first = {
            (kind, holder, plugin.filename, plugin.name): plugin.number
            for kind, holder, plugin in self._plugins.present()
        }

    def differ(self, listed: bytes) -> bool:
        """Whether plugins of a state's list do not run."""
        return not self.is_current(listed) and any(True for _ in self._missing(listed))

    def _missing(self, listed: bytes) -> Iterator[tuple[str, str, str, str, str]]:
        """(kind, name of the holder, file, name, text) of plugins in a list that do not run."""
        running = Counter((kind, holder, one.filename, one.name) for kind, holder, one in self._plugins.present())
        for kind, holder, rows in decode(listed):
            for filename, name, source, *_ in rows:
                running[kind, holder, filename, name] -= 1
                if running[kind, holder, filename, name] < 0:
                    yield kind, holder, filename, name, source

    def _surplus(self, listed: bytes) -> Iterator[tuple[str, LoadedPlugin]]:
        """(kind, plugin) of plugins that run and are not in a list."""
        wanted = Counter(
            (kind, holder, filename, name) for kind, holder, rows in decode(listed) for filename, name, *_ in rows
        )
        for kind, holder, plugin in self._plugins.present():
            wanted[kind, holder, plugin.filename, plugin.name] -= 1
            if wanted[kind, holder, plugin.filename, plugin.name] < 0:
                yield kind, plugin

    @contextlib.contextmanager
    def discarding(self) -> Iterator[None]:
        """What plugins that are loaded for a state insert or delete has no effect, for the state has it."""
        with self._core.hold():
            deferred = self._core.agenda.deferred
            before = len(deferred)
            try:
                yield
            finally:
                del deferred[before:]

    def load_missing(self, listed: bytes) -> None:
        """Load the plugins of a state that do not run, but those that need its sensors and visuals."""
        for kind, plugin in [*self._surplus(listed)]:
            if kind in ("World", "Model"):  # drop it before others are loaded, which may serve what it does
                plugin.drop()
        for kind, *names in [*self._missing(listed)]:
            if kind in ("World", "Model"):
                self._plugins.load_again(kind, *names)
        for *_, plugins in self._plugins.by_holder():
            plugins[:] = [plugin for plugin in plugins if plugin.plugin is not None]

    def is_current(self, listed: bytes) -> bool:
        """Whether the plugins that run are those of a state's list."""
        return listed == self._listed()

    def save(self) -> tuple[bytes, list[Any]]:
        """Which plugins there are, encoded, and the states of those that keep one."""
        return self._listed(), [plugin.save() for plugin in self._keeping()]

    def _keeping(self) -> list[LoadedPlugin]:
        """The plugins that keep a state, in the order of their list."""
        holders = sorted(self._plugins.by_holder(), key=itemgetter(0, 1))
        return [one for *_, plugins in holders for one in plugins if one.plugin is not None and one.keeps]

    def _listed(self) -> bytes:
        """By kind and holder: file, name and text of each plugin, when it was loaded, and whether it keeps a state."""
        rows = []
        holders = sorted(self._plugins.by_holder(), key=itemgetter(0, 1))
        numbers = sorted(one.number for *_, plugins in holders for one in plugins if one.plugin is not None)
        for kind, holder, plugins in holders:
            running = [plugin for plugin in plugins if plugin.plugin is not None]
            for plugin in plugins:
                if plugin.plugin_class not in self._seen and not self._plugins.reloading:
                    self._warn_of_undeclared(plugin)
            if running:
                kept = [(p.filename, p.name, p.source, bisect_left(numbers, p.number), p.keeps) for p in running]
                rows.append((kind, holder, kept))
        return encode(rows)

    def load(self, listed: bytes, states: Sequence[Any]) -> bool:
        """Make the plugins those of a state, and set their states; whether they were others."""
        if self.is_current(listed):
            for plugin, saved in zip(self._keeping(), states, strict=True):
                self._load_state(plugin, saved)
            return False
        left = iter(states)
        wanted = {
            (kind, holder): [(*names, next(left) if keeps else None) for *names, keeps in rows]
            for kind, holder, rows in decode(listed)
        }
        for kind, _ in wanted:
            if kind not in KINDS:
                raise StateError(f"the state is damaged: plugins are of the kinds {', '.join(KINDS)}, not {kind!r}")
        order: list[tuple[int, LoadedPlugin]] = []
        with self.discarding():
            for kind, holder, plugins in list(self._plugins.by_holder()):
                order += self._match(kind, holder, plugins, wanted.pop((kind, holder), ()))
            for (kind, holder), rows in wanted.items():
                order += self._match(kind, holder, [], rows)
        self._arrange([plugin for _, plugin in sorted(order, key=itemgetter(0))])
        return True

    @staticmethod
    def _arrange(order: Sequence[LoadedPlugin]) -> None:
        """Have the callbacks of plugins called in the order in which a state has them loaded."""
        numbers = sorted(plugin.number for plugin in order)
        for place, (plugin, number) in enumerate(zip(order, numbers, strict=True)):
            if any(other.number < plugin.number for other in order[place + 1 :]):
                plugin.precede(set(order[place + 1 :]))
            plugin.number = number

    def arrange_as_at_start(self) -> None:
        """Have the plugins of the start called in its order, which a state may have changed; later ones come last."""
        present = [
            (self._first.get((kind, holder, plugin.filename, plugin.name), math.inf), plugin.number, plugin)
            for kind, holder, plugin in self._plugins.present()
        ]
        self._arrange([plugin for *_, plugin in sorted(present, key=itemgetter(0, 1))])
        for *_, plugins in self._plugins.by_holder():
            plugins.sort(key=attrgetter("number"))

    def _match(
        self, kind: str, holder: str, present: list[LoadedPlugin], rows: Sequence[Any]
    ) -> list[tuple[int, LoadedPlugin]]:
        """Drop plugins that came since a state, load again those that ended, and set their states.

        Returns:
            The plugins, and their numbers in the order in which they were loaded.
        """
        left = [plugin for plugin in present if plugin.plugin is not None]
        kept: list[LoadedPlugin | None] = []
        for filename, name, *_ in rows:
            same = next((one for one in left if (one.filename, one.name) == (filename, name)), None)
            left = [other for other in left if other is not same]
            kept.append(same)
        for plugin in left:  # before others are loaded, as in `load_missing`
            plugin.drop()
        found = []
        for same, (filename, name, source, number, saved) in zip(kept, rows, strict=True):
            one = same or self._plugins.load_again(kind, holder, filename, name, source)
            if one is not None:
                found.append((one, number, saved))
            else:
                reason = self._plugins.failures.get((kind, holder, filename, name)) or "the log says why"
                place = f" of {holder}" if holder else ""
                self._core.snapshots.failures.append(
                    StateError(f"{kind} plugin {name!r}{place} of the state cannot be loaded again: {reason}")
                )
        present[:] = [plugin for plugin, *_ in found]
        for plugin, _, saved in found:
            self._load_state(plugin, saved)
        return [(number, plugin) for plugin, number, _ in found]

    def _load_state(self, plugin: LoadedPlugin, saved: Any) -> None:
        """Set the state of a plugin; what fails is kept, and the other plugins are set all the same."""
        try:
            plugin.load_state(saved)
        except PluginError as error:
            self._core.snapshots.failures.append(error)

    def _warn_of_undeclared(self, plugin: LoadedPlugin) -> None:
        kind: Any = plugin.plugin_class
        self._seen.add(kind)
        if undeclared(kind) and not is_ready(plugin.path):  # those of libgz declare theirs in their bases
            if getattr(kind, "not_kept", ""):  # one in C++
                log.warning("%s: %s", plugin, kind.not_kept)
                return
            log.warning(
                "%s: class %s does not declare its state, so snapshots of the world do not have it; name its "
                'attributes, `STATE = ("goal", "since")`, or write `STATE = ()` if it remembers nothing',
                plugin,
                kind.__name__,
            )
