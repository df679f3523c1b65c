"""A loaded world as SDF 1.6, which both Gazebo classic and gz-sim read.

Each model of the top level becomes one SDF model; the models attached to it, at any depth, become further links of it
with fixed joints. Nested models would preserve more of the structure, but the two simulators name and join their
content differently. The result is made from bodies, joints and geoms, not from the worldfile.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from lxml import etree

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzCoordPoseSub, GzPose
from libgz.convert.element import Notes, add, color, name_of, pose
from libgz.convert.joints import add_joint, ends_of
from libgz.convert.sensors import add_sensors
from libgz.convert.shapes import CORRECTING_VELOCITY, Meshes, add_geom, is_shape
from libgz.front import World
from libgz.legacy.model import Model
from libgz.ode.types import dParamFMax, dParamFMax2, dParamHiStop, dParamLoStop
from libgz.physics.body import Body
from libgz.physics.geoms import LightGeom
from libgz.physics.joint import HingeJoint, Joint, SliderJoint
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint

__all__ = ["RAY_TYPES", "Converted", "convert"]

RAY_TYPES = ("ray", "gpu_ray")
LIGHT_RANGE = 1000.0  # [m]; SDF requires one, libgz's lights have none
GUI_CAMERA = "ObserverCam"
SKY = "SkyDome"


@dataclass
class Converted:
    """A world as SDF, its mesh files (path relative to the SDF file -> bytes), and notes on what has no counterpart."""

    sdf: bytes
    meshes: dict[str, bytes]
    notes: list[str]


def convert(world: World, *, meshes: str = "meshes", rays: str = "ray") -> Converted:
    """A loaded world as SDF 1.6.

    Args:
        world: it need not be initialized, and should not have been stepped.
        meshes: the directory of mesh files, relative to the SDF file.
        rays: ``"ray"``, which Gazebo classic computes as libgz does, or ``"gpu_ray"``, which gz-sim also supports.

    Raises:
        ParameterError: `rays` is something else.
    """
    if rays not in RAY_TYPES:
        raise ParameterError(f"rays is {rays!r}; it must be {' or '.join(RAY_TYPES)}")
    root = etree.Element("sdf", version="1.6")
    work = _Conversion(world, add(root, "world", name="default"), rays, Meshes(meshes))
    for warning in world.file.diagnostics.warnings if world.file is not None else ():
        work.notes.lines.setdefault(str(warning))  # what libgz itself has ignored
    work.settings()
    for model in world.legacy.models:
        if model.parent is None:
            work.model(model)
    text = etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="utf-8")
    return Converted(text, work.meshes.files, list(work.notes.lines))


@dataclass
class _Conversion:
    world: World
    root: etree._Element
    rays: str
    meshes: Meshes
    notes: Notes = field(default_factory=Notes)
    names: set[str] = field(default_factory=set)

    def settings(self) -> None:
        """Physics and scene."""
        world = self.world
        add(self.root, "gravity", world.engine.gravity)
        physics = add(self.root, "physics", name="default_physics", default="1", type="ode")
        add(physics, "max_step_size", world.engine.step_time)
        add(physics, "real_time_factor", world.simSpeed or 1.0)
        add(physics, "real_time_update_rate", world.simSpeed / world.engine.step_time)
        ode = add(physics, "ode")
        solver = add(ode, "solver")
        add(solver, "type", world.engine.solver)
        add(solver, "iters", 50)
        add(solver, "sor", 1.3)
        constraints = add(ode, "constraints")
        add(constraints, "cfm", 0.0)
        add(constraints, "erp", world.engine.erp)
        add(constraints, "contact_max_correcting_vel", CORRECTING_VELOCITY)
        add(constraints, "contact_surface_layer", 0.0)
        scene = add(self.root, "scene")
        add(scene, "ambient", self._ambient())
        add(scene, "background", color(world.skyColor))
        add(scene, "shadows", False)
        if world.fogEnable:
            fog = add(scene, "fog")
            add(fog, "color", color(world.skyColor))
            add(fog, "type", "exp2")
            add(fog, "density", world.fogDensity)
        sky = next((model for model in world.legacy.models if model.GetName() == SKY), None)
        if sky is not None:
            day_time = world.settings.dayTime
            add(add(scene, "sky"), "time", day_time / 3600.0 if day_time >= 0.0 else 12.0)
            self.notes.add(_owner(sky), "becomes the simulator's own sky; its toneMap is omitted")
        observers = [model for model in world.legacy.models if model.GetName() == GUI_CAMERA]
        for observer in observers[:1]:
            camera = add(add(self.root, "gui"), "camera", name="user_camera")
            add(camera, "pose", pose(observer.GetPose()))
            self.notes.add(_owner(observer), "only sets the initial view of the simulator's own window")
        for observer in observers[1:]:
            self.notes.add(_owner(observer), "is omitted: the simulator has one window")

    def _ambient(self) -> list[float]:
        """The ambient light of all lights together; in SDF it is the scene's."""
        total = [0.0, 0.0, 0.0]
        for model in self.world.models:
            for geom in (geom for body in model.bodies for geom in body.geoms if isinstance(geom, LightGeom)):
                total = [old + new for old, new in zip(total, geom.GetAmbientColor(), strict=False)]
        return [*(min(part, 1.0) for part in total), 1.0]

    def model(self, top: Model) -> None:
        """One model of the top level, with all that is attached to it."""
        members = list(_with_attached(top))
        for member in members:
            self._lights(member, nested=member is not top)
        shapes = [body for m in members for body in m.bodies if not body.dummy or any(map(is_shape, body.geoms))]
        if shapes:
            self._solid(top, members, shapes)
        elif not any(isinstance(geom, LightGeom) for m in members for body in m.bodies for geom in body.geoms):
            for member in members:
                if member.GetName() not in (GUI_CAMERA, SKY):
                    self.notes.add(_owner(member), "is omitted: it has no bodies that could become links")
                    self._note_interfaces(member, set())
                    self._note_behaviour(member)

    def _solid(self, top: Model, members: list[Model], bodies: list[Body]) -> None:
        element = add(self.root, "model", name=name_of(top.GetId(), self.names))
        place = top.GetPose()
        add(element, "pose", pose(place))
        static = top.fixed or all(body.dummy for body in top.bodies)
        if static:
            add(element, "static", True)
        taken: set[str] = set()
        links: dict[Body, etree._Element] = {}
        canonical_first = sorted(bodies, key=lambda body: body is not top.GetBody())
        for body in canonical_first:
            owner = next(member for member in members if body in member.bodies)
            links[body] = self._link(element, owner, body, name_of(_link_name(top, owner, body), taken), place)
        for member in members:
            served = add_sensors(member, links, self.rays, _owner(member), self.notes)
            self._note_interfaces(member, served)
            self._note_behaviour(member)
        self._joints(element, top, members, links, taken)
        for member in members:
            if member.follows and not static and any(body in links for body in member.bodies):
                self.notes.add(_owner(member), "follows its parent without a joint; as SDF it will fall")

    def _joints(
        self,
        element: etree._Element,
        top: Model,
        members: list[Model],
        links: dict[Body, etree._Element],
        taken: set[str],
    ) -> None:
        """The joints of a model and of the models attached to it; their names differ from those of the links."""

        def link_name(body: Body | None) -> str:
            return "world" if body is None else str(links[body].get("name"))

        held: set[Body] = set()
        for joint in _joints_between(members, links):
            child, _ = ends_of(joint)
            if child is None:
                continue
            owner = next(member for member in members if child in member.bodies)
            if child in held:
                self.notes.add(
                    _owner(owner), f"link {link_name(child)} has two parent joints, which gz-sim does not support"
                )
            held.add(child)
            if joint is owner.welded:
                name = f"{link_name(child)}_weld"
            else:
                name = f"{'' if owner is top else owner.GetId() + '_'}{joint.name or link_name(child)}_joint"
            add_joint(element, joint, name_of(name, taken), link_name, _owner(owner), self.notes)

    def _link(self, model: etree._Element, owner: Model, body: Body, name: str, base: GzPose) -> etree._Element:
        """The link of a body: its place in the model, mass, shapes."""
        link = add(model, "link", name=name)
        add(link, "pose", pose(GzCoordPoseSub(body.GetPose(), base)))
        if not body.dummy:
            if not body.GetGravityMode():
                add(link, "gravity", False)
            self._inertial(link, body)
        for i, geom in enumerate(body.geoms):
            if is_shape(geom):
                part = f"{model.get('name')}_{name}_{i}"  # also the name of a mesh file
                add_geom(link, geom, part, body.GetPose(), _owner(owner), self.meshes, self.notes)
        return link

    def _inertial(self, link: etree._Element, body: Body) -> None:
        mass = body.GetMass()
        inertial = add(link, "inertial")
        add(inertial, "pose", pose(GzPose(body.com)))
        add(inertial, "mass", float(mass.mass))
        inertia = add(inertial, "inertia")
        for tag, index in (("ixx", 0), ("ixy", 1), ("ixz", 2), ("iyy", 5), ("iyz", 6), ("izz", 10)):
            add(inertia, tag, float(mass.I[index]))

    def _lights(self, model: Model, nested: bool) -> None:
        """Add the lights of a model to the world: in SDF 1.6 lights cannot be part of a model."""
        for body in model.bodies:
            for geom in body.geoms:
                if not isinstance(geom, LightGeom):
                    continue
                light = add(self.root, "light", name=name_of(model.GetId(), self.names), type="point")
                add(light, "pose", pose(geom.GetPose()))
                add(light, "cast_shadows", False)
                add(light, "diffuse", color(geom.GetDiffuseColor()))
                add(light, "specular", color(geom.GetSpecularColor()))
                attenuation = add(light, "attenuation")
                add(attenuation, "range", LIGHT_RANGE)
                for tag, value in zip(("constant", "linear", "quadratic"), geom.attenuation, strict=True):
                    add(attenuation, tag, value)
                if nested:
                    self.notes.add(_owner(model), "does not move: lights of SDF 1.6 belong to the world")

    def _note_interfaces(self, model: Model, served: set[str]) -> None:
        left = [name for name in model.interfaces if name not in served]
        if left:
            self.notes.add(_owner(model), f"interfaces without a counterpart: {', '.join(left)}; use a plugin instead")

    def _note_behaviour(self, model: Model) -> None:
        """Note what bodies, joints and sensors do not show: what the model's code does, and what ODE applies."""
        owner, kind = _owner(model), type(model)
        if model.node is not None and model.node.GetChild("plugin") is not None:
            self.notes.add(owner, "its plugin is omitted: it is legacy Python")
        if kind.behaviour:
            self.notes.add(owner, f"its behaviour is lost: {kind.behaviour}; use a plugin instead")
        elif kind.Update is not Model.Update and not kind.__module__.startswith("libgz."):
            self.notes.add(owner, f"what {kind.__name__}.Update does is lost; use a plugin instead")
        bodies = [body for body in model.bodies if not body.dummy]
        joints = {joint: None for body in bodies for joint in body.joints if ends_of(joint)[0] is body}
        driven = [joint.name or "unnamed" for joint in joints if joint is not model.welded and _is_driven(joint)]
        if driven:
            self.notes.add(owner, f"motors of joints are lost, which turn freely: {', '.join(driven)}")
        if any(body.damping != (0.0, 0.0) for body in bodies):
            self.notes.add(owner, "the damping of its bodies is lost")
        if bodies and not any(body.IsEnabled() for body in bodies):
            self.notes.add(owner, "moves from the start: SDF has no <enable>false</enable>")


