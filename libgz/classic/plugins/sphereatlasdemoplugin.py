"""SphereAtlasDemoPlugin: holds the joints of the humanoid robot Atlas where they are at the start."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError
from libgz.classic.common import PID
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

# Part of a joint's name, and the gains P [N m/rad] and D [N m s/rad] of those that have it; the first that fits.
GAINS = {"neck": (100.0, 1.0), "arm": (1000.0, 10.0), "leg": (4000.0, 40.0), "back": (5000.0, 50.0)}


class SphereAtlasDemoPlugin(ModelPlugin):
    """Holds the joints of arms, legs, back and neck at the position zero by PD controllers, so that the robot stands.

    The joints are those with `arm`, `leg`, `back` or `neck` in their names.
    """

    STATE = ("pids", "last")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints.

        Raises:
            NotFoundError: the model has none of them.
        """
        self.joints: list[Joint] = []
        self.pids: list[PID] = []
        for joint in model.all_joints():
            gains = next((gains for part, gains in GAINS.items() if part in joint.GetName()), None)
            if gains is not None and joint.DOF() == 1:
                self.joints.append(joint)
                self.pids.append(PID(gains[0], 0.0, gains[1]))
        if not self.joints:
            raise NotFoundError(
                f"{sdf.where}: model {model.GetName()!r} has no joints with {', '.join(GAINS)} in their names"
            )
        self.world = model.GetWorld()
        self.last = self.world.SimTime().Double()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Begin again."""
        self.last = self.world.SimTime().Double()
        for pid in self.pids:
            pid.Reset()

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply the efforts."""
        now = info.simTime.Double()
        for joint, pid in zip(self.joints, self.pids, strict=True):
            joint.SetForce(0, pid.Update(joint.Position(0), now - self.last))
        self.last = now


GZ_REGISTER_MODEL_PLUGIN(SphereAtlasDemoPlugin)
