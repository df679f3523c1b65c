"""ContainPlugin: reports whether a box contains an entity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin
from libgz.classic.plugins._boxes import Box, box_of

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.sdf.element import Element


class ContainPlugin(WorldPlugin):
    """Publishes on /<namespace>/contain, as an Int, 1 when the origin of an entity enters a box, 0 when it leaves.

    The first message follows in the first iteration. An Int on /<namespace>/enable starts (1) and stops (0) it.

    Elements:
        entity: its scoped name, such as `robot` or `robot::arm`.
        namespace: of the topics.
        enabled: whether it runs from the start on (true).
        pose: of the box [m], [rad]: in the world frame, or in that of the entity that an attribute `frame` names.
        geometry: `<box><size>` [m].
    """

    STATE = ("enabled", "contained")

    def Load(self, world: World, sdf: Element) -> None:
        """Read the box, and subscribe.

        Raises:
            NotFoundError: an element is missing.
        """
        self.world = world
        for tag in ("entity", "namespace"):
            if not sdf.Get(str, tag).strip():
                raise NotFoundError(f"{sdf.where}: <{tag}> is missing")
        self.entity, space = sdf.Get(str, "entity").strip(), sdf.Get(str, "namespace").strip().strip("/")
        pose = next(sdf.named("pose"), None)  # the attribute of one is the frame
        self.box, self.frame = box_of(sdf), pose.Get(str, "frame").strip() if pose is not None else ""
        self.start = sdf.Get(bool, "enabled", True)[0]
        self.node = transport.Node()
        self.node.Init(space)
        self.publisher = self.node.Advertise(msgs.Int, f"/{space}/contain")
        self.subscriber = self.node.Subscribe(f"/{space}/enable", self.OnEnable, kind="Int")
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Return to the state of the start."""
        self.enabled = self.start
        self.contained: bool | None = None  # not known yet

    def OnEnable(self, message: Any) -> None:
        """Start or stop."""
        self.enabled, self.contained = bool(message.data), None

    def OnUpdate(self) -> None:
        """Compare."""
        entity = self.world.EntityByName(self.entity) if self.enabled else None
        if entity is None:
            return
        box = self.box
        if self.frame:
            frame = self.world.EntityByName(self.frame)
            if frame is None:
                return
            box = Box(frame.WorldPose() * box.pose, box.size)
        contained = box.contains(entity.WorldPose().Pos())
        if contained != self.contained:
            self.contained = contained
            self.publisher.Publish(msgs.Int(data=int(contained)))


GZ_REGISTER_WORLD_PLUGIN(ContainPlugin)
