"""SdfGripper: a `<gripper>`, which fixes what its links hold to its palm."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from libgz.base.errors import NotFoundError, ParameterError
from libgz.base.geometry import GzCoordPoseSub, GzVector
from libgz.physics.body import Body
from libgz.sdf.element import Element
from libgz.sdfworld.axis import Axis
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.joint_table import JointTable
from libgz.simulation.world import World

__all__ = ["SdfGripper"]

CALM = 0.01  # [m/s] at which what is held may still move in the palm's frame
CALM_STEPS = 10  # for so many steps
LEAST_TOUCHES = 2  # of the geom that is fixed, with links of the gripper


class Holder(Protocol):
    """The part of a model that its grippers use."""

    world: World
    sdf_joints: JointTable

    def find_link(self, name: str) -> Body:
        """A link by name."""

    def make_joint(self, name: str, kind: str, parent: Body | None, child: Body | None, *axes: Axis) -> SdfJoint:
        """Join two links as they stand now."""

    def remove_joint(self, name: str) -> bool:
        """Destroy a joint."""


class SdfGripper:
    """Fixes a body to the palm while the gripper's links hold it.

    In each step the pairs of geoms are counted in which a link of the gripper touches something that can move. With
    `min_contact_count` of them in more than `attach_steps` steps, a body that touches twice and rests in the palm's
    frame is fixed to the palm by a joint; after more than `detach_steps` steps with fewer it is free again. Gazebo
    counts so, too, but once in 0.75 s of wall-clock time instead of once in a step.

    Args:
        model: which it belongs to.
        element: the `<gripper>`.

    Raises:
        NotFoundError: a link does not exist.
        ParameterError: a number is negative.
    """

    def __init__(self, model: Holder, element: Element) -> None:
        self.model = model
        self.sdf = element
        self.name = element.Get(str, "name")
        self.facade: Any = None  # by which the API of a layer above presents it; set by that layer
        check = element.child("grasp_check")
        self.attach_steps, self.detach_steps = check.Get(int, "attach_steps"), check.Get(int, "detach_steps")
        self.min_contacts = check.Get(int, "min_contact_count")
        if min(self.attach_steps, self.detach_steps, self.min_contacts) < 0:
            raise ParameterError("attach_steps, detach_steps and min_contact_count must not be negative")
        self.palm = self._link(element.child("palm_link"))
        self.links = [self._link(link) for link in element.named("gripper_link")]
        self._held = self._open = self._calm = 0  # steps
        self._last: tuple[int, GzVector] | None = None  # number of the body that may be fixed, where it was in the palm
        model.world.engine.record_contacts = True

    def _link(self, element: Element) -> Body:
        name = element.Get(str).strip()
        try:
            return self.model.find_link(name)
        except NotFoundError as error:
            raise NotFoundError(f"{element.where}: <{element.name}> is {name!r}; {error}") from None

    @property
    def joint_name(self) -> str:
        """The name of the joint that fixes what is held."""
        return f"{self.name}__gripper_fixed_joint__"

    @property
    def attached(self) -> bool:
        """Whether a body is fixed to the palm."""
        return self.joint_name in self.model.sdf_joints

    def update(self) -> None:
        """Act on the contacts of the last step."""
        self.model.world.engine.record_contacts = True  # others may have ended it
        touched = self._touched()
        if sum(touched.values()) >= self.min_contacts and touched:
            self._held, self._open = self._held + 1, 0
        else:
            self._held, self._open = max(0, self._held - 1), self._open + 1
        if self.attached:
            if self._open > self.detach_steps:
                self.release()
        elif self._held > self.attach_steps:
            self._try_to_attach(touched)

    def _touched(self) -> dict[Body, int]:
        """Bodies that links of the gripper touch, and in how many pairs of geoms."""
        engine, own = self.model.world.engine, set(self.links)
        found: dict[Body, int] = {}
        for row1, row2 in {(int(point["geom1"]), int(point["geom2"])) for point in engine.contacts}:
            geoms = [engine.geoms[row] for row in (row1, row2) if row in engine.geoms]
            if len(geoms) < 2 or any(geom.body.dummy for geom in geoms):
                continue
            others = [geom.body for geom in geoms if geom.body not in own]
            if len(others) == 1:
                found[others[0]] = found.get(others[0], 0) + 1
        return dict(sorted(found.items(), key=lambda pair: pair[0].number))

    def _try_to_attach(self, touched: dict[Body, int]) -> None:
        body = next((b for b, count in touched.items() if count >= LEAST_TOUCHES and b is not self.palm), None)
        if body is None:
            self._calm, self._last = 0, None
            return
        place = GzCoordPoseSub(body.GetPose(), self.palm.GetPose()).pos
        step = self.model.world.engine.step_time
        near = (
            self._last is not None
            and self._last[0] == body.number
            and sum((a - b) ** 2 for a, b in zip(place, self._last[1], strict=True)) < (CALM * step) ** 2
        )
        self._calm = self._calm + 1 if near else 0
        self._last = body.number, place
        if self._calm >= CALM_STEPS:
            self.model.make_joint(self.joint_name, "fixed", self.palm, body)

    def release(self) -> None:
        """Free what is fixed to the palm."""
        joint = self.model.sdf_joints.get(self.joint_name)
        held = joint.child.model if joint is not None and joint.child is not None else None
        self.model.remove_joint(self.joint_name)
        if held is not None:
            held.set_auto_disable(held.sdf.Get(bool, "allow_auto_disable"))
        self._held = self._calm = 0
        self._last = None

    def save(self) -> tuple[Any, ...]:
        """Its state as plain data; the joint is the model's."""
        last = None
        if self._last is not None:
            bodies = list(self.model.world.engine.bodies.values())
            place = next((i for i, body in enumerate(bodies) if body.number == self._last[0]), -1)
            last = (place, *self._last[1])
        return self._held, self._open, self._calm, last

    def load(self, state: Sequence[Any]) -> None:
        """Take what `save` returned."""
        self._held, self._open, self._calm, last = state
        bodies = list(self.model.world.engine.bodies.values())
        self._last = None
        if last is not None and 0 <= last[0] < len(bodies):
            self._last = bodies[last[0]].number, GzVector(*last[1:])
