"""SceneLink: a client's copy of the server's world, for rendering."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz.base.errors import GazeboError, ServerError
from libgz.classic import msgs
from libgz.classic.commands import Commands, PausedSteps
from libgz.classic.physics.base import Entity
from libgz.classic.server import WorldServer
from libgz.classic.transport import Node, TopicManager, request
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["SceneLink", "only_looks"]

log = logging.getLogger("libgz.classic")

TIMEOUT = 30.0  # [s] for the server to answer


def only_looks(root: Element) -> None:
    """Remove what runs in the server: sensors, and plugins other than those of visuals and of the client."""
    for element in list(_all(root)):
        acts = element.name == "sensor" or (
            element.name == "plugin" and element.parent is not None and element.parent.name not in ("visual", "gui")
        )
        if acts and element.parent is not None:
            element.parent.RemoveChild(element)


def _all(element: Element) -> Iterator[Element]:
    for child in element.children:
        yield child
        if child.name != "plugin":
            yield from _all(child)


class SceneLink:
    """A world without physics, updated from the server.

    Args:
        timeout: how long the server may take to answer [s].

    Attributes:
        node: in the server's world.
        world: the classic world; its events PreRender, Render and PostRender are the client's.

    Raises:
        ServerError: no world answers.
        WorldFileError: the server's world cannot be read.
    """

    def __init__(self, timeout: float = TIMEOUT) -> None:
        self._timeout = timeout
        self.node = Node()
        self.node.Init()
        self._core = CoreWorld()
        self._core.physics_enabled = False
        self.world: World = self._build(self._ask())
        self._entities: dict[str, Entity | None] = {}
        self._waiting: list[Any] = []
        commands = Commands(self.world, lambda _answer: None, PausedSteps(self._core))
        self._subscribers = (
            self.node.Subscribe("~/pose/info", self._waiting.append),
            self.node.Subscribe("~/light/modify", commands.guarded("~/light/modify", commands.light_modify)),
        )

    def _ask(self) -> SdfFile:
        """The server's world as it is now, without sensors and plugins."""
        name = self.node.GetTopicNamespace()
        try:
            answer = request(name, "world_sdf", timeout=self._timeout)
        except GazeboError as error:
            raise ServerError(f"the server has no scene to show: {error}") from None
        text = msgs.GzString.FromString(answer.serialized_data).data
        file = SdfFile.from_string(text, f"<world {name}>", Path.cwd())
        only_looks(file.root)
        return file

    def _build(self, file: SdfFile) -> World:
        core = self._core
        try:
            core.extension(SdfWorld).load(file)
            server = WorldServer(core, quiet=True)
            core.companions.append(server)
            core.Initialize()
        except BaseException:
            core.close()
            raise
        core.paused = True
        return server.world

    # Updates -----------------------------------------------------------------------------------------------------

    def update(self) -> None:
        """Apply the server's messages since the last call."""
        TopicManager.Instance().ProcessNodes()
        waiting, self._waiting[:] = list(self._waiting), []
        if waiting:
            self._follow(waiting[-1])  # the newest message contains everything

    def _follow(self, message: Any) -> None:
        """Set time, models and lights from a message of poses."""
        self._core.set_sim_time(message.time.sec + 1e-9 * message.time.nsec)
        here = {part.GetName() for part in self.world.children()}
        if here != {pose.name for pose in message.pose if "::" not in pose.name}:
            self._follow_changes()
        for pose in message.pose:
            entity = self._entity(pose.name)
            if entity is not None:
                entity.SetRelativePose(msgs.ConvertIgn(pose))

    def _entity(self, name: str) -> Entity | None:
        if name not in self._entities:
            self._entities[name] = self.world.EntityByName(name)
        return self._entities[name]

    def _follow_changes(self) -> None:
        """Add and remove models and lights as the server did."""
        holder = next(self._ask().root.named("world"))
        there = {e.Get(str, "name"): e for e in holder.children if e.name in ("model", "light")}
        here = {part.GetName() for part in self.world.children()}
        for name in here - there.keys():
            self.world.RemoveModel(name)
        version = file.version if (file := self._core.extension(SdfWorld).file) is not None else "1.6"
        for name, element in there.items():
            if name not in here:
                self.world.InsertModelString(f"<sdf version='{version}'>{element.ToString()}</sdf>")
        self._entities.clear()
        if self.world.server.visuals is not None:
            self.world.server.visuals.add()

    def close(self) -> None:
        """Close the copy."""
        self.node.Fini()
        self._core.close()
