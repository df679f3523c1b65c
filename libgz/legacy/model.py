"""Model: what a worldfile is made of, and what users subclass."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.errors import GazeboError, NotFoundError, ParameterError, nearest
from libgz.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzVector, GzVectorMag, GzVectorSub
from libgz.ode.types import dParamHiStop, dParamLoStop
from libgz.physics.joint import HingeJoint
from libgz.physics.space import Space
from libgz.worldfile.attributes import NoAttributes, boolean, rotation, text, vector

if TYPE_CHECKING:
    from libgz.physics.body import Body
    from libgz.physics.joint import Joint
    from libgz.simulation.world import World
    from libgz.worldfile.file import WorldFile
    from libgz.worldfile.node import WorldFileNode

__all__ = ["CommonAttributes", "Model"]

CANONICAL = "canonical"
TRAIL_SPACING = 1.0  # [m] between logged poses

_numbers = itertools.count(1)


@dataclass(frozen=True)
class CommonAttributes:
    """What every model's element may hold besides its own attributes."""

    id: str = text("", help="name of the model and its interfaces; the class name if it is absent")
    xyz: GzVector = vector((0.0, 0.0, 0.0), help="place in the world, or in the body it is attached to")
    rpy: GzPose = rotation(help="roll, pitch and yaw, likewise")
    parentBody: str = text("canonical", help="body of the enclosing model that this one is attached to")
    plugin: str = text("", help="Python file that brings the model")
    gravity: bool = boolean(True, help="whether gravity acts on it")
    enable: bool = boolean(True, help="false: it rests until something touches it; also written `enabled`")


