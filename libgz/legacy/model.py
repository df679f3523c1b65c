"""Model: what a worldfile is made of, and what users subclass."""

from __future__ import annotations

import itertools
import logging
import weakref
from collections.abc import Set
from types import CodeType, FunctionType
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import USER_ERRORS, GazeboError, ParameterError, PluginError, pass_interrupt
from libgz.base.geometry import GzCoordPoseSub, GzPose, GzVector, GzVectorMag, GzVectorSub
from libgz.ode.types import dParamHiStop, dParamLoStop
from libgz.physics.joint import HingeJoint
from libgz.simulation.entity import Entity
from libgz.simulation.plan import Plan, overrides
from libgz.simulation.plugins import own_place, own_traceback
from libgz.simulation.running_code import names
from libgz.worldfile.attributes import NoAttributes, boolean, declaration, rotation, text, vector
from libgz.worldfile.file import WorldFile

if TYPE_CHECKING:
    from libgz.physics.body import Body
    from libgz.simulation.world import World
    from libgz.worldfile.node import WorldFileNode

__all__ = ["CommonAttributes", "Model"]


def _named(bodies: list[Body]) -> str:
    """Bodies in a message, in the order in which they were made."""
    names = [repr(body.bodyName) if body.bodyName else "an unnamed body" for body in reversed(bodies)]
    return f"body {names[0]}" if len(bodies) == 1 and bodies[0].bodyName else ", ".join(names)


WELD = "weld"
TRAIL_SPACING = 1.0  # [m] between logged poses


@declaration
class CommonAttributes:
    """What every model's element may hold besides its own attributes."""

    id: str = text("", help="name of the model and its interfaces; the class name if it is absent")
    xyz: GzVector = vector((0.0, 0.0, 0.0), help="place in the world, or in the body it is attached to")
    rpy: GzPose = rotation(help="roll, pitch and yaw, likewise")
    parentBody: str = text("canonical", help="body of the enclosing model that this one is attached to")
    plugin: str = text("", help="Python file that brings the model")
    gravity: bool = boolean(True, help="whether gravity acts on it")
    enable: bool = boolean(True, help="false: it rests until something touches it; also written `enabled`")


