"""MisalignmentPlugin: publishes the pose of one frame in another."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic import msgs, transport
from libgz.classic.common import gzwarn
from libgz.classic.event import Events
from libgz.classic.math import Pose3d
from libgz.classic.plugin import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import World
    from libgz.sdf.element import Element


class MisalignmentPlugin(WorldPlugin):
    """Publishes how far a target is from a reference on /<namespace>/misalignment, a PoseStamped, in each iteration.

    Elements:
        pose: two, the reference and the target [m, rad]; the attribute `frame` names the model or link that it is in;
            without it, the world.
        namespace: of the topics; required. An Int on /<namespace>/enable switches the plugin on (1) or off (0).
        enabled: whether it is on from the start (true).
    """

    STATE = ("enabled",)

    def Load(self, world: World, sdf: Element) -> None:
        """Read the elements, and advertise.

        Raises:
            ParameterError: a pose or the namespace is missing.
        """
        poses = list(sdf.named("pose"))
        if len(poses) < 2:
            raise ParameterError(f"{sdf.where}: Two <pose> tags are required: the reference and the target")
        space = sdf.Get(str, "namespace").strip()
        if not space:
            raise ParameterError(f"{sdf.where}: <namespace> is missing; the topics are in it")
        self.world = world
        self.frames = [
            (element.Get(str, "frame").strip() if element.HasAttribute("frame") else "", element.Get(Pose3d))
            for element in poses[:2]
        ]
        self.missing: set[str] = set()
        self.node = transport.Node()
        self.node.Init(world.Name())
        self.publisher = self.node.Advertise(msgs.PoseStamped, f"/{space}/misalignment")
        self.subscriber = self.node.Subscribe(f"/{space}/enable", self.OnEnable, kind="Int")
        self.initially = self.LoadParam(sdf, "enabled", True)
        self.connection: object | None = None
        self.enabled = False
        self.Reset()

    def OnEnable(self, message: Any) -> None:
        """Switch it on or off."""
        self._enable(message.data != 0)

    def _enable(self, on: bool) -> None:
        self.enabled = on
        if self.connection is None:
            self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """As at the start."""
        self._enable(self.initially)

    def _pose(self, frame: str, pose: Pose3d) -> Pose3d | None:
        """A pose in the world; None while there is no such frame."""
        if not frame:
            return pose
        entity = self.world.EntityByName(frame)
        if entity is None:
            if frame not in self.missing:
                self.missing.add(frame)
                gzwarn(f"Did not find {frame}; its misalignment is published once there is one.")
            return None
        self.missing.discard(frame)
        found: Pose3d = pose + entity.WorldPose()
        return found

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Publish."""
        if not self.enabled:
            return
        reference, target = (self._pose(frame, pose) for frame, pose in self.frames)
        if reference is None or target is None:
            return
        message = msgs.PoseStamped()
        msgs.Set(message.time, info.simTime)
        msgs.Set(message.pose, target - reference)
        self.publisher.Publish(message)


GZ_REGISTER_WORLD_PLUGIN(MisalignmentPlugin)
