"""Entity: what a world is made of. Models of both eras, lights and the joints beside models are its subclasses."""

from __future__ import annotations

import logging
import struct
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import USER_ERRORS, NotFoundError, ParameterError, StateError, listed, nearest, pass_interrupt
from libgz.base.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzPoseOf, GzQuatern, GzVector, place_of
from libgz.base.law import constant, law
from libgz.physics.space import Space
from libgz.simulation.description import Store, describe_joint, describe_rays
from libgz.simulation.plan import Plan, overrides
from libgz.simulation.plugins import own_traceback
from libgz.simulation.problems import NOTED, note

if TYPE_CHECKING:
    from libgz.physics.body import Body
    from libgz.physics.joint import Joint
    from libgz.simulation.journal import Origin
    from libgz.simulation.world import World

__all__ = ["CANONICAL", "Entity", "packed_pose"]

log = logging.getLogger("libgz.simulation")

CANONICAL = "canonical"
STILL = (0.0, 0.0, 0.0)
_HOME = struct.Struct("7d")


def packed_pose(pose: GzPose) -> bytes:
    """The bytes of the numbers of a pose."""
    place, turn = pose.pos, pose.rot
    return _HOME.pack(place.x, place.y, place.z, turn.u, turn.x, turn.y, turn.z)


def _unpacked(packed: bytes) -> GzPose:
    x, y, z, u, qx, qy, qz = _HOME.unpack(packed)
    return GzPose(GzVector(x, y, z), GzQuatern(u, qx, qy, qz))


class _Error:
    """What an entity's update or plugin raised, which stopped it; None while it runs.

    Models of users may keep something else in an attribute of this name.
    """

    def __get__(self, entity: Entity | None, kind: type[Entity]) -> BaseException | None:
        for error in () if entity is None else (entity.failed, entity.plugin_error):
            if isinstance(error, BaseException):
                return error
        return None


