"""SdfModel: links, collisions, visuals and joints of an SDF document on the engine."""

from __future__ import annotations

import logging
import math

from libgz.errors import GazeboError, NotFoundError, ParameterError, nearest
from libgz.fault import Fault, Faults
from libgz.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzQuaternIdent, GzVector, rotate
from libgz.ode.types import Surface
from libgz.physics.body import Body
from libgz.physics.engine import Space
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CylinderGeom, PlaneGeom, SphereGeom
from libgz.physics.mass import given_mass
from libgz.sdf.element import Element
from libgz.simulation.model import Model
from libgz.simulation.sdf_joint import SdfJoint
from libgz.simulation.sdf_visual import dress, link_lights
from libgz.simulation.world import World

__all__ = ["SdfModel"]

log = logging.getLogger("libgz.simulation")

WORLD_CONTACTS = 20  # physics/max_contacts


class SdfModel(Model):
    """A model built from a `<model>` element.

    Its pose is that of the model frame; links keep their names. Static models have dummy bodies: they stand still
    whatever happens, and touch what moves.
    """

    def __init__(self, world: World, element: Element, faults: Faults, parent: SdfModel | None = None) -> None:
        super().__init__(world)
        self.sdf = element
        self.faults = faults
        self.static: bool = element.Get(bool, "static") or (parent is not None and parent.static)
        self.links: dict[str, Body] = {}
        self.sdf_joints: dict[str, SdfJoint] = {}
        self.geom_names: dict[Geom, str] = {}
        self.visual_elements: dict[Geom, Element] = {}
        self._frame_in_canonical = GzPose()
        self._acting: list[SdfJoint] = []
        self.SetName("model")
        self.SetId(element.Get(str, "name"))

    def build(self, pose: GzPose) -> None:
        """Make links, then joints, with the model frame at a global pose. What is wrong becomes a fault of the file."""
        for link in self.sdf.named("link"):
            self._guard(link, lambda link=link: self._add_link(link, pose))
        if not self.bodies:
            self._note(self.sdf, "a model needs at least one link", "error")
            return
        self._canonical = self.bodies[0]
        self._frame_in_canonical = GzCoordPoseSub(pose, self.bodies[0].GetPose())
        for joint in self.sdf.named("joint"):
            self._guard(joint, lambda joint=joint: self._add_joint(joint, pose))
        self._acting = [joint for joint in self.sdf_joints.values() if joint.acts]

    def _note(self, element: Element, message: str, severity: str = "warning") -> None:
        self.faults.add(Fault(element.file or "<string>", element.line, element.name, message, severity))

    def _guard(self, element: Element, action: object) -> None:
        """Do something; what it raises is an error of the file, told with all others."""
        try:
            action()  # type: ignore[operator]
        except GazeboError as fault:
            self._note(element, str(fault), "error")

    # Links -------------------------------------------------------------------------------------------------------

    def _add_link(self, element: Element, model_pose: GzPose) -> None:
        name = element.Get(str, "name")
        if name in self.links:
            raise ParameterError(f"model {self.GetId()!r} has a link {name!r} already")
        body = Body(self.world, name, dummy=self.static)
        self.links[name] = body
        self.bodies.append(body)
        body.SetPose(GzCoordPoseAdd(element.Get(GzPose, "pose"), model_pose))
        space = Space(self.world.engine) if self._self_collides(element) else self.modelSpaceId
        for collision in element.named("collision"):
            self._guard(collision, lambda c=collision: self._add_collision(body, space, c))
        for visual in element.named("visual"):
            self._guard(visual, lambda v=visual: self._add_visual(body, v))
        link_lights(body, element)
        inertial = element.child("inertial")
        inertia = inertial.child("inertia")
        moments = [inertia.Get(float, key) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]
        if not self.static:
            body.SetMassMatrix(given_mass(inertial.Get(float, "mass"), moments, inertial.Get(GzPose, "pose")))
        body.SetGravityMode(element.Get(bool, "gravity"))
        body.set_damping(*self._decay(element))
        if element.Get(bool, "kinematic"):
            body.set_kinematic(True)

    def _self_collides(self, link: Element) -> bool:
        """Whether a link touches others of its model; from SDF 1.5 the link's word is stronger than the model's."""
        if link.HasElement("self_collide"):
            return link.Get(bool, "self_collide")
        return self.sdf.Get(bool, "self_collide")

    @staticmethod
    def _decay(link: Element) -> tuple[float, float]:
        """Share of linear and angular velocity lost in each step."""
        if not link.HasElement("velocity_decay"):
            return 0.0, 0.0
        decay = link.child("velocity_decay")
        return decay.Get(float, "linear"), decay.Get(float, "angular")

    # Geoms -------------------------------------------------------------------------------------------------------

    def _make_geom(self, body: Body, space: Space | None, element: Element) -> Geom | None:
        """The geom of a collision or visual at its place in the link; None for shapes that are not known here."""
        shape = element.child("geometry").GetFirstElement()
        if shape is None or shape.name == "empty":
            return None
        pose = element.Get(GzPose, "pose")
        geom: Geom
        if shape.name == "box":
            geom = BoxGeom(body, space, *shape.Get(GzVector, "size"))
        elif shape.name == "sphere":
            geom = SphereGeom(body, space, shape.Get(float, "radius"))
        elif shape.name == "cylinder":
            geom = CylinderGeom(body, space, shape.Get(float, "radius"), shape.Get(float, "length"))
        elif shape.name == "plane":
            placed = GzCoordPoseAdd(pose, body.GetPose())
            normal = rotate(placed.rot, shape.Get(GzVector, "normal"))
            altitude = sum(n * p for n, p in zip(normal, placed.pos, strict=True))
            return PlaneGeom(body, space, altitude, normal)
        else:
            known = "box, sphere, cylinder, plane and empty"
            hint = nearest(shape.name, ("box", "sphere", "cylinder", "plane"))
            self._note(shape, f"this shape is not simulated, and is left out; {known} are{hint}")
            return None
        geom.SetRelativePose(pose)
        return geom

    def _add_collision(self, body: Body, space: Space, element: Element) -> None:
        geom = self._make_geom(body, space, element)
        if geom is None:
            return
        geom.appearance.visible = False
        geom.SetRetro(element.Get(float, "laser_retro"))
        self.geom_names[geom] = element.Get(str, "name")
        self._set_surface(geom, element)

    def _set_surface(self, geom: Geom, element: Element) -> None:
        """How a collision touches others; negative friction coefficients are infinite ones."""
        surface = element.child("surface")
        contact, bounce = surface.child("contact"), surface.child("bounce")
        ode, friction = contact.child("ode"), surface.child("friction").child("ode")
        engine, row = self.world.engine, geom.row
        mu, mu2 = (friction.Get(float, key) for key in ("mu", "mu2"))
        geom.SetFriction(mu if mu >= 0.0 else math.inf, mu2 if mu2 >= 0.0 else math.inf)
        geom.SetHardness(ode.Get(float, "kp"), ode.Get(float, "kd"))
        for i, value in enumerate(friction.Get(GzVector, "fdir1")):
            engine.set_surface(row, Surface.FDIR1 + i, value)  # type: ignore[arg-type]
        most = min(element.Get(int, "max_contacts"), WORLD_CONTACTS)
        for column, value in (
            (Surface.SLIP1, friction.Get(float, "slip1")),
            (Surface.SLIP2, friction.Get(float, "slip2")),
            (Surface.BOUNCE, bounce.Get(float, "restitution_coefficient")),
            (Surface.BOUNCE_VEL, bounce.Get(float, "threshold")),
            (Surface.MAX_CONTACTS, most),
            (Surface.MAX_VEL, 0.0 if self.static else ode.Get(float, "max_vel")),
            (Surface.MIN_DEPTH, ode.Get(float, "min_depth")),
            (Surface.BITS, contact.Get(int, "collide_bitmask") & 0xFFFFFFFF),
        ):
            engine.set_surface(row, column, float(value))

    def _add_visual(self, body: Body, element: Element) -> None:
        """A geom without a space: it is drawn and touches nothing."""
        geom = self._make_geom(body, None, element)
        if geom is None:
            return
        self.geom_names[geom] = element.Get(str, "name")
        self.visual_elements[geom] = element
        dress(geom, element, self._note)

    # Joints ------------------------------------------------------------------------------------------------------

    def _add_joint(self, element: Element, model_pose: GzPose) -> None:
        name = element.Get(str, "name")
        if name in self.sdf_joints:
            raise ParameterError(f"model {self.GetId()!r} has a joint {name!r} already")
        if not self.static:
            self.sdf_joints[name] = SdfJoint(self.world.engine, element, self.links, model_pose)

    def Update(self, step: float) -> None:
        """Damping and springs of the joints."""
        if step > 0.0:
            for joint in self._acting:
                joint.update()

    # Pose --------------------------------------------------------------------------------------------------------

    def GetPose(self) -> GzPose:
        """Global pose of the model frame, which is fixed to the first link [m]."""
        return GzCoordPoseAdd(self._frame_in_canonical, self.GetBody().GetPose())

    def GetBody(self, name: str | None = None) -> Body:
        """A link by name; without one, or for ``canonical``, the first.

        Raises:
            NotFoundError: there is none of this name.
        """
        if name in (None, "canonical"):
            return self.bodies[0]
        if name not in self.links:
            known = ", ".join(self.links)
            raise NotFoundError(
                f"model {self.GetId()!r} has no link {name!r}; it has {known}{nearest(name or '', self.links)}"
            )
        return self.links[name]


def model_pose(element: Element) -> GzPose:
    """The pose of a `<model>` in what is around it."""
    return element.Get(GzPose, "pose") if element.HasElement("pose") else GzPose(GzVector(), GzQuaternIdent())
