"""WorldServices: the interface of `libgz.classic.server.WorldServer` that the views of its world use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from libgz.classic.loading import LoadedPlugin
from libgz.classic.physics.activity import Activity
from libgz.classic.physics.engine import PhysicsEngine
from libgz.classic.physics.ids import Ids
from libgz.classic.physics.joint import Joint
from libgz.classic.physics.model import Model
from libgz.classic.physics.preset import PresetManager
from libgz.sdf.element import Element

if TYPE_CHECKING:
    from libgz.classic.physics.link import Link
    from libgz.classic.physics.world import World

__all__ = ["PluginServices", "WorldServices"]


class PluginServices(Protocol):
    """The plugins of a world, as its views use them: `libgz.classic.world_plugins.WorldPlugins`."""

    def new(self, kind: str, filename: str, name: str, holder: str, sdf: Element | None) -> LoadedPlugin | None:
        """A plugin of this world, constructed; None if that fails, which is logged."""

    def load_for_world(self, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a World plugin; returns whether it runs."""

    def load_for_model(self, model: Model, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a Model plugin; returns whether it runs."""

    def remove_from_world(self, name: str) -> None:
        """Remove a World plugin.

        Raises:
            NotFoundError: there is none of this name.
        """

    def plugin_names(self) -> list[str]:
        """What the plugins of this world are called."""

    def has_plugin(self, name: str) -> bool:
        """Whether a plugin, or a plugin's file, is called this."""

    def reload_plugin(self, name: str) -> list[str]:
        """Load the edited files of plugins again; what was replaced.

        Raises:
            PluginError: one of them fails.
        """

    def reset_others(self) -> None:
        """Call Reset of the plugins that are none of models."""

    def reset_of(self, model: Model) -> None:
        """Reset the Model plugins of a model."""


class WorldServices(Protocol):
    """What the server of a world offers to views; it keeps the state that is neither the engine's nor a view's.

    Attributes:
        world: the view on the world.
        element: the `<world>` element; None if the world was not loaded from SDF.
        ids: the numbers of views.
        activity: joint controllers, batteries, animations and attached models.
        physics, presets: settings of the engine, and their profiles.
        sensors, visuals, scene: sensors, Visual plugins and the rendered part, of packages above this one; None as long
            as there are none.
        stopped: whether World.Stop was called.
    """

    world: World
    element: Element | None
    ids: Ids
    activity: Activity
    physics: PhysicsEngine
    presets: PresetManager
    sensors: Any
    visuals: Any
    scene: Any
    stopped: bool

    @property
    def plugins(self) -> PluginServices:
        """The plugins of the world."""

    def described(self, entity: object) -> Any:
        """The message that describes a model, link, joint, collision or light; None for anything else."""

    def all_sensors(self) -> Any:
        """The sensors, created on first use."""

    def sensors_of(self, holder: Link | Joint) -> list[Any]:
        """The sensors that a link carries, or that measure a joint."""

    def sensor_names(self) -> list[str]:
        """The full scoped names of all sensors."""

    def serve_visuals(self) -> Any:
        """The Visual plugins, created on first use."""

    def finish_added(self) -> None:
        """Create sensors and plugins of models that were inserted."""

    def joint_added(self, joint: Joint) -> None:
        """A joint was added to a model."""

    def joint_removed(self, joint: Joint) -> None:
        """A joint was removed from its model."""

    def time_was_reset(self) -> None:
        """The sim time was set back."""
