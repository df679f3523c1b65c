"""WorldTopics: what a world says and hears on Gazebo's topics."""

from __future__ import annotations

from libgz.classic.physics.registry import live_worlds
from libgz.classic.physics.world import World
from libgz.classic.transport import TopicManager

__all__ = ["WorldTopics"]


class WorldTopics:
    """The topics of one world."""

    def __init__(self, world: World) -> None:
        self._world = world
        TopicManager.Instance().AddTopicNamespace(world.Name())

    def update(self) -> None:
        """Deliver what was published in this iteration."""
        TopicManager.Instance().ProcessNodes()

    def close(self) -> None:
        """The world ends; so do its topics, unless another world of this process has the same name."""
        name = self._world.Name()
        if not any(world.Name() == name for world in live_worlds() if world is not self._world):
            TopicManager.Instance().RemoveTopicNamespace(name)
