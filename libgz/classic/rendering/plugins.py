"""VisualPlugins: the Visual plugins of a world, loaded where pictures are drawn."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from libgz.classic.rendering.scene import scene_of
from libgz.classic.rendering.visual import Visual

if TYPE_CHECKING:
    from libgz.classic.loading import LoadedPlugin
    from libgz.classic.physics.model import Model
    from libgz.classic.physics.world import World
    from libgz.simulation.entity import Entity as CoreModel

__all__ = ["VisualPlugins"]


class VisualPlugins:
    """Loads the `<plugin>` elements of visuals. Each visual holds its own plugins; this finds them."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._seen: set[Visual] = set()

    def add(self, _models: Iterable[CoreModel] = ()) -> None:
        """Load the plugins of all visuals that have come since the last time: whole visuals, one after the other."""
        for visual in list(scene_of(self._world).visuals()):
            if visual not in self._seen:
                self._seen.add(visual)
                self._load(visual)

    @staticmethod
    def _load(visual: Visual) -> None:
        for element in visual.sdf.named("plugin") if visual.sdf is not None else ():
            visual.begin_plugin(element.Get(str, "filename"), element.Get(str, "name"), element)
        visual.init_plugins()

    def plugins(self) -> Iterator[LoadedPlugin]:
        """All of them that run."""
        for visual in scene_of(self._world).visuals():
            yield from visual.plugins

    def remove_of(self, model: Model) -> None:
        """A model leaves: so do the plugins of its visuals."""
        for visual in scene_of(self._world).model_visual(model.core).tree():
            self._drop(visual)

    def _drop(self, visual: Visual) -> None:
        for plugin in visual.plugins:
            plugin.drop()
        visual.plugins.clear()
        self._seen.discard(visual)

    def close(self) -> None:
        """Let all go."""
        for visual in list(scene_of(self._world).visuals()):
            self._drop(visual)