class Model(Entity):
    """Base of all models of worldfiles.

    A subclass builds itself in `Load`, creates its interfaces in `Init`, acts in `Update`, and destroys its interfaces
    in `Fini`. Load and Init return 0 (or nothing) for success, -1 for failure; an exception is a failure with a reason.

    Bodies are built in the model's own frame; the world moves them to their place after `Load`. Every model needs one
    canonical body: ``self.AddBody(body, True)``.
    """

    STATE: ClassVar[tuple[str, ...]] = ("logPoses", "poses", "initialized", "_pick_id", "_gravity", "_enabled")

    # What tools print about a model; `libgz models`, the reference pages and the grammar are generated from it.
    attributes: ClassVar[type[Any]] = NoAttributes  # the dataclass of its own attributes
    interfaces: ClassVar[tuple[str, ...]] = ()  # that it serves under its id
    behaviour: ClassVar[str] = ""  # what its Update does to itself and to others, interfaces apart
    example: ClassVar[str] = ""  # elements of a small world that shows it; by default itself with an id

    active_while_paused: ClassVar[bool] = False  # whether its plan runs then, too
    _watched: Set[str] = frozenset()  # the attributes that its rows depend on

    def __init__(self, world: World) -> None:
        super().__init__(world)
        self.node: WorldFileNode | None = None
        self._own_joint: Any = None  # what a subclass keeps under the name of the weld
        self._log_poses = False
        self.poses: list[GzPose] = []
        self.initialized: bool | None = None  # by Init; None before it is called
        self._unregistered: list[Body] = []  # made by Load and not registered with AddBody
        self._parts: list[weakref.ref[Any]] = []  # joints and rays made by Load and Init
        self._pick_id = 0
        self._gravity = True
        self._enabled = True

    # What subclasses write ---------------------------------------------------------------------------------------

    def Load(self, file: WorldFile, node: WorldFileNode) -> int | None:
        """Read attributes from `node` and build bodies, geoms and joints."""
        raise GazeboError(f"{type(self).__name__} has no Load(file, node)")

    def Init(self, file: WorldFile, node: WorldFileNode) -> int | None:
        """Create interfaces; all models are loaded by now."""

    def plan_update(self, plan: Plan) -> None:
        """Describe what it does in each step, line by line, instead of an `Update`; native code then does the laws."""

    def Update(self, step: float) -> None:
        """Act. Called once per step with the step's length [s], and with 0 while the world is paused.

        By default what `plan_update` describes; while the world is paused only if it is `active_while_paused`.
        """
        if step or self.active_while_paused:
            plan = Plan()
            self.plan_update(plan)
            plan.run(step, self.world.GetSimTime())

    def Fini(self) -> int | None:
        """Destroy interfaces."""

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
            with self.world.engine.making(self._parts):
                result = self.Load(file, node)
        finally:
            self._unregistered = self._unregistered_since(before)
        if result:
            raise GazeboError(f"Load of model {self._id!r} failed: it returned {result}")
        if self._canonical is None:
            raise GazeboError(f"model {self._id!r} has no canonical body: {self._missing_body()}")
        for body in self.bodies:
            self._switch(body)
        if self._unregistered:
            node.warn(
                f"has {_named(self._unregistered)} that {type(self).__name__}.Load made and did not register: it stays "
                "where Load put it, outside the model; call self.AddBody(body) for each body"
            )

    def _missing_body(self) -> str:
        """How to give the model a canonical body."""
        load = f"{type(self).__name__}.Load"
        if self.bodies:
            return f"{load} must call self.AddBody(body, True) for one body; it called AddBody without True"
        if self._unregistered:
            bodies = _named(self._unregistered)
            return f"{load} made {bodies}, but never called AddBody; it must call self.AddBody(body, True) for one body"
        return f"{load} must make one, body = Body(self.world), and call self.AddBody(body, True)"

    def _unregistered_since(self, before: Body | None) -> list[Body]:
        """Bodies that were created after `before` and belong to no model."""
        made = itertools.takewhile(lambda body: body is not before, reversed(self.world.engine.bodies.values()))
        return [body for body in made if body.model is None]

    def _entity_init(self, file: WorldFile, node: WorldFileNode) -> None:
        """Call `Init`.

        Raises:
            GazeboError: it returned something but 0.
        """
        with self.world.engine.making(self._parts):
            result = self.Init(file, node)
        if result:
            raise GazeboError(f"it returned {result}, which is not 0")

    def _entity_place(self) -> str:
        """``file:line: <tag>: `` of its element, for messages; empty for a model that was not loaded from a file."""
        return f"{self.node.file.label}:{self.node.line}: <{self.node.tag}>: " if self.node is not None else ""

    def _entity_start(self) -> None:
        """Call `Init`; what it raises becomes an error of the model's element.

        Raises:
            PluginError: Init failed.
        """
        if self.node is None:
            return
        self.initialized = False
        server = self.world.gz_server
        server.place = self._entity_place()
        try:
            self._entity_init(WorldFile.of(self.node), self.node)
        except GazeboError as error:
            reason = f"{error}{own_place(error)}"
            raise PluginError(f"{self._entity_place()}Init of model {self.GetId()!r}: {reason}") from error
        except USER_ERRORS as error:
            pass_interrupt(error)
            text = own_traceback(error, called=self.Init)
            raise PluginError(f"{self._entity_place()}Init of model {self.GetId()!r} failed with\n{text}") from error
        finally:
            server.place = ""
        self.initialized = True

    def MasterUpdate(self, step: float) -> None:
        """Log the pose if wanted, then `Update`."""
        if self.logPoses:
            self.LogPose()
        self.Update(step)

    def _entity_plan(self, plan: Plan) -> None:
        """Describe the update: by `plan_update`, where no subclass has an `Update` of its own."""
        self._watched = {"MasterUpdate", "Update", "LogPose", *_names_in_plans(type(self))}
        if overrides(self, Model, "MasterUpdate"):
            plan.do(self.MasterUpdate)
            return
        if self.logPoses:
            plan.do(lambda _: self.LogPose())
        if overrides(self, Model, "Update"):
            plan.do(self.Update)
        else:
            self.plan_update(plan)

    def __setattr__(self, name: str, value: object) -> None:
        """Set an attribute; what native code does is found anew if it depends on this one."""
        object.__setattr__(self, name, value)
        if name in self._watched:
            self.world.update_rows_changed()

    @property
    def logPoses(self) -> bool:
        """Whether the pose is logged each metre, in `poses`."""
        return self._log_poses

    @logPoses.setter
    def logPoses(self, value: bool) -> None:
        self._log_poses = value
        self.world.update_rows_changed()

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
        """Add a body. Exactly one is canonical; it is renamed so, and stands for the model's pose.

        Raises:
            ParameterError: the body belongs to a model already, or the model has a canonical body.
        """
        super().AddBody(body, canonical)
        self._switch(body)

    def _switch(self, body: Body) -> None:
        """Apply the model's gravity and enable switches to a body."""
        if not self._gravity:
            body.SetGravityMode(False)
        if not self._enabled:
            body.Enable(False)

    # Parent ------------------------------------------------------------------------------------------------------

    def SetParent(self, parent: Model, body: Body) -> None:
        """Note which model, and which of its bodies, this one is attached to, in place of a previous one.

        Raises:
            ParameterError: the body is none of the parent's, or the parent is this model or attached to it.
        """
        if body not in parent.bodies:
            raise ParameterError(f"model {self._id!r} cannot be attached to {body!r}, which is no body of {parent!r}")
        if parent in self.with_attached():
            raise ParameterError(f"model {self._id!r} cannot be attached to {parent!r}, which belongs to it")
        self.Detach()
        self.parent, self.parentBody = parent, body
        parent.children.append(self)

    def Attach(self) -> None:
        """Weld the canonical body to the parent body: a hinge whose stops are both zero.

        If either is a dummy there is nothing to weld; the model then follows its parent after each step.
        """
        if self.parentBody is None:
            return
        if (weld := self._weld) is not None:
            weld.close()
        body = self.GetBody()
        self.relPose = GzCoordPoseSub(body.GetPose(), self.parentBody.GetPose())
        if body.dummy or self.parentBody.dummy:
            self.world.add_follower(self)
            return
        weld = HingeJoint(self.world, name=WELD)
        weld.Attach(body, self.parentBody)
        self.weld()
        weld.SetParam(dParamHiStop, 0.0)
        weld.SetParam(dParamLoStop, 0.0)

    @property
    def _weld(self) -> HingeJoint | None:
        """The joint of `Attach`, found at its body: which of the engine's joints it is, a state decides."""
        body = self._canonical
        if self.parentBody is None or body is None:
            return None
        found = (joint for joint in body.joints if joint.bodies[0] is body and joint.name == WELD)
        return next((joint for joint in found if isinstance(joint, HingeJoint)), None)

    def weld(self) -> None:
        """Make the present place on the parent the one that the weld keeps."""
        if (weld := self._weld) is not None:
            weld.SetAnchor(self.GetBody().GetPosition())
            weld.SetAxis((0.0, 0.0, 1.0))

    def Detach(self) -> None:
        """Take it off its parent."""
        if (weld := self._weld) is not None:
            weld.close()
        super().Detach()

    def _entity_attach(self, parent: Entity | None, body: Body | None) -> None:
        """Attach it to a body of another model, or to none."""
        self.Detach()
        if isinstance(parent, Model) and body is not None:
            self.SetParent(parent, body)
            self.Attach()

    @property
    def follows(self) -> bool:
        """Whether the model is moved along with its parent without a joint."""
        return self.parentBody is not None and self._weld is None

    def follow(self) -> None:
        """Move to where the parent body is now."""
        if self.parentBody is not None:
            self.world.SetModelPose(self, self.relPose)

    def SetPickId(self, number: int) -> None:
        """A number by which a user interface finds this model."""
        self._pick_id = int(number)

    def GetPickId(self) -> int:
        """The parent's pick number, or the model's own."""
        return self.parent.GetPickId() if isinstance(self.parent, Model) else self._pick_id

    # End ---------------------------------------------------------------------------------------------------------

    def _entity_fini(self, *, removed: bool = False) -> None:
        """Call `Fini`; at the end of the world not where the world's failing start never came to this `Init`."""
        if removed or self.node is None or self.initialized:
            super()._entity_fini(removed=removed)
        elif self.initialized is False:
            self._call_fini(logging.DEBUG)

    def close(self) -> None:
        """Destroy bodies, joints and space."""
        if (weld := self._weld) is not None:
            weld.close()
        for body in (*self.bodies, *self._unregistered):
            body.close()
        for part in self._parts:  # those on no body of the model: detached joints, rays fixed to the parent
            if (made := part()) is not None:
                made.close()
        self.modelSpaceId.close()


_plan_names: weakref.WeakKeyDictionary[type, frozenset[str]] = weakref.WeakKeyDictionary()


def _names_in_plans(kind: type) -> frozenset[str]:
    """The names of the attributes that the plans of a class mention: its methods `plan_...` and `_plan_...`."""
    found = _plan_names.get(kind)
    if found is None:
        found = _plan_names[kind] = _found_in_plans(kind)
    return found


def _found_in_plans(kind: type) -> frozenset[str]:
    methods = (item for base in kind.__mro__ for item in vars(base).items())
    plans = [plan for name, plan in methods if name.lstrip("_").startswith("plan_") and isinstance(plan, FunctionType)]
    return frozenset(name for plan in plans for name in _names_in(plan.__code__))


def _names_in(code: CodeType) -> set[str]:
    """The names of attributes and globals in a function and in those inside it."""
    inner = (constant for constant in code.co_consts if isinstance(constant, CodeType))
    return set(code.co_names).union(*map(_names_in, inner))


names(Model.MasterLoad, lambda values: f"Load of model {values['self'].GetId()!r}")
names(Model._entity_init, lambda values: f"Init of model {values['self'].GetId()!r}")
names(Model._call_fini, lambda values: f"Fini of model {values['self'].GetId()!r}")
