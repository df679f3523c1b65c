"""VisualPlugins: the Visual plugins of a world, loaded where images are rendered."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING

from libgz.classic.rendering.scene import scene_of
from libgz.classic.rendering.visual import Visual

if TYPE_CHECKING:
    from libgz.classic.loading import LoadedPlugin
    from libgz.classic.physics.model import Model
    from libgz.classic.physics.world import World
    from libgz.sdf.element import Element
    from libgz.simulation.entity import Entity as CoreModel

__all__ = ["VisualPlugins"]


class VisualPlugins:
    """Loads the `<plugin>` elements of visuals. Each visual owns its plugins."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._seen: dict[Visual, None] = {}

    def add(self, _models: Iterable[CoreModel] = ()) -> None:
        """Load the plugins of all visuals added since the last call, one visual after the other."""
        for visual in list(scene_of(self._world).visuals()):
            if visual not in self._seen:
                self._seen[visual] = None
                self._load(visual)

    @staticmethod
    def _load(visual: Visual) -> None:
        for element in visual.sdf.named("plugin") if visual.sdf is not None else ():
            visual.begin_plugin(element.Get(str, "filename"), element.Get(str, "name"), element)
        visual.init_plugins()

    def plugins(self) -> Iterator[LoadedPlugin]:
        """All running plugins."""
        for visual in scene_of(self._world).visuals():
            yield from visual.plugins

    def plugins_by_holder(self) -> Iterator[tuple[str, str, list[LoadedPlugin]]]:
        """("Visual", name of the visual, its plugins) of all visuals that have any."""
        for visual in self._seen:
            if visual.plugins:
                yield "Visual", visual.Name(), visual.plugins

    def elements(self) -> Iterator[tuple[str, Element]]:
        """(name of the visual, `<plugin>`) of all visuals."""
        for visual in self._seen:
            for element in visual.sdf.named("plugin") if visual.sdf is not None else ():
                yield visual.Name(), element

    def holder(self, name: str) -> tuple[Visual | None, Callable[[str, str, Element | None], object]]:
        """A visual by its full name, and a function that loads one more plugin for it."""
        visual = scene_of(self._world).GetVisual(name)
        return visual, visual.LoadPlugin if visual is not None else lambda *_: None

    def remove_of(self, model: Model) -> None:
        """Remove the plugins of the visuals of a model that is being deleted."""
        for visual in scene_of(self._world).model_visual(model).tree():
            self._drop(visual)

    def _drop(self, visual: Visual) -> None:
        for plugin in visual.plugins:
            plugin.drop()
        visual.plugins.clear()
        self._seen.pop(visual, None)

    def close(self) -> None:
        """Remove all plugins."""
        for visual in list(scene_of(self._world).visuals()):
            self._drop(visual)
