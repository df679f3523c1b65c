"""Gazebo classic's `physics` names: views on the objects of the engine.

There is one view for each World, Model, Link, Joint, Collision and Light of the engine, so that `is` works; the
engine's object holds it as `view`. Poses, velocities and settings are the engine's. A view keeps its name, id, parent
and SDF element, a Link whether it is kinematic, and a Collision its bitmask while it has no contacts. All other state,
such as joint controllers, batteries and animations, is kept by its `libgz.classic.server.WorldServer`.
"""

from libgz.classic.api import without
from libgz.classic.physics.actor import Actor, TrajectoryInfo
from libgz.classic.physics.atmosphere import Atmosphere
from libgz.classic.physics.base import Base, Entity
from libgz.classic.physics.collision import Collision, FrictionPyramid, SurfaceParams
from libgz.classic.physics.contact import Contact, JointWrench
from libgz.classic.physics.contact_manager import ContactManager
from libgz.classic.physics.engine import PhysicsEngine
from libgz.classic.physics.gripper import Gripper
from libgz.classic.physics.inertial import Inertial
from libgz.classic.physics.joint import Joint
from libgz.classic.physics.joint_controller import JointController
from libgz.classic.physics.light import Light
from libgz.classic.physics.link import Link
from libgz.classic.physics.model import Model
from libgz.classic.physics.preset import PresetManager
from libgz.classic.physics.ray_shape import MultiRayShape, RayShape
from libgz.classic.physics.registry import (
    get_world,
    getUniqueId,
    has_world,
    pause_world,
    pause_worlds,
    stop_world,
    stop_worlds,
    worlds,
    worlds_running,
)
from libgz.classic.physics.shape import (
    BoxShape,
    CylinderShape,
    HeightmapShape,
    MeshShape,
    PlaneShape,
    PolylineShape,
    Shape,
    SphereShape,
)
from libgz.classic.physics.state import (
    CollisionState,
    JointState,
    LightState,
    LinkState,
    ModelState,
    State,
    WorldState,
)
from libgz.classic.physics.wind import Wind
from libgz.classic.physics.world import World

__all__ = [
    "Actor",
    "Atmosphere",
    "Base",
    "BoxShape",
    "Collision",
    "CollisionState",
    "Contact",
    "ContactManager",
    "CylinderShape",
    "Entity",
    "FrictionPyramid",
    "Gripper",
    "HeightmapShape",
    "Inertial",
    "Joint",
    "JointController",
    "JointState",
    "JointWrench",
    "Light",
    "LightState",
    "Link",
    "LinkState",
    "MeshShape",
    "Model",
    "ModelState",
    "MultiRayShape",
    "PhysicsEngine",
    "PlaneShape",
    "PolylineShape",
    "PresetManager",
    "RayShape",
    "Shape",
    "SphereShape",
    "State",
    "SurfaceParams",
    "TrajectoryInfo",
    "Wind",
    "World",
    "WorldState",
    "getUniqueId",
    "get_world",
    "has_world",
    "pause_world",
    "pause_worlds",
    "stop_world",
    "stop_worlds",
    "worlds",
    "worlds_running",
]

__getattr__ = without(__name__)
