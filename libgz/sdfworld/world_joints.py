"""WorldJoints: the joints that stand in a `<world>` beside its models."""

from __future__ import annotations

from typing import Any

from libgz.base.errors import Diagnostics, explain
from libgz.base.geometry import GzPose
from libgz.physics.body import Body
from libgz.physics.joint import Joint
from libgz.sdf.element import Element
from libgz.sdfworld.axis import lost_link, read_joint
from libgz.sdfworld.description import describe_sdf_joint, ode_joints
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.joint_table import JointTable
from libgz.simulation.description import Store
from libgz.simulation.entity import Entity
from libgz.simulation.plan import Plan
from libgz.simulation.state import decode, encode
from libgz.simulation.world import World

__all__ = ["WorldJoints"]


class WorldJoints(Entity):
    """The world's own joints. It has a dummy body at the world's origin.

    Args:
        world: where.
        holder: the `<world>`, which contains the `<joint>` elements.
        diagnostics: takes warnings: what cannot be made is left out.
    """

    is_model = False

    def __init__(self, world: World, holder: Element, diagnostics: Diagnostics) -> None:
        super().__init__(world)
        self.sdf = holder
        self.SetName("joints")
        self.SetId("world_joints")
        self.AddBody(Body(world, dummy=True), True)
        self.sdf_joints = JointTable(world, holder)
        for element in holder.named("joint"):
            if lost := lost_link(element, self.find_link):
                diagnostics.warn(element, lost)
                continue
            try:
                plan = read_joint(element, self.find_link, GzPose(), diagnostics.warn)
                self.sdf_joints.add(SdfJoint(world.engine, plan))
            except Exception as error:  # noqa: BLE001 - whatever it met
                diagnostics.warn(element, f"{explain(error)}; it is left out")

    def SaveState(self) -> tuple[bytes, bytes]:
        """The joints, and their efforts."""
        joints = encode(self.sdf_joints.save())
        return joints, b"".join([joint.efforts for joint in self.sdf_joints.values()])

    def LoadState(self, state: tuple[bytes, bytes]) -> None:
        """Take what SaveState returned."""
        joints, efforts = state
        if joints != self.SaveState()[0]:
            self.sdf_joints.load(decode(joints))
        SdfJoint.load_efforts(self.sdf_joints.values(), efforts)

    def _entity_plan(self, plan: Plan) -> None:
        """Updated in Python while a joint acts by itself."""
        if any(joint.acts for joint in self.sdf_joints.values()):
            plan.do(self.MasterUpdate)

    def MasterUpdate(self, step: float) -> None:
        """Apply damping, springs, threads and gears of the joints."""
        if step > 0.0:
            for joint in self.sdf_joints.values():
                if joint.acts:
                    joint.update()

    def _entity_joints(self) -> list[Joint]:
        """What ODE has of the joints of the file."""
        return ode_joints(self.sdf_joints.values())

    def _entity_describe(self, store: Store) -> dict[str, Any]:
        """As of all entities; joints by SDF's kinds."""
        joints = [describe_sdf_joint(joint) for joint in self.sdf_joints.values()]
        return {**super()._entity_describe(store), "joints": joints}

    def find_link(self, name: str) -> Body:
        """A link by `model::link`; a model's name alone is its first link.

        Raises:
            NotFoundError: there is none.
        """
        for entity in self.world.entities:
            if entity.GetId() == name:
                return entity.GetBody()
        owner, _, link = name.rpartition("::")
        found: Entity = self.world.model(owner)
        return found.GetBody(link)

    def close(self) -> None:
        """Destroy the joints."""
        for joint in self.sdf_joints.values():
            joint.close()
        super().close()
