"""gazebo_mimic_joint_plugin: a joint follows another one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.law import law
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint
from libgz.sdfworld.mimic import Mimic

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class MimicJointPlugin(ModelPlugin):
    """Keeps a joint at ``multiplier * position of the leader + offset`` by its motor; the leader does not feel it.

    The plugin of the package roboticsgroup_gazebo_plugins sets the position instead, so that a follower passes through
    what it meets; here it is held by what is in its way.

    Elements:
        joint: the leader.
        mimicJoint: the follower, a revolute or prismatic joint.
        multiplier, offset: (1), (0) [rad or m].
        maxEffort: of the follower [N m or N] (the limit of the joint).
        sensitiveness: deviation that is not corrected [rad or m] (0).
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints.

        Raises:
            NotFoundError: there is no such joint.
            ParameterError: the follower has no motor, or the leader no axis.
        """
        leader, follower = named_joint(model, sdf, "joint"), named_joint(model, sdf, "mimicJoint")
        self.mimic = Mimic(
            leader.GetName(),
            follower.GetName(),
            {joint.GetName(): joint.core for joint in (leader, follower)},
            multiplier=sdf.Get(float, "multiplier", 1.0)[0],
            offset=sdf.Get(float, "offset", 0.0)[0],
            effort=sdf.Get(float, "maxEffort") if sdf.HasElement("maxEffort") else None,
            tolerance=sdf.Get(float, "sensitiveness", 0.0)[0],
        )
        self.tables = model.GetWorld().core.engine.tables.record
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    @law
    def OnUpdate(self) -> None:
        """Let the follower follow."""
        self.mimic.update(self.tables.step)


GZ_REGISTER_MODEL_PLUGIN(MimicJointPlugin)