class Entity:
    """Base of what stands in a world: bodies in a space of their own, a name, a place, perhaps a parent.

    A world calls `_entity_start`, then `MasterUpdate` in each step, and at the end `_entity_fini` and `close`. Names
    that only the library calls begin with `_entity_`, unless the old API had them (`MasterLoad`, `MasterUpdate`), for
    models of users must be free to name their own methods as they like.

    Args:
        world: the World.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_homes", "fixed", "_id", "_name", "_number")

    origin: Origin | None  # where it can be built from again; None if it was made by code
    parent: Entity | None
    parentBody: Body | None
    fixed: bool
    failed: BaseException | None  # what its update raised; it is not updated any more
    plugin_error: BaseException | None  # what a plugin of it raised
    _packed_init_pose: bytes  # the packed numbers of initPose
    _packed_rel_pose: bytes  # and of relPose

    error = _Error()
    is_model: ClassVar[bool] = True  # whether it is listed among the world's models
    is_actor: ClassVar[bool] = False  # whether it is an actor of SDF
    is_extended = False  # whether code gave it joints or links that its file does not have
    not_kept: ClassVar[str] = ""  # of its own state, in a warning; by default, what its class does not declare

    def __init__(self, world: World) -> None:
        self.world = world
        self.origin = None
        self.modelSpaceId = Space(world.engine)
        self.parent = None
        self.parentBody = None
        self.initPose = GzPose()
        self.relPose = GzPose()
        self.fixed = False
        self.failed = self.plugin_error = None
        self.facade: Any = None  # by which the API of a layer above presents it; set by that layer
        self._children: list[Entity] = []
        self._bodies: list[Body] = []
        self._canonical: Body | None = None
        self._id = ""
        self._name = type(self).__name__
        self._number = world.next_number()

    def __repr__(self) -> str:
        return f"<{self._name} {self._id!r}{place_of(self)}>"

    def _entity_place(self) -> str:
        """``file:line: <tag>: `` of its element, for messages; empty for what was not loaded from a file."""
        return ""

    # Life ----------------------------------------------------------------------------------------------------------

    def _entity_start(self) -> None:
        """Start; all entities of the file are loaded by now.

        Raises:
            PluginError: its own code failed.
        """

    def MasterUpdate(self, step: float) -> None:
        """Act. Called once per step with the step's length [s], and with 0 while the world is paused."""

    def _entity_plan(self, plan: Plan) -> None:
        """Describe `MasterUpdate` line by line, for native code; an entity without lines is not updated.

        By default one line, which calls `MasterUpdate`, if a subclass has it. Plans are not used while the world is
        paused. Whoever changes later what they depend on calls `World.update_rows_changed`.
        """
        if overrides(self, Entity, "MasterUpdate"):
            plan.do(self.MasterUpdate)

    def Fini(self) -> int | None:
        """Release what Initialize made."""

    def _entity_fini(self, *, removed: bool = False) -> None:
        """Call `Fini`. It may fail where `_entity_start` did not come to its end; else an error of it is logged as one.

        Args:
            removed: it is taken out of a running world; otherwise the world ends.
        """
        self._call_fini(logging.DEBUG if removed else logging.ERROR)

    def _call_fini(self, level: int) -> None:
        try:
            self.Fini()
        except USER_ERRORS as error:
            pass_interrupt(error)
            if level >= logging.ERROR:
                note(f"model {self.GetId()!r}", "its Fini", error)
            text = own_traceback(error, called=self.Fini)
            log.log(level, "Fini of model %r failed with\n%s", self.GetId(), text, extra=NOTED)

    def _entity_end(self) -> None:
        """The world is about to be closed as a whole: release what its engine does not."""

    def close(self) -> None:
        """Destroy bodies, joints and space."""
        for body in self.bodies:
            body.close()
        self.modelSpaceId.close()

    # State -----------------------------------------------------------------------------------------------------------

    @property
    def initPose(self) -> GzPose:
        """The initial pose, a copy [m]; to change it, set it."""
        return _unpacked(self._packed_init_pose)

    @initPose.setter
    def initPose(self, pose: GzPose) -> None:
        self._packed_init_pose = packed_pose(pose)

    @property
    def relPose(self) -> GzPose:
        """The pose in the parent body, a copy [m]; to change it, set it."""
        return _unpacked(self._packed_rel_pose)

    @relPose.setter
    def relPose(self, pose: GzPose) -> None:
        self._packed_rel_pose = packed_pose(pose)

    @property
    def _homes(self) -> bytes:
        """The initial pose and the one in the parent body, as the bytes of their numbers."""
        return self._packed_init_pose + self._packed_rel_pose

    @_homes.setter
    def _homes(self, packed: bytes) -> None:
        self.initPose, self.relPose = _unpacked(packed[: _HOME.size]), _unpacked(packed[_HOME.size :])

    def _entity_states_set(self) -> None:
        """All entities have taken what a state has of them; what reaches into others of them follows here."""

    def _entity_attach(self, parent: Entity | None, body: Body | None) -> None:
        """Attach it to the body of another entity that a state has as its parent, or to none.

        Raises:
            StateError: entities of this kind cannot be attached like this.
        """
        raise StateError(f"model {self._id!r} was attached to another parent since, which cannot be restored")

    # Bodies and joints -----------------------------------------------------------------------------------------------

    @property
    def bodies(self) -> list[Body]:
        """All bodies, in the order in which they were added."""
        return self._bodies

    def AddBody(self, body: Body, canonical: bool = False) -> None:
        """Add a body. Exactly one is canonical; it is renamed so, and stands for the entity's pose.

        Raises:
            ParameterError: the body belongs to an entity already, or there is a canonical body.
        """
        if body.model is not None:
            raise ParameterError(f"body {body.label!r} was added to a model already; a body belongs to one, once")
        if canonical:
            if self._canonical is not None:
                raise ParameterError(f"model {self._id or self._name!r} has a canonical body already")
            self._canonical = body
            body.bodyName = CANONICAL
        self.bodies.append(body)
        body.model = self

    @constant
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
            f"body [{name}] not defined for model {self._id!r}; it has {listed(names)}{nearest(name or '', names)}"
        )

    def GetBodies(self) -> list[Body]:
        """All bodies in order."""
        return list(self.bodies)

    def GetNumBodies(self) -> int:
        """How many bodies there are."""
        return len(self.bodies)

    @property
    def joints(self) -> list[Joint]:
        """The joints between its own bodies, and from them to the world, in order of construction."""
        own = set(self.bodies)
        found = {joint.row: joint for body in self.bodies for joint in tuple(body.joints)}
        return [j for _, j in sorted(found.items()) if all(b is None or b in own for b in j.bodies)]

    def GetJoint(self, name: str) -> Joint:
        """A joint by name.

        Raises:
            NotFoundError: there is none of this name.
        """
        names = {joint.name: joint for joint in self.joints if joint.name}
        if name not in names:
            raise NotFoundError(
                f"model {self._id!r} has no joint {name!r}; it has {listed(names)}" + nearest(name, names)
            )
        return names[name]

    def _entity_joints(self) -> list[Joint]:
        """The joints that observers find with it: those whose first body is its own."""
        found = {joint.row: joint for body in self.bodies for joint in tuple(body.joints)}
        own = set(self.bodies)
        return [j for _, j in sorted(found.items()) if next((b for b in j.bodies if b is not None), None) in own]

    def _entity_describe(self, store: Store) -> dict[str, Any]:
        """What observers are to know of it beside its bodies; see docs/observer.md.

        Args:
            store: keeps arrays in a file; returns how to refer to them.

        Returns:
            ``kind``, ``static``, ``joints``, ``sensors``, and ``shape_names``, the names of geoms.
        """
        return {
            "kind": "model" if self.is_model else self._name,
            "static": all(body.dummy for body in self.bodies),
            "joints": [describe_joint(joint) for joint in self._entity_joints()],
            "sensors": [sensor for body in self.bodies for sensor in describe_rays(body, store)],
            "shape_names": {},
        }

    def motors_off(self) -> None:
        """Set all motors' efforts to zero."""
        for joint in self.joints:
            joint.motors_off()

    # Relatives -------------------------------------------------------------------------------------------------------

    @property
    def children(self) -> list[Entity]:
        """The entities that are attached to this one."""
        return self._children

    def with_attached(self) -> list[Entity]:
        """This entity and all that is attached to it, parents first."""
        return [self, *(relative for child in self.children for relative in child.with_attached())]

    def Detach(self) -> None:
        """Take it off its parent."""
        if self.parent is not None:
            self.parent.children.remove(self)
        self.parent = self.parentBody = None

    def weld(self) -> None:
        """Make the present place on the parent the one that is kept."""

    @property
    def follows(self) -> bool:
        """Whether `follow` is called after each step."""
        return False

    def follow(self) -> None:
        """Move to where the parent is now."""

    # Pose ------------------------------------------------------------------------------------------------------------

    @law
    def GetPose(self) -> GzPose:
        """Global pose of the canonical body [m]."""
        return self.GetBody().GetPose()

    def SetPose(self, pose: GzPose) -> None:
        """Move all bodies as one so that the canonical body has this global pose [m]; all velocities become zero.

        Entities attached to this one stay where they are: `World.SetModelPose` moves them, too.
        """
        pose = GzPoseOf(pose)
        with self.world.lock:
            before, bodies = self.GetPose(), list(self.bodies)
            moved = bodies[0].engine.carry_bodies(bodies, before, pose) if bodies else 0
            for body in bodies[moved:]:
                relative = GzCoordPoseSub(body.GetPose(), before)
                body.SetPose(GzCoordPoseAdd(relative, pose))
                body.SetLinearVel(STILL)
                body.SetAngularVel(STILL)

    def restore(self) -> None:
        """Return to the initial pose, at rest, with all that is attached."""
        self.world.SetModelPose(self, self.initPose)

    # Names and numbers -----------------------------------------------------------------------------------------------

    def SetId(self, id: str) -> None:
        """Set the name of the entity and of its interfaces."""
        self._id = id

    def GetId(self) -> str:
        """Its name."""
        return self._id

    def SetName(self, name: str) -> None:
        """Set the class name as the file has it."""
        self._name = name

    def GetName(self) -> str:
        """The class name as the file has it."""
        return self._name

    def GetIntId(self) -> int:
        """Its number in interface headers."""
        return self._number

    def GetParentIntId(self) -> int:
        """The parent's number, or 0."""
        return self.parent.GetIntId() if self.parent is not None else 0
