"""JointTrajectoryPlugin: moves joints periodically."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import find_joint

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class JointTrajectoryPlugin(ModelPlugin):
    """Sets joints to the position cos(t) [rad] or [m] in every iteration, t being the sim time [s].

    Their velocities are set accordingly, so that the links do not accelerate under gravity.

    Elements:
        joint: the name of a joint; any number of them.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints."""
        self.joints = [find_joint(model, element.Get(str).strip()) for element in sdf.named("joint")]
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Move the joints."""
        now = info.simTime.Double()
        for joint in self.joints:
            joint.SetPosition(0, math.cos(now))
            joint.SetVelocity(0, -math.sin(now))


GZ_REGISTER_MODEL_PLUGIN(JointTrajectoryPlugin)