class Model:
    """Base of all models.

    A subclass builds itself in `Load`, makes its interfaces in `Init`, acts in `Update`, and lets its interfaces go in
    `Fini`. Load and Init return 0 (or nothing) for success, -1 for failure; an exception is a failure with a reason.

    Bodies are built in the model's own frame; the world moves them to their place after `Load`. Every model needs one
    canonical body: ``self.AddBody(body, True)``.
    """

    # What tools tell about a model; `libgz models`, the reference pages and the grammar are made from it.
    attributes: ClassVar[type[Any]] = NoAttributes  # the dataclass of its own attributes
    interfaces: ClassVar[tuple[str, ...]] = ()  # that it serves under its id
    example: ClassVar[str] = ""  # elements of a small world that shows it; by default itself with an id

    def __init__(self, world: World) -> None:
        self.world = world
        self.modelSpaceId = Space(world.engine)
        self.node: WorldFileNode | None = None
        self.parent: Model | None = None
        self.parentBody: Body | None = None
        self._children: list[Model] = []
        self._weld: HingeJoint | None = None
        self._own_joint: Any = None  # what a subclass keeps under the name of the weld
        self.relPose = GzPose()
        self.initPose = GzPose()
        self.fixed = False
        self.logPoses = False
        self.poses: list[GzPose] = []
        self._bodies: list[Body] = []
        self.failed: BaseException | None = None
        self.initialized: bool | None = None  # by Init; None before it is called
        self._canonical: Body | None = None
        self._unregistered: list[Body] = []  # that Load made and told no AddBody of
        self._id = ""
        self._name = type(self).__name__
        self._number = next(_numbers)
        self._pick_id = 0
        self._gravity = True
        self._enabled = True

    def __repr__(self) -> str:
        return f"<{self._name} {self._id!r}>"

    # What subclasses write ---------------------------------------------------------------------------------------

    def Load(self, file: WorldFile, node: WorldFileNode) -> int | None:
        """Read attributes from `node` and build bodies, geoms and joints."""
        raise GazeboError(f"{type(self).__name__} has no Load(file, node)")

    def Init(self, file: WorldFile, node: WorldFileNode) -> int | None:
        """Make interfaces; all models are loaded by now."""

    def Update(self, step: float) -> None:
        """Act. Called once per step with the step's length [s], and with 0 while the world is paused."""

    def Fini(self) -> int | None:
        """Let interfaces go."""

    # What the world calls ----------------------------------------------------------------------------------------

    def MasterLoad(self, file: WorldFile, node: WorldFileNode) -> None:
        """Read the attributes common to all models, then `Load`.

        Raises:
            GazeboError: Load returned something but 0, or left the model without a canonical body.
        """
        self._gravity = node.GetBool("gravity", True)
        self._enabled = node.GetBool("enable", node.GetBool("enabled", True))
        before = next(reversed(self.world.engine.bodies.values()), None)
        try:
            result = self.Load(file, node)
        finally:
            self._unregistered = self._unregistered_since(before)
        if result:
            raise GazeboError(f"Load of model {self._id!r} failed: it returned {result}")
        if self._canonical is None:
            raise GazeboError(
                f"model {self._id!r} has no canonical body; its Load must call AddBody(body, True) for one body"
            )
        for body in self.bodies:
            self._switch(body)
        if self._unregistered:
            node.warn("has a body that no AddBody was told of: it stays where Load put it, and is not the model's")

    def _unregistered_since(self, before: Body | None) -> list[Body]:
        """Bodies that were made since `before` and belong to no model."""
        made = itertools.takewhile(lambda body: body is not before, reversed(self.world.engine.bodies.values()))
        return [body for body in made if body.model is None]

    def MasterInit(self, file: WorldFile, node: WorldFileNode) -> None:
        """Call `Init`.

        Raises:
            GazeboError: it returned something but 0.
        """
        result = self.Init(file, node)
        if result:
            raise GazeboError(f"it returned {result}, which is not 0")

    def MasterUpdate(self, step: float) -> None:
        """Log the pose if wanted, then `Update`."""
        if self.logPoses:
            self.LogPose()
        self.Update(step)

    def LogPose(self) -> None:
        """Add the canonical body's centre of mass to the trail, if it is a metre from the last entry."""
        pose = self.GetBody().GetCoMPose()
        if not self.poses or GzVectorMag(GzVectorSub(pose.pos, self.poses[-1].pos)) >= TRAIL_SPACING:
            self.poses.append(pose)

    @property
    def poseCount(self) -> int:
        """Entries in the trail."""
        return len(self.poses)

    # Bodies and joints -------------------------------------------------------------------------------------------

    @property
    def bodies(self) -> list[Body]:
        """All bodies in order of `AddBody`."""
        return self._bodies

    @property
    def children(self) -> list[Model]:
        """The models that are attached to this one."""
        return self._children

    @property
    def joint(self) -> Any:
        """The weld to the parent body, or None; in a subclass that keeps something else under this name, that."""
        return self._weld if self._own_joint is None else self._own_joint

    @joint.setter
    def joint(self, joint: Any) -> None:
        self._own_joint = joint

    @property
    def welded(self) -> HingeJoint | None:
        """The weld to the parent body; None at the top level, and where one of the bodies is a dummy."""
        return self._weld

    def AddBody(self, body: Body, canonical: bool = False) -> None:
        """Take a body in. Exactly one is canonical; it is renamed so, and stands for the model's pose.

        Raises:
            ParameterError: the body belongs to a model already, or the model has a canonical body.
        """
        if body.model is not None:
            raise ParameterError(f"{body!r} was added to a model already, {body.model!r}; a body belongs to one, once")
        if canonical:
            if self._canonical is not None:
                raise ParameterError(f"model {self._id or self._name!r} has a canonical body already")
            self._canonical = body
            body.bodyName = CANONICAL
        self.bodies.append(body)
        body.model = self
        self._switch(body)

    def _switch(self, body: Body) -> None:
        """Hand the model's gravity and enable switches on to a body."""
        if not self._gravity:
            body.SetGravityMode(False)
        if not self._enabled:
            body.Enable(False)

    def GetBody(self, name: str | None = None) -> Body:
        """A body by name; without one, the canonical body. On robots, `chassis` is another name for that.

        Raises:
            NotFoundError: there is none of this name.
        """
        for body in self.bodies:
            if body is self._canonical if name in (None, CANONICAL) else body.bodyName == name:
                return body
        if name == "chassis" and self._canonical is not None:
            return self._canonical
        names = sorted({body.bodyName for body in self.bodies if body.bodyName})
        raise NotFoundError(
            f"body [{name}] not defined for model {self._id!r}; it has {', '.join(names)}{nearest(name or '', names)}"
        )

    def GetBodies(self) -> list[Body]:
        """All bodies in order."""
        return list(self.bodies)

    def GetNumBodies(self) -> int:
        """How many bodies there are."""
        return len(self.bodies)

    @property
    def joints(self) -> list[Joint]:
        """The joints between this model's bodies, and from them to the world, in order of construction."""
        own = set(self.bodies)
        found = {joint.row: joint for body in self.bodies for joint in body.joints}
        return [j for _, j in sorted(found.items()) if all(b is None or b in own for b in j.bodies)]

    def GetJoint(self, name: str) -> Joint:
        """A joint by name.

        Raises:
            NotFoundError: there is none of this name.
        """
        names = {joint.name: joint for joint in self.joints if joint.name}
        if name not in names:
            raise NotFoundError(
                f"model {self._id!r} has no joint {name!r}; it has {', '.join(names) or 'none'}" + nearest(name, names)
            )
        return names[name]

    # Pose --------------------------------------------------------------------------------------------------------

    def GetPose(self) -> GzPose:
        """Global pose of the canonical body [m]."""
        return self.GetBody().GetPose()

    def SetPose(self, pose: GzPose) -> None:
        """Move all bodies as one so that the canonical body has this global pose [m]; all velocities become zero.

        Models attached to this one stay where they are: `World.SetModelPose` takes them along.
        """
        before = self.GetPose()
        for body in self.bodies:
            relative = GzCoordPoseSub(body.GetPose(), before)
            body.SetPose(GzCoordPoseAdd(relative, pose))
            body.SetLinearVel((0.0, 0.0, 0.0))
            body.SetAngularVel((0.0, 0.0, 0.0))

    def restore(self) -> None:
        """Go back to the initial pose, at rest, with all that is attached."""
        self.world.SetModelPose(self, self.initPose)

    # Parent ------------------------------------------------------------------------------------------------------

    def SetParent(self, parent: Model, body: Body) -> None:
        """Note which model, and which of its bodies, this one is attached to."""
        self.parent, self.parentBody = parent, body
        parent.children.append(self)

    def Attach(self) -> None:
        """Weld the canonical body to the parent body: a hinge whose stops are both zero.

        If either is a dummy there is nothing to weld; the model then follows its parent after each step.
        """
        if self.parentBody is None:
            return
        body = self.GetBody()
        self.relPose = GzCoordPoseSub(body.GetPose(), self.parentBody.GetPose())
        if body.dummy or self.parentBody.dummy:
            self.world.take_along(self)
            return
        self._weld = HingeJoint(self.world, name="weld")
        self._weld.Attach(body, self.parentBody)
        self.weld()
        self._weld.SetParam(dParamHiStop, 0.0)
        self._weld.SetParam(dParamLoStop, 0.0)

    def weld(self) -> None:
        """Make the present place on the parent the one that the weld keeps."""
        if self._weld is not None:
            self._weld.SetAnchor(self.GetBody().GetPosition())
            self._weld.SetAxis((0.0, 0.0, 1.0))

    def Detach(self) -> None:
        """Let the parent go."""
        if self._weld is not None:
            self._weld.close()
            self._weld = None
        if self.parent is not None:
            self.parent.children.remove(self)
        self.parent = self.parentBody = None

    @property
    def follows(self) -> bool:
        """Whether the model is carried along by its parent without a joint."""
        return self.parentBody is not None and self._weld is None

    def follow(self) -> None:
        """Go where the parent body takes the model."""
        if self.parentBody is not None:
            self.world.SetModelPose(self, self.relPose)

    # Names and numbers -------------------------------------------------------------------------------------------

    def SetId(self, id: str) -> None:
        """Name the model and its interfaces."""
        self._id = id

    def GetId(self) -> str:
        """The id in the worldfile, or the class name."""
        return self._id

    def SetName(self, name: str) -> None:
        """Set the class name as the worldfile has it."""
        self._name = name

    def GetName(self) -> str:
        """The class name as the worldfile has it."""
        return self._name

    def GetIntId(self) -> int:
        """The model's number in interface headers."""
        return self._number

    def GetParentIntId(self) -> int:
        """The parent's number, or 0."""
        return self.parent.GetIntId() if self.parent is not None else 0

    def SetPickId(self, number: int) -> None:
        """A number by which a user interface finds this model."""
        self._pick_id = int(number)

    def GetPickId(self) -> int:
        """The parent's pick number, or the model's own."""
        return self.parent.GetPickId() if self.parent is not None else self._pick_id

    # End ---------------------------------------------------------------------------------------------------------

    def motors_off(self) -> None:
        """Let all joints go slack."""
        for joint in self.joints:
            joint.motors_off()

    def close(self) -> None:
        """Destroy bodies, joints and space."""
        if self._weld is not None:
            self._weld.close()
        for body in (*self.bodies, *self._unregistered):
            body.close()
        self.modelSpaceId.close()