def _is_driven(joint: Joint) -> bool:
    """Whether a motor acts on a joint that can move."""
    if isinstance(joint, HingeJoint | SliderJoint):
        return joint.GetParam(dParamFMax) > 0.0 and joint.GetParam(dParamLoStop) < joint.GetParam(dParamHiStop)
    if isinstance(joint, Hinge2Joint | UniversalJoint):
        return joint.GetParam(dParamFMax) > 0.0 or joint.GetParam(dParamFMax2) > 0.0
    return False


def _owner(model: Model) -> str:
    """The name of a model in notes."""
    where = f"{model.node.file.label}:{model.node.line}: " if model.node is not None else ""
    return f"{where}<model:{model.GetName()}> {model.GetId()!r}"


def _with_attached(model: Model) -> list[Model]:
    """A model and all models attached to it, at any depth."""
    return [entity for entity in model.with_attached() if isinstance(entity, Model)]


def _link_name(top: Model, owner: Model, body: Body) -> str:
    own = body.bodyName or f"body{owner.bodies.index(body)}"
    return own if owner is top else f"{owner.GetId()}_{own}"


def _joints_between(members: list[Model], links: dict[Body, etree._Element]) -> Iterator[Joint]:
    """All joints of these models whose bodies are links, in order of construction; once each."""
    found = {joint.row: joint for member in members for body in member.bodies for joint in body.joints}
    for _, joint in sorted(found.items()):
        if all(body is None or body.dummy or body in links for body in joint.bodies):
            yield joint
