"""Messages that describe a world, its models, links, joints, collisions and lights."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from libgz.base.geometry import GzCoordPoseSub, GzPose
from libgz.classic import msgs
from libgz.classic.common import Time
from libgz.classic.looks import (
    collision_visual,
    entity_visual,
    fill_geometry,
    fill_plugins,
    fill_scene,
    visual_messages,
)
from libgz.classic.physics.base import Entity
from libgz.classic.physics.collision import Collision
from libgz.classic.physics.contact_messages import contacts_message
from libgz.classic.physics.joint import Joint
from libgz.classic.physics.light import Light
from libgz.classic.physics.link import Link
from libgz.classic.physics.model import Model
from libgz.classic.physics.shape import BoxShape, CylinderShape, HeightmapShape, SphereShape
from libgz.classic.physics.world import World
from libgz.physics.geoms import LightGeom
from libgz.sdf.element import Element

if TYPE_CHECKING:
    from libgz.classic.physics.actor import Actor

__all__ = [
    "contacts_of",
    "diagnostics_message",
    "entity_message",
    "heights_message",
    "joint_message",
    "light_message",
    "link_data_message",
    "model_message",
    "physics_message",
    "place_message",
    "poses_message",
    "scene_message",
    "skeleton_message",
    "statistics_message",
    "surroundings_message",
]

LIGHT_KINDS = ("point", "spot", "directional")


def statistics_message(world: World) -> Any:
    """~/world_stats."""
    message = msgs.WorldStatistics(
        paused=world.IsPaused(), iterations=world.Iterations(), model_count=world.ModelCount()
    )
    msgs.Set(message.sim_time, world.SimTime())
    msgs.Set(message.pause_time, world.PauseTime())
    msgs.Set(message.real_time, world.RealTime())
    if world.played is not None:
        for field, seconds in zip(("start_time", "end_time"), world.played(), strict=True):
            msgs.Set(getattr(message.log_playback_stats, field), Time(seconds))
    return message


def link_data_message(link: Link) -> Any:
    """~/MODEL::LINK: the velocities of a link [m/s], [rad/s]."""
    message = msgs.LinkData(name=link.GetScopedName())
    msgs.Set(message.time, link.GetWorld().SimTime())
    msgs.Set(message.linear_velocity, link.WorldLinearVel())
    msgs.Set(message.angular_velocity, link.WorldAngularVel())
    return message


def diagnostics_message(world: World) -> Any:
    """~/diagnostics: times, and the real-time factor since the start."""
    message, real = msgs.Diagnostics(), world.RealTime().Double()
    msgs.Set(message.real_time, world.RealTime())
    msgs.Set(message.sim_time, world.SimTime())
    message.real_time_factor = world.SimTime().Double() / real if real > 0.0 else 0.0
    return message


def place_message(world: World) -> Any:
    """Where a world is on Earth."""
    place = world.SphericalCoords()
    return msgs.SphericalCoordinates(
        surface_model=msgs.SphericalCoordinates.EARTH_WGS84,
        latitude_deg=math.degrees(float(place.LatitudeReference())),
        longitude_deg=math.degrees(float(place.LongitudeReference())),
        elevation=place.ElevationReference(),
        heading_deg=math.degrees(float(place.HeadingOffset())),
    )


def poses_message(world: World) -> Any:
    """~/pose/info: the poses of all models, links and lights, relative to their parents."""
    message = msgs.PosesStamped()
    msgs.Set(message.time, world.SimTime())
    for entity in _entities(world):
        pose = message.pose.add()
        msgs.Set(pose, entity.RelativePose())
        pose.name, pose.id = entity.GetScopedName(), entity.GetId()
    return message


def _entities(world: World) -> Iterator[Entity]:
    for model in world.all_models():
        yield model
        yield from model.GetLinks()
    yield from world.Lights()


def physics_message(world: World) -> Any:
    """The physics parameters of a world."""
    physics = world.Physics()
    message = msgs.Physics(
        type=msgs.Physics.ODE,
        solver_type=physics.GetParam("solver_type"),
        min_step_size=physics.GetParam("min_step_size"),
        precon_iters=physics.GetParam("precon_iters"),
        contact_surface_layer=physics.GetParam("contact_surface_layer"),
        iters=physics.GetParam("iters"),
        sor=physics.GetParam("sor"),
        cfm=physics.GetParam("cfm"),
        erp=physics.GetParam("erp"),
        enable_physics=world.PhysicsEnabled(),
        real_time_factor=physics.GetTargetRealTimeFactor(),
        real_time_update_rate=physics.GetRealTimeUpdateRate(),
        max_step_size=physics.GetMaxStepSize(),
        profile_name=world.PresetMgr().CurrentProfile(),
    )
    correcting_velocity = physics.GetParam("contact_max_correcting_vel")
    if math.isfinite(correcting_velocity):
        message.contact_max_correcting_vel = correcting_velocity
    msgs.Set(message.gravity, world.Gravity())
    msgs.Set(message.magnetic_field, world.MagneticField())
    return message


def contacts_of(world: World) -> Any:
    """~/physics/contacts: the recorded contacts of the last step."""
    return contacts_message(world.Physics().GetContactManager().read(), world.SimTime())


def model_message(model: Model) -> Any:
    """A model with its links, joints, nested models and plugins."""
    message = msgs.Model(
        name=model.GetScopedName(),
        id=model.GetId(),
        is_static=model.IsStatic(),
        self_collide=model.GetSelfCollide(),
        enable_wind=model.WindMode(),
    )
    msgs.Set(message.pose, model.RelativePose())
    msgs.Set(message.scale, model.Scale())
    message.visual.append(entity_visual("MODEL", message, *_parent(model)))
    for link in model.GetLinks():
        message.link.append(_link_message(link))
    for joint in model.GetJoints():
        message.joint.append(joint_message(joint))
    for nested in model.NestedModels():
        message.model.append(model_message(nested))
    sdf = model.GetSDF()
    if sdf is not None:
        fill_plugins(message, sdf)
    return message


def _link_message(link: Link) -> Any:
    message = msgs.Link(
        name=link.GetScopedName(),
        id=link.GetId(),
        gravity=link.GetGravityMode(),
        kinematic=link.GetKinematic(),
        enabled=link.GetEnabled(),
        self_collide=link.GetSelfCollide(),
        canonical=link.IsCanonicalLink(),
        enable_wind=link.WindMode(),
    )
    msgs.Set(message.pose, link.RelativePose())
    message.visual.append(entity_visual("LINK", message, *_parent(link)))
    _fill_inertial(message.inertial, link)
    for collision in link.GetCollisions():
        message.collision.append(_collision_message(collision))
    for battery in link.batteries:
        message.battery.add(name=battery.Name(), voltage=battery.Voltage())
    for sensor in link.GetWorld().server.sensors_of(link):
        sensor.FillMsg(message.sensor.add())
    sdf = link.GetSDF()
    if sdf is not None:
        message.visual.extend(visual_messages(sdf, link.GetScopedName(), link.GetId(), link.IsStatic()))
        geoms = [geom for geom in link.body.geoms if isinstance(geom, LightGeom)]
        for geom, element in zip(geoms, sdf.named("light"), strict=False):
            light = message.light.add(name=f"{link.GetScopedName()}::{element.Get(str, 'name')}")
            msgs.Set(light.pose, element.Get(GzPose, "pose"))
            _fill_light(light, geom)
    return message


def _fill_inertial(message: Any, link: Link) -> None:
    """Describe mass and moments of inertia; those of static models are 0, as in Gazebo."""
    inertial = link.GetInertial()
    message.mass = inertial.Mass()
    for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"):
        setattr(message, name, getattr(inertial, name.upper())())
    msgs.Set(message.pose, inertial.Pose())


def _collision_message(collision: Collision) -> Any:
    message = msgs.Collision(
        name=collision.GetScopedName(),
        id=collision.GetId(),
        laser_retro=collision.GetLaserRetro(),
        max_contacts=collision.GetMaxContacts(),
    )
    msgs.Set(message.pose, collision.RelativePose())
    shape, geometry = collision.GetShape(), message.geometry
    kinds = type(geometry)
    if isinstance(shape, BoxShape):
        geometry.type = kinds.BOX
        msgs.Set(geometry.box.size, shape.Size())
    elif isinstance(shape, SphereShape):
        geometry.type = kinds.SPHERE
        geometry.sphere.radius = shape.GetRadius()
    elif isinstance(shape, CylinderShape):
        geometry.type = kinds.CYLINDER
        geometry.cylinder.radius, geometry.cylinder.length = shape.GetRadius(), shape.GetLength()
    elif (sdf := collision.GetSDF()) is not None:
        for element in sdf.named("geometry"):
            fill_geometry(geometry, element)
    _fill_surface(message.surface, collision)
    at = _parent(collision)
    shown = collision_visual(message, *at, collision.IsStatic())
    message.visual.extend((entity_visual("COLLISION", message, *at), shown))
    return message


def _parent(entity: Entity) -> tuple[str, int]:
    """The name and the id of what an entity belongs to: a model, a link, or the world."""
    parent = entity.GetParent()
    return parent.GetScopedName(), parent.GetId()


def _fill_surface(message: Any, collision: Collision) -> None:
    """Describe the contact parameters of a collision; coefficients without a limit are negative, as in a file."""
    surface = collision.GetSurface()
    pyramid, friction = surface.FrictionPyramid(), message.friction
    friction.mu, friction.mu2, friction.torsional.coefficient = (
        value if math.isfinite(value) else -1.0
        for value in (pyramid.MuPrimary(), pyramid.MuSecondary(), pyramid.MuTorsion())
    )
    msgs.Set(friction.fdir1, pyramid.direction1)
    friction.slip1, friction.slip2 = surface.slip1, surface.slip2
    friction.torsional.use_patch_radius = pyramid.UsePatchRadius()
    friction.torsional.patch_radius = pyramid.PatchRadius()
    friction.torsional.surface_radius = pyramid.SurfaceRadius()
    message.restitution_coefficient, message.bounce_threshold = surface.bounce, surface.bounceThreshold
    message.kp, message.kd = surface.kp, surface.kd
    if (sdf := collision.GetSDF()) is not None:
        _fill_as_declared(message, sdf.child("surface"))
    message.max_vel, message.min_depth = surface.maxVel, surface.minDepth
    message.collide_bitmask = surface.collideBitmask & 0xFFFFFFFF
    message.collide_without_contact = surface.collideWithoutContact
    message.collide_without_contact_bitmask = surface.collideWithoutContactBitmask & 0xFFFFFFFF


def _fill_as_declared(message: Any, surface: Element) -> None:
    """Describe what has no setter, as the file has it: elasticity, and what contacts do not use."""
    contact, torsional = surface.child("contact"), surface.child("friction").find_or_imply("torsional")
    ode = contact.child("ode")
    message.soft_cfm, message.soft_erp = ode.Get(float, "soft_cfm"), ode.Get(float, "soft_erp")
    message.elastic_modulus = contact.Get(float, "elastic_modulus")
    if torsional is not None:  # from 1.5 on
        message.friction.torsional.ode.slip = torsional.child("ode").Get(float, "slip")


def joint_message(joint: Joint) -> Any:
    """A joint."""
    message = msgs.Joint(name=joint.GetScopedName(), id=joint.GetId(), type=joint.GetMsgType())
    message.parent, message.parent_id = _name_and_id(joint.GetParent())
    message.child, message.child_id = _name_and_id(joint.GetChild())
    msgs.Set(message.pose, joint.InitialAnchorPose())
    for index in range(len(joint.core.axes)):
        message.angle.append(joint.Position(index))
        axis = message.axis1 if index == 0 else message.axis2
        msgs.Set(axis.xyz, joint.LocalAxis(index))
        axis.limit_lower, axis.limit_upper = joint.LowerLimit(index), joint.UpperLimit(index)
        axis.limit_effort, axis.limit_velocity = joint.GetEffortLimit(index), joint.GetVelocityLimit(index)
        axis.damping, axis.friction = joint.GetDamping(index), joint.GetParam("friction", index)
        axis.use_parent_model_frame, axis.xyz_expressed_in = False, ""  # LocalAxis is in the joint's frame
    if message.type == message.SCREW:
        message.screw.thread_pitch = joint.GetParam("thread_pitch", 0)
    elif message.type == message.GEARBOX:
        message.gearbox.gearbox_ratio = joint.GetParam("gearbox_ratio", 0)
        sdf = joint.GetSDF()
        message.gearbox.gearbox_reference_body = (
            sdf.Get(str, "gearbox_reference_body")
            if sdf is not None and sdf.HasElement("gearbox_reference_body")
            else ""
        )
    for sensor in joint.GetWorld().server.sensors_of(joint):
        sensor.FillMsg(message.sensor.add())
    return message


def _name_and_id(link: Link | None) -> tuple[str, int]:
    return (link.GetScopedName(), link.GetId()) if link is not None else ("world", 0)


def light_message(light: Light) -> Any:
    """A light."""
    message = msgs.Light(name=light.GetName(), id=light.GetId())
    msgs.Set(message.pose, light.RelativePose())
    _fill_light(message, light.core.light)
    return message


def _fill_light(message: Any, geom: LightGeom) -> None:
    message.type = LIGHT_KINDS.index(geom.kind) + 1
    msgs.Set(message.diffuse, geom.GetDiffuseColor())
    msgs.Set(message.specular, geom.GetSpecularColor())
    msgs.Set(message.direction, geom.direction)
    message.range, message.cast_shadows = geom.range, geom.cast_shadows
    message.attenuation_constant, message.attenuation_linear, message.attenuation_quadratic = geom.attenuation
    if geom.kind == "spot":
        message.spot_inner_angle, message.spot_outer_angle, message.spot_falloff = geom.spot


def surroundings_message(world: World) -> Any:
    """~/scene: the look of the scene, without models and lights."""
    message = msgs.Scene(name=world.Name())
    sdf = world.SDF()
    for scene in sdf.named("scene") if sdf is not None else ():
        fill_scene(message, scene)
    return message


def scene_message(world: World) -> Any:
    """All models and lights, and the look of the scene."""
    message = surroundings_message(world)
    for model in world.Models():
        message.model.append(model_message(model))
        message.joint.extend(message.model[-1].joint)
    for light in world.Lights():
        message.light.append(light_message(light))
    return message


def skeleton_message(actor: Actor) -> Any:
    """The bones of an actor, each relative to its parent; its links, relative to the actor; and the actor itself."""
    message = msgs.PoseAnimation(model_name=actor.GetScopedName(), model_id=actor.GetId())
    place, bones = actor.core.GetPose(), actor.core.bones()
    for name, pose, body in bones:
        link = actor.link(body)
        for number, called, part in (
            (0, name, pose),
            (link.GetId(), link.GetScopedName(), GzCoordPoseSub(body.GetPose(), place)),
        ):
            entry = message.pose.add(name=called)
            if number:
                entry.id = number
            msgs.Set(entry, part)
    whole = message.pose.add(name=actor.GetScopedName(), id=actor.GetId())
    msgs.Set(whole, actor.RelativePose())
    msgs.Set(message.time.add(), actor.core.script_time)
    return message


def heights_message(world: World) -> Any:
    """The heights of the world's first heightmap as a msgs.Geometry, rows from -y to +y; None if there is none."""
    for model in world.all_models():
        for link in model.GetLinks():
            for collision in link.GetCollisions():
                shape = collision.GetShape()
                if isinstance(shape, HeightmapShape):
                    geometry: Any = _collision_message(collision).geometry
                    heights = shape.heights()
                    geometry.heightmap.height, geometry.heightmap.width = heights.shape
                    geometry.heightmap.heights.extend(heights[::-1].ravel().tolist())
                    return geometry
    return None


def entity_message(entity: object) -> Any:
    """A model, link, collision, joint or light; None for anything else."""
    if isinstance(entity, Model):
        return model_message(entity)
    if isinstance(entity, Link):
        return _link_message(entity)
    if isinstance(entity, Collision):
        return _collision_message(entity)
    if isinstance(entity, Joint):
        return joint_message(entity)
    return light_message(entity) if isinstance(entity, Light) else None
