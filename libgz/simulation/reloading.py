"""Reloading: edited plugin files are loaded again while the world runs.

`World.reload_plugin` (`simulation/reloading.py`) asks all `World.reloaders` that have a plugin of this name, between
two steps and
with insertions held back.

- Files. `reload_plugin` in `simulation/plugins.py` runs a file again, and the modules beside it if one of them changed;
  if that
  fails, `sys.modules` is as before.
- Classic. `LoadedPlugin.reload` keeps its place in all lists and exchanges what it holds: class, instance, connections.
  The
  old connections end last. If the new instance fails, `WorldServer` restores the state from before.
- Legacy. `legacy/replacement.py` builds the new model beside the old one, lets its interfaces take over the memory of
  the
old ones (`LocalServer.hand_over`), and exchanges both in the lists. The engine's objects are in another order then, so
  states from
before do not fit: `World.forget_states`. The next reset takes the state at the start from another world of the same
  file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from libgz.base.errors import NotFoundError, nearest

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = ["Reloader", "reload"]


class Reloader(Protocol):
    """A part of a world that has plugins; it is registered in `World.reloaders`."""

    def plugin_names(self) -> list[str]:
        """What its plugins are called, for messages."""

    def has_plugin(self, name: str) -> bool:
        """Whether a plugin, or a plugin file, is called this."""

    def reload_plugin(self, name: str) -> list[str]:
        """Load the files of all plugins that are called this again, and replace what runs of them.

        Returns:
            What was replaced, such as ``Model plugin robot1::drive``.

        Raises:
            PluginError: an edited file fails; what ran before runs on.
        """


def reload(world: World, name: str) -> list[str]:
    """Do what `World.reload_plugin` describes, between two steps.

    Raises:
        NotFoundError: no plugin has this name.
        PluginError: an edited file fails.
    """
    chosen = [part for part in world.reloaders if part.has_plugin(name)]
    if not chosen:
        names = list(dict.fromkeys(one for part in world.reloaders for one in part.plugin_names()))
        raise NotFoundError(
            f"world {world.name!r} has no plugin {name!r}; it has {', '.join(names) or 'none'}{nearest(name, names)}"
        )
    found: list[str] = []
    with world.hold():
        deferred = world.agenda.deferred
        before = len(deferred)
        try:
            for part in chosen:
                found += part.reload_plugin(name)
        except BaseException:
            del deferred[before:]  # what the failed plugin asked for
            raise
    return found
