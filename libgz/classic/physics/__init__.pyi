"""The public names of libgz.classic.physics, and the one module that each comes from."""

from libgz.classic.physics.actor import Actor as Actor, TrajectoryInfo as TrajectoryInfo
from libgz.classic.physics.atmosphere import Atmosphere as Atmosphere
from libgz.classic.physics.base import Base as Base, Entity as Entity
from libgz.classic.physics.collision import (
    Collision as Collision,
    FrictionPyramid as FrictionPyramid,
    SurfaceParams as SurfaceParams,
)
from libgz.classic.physics.contact import Contact as Contact, JointWrench as JointWrench
from libgz.classic.physics.contact_manager import ContactManager as ContactManager
from libgz.classic.physics.engine import PhysicsEngine as PhysicsEngine
from libgz.classic.physics.gripper import Gripper as Gripper
from libgz.classic.physics.inertial import Inertial as Inertial
from libgz.classic.physics.joint import Joint as Joint
from libgz.classic.physics.joint_controller import JointController as JointController
from libgz.classic.physics.light import Light as Light
from libgz.classic.physics.link import Link as Link
from libgz.classic.physics.model import Model as Model
from libgz.classic.physics.preset import PresetManager as PresetManager
from libgz.classic.physics.ray_shape import MultiRayShape as MultiRayShape, RayShape as RayShape
from libgz.classic.physics.registry import (
    get_world as get_world,
    getUniqueId as getUniqueId,
    has_world as has_world,
    pause_world as pause_world,
    pause_worlds as pause_worlds,
    stop_world as stop_world,
    stop_worlds as stop_worlds,
    worlds as worlds,
    worlds_running as worlds_running,
)
from libgz.classic.physics.shape import (
    BoxShape as BoxShape,
    CylinderShape as CylinderShape,
    HeightmapShape as HeightmapShape,
    MeshShape as MeshShape,
    PlaneShape as PlaneShape,
    PolylineShape as PolylineShape,
    Shape as Shape,
    SphereShape as SphereShape,
)
from libgz.classic.physics.state import (
    CollisionState as CollisionState,
    JointState as JointState,
    LightState as LightState,
    LinkState as LinkState,
    ModelState as ModelState,
    State as State,
    WorldState as WorldState,
)
from libgz.classic.physics.wind import Wind as Wind
from libgz.classic.physics.world import World as World
