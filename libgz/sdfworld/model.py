"""SdfModel: links, collisions, visuals, joints and nested models of an SDF document on the engine."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from libgz.base.errors import Diagnostics, NotFoundError, ParameterError, explain, listed, nearest
from libgz.base.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzPoseOf, GzQuaternIdent, GzVector
from libgz.base.law import law
from libgz.physics.body import Body
from libgz.physics.check import LARGEST
from libgz.physics.geom import Geom
from libgz.physics.joint import Joint
from libgz.physics.mass import Mass, about_centre, given_mass, is_possible, positive_definite
from libgz.physics.saved import saved_pose
from libgz.physics.space import Space
from libgz.sdf.element import Element
from libgz.sdfworld.axis import Axis, JointPlan, lost_link, read_joint
from libgz.sdfworld.description import describe_sdf_joint, describe_sensors, ode_joints
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.joint_table import NO_JOINTS, JointTable
from libgz.sdfworld.shapes import make_collision, make_visual
from libgz.sdfworld.surface import set_body_surface, set_surface
from libgz.sdfworld.visual import dress, link_lights
from libgz.simulation.description import Store
from libgz.simulation.entity import Entity
from libgz.simulation.plan import Plan, overrides
from libgz.simulation.state import decode, encode
from libgz.simulation.world import World

if TYPE_CHECKING:
    from libgz.sdfworld.gripper import SdfGripper
    from libgz.sdfworld.mimic import Mimic

__all__ = ["SdfModel", "model_pose"]

UNIT = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]  # moments of inertia [kg m^2]


class SdfModel(Entity):
    """A model built from a `<model>` element.

    Its pose is that of the model frame; links keep their names. Static models have dummy bodies: they stand still
    whatever happens, and touch what moves. `build` makes links, and nested models with theirs; `build_joints` follows
    when all models of a file stand, for joints reach into other models.
    """

    STATE = ("_parts", "_motion")

    def __init__(
        self, world: World, element: Element, diagnostics: Diagnostics, parent: SdfModel | None = None
    ) -> None:
        super().__init__(world)
        self.sdf = element
        self.diagnostics = diagnostics
        self.name = element.Get(str, "name")
        self.static: bool = element.Get(bool, "static") or (parent is not None and parent.static)
        self._for_links = {
            key: element.Get(bool, key) for key in ("self_collide", "enable_wind")
        }  # with none of theirs
        self.links: dict[str, Body] = {}
        self.nested: dict[str, SdfModel] = {}
        self.sdf_joints = JointTable(world, element)
        self.grippers: dict[str, SdfGripper] = {}
        self.mimics: list[Mimic] = []
        self.geom_names: dict[Geom, str] = {}
        self.visual_elements: dict[Geom, Element] = {}
        self._frame_in_canonical = GzPose()
        self._frame = GzPose()  # of a model without any link
        self._places: list[tuple[Body, GzPose, GzPose]] = []  # where links began: in the model frame, and global
        self._start = GzPose()  # where the model was then
        self._spaces: dict[Body, Space] = {}  # of links that touch others of the model
        self._added: dict[str, Element] = {}  # elements of links that `create_link` made
        self._coming: tuple[Any, Any] | None = None  # joints and motion of a state, until all models have their links
        self.SetName("model")
        self.SetId(self.name)
        if parent is not None:
            self.parent = parent
            parent.children.append(self)
            self.SetId(f"{parent.GetId()}::{self.name}")

    def build(self, pose: GzPose) -> None:
        """Make links and nested models, with the model frame at a global pose; errors are those of the file."""
        self._frame = pose
        for link in self.sdf.named("link"):
            self._guard(link, self._add_link, link, pose)
        for element in self.sdf.named("model"):
            self._guard(element, self._add_nested, element, pose)
        self._canonical = self._canonical_link()
        if self._canonical is None and self.parent is None:
            self.diagnostics.warn(
                self.sdf, "a model without links is only a name: it neither moves nor touches anything"
            )
        elif self._canonical is not None:
            self._frame_in_canonical = GzCoordPoseSub(pose, self._canonical.GetPose())
        self._places = [(body, GzCoordPoseSub(body.GetPose(), pose), body.GetPose()) for body in self.bodies]
        self._start = self.GetPose()

    def _canonical_link(self) -> Body | None:
        """The link that the model's frame is fixed to: the one that the file names, or the first."""
        name = self.sdf.attributes["canonical_link"].text if self.sdf.HasAttribute("canonical_link") else ""
        link = self._own_link(name) if name else None
        if name and link is None:
            names = list(self.link_names())
            self.diagnostics.warn(
                self.sdf, f"canonical_link is {name!r}; it must be a link{nearest(name, names)}; the first one is used"
            )
        return link or next((body for model in self.nested_family() for body in model.bodies), None)

    def build_joints(self) -> None:
        """Make the joints of this model and of those nested in it, and enable auto-disable for links without joints."""
        # Gears search for the hinges of the links they join.
        for element in sorted(self.sdf.named("joint"), key=lambda e: e.Get(str, "type") == "gearbox"):
            if lost := lost_link(element, self.find_link):
                self.diagnostics.warn(element, lost)
            else:
                self._leave_out(element, self.add_joint, element)
        for element in self.sdf.named("gripper"):
            self._leave_out(element, self._add_gripper, element)
        for element in self.sdf.named("joint"):
            for mimic in element.child("axis").named("mimic") if element.HasElement("axis") else ():
                self._leave_out(mimic, self._add_mimic, mimic, element.Get(str, "name"))
        for model in self.nested.values():
            model.build_joints()
        self.set_auto_disable(self.sdf.Get(bool, "allow_auto_disable"))

    def set_auto_disable(self, allow: bool) -> None:
        """Whether links may be auto-disabled at rest; those of models with joints or sensors never are."""
        busy = any(body.joints for body in self.bodies) or any(
            link.HasElement("sensor") for link in self.sdf.named("link")
        )
        for body in self.bodies:
            body.set_auto_disable(allow and not busy and not body.kinematic)

    def build_nested(self, element: Element) -> SdfModel:
        """Build a nested model again that was removed, where the file has it."""
        above, pose = self.parent, model_pose(self.sdf)
        while isinstance(above, SdfModel):
            pose, above = GzCoordPoseAdd(pose, model_pose(above.sdf)), above.parent
        self._add_nested(element, pose)
        return self.nested[element.Get(str, "name")]

    def nested_family(self) -> Iterator[SdfModel]:
        """This model and all models nested in it."""
        yield self
        for model in self.nested.values():
            yield from model.nested_family()

    def _guard(self, element: Element, action: Callable[..., object], *arguments: object) -> None:
        """Call `action`; what it raises becomes an error of the file, reported with all others."""
        try:
            action(*arguments)
        except Exception as error:  # noqa: BLE001 - an error of the file, whatever it met; the others are still found
            self.diagnostics.failure(element, error)

    def _leave_out(self, element: Element, action: Callable[..., object], *arguments: object) -> None:
        """Call `action`; what it raises becomes a warning: the element is left out, and the rest stands."""
        try:
            action(*arguments)
        except Exception as error:  # noqa: BLE001 - whatever it met
            self.diagnostics.warn(element, f"{explain(error)}; it is left out")

    # Links -------------------------------------------------------------------------------------------------------

    def _add_nested(self, element: Element, pose: GzPose) -> None:
        name = element.Get(str, "name")
        model = SdfModel(self.world, element, self.diagnostics, self)
        self.nested[name] = model
        model.build(GzCoordPoseAdd(model_pose(element), pose))

    def _add_link(self, element: Element, frame: GzPose) -> None:
        name = element.Get(str, "name")
        body = Body(self.world, name, dummy=self.static)
        body.model = self
        self.links[name] = body
        self.bodies.append(body)
        self._fill_link(body, element, frame)

    def _fill_link(self, body: Body, element: Element, frame: GzPose) -> None:
        """Place a link, and give it shapes and mass."""
        body.SetPose(GzCoordPoseAdd(element.Get(GzPose, "pose"), frame))
        with body.assembly():
            self._add_collisions(body, element)
            for visual in element.named("visual"):
                self._leave_out(visual, self._add_visual, body, visual)
        link_lights(body, element, self.diagnostics.warn)
        if self.static:
            return
        inertial = element.child("inertial")
        body.SetMassMatrix(self._mass(inertial))
        body.SetGravityMode(element.Get(bool, "gravity"))
        body.set_damping(*self._decay(element))
        body.in_wind = self._in_wind(element)
        if element.Get(bool, "kinematic"):
            body.set_kinematic(True)

    def _mass(self, inertial: Element) -> Mass:
        """The mass matrix of `<inertial>`; what no body can have is replaced, with a warning, as in Gazebo classic."""
        inertia, mass, pose = inertial.child("inertia"), inertial.Get(float, "mass"), inertial.Get(GzPose, "pose")
        moments = [inertia.Get(float, key) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]
        if not 0.0 < mass <= LARGEST:
            self.diagnostics.warn(inertial, f"mass is {mass:g}; 1 kg is used instead")
            mass = 1.0
        if (found := _possible(mass, moments, pose)) is not None:
            return found
        words = " ".join(f"{moment:g}" for moment in moments)
        self.diagnostics.warn(
            inertia,
            f"moments of inertia ixx iyy izz ixy ixz iyz are {words}, which no body has: they are not positive "
            "definite, or singular but for rounding; 1 kg m^2 about each axis is used instead",
        )
        if (found := _possible(mass, UNIT, pose)) is not None:
            return found
        self.diagnostics.warn(inertial, "the centre of mass is too far away; the link's origin is used instead")
        return given_mass(mass, UNIT, GzPose())

    def create_link(self, name: str) -> Body:
        """Add a link without shapes, of 1 kg, at the model's pose.

        Raises:
            ParameterError: the name is taken.
        """
        if name in self.links or name in self.nested:
            raise ParameterError(f"model {self.GetId()!r} has something named {name!r} already")
        element = self.sdf.AddElement("link")
        element.set_attribute("name", name)
        pose = self.GetPose()
        self._add_link(element, pose)
        body = self.links[name]
        self._added[name] = element
        place = GzCoordPoseSub(body.GetPose(), pose)
        self._places.append((body, place, GzCoordPoseAdd(place, self._start)))
        return body

    def load_link(self, name: str, element: Element) -> bool:
        """Build a link that `create_link` made anew from an element; false for a link of the file.

        Raises:
            WorldFileError: the element has errors.
        """
        if name not in self._added:
            return False
        body, own = self.links[name], self._added[name]
        for child in list(own.children):
            own.RemoveChild(child)
        for child in element.children:
            own.InsertElement(child.Clone())
        for geom in list(body.geoms):
            self.geom_names.pop(geom, None)
            self.visual_elements.pop(geom, None)
            geom.close()
        self._fill_link(body, own, self.GetPose())
        self.set_first_place(body, GzCoordPoseSub(body.GetPose(), self.GetPose()))
        self.diagnostics.raise_errors()
        return True

    def link_element(self, name: str) -> Element:
        """The element of a link that `create_link` made."""
        return self._added[name]

    @property
    def start(self) -> GzPose:
        """The global pose where it was built [m]; not to be changed."""
        return self._start

    def first_place(self, body: Body) -> GzPose:
        """The pose in the model frame that a reset restores [m]."""
        return next((place for link, place, _ in self._places if link is body), GzPose())

    def set_first_place(self, body: Body, place: GzPose) -> None:
        """Set the pose in the model frame that a reset restores [m]."""
        row = (body, place, GzCoordPoseAdd(place, self._start))
        self._places = [row if old[0] is body else old for old in self._places]

    def remove_link(self, name: str) -> None:
        """Destroy a link that `create_link` made."""
        body = self.links.pop(name)
        self.bodies.remove(body)
        self._places = [place for place in self._places if place[0] is not body]
        self.sdf.RemoveChild(self._added.pop(name))
        body.close()
        if body in self._spaces:
            self._spaces.pop(body).close()

    def _self_collides(self, link: Element) -> bool:
        """Whether a link touches others of its model; from SDF 1.5 the link's setting overrides the model's."""
        return self._of_link(link, "self_collide")

    def self_collides(self, body: Body) -> bool:
        """Whether a link touches others of its model."""
        return body in self._spaces

    def set_self_collide(self, body: Body, collide: bool) -> None:
        """Let a link touch others of its model, or not. It needs a space of its own: geoms of one never touch."""
        if collide == self.self_collides(body):
            return
        space, former = self.modelSpaceId, self._spaces.pop(body, None)
        if collide:
            space = self._spaces[body] = Space(self.world.engine)
        for geom in body.geoms:
            if geom.space is not None:
                geom.move_to(space)
        if former is not None:
            former.close()

    def _in_wind(self, link: Element) -> bool:
        """Whether wind acts on a link; its own setting overrides the model's."""
        return self._of_link(link, "enable_wind")

    def _of_link(self, link: Element, key: str) -> bool:
        """A setting of a link, else that of the model."""
        return link.Get(bool, key) if link.HasElement(key) else self._for_links[key]

    @staticmethod
    def _decay(link: Element) -> tuple[float, float]:
        """Share of linear and angular velocity lost in each step."""
        if not link.HasElement("velocity_decay"):
            return 0.0, 0.0
        decay = link.child("velocity_decay")
        return decay.Get(float, "linear"), decay.Get(float, "angular")

    # Geoms -------------------------------------------------------------------------------------------------------

    def _add_collisions(self, body: Body, link: Element) -> None:
        space = self.modelSpaceId
        if self._self_collides(link):
            space = self._spaces[body] = Space(self.world.engine)
        for collision in link.named("collision"):
            self._leave_out(collision, self.add_collision, body, collision, space)
        last = next(reversed(list(link.named("collision"))), None)
        if last is not None and body.geoms:
            hilly = last.child("geometry").HasElement("heightmap")
            set_body_surface(body.geoms, last, still=self.static or hilly)

    def add_collision(self, body: Body, element: Element, space: Space | None = None) -> Geom | None:
        """Add a `<collision>` to a link; None, with a warning, where its shape cannot be built."""
        geom = make_collision(body, space or self.modelSpaceId, element, self.diagnostics.warn)
        if geom is None:
            return None
        geom.appearance.visible = False
        geom.SetRetro(element.Get(float, "laser_retro"))
        self.geom_names[geom] = element.Get(str, "name")
        set_surface(geom, element)
        return geom

    def _add_visual(self, body: Body, element: Element) -> None:
        """Geoms without a space: they are rendered and touch nothing."""
        for geom in make_visual(body, element, self.diagnostics.warn):
            self.geom_names[geom] = element.Get(str, "name")
            self.visual_elements[geom] = element
            dress(geom, element, self.diagnostics.warn)

    # Joints ------------------------------------------------------------------------------------------------------

    def find_link(self, name: str) -> Body:
        """A link by the name that a joint of this model calls it: own, `nested::link`, or `model::link` of the world.

        Raises:
            NotFoundError: there is none.
        """
        found = self._own_link(name) or self._own_link(name.removeprefix(f"{self.name}::"))
        if found is not None:
            return found
        model: Entity | None = self.parent
        while isinstance(model, SdfModel):
            found = model._own_link(name)
            if found is not None:
                return found
            model = model.parent
        owner, _, link = name.rpartition("::")
        for other in self.world.entities if owner else ():
            if other.GetId() == owner:
                return other.GetBody(link)
        raise NotFoundError(f"there are {listed(self.link_names())}")

    def _own_link(self, name: str) -> Body | None:
        if name in self.links:
            return self.links[name]
        head, _, rest = name.partition("::")
        return self.nested[head]._own_link(rest) if rest and head in self.nested else None

    def link_names(self) -> Iterator[str]:
        """Names of all links as joints of this model call them."""
        yield from self.links
        for name, model in self.nested.items():
            yield from (f"{name}::{link}" for link in model.link_names())

    def add_joint(self, element: Element) -> SdfJoint | None:
        """Make a `<joint>`; None in a static model, where nothing moves.

        Raises:
            ParameterError: the name is taken, or a value is not allowed.
            NotFoundError: a link does not exist.
        """
        return self._take_joint(read_joint(element, self.find_link, self.GetPose(), self.diagnostics.warn))

    def make_joint(
        self, name: str, kind: str, parent: Body | None, child: Body | None, *axes: Axis, pitch: float = 1.0
    ) -> SdfJoint:
        """Join two links as they stand now; None is the world. The joint's frame is turned as the child's.

        It lies in the child's centre of mass, of a `revolute2` in the parent's, where ODE has it at first; of a `fixed`
        joint in the child's origin.

        Raises:
            ParameterError: the name is taken, the kind unknown, or the model static.
        """
        ends = [body for body in (child, parent) if body is not None]
        frame = GzPose()
        if ends and kind == "fixed":
            frame = ends[0].GetPose()
        elif ends:
            frame = GzPose(ends[-1 if kind == "revolute2" else 0].GetCoMPose().pos, ends[0].GetPose().rot)
        plan = JointPlan(name, kind, parent, child, frame, list(axes), pitch)
        joint = self._take_joint(plan)
        if joint is None:
            raise ParameterError(f"model {self.GetId()!r} is static; its links cannot be joined")
        return joint

    def _take_joint(self, plan: JointPlan) -> SdfJoint | None:
        if plan.name in self.sdf_joints:
            raise ParameterError(f"model {self.GetId()!r} has a joint {plan.name!r} already")
        if self.static:
            return None
        joint = SdfJoint(self.world.engine, plan)
        self.sdf_joints.add(joint)
        for body in (plan.parent, plan.child):
            if body is not None and body.auto_disable:
                body.set_auto_disable(False)
        return joint

    def _add_gripper(self, element: Element) -> None:
        if not self.static:
            from libgz.sdfworld.gripper import SdfGripper  # few models have one

            gripper = SdfGripper(self, element)
            self.grippers[gripper.name] = gripper

    def _add_mimic(self, element: Element, follower: str) -> None:
        if follower in self.sdf_joints:  # a static model has none
            from libgz.sdfworld.mimic import Mimic  # few models have one

            self.mimics.append(Mimic.from_element(element, follower, self.sdf_joints))

    def remove_joint(self, name: str) -> bool:
        """Destroy a joint; false if there is none of this name."""
        return self.sdf_joints.remove(name)

    def _entity_plan(self, plan: Plan) -> None:
        """A line for joints that act or follow others, grippers, and what a subclass does."""
        acting = any(joint.acts for joint in self.sdf_joints.values())
        if acting or self.grippers or overrides(self, SdfModel, "MasterUpdate"):
            plan.do(self.MasterUpdate)
            return
        for mimic in self.mimics:
            plan.do(mimic.update)

    def MasterUpdate(self, step: float) -> None:
        """Apply damping, springs, threads and gears of the joints; let joints follow others, and grippers hold."""
        if self.sdf_joints and step > 0.0:
            for joint in self.sdf_joints.values():
                if joint.acts:
                    joint.update()
            for mimic in self.mimics:
                mimic.update(step)
        if self.grippers and step > 0.0:
            for gripper in self.grippers.values():
                gripper.update()

    def _entity_place(self) -> str:
        """``file:line: <tag>: `` of its element, for messages."""
        return f"{self.sdf.where}: <{self.sdf.name}>: "

    # State -------------------------------------------------------------------------------------------------------

    def _start_of(self, name: str) -> tuple[tuple[float, ...] | int, ...]:
        """Where a link that was added began: in the model frame, and global; and its number among all bodies."""
        places = next(places for body, *places in self._places if body is self.links[name])
        return (*((*place.pos, *place.rot) for place in places), self._number_of(name))

    def _number_of(self, name: str) -> int:
        bodies = list(self.world.engine.bodies.values())
        return bodies.index(self.links[name]) if self.links[name] in bodies else -1

    @property
    def is_extended(self) -> bool:  # type: ignore[override]
        """Whether it has joints or links that its file does not have."""
        own = {joint.Get(str, "name") for joint in self.sdf.named("joint")} if self.sdf_joints else ()
        return bool(self._added) or any(name not in own for name in self.sdf_joints)

    @property
    def _has_parts(self) -> bool:
        return bool(self._canonical is None or self._added or self.sdf_joints.count or self._spaces)

    @property
    def _parts(self) -> bytes | None:
        """Links that were added, joints, and where the frame is of a model without links; encoded."""
        if self._coming is not None:  # of a state that could not be set
            return b""
        if not self._has_parts:
            return None
        frame = (*self._frame.pos, *self._frame.rot) if self._canonical is None else None
        joints = self.sdf_joints.save() if self.sdf_joints.count else None
        added = [(name, self._start_of(name)) for name in self._added] if self._added else None
        colliding = [name for name, body in self.links.items() if body in self._spaces]
        return encode((frame, added, joints, colliding))

    @_parts.setter
    def _parts(self, state: bytes | None) -> None:
        """Links and joints that came since go, those that went are made again."""
        frame, added, joints, colliding = decode(state) if state is not None else (None, None, None, None)
        if frame is not None:
            self._frame = saved_pose(frame)
        places = dict(added or ())
        self.sdf_joints.remove_others(joints or NO_JOINTS)
        for name in [name for name in self._added if name not in places]:
            self.remove_link(name)
        for name, (*start, number) in places.items():
            if name in self.links and self._number_of(name) != number:
                self.remove_link(name)  # it came before what was built again
            body = self.links[name] if name in self.links else self.create_link(name)
            local, whole = map(saved_pose, start)
            self._places = [row for row in self._places if row[0] is not body] + [(body, local, whole)]
        for name, body in self.links.items():
            self.set_self_collide(body, name in (colliding or ()))
        self._coming = joints or NO_JOINTS, None

    def _entity_states_set(self) -> None:
        """Take the joints of a state: now all models have their links."""
        if self._coming is not None:
            (joints, motion), self._coming = self._coming, None
            self.sdf_joints.load(joints)
            if motion is not None:
                self._motion = motion

    @property
    def _motion(self) -> bytes | tuple[Any, ...] | None:
        """The efforts of joints, and behind them what grippers hold."""
        if self._coming is not None:
            return None
        if not (self.sdf_joints or self.grippers):
            return b""
        efforts = b"".join([joint.efforts for joint in self.sdf_joints.values()])
        return (efforts, *(gripper.save() for gripper in self.grippers.values())) if self.grippers else efforts

    @_motion.setter
    def _motion(self, state: bytes | tuple[Any, ...]) -> None:
        if self._coming is not None:
            self._coming = self._coming[0], state
            return
        efforts, *held = (state,) if isinstance(state, bytes) else state
        SdfJoint.load_efforts(self.sdf_joints.values(), efforts)
        for gripper, one in zip(self.grippers.values(), held, strict=False):
            gripper.load(one)

    def _entity_joints(self) -> list[Joint]:
        """What ODE has of the joints of the file."""
        return ode_joints(self.sdf_joints.values())

    def _entity_describe(self, store: Store) -> dict[str, Any]:
        """As of all entities; joints by SDF's kinds, sensors, and the names of collisions and visuals."""
        links = ((self.links.get(link.Get(str, "name")), link) for link in self.sdf.named("link"))
        return {
            **super()._entity_describe(store),
            "static": self.static,
            "joints": [describe_sdf_joint(joint) for joint in self.sdf_joints.values()],
            "sensors": [s for body, link in links if body is not None for s in describe_sensors(body, link)],
            "shape_names": self.geom_names,
        }

    # Pose --------------------------------------------------------------------------------------------------------

    @law
    def GetPose(self) -> GzPose:
        """Global pose of the model frame, which is fixed to the first link [m]."""
        if self._canonical is None:
            return GzPose(GzVector(*self._frame.pos), self._frame.rot)
        return GzCoordPoseAdd(self._frame_in_canonical, self._canonical.GetPose())

    def frame_in_body(self) -> tuple[Body, GzPose] | None:
        """The link that the model frame is fixed to, and its pose there [m]; None without links."""
        return None if self._canonical is None else (self._canonical, self._frame_in_canonical)

    def SetPose(self, pose: GzPose) -> None:
        """Move all links, and nested models, as one; all velocities become zero."""
        pose = GzPoseOf(pose)
        before = self.GetPose()
        for model in self.nested_family():
            if model._canonical is None:
                model._frame = GzCoordPoseAdd(GzCoordPoseSub(model._frame, before), pose)
            for body in model.bodies:
                body.SetPose(GzCoordPoseAdd(GzCoordPoseSub(body.GetPose(), before), pose))
                body.SetLinearVel((0.0, 0.0, 0.0))
                body.SetAngularVel((0.0, 0.0, 0.0))

    def restore(self) -> None:
        """Return all links, and those of nested models, to their initial poses in the world, at rest."""
        for model in self.nested_family():
            model._frame, elsewhere = model.initPose, model.initPose != model._start
            for body, place, start in model._places:
                body.SetPose(GzCoordPoseAdd(place, model.initPose) if elsewhere else start)
                body.SetLinearVel((0.0, 0.0, 0.0))
                body.SetAngularVel((0.0, 0.0, 0.0))
                body.SetForce((0.0, 0.0, 0.0))
                body.SetTorque(0.0, 0.0, 0.0)
        for model in self.nested_family():
            for joint in model.sdf_joints.values():
                joint.restore()

    def GetBody(self, name: str | None = None) -> Body:
        """A link by name, `nested::link` too; without one, or for ``canonical``, the first.

        Raises:
            NotFoundError: there is none of this name.
        """
        found = self._canonical if name in (None, "canonical") else self._own_link(name or "")
        if found is None:
            raise NotFoundError(
                f"model {self.GetId()!r} has no link {name!r}; it has {listed(self.link_names())}"
                f"{nearest(name or '', self.link_names())}"
            )
        return found

    def Detach(self) -> None:
        """Take it out of the model that it is nested in."""
        if isinstance(self.parent, SdfModel):
            self.parent.nested.pop(self.name, None)
        super().Detach()

    def close(self) -> None:
        """Destroy joints, links and spaces."""
        for element in self._added.values():
            self.sdf.RemoveChild(element)
        self._added.clear()
        for joint in self.sdf_joints.values():
            joint.close()
        super().close()
        for space in self._spaces.values():
            space.close()


def model_pose(element: Element) -> GzPose:
    """The pose of a `<model>` in its parent."""
    return element.Get(GzPose, "pose") if element.HasElement("pose") else GzPose(GzVector(), GzQuaternIdent())


def _possible(mass: float, moments: list[float], pose: GzPose) -> Mass | None:
    """A mass matrix from its numbers; None where ODE cannot use it."""
    if max(map(abs, (*moments, *pose.pos))) > LARGEST or not positive_definite(moments):
        return None
    found = given_mass(mass, moments, pose)
    return found if is_possible(about_centre(found)) else None
