"""Values of Gazebo classic's API: what is read after each change, in C++ under Gazebo and in Python here.

A scene has a world, objects, and a script of changes. After each change all getters of all objects are read twice:
at once, and after one iteration. The expressions are Python, and become C++ by `cxx_source`: a dot before a capital is
an arrow, `!` a dot, and texts have double quotes.

`tests/data/classic_values` has what Gazebo 11.1 returned; `tests/trials/test_classic_values.py` records it.
"""

# ruff: noqa: E501, BLE001 - lines of SDF and C++; what a getter raises is a value

from __future__ import annotations

import gzip
import json
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

RECORDED = Path(__file__).parent / "data" / "classic_values"
POSES = ("0 0 20 0 0 0", "13 1 22 0.3 0 0", "-14 2 21 0 0.7 0", "5 -13 24 0 0 2.1", "-6 -17 23 0.4 -1.1 2.8")

INERTIAL = """<inertial><pose>0.05 -0.02 0.03 0.1 0.2 0.3</pose><mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.2</iyy>
  <izz>0.25</izz><ixy>0.01</ixy><ixz>0.02</ixz><iyz>-0.015</iyz></inertia></inertial>"""
SMALL = """<inertial><pose>0 0.02 0 0 0 0</pose><mass>0.5</mass>
  <inertia><ixx>0.01</ixx><iyy>0.02</iyy><izz>0.015</izz></inertia></inertial>"""
# Without gyroscopic torques: Gazebo's ODE solves them explicitly, Debian's implicitly.
EVEN = """<inertial><pose>0.05 -0.02 0.03 0.1 0.2 0.3</pose><mass>{mass}</mass>
  <inertia><ixx>{moment}</ixx><iyy>{moment}</iyy><izz>{moment}</izz></inertia></inertial>"""


@dataclass
class Scene:
    """One world and what is done in it.

    Attributes:
        world: what is in `<world>`; `{i}` and `{pose}` in `each` are the number of a pose and the pose.
        each: what is in it once for each pose.
        objects: name -> (class in the tables of getters, expression); `{i}` makes it one for each pose.
        script: "object change", several of one iteration apart by " | "; "" changes nothing.
    """

    objects: dict[str, tuple[str, str]]
    script: list[str]
    world: str = ""
    each: str = ""
    version: str = "1.6"
    tolerance: float = 1e-9

    @property
    def text(self) -> str:
        """The world's file, without plugin."""
        models = "".join(self.each.format(i=i, pose=pose) for i, pose in enumerate(POSES))
        return (
            f"<sdf version='{self.version}'><world name='default'>{self.world}{models}"
            "<plugin name='probe' filename='libprobe.so'/></world></sdf>"
        )

    def all_objects(self) -> dict[str, tuple[str, str]]:
        """Those of all poses."""
        found = {}
        for name, (kind, expression) in self.objects.items():
            for i in range(len(POSES)) if "{i}" in name + expression else [None]:
                found[name if i is None else f"{name}{i}"] = (kind, expression.replace("{i}", str(i)))
        return found

    def changes(self, line: str) -> list[tuple[str, str]]:
        """(object, change) of a line of the script, for all poses."""
        found = []
        for part in line.split(" | ") if line else []:
            name, _, change = part.partition(" ")
            holders = [one for one in self.all_objects() if one == name or one[:-1] == name]
            assert holders, line
            found += [(holder, change.replace("{i}", holder[-1])) for holder in holders]
        return found


# Getters, by class: expressions on the object. Names of parents are in PARENTS.
PARENTS = {
    "Model": "Entity", "Link": "Entity", "Collision": "Entity", "Light": "Entity", "Entity": "Base", "Joint": "Base",
    "BoxShape": "Shape", "SphereShape": "Shape", "CylinderShape": "Shape", "PlaneShape": "Shape",
    "HingeJoint": "Joint", "SliderJoint": "Joint", "ScrewJoint": "Joint", "Hinge2Joint": "TwoAxes",
    "UniversalJoint": "TwoAxes", "GearboxJoint": "TwoAxes", "TwoAxes": "Joint",
    "BallJoint": "Joint", "FixedJoint": "Joint",
    "ImuSensor": "Sensor", "AltimeterSensor": "Sensor", "GpsSensor": "Sensor", "MagnetometerSensor": "Sensor",
    "RaySensor": "Sensor", "SonarSensor": "Sensor", "ContactSensor": "Sensor", "ForceTorqueSensor": "Sensor",
    "LogicalCameraSensor": "Sensor", "WirelessTransmitter": "Sensor",
}  # fmt: skip
GETTERS: dict[str, list[str]] = {
    "World": [
        "Name()", "Gravity()", "MagneticField()", "ModelCount()", "ModelByIndex(0)", "ModelByIndex(99)", "Models()",
        "LightCount()", "Lights()", "IsLoaded()", "SimTime()", "PauseTime()", "ModelBelowPoint(V(2, 0, 9))",
        "EntityBelowPoint(V(2, 0, 9))", "EntityBelowPoint(V(2, 0, -9))", "IsPaused()", "BaseByName('box0')", "BaseByName('m1')",
        "ModelByName('m2')", "ModelByName('inner')", "ModelByName('m1::inner')", "EntityByName('m1::inner')",
        "EntityByName('m1::inner::part')", "EntityByName('base')", "EntityByName('m3::base')",
        "EntityByName('m3::base::box')", "EntityByName('sun')", "LightByName('sun')", "PhysicsEnabled()",
        "WindEnabled()", "AtmosphereEnabled()", "Iterations()", "Running()", "StripWorldName('default::m1')",
        "SensorsInitialized()", "UniqueModelName('m1')", "UniqueModelName('m9')",
        "Physics().GetType()", "Physics().GetMaxStepSize()", "Physics().GetRealTimeUpdateRate()",
        "Physics().GetTargetRealTimeFactor()", "Physics().GetAutoDisableFlag()", "Physics().GetUpdatePeriod()",
        *(f"Physics().GetParam('{key}')" for key in (
            "solver_type", "cfm", "erp", "precon_iters", "iters", "sor", "contact_surface_layer",
            "contact_max_correcting_vel", "max_contacts", "min_step_size", "max_step_size", "real_time_factor",
            "real_time_update_rate", "gravity", "magnetic_field", "sor_lcp_tolerance", "rms_error_tolerance",
            "contact_residual_smoothing", "contact_sor_scale", "thread_position_correction", "friction_model",
            "world_step_solver", "island_threads", "inertia_ratio_reduction", "type",
        )),
        "Physics().GetContactManager().GetContactCount()", "Physics().GetContactManager().GetFilterCount()",
        "Physics().GetContactManager().NeverDropContacts()", "Physics().GetContactManager().HasFilter('f')",
        "Atmosphere()!Type()", "Atmosphere()!Temperature()", "Atmosphere()!Temperature(100.0)",
        "Atmosphere()!Pressure()", "Atmosphere()!Pressure(100.0)", "Atmosphere()!MassDensity()",
        "Atmosphere()!MassDensity(100.0)", "Atmosphere()!TemperatureGradient()", "Wind()!LinearVel()",
        "SphericalCoords().LatitudeReference()", "SphericalCoords().LongitudeReference()",
        "SphericalCoords().GetElevationReference()", "SphericalCoords().HeadingOffset()",
    ],
    "Base": [
        "GetName()", "GetScopedName()", "GetScopedName(True)", "GetType()", "GetChildCount()", "GetParent()", "HasType(LINK)",
        "GetWorld().Name()", "GetByName('base')", "GetByName('nothing')", "TypeStr()", "GetSaveable()", "IsSelected()",
    ],
    "Entity": [
        "GetChild(0)", "GetChild('base')", "WorldPose()", "RelativePose()", "InitialRelativePose()", "WorldLinearVel()", "WorldAngularVel()",
        "RelativeLinearVel()", "RelativeAngularVel()", "WorldLinearAccel()", "WorldAngularAccel()",
        "RelativeLinearAccel()", "RelativeAngularAccel()", "BoundingBox()", "CollisionBoundingBox()", "IsStatic()",
        "IsCanonicalLink()", "GetParentModel()", "DirtyPose()",
    ],
    "Model": [
        "GetJointCount()", "NestedModel('inner')", "NestedModel('m1::inner')", "NestedModels()", "GetLinks()",
        "GetJoints()", "GetLink()", "GetLink('canonical')", "GetLink('base')", "GetLink('inner::part')",
        "GetLink('part')", "GetLink('m1::base')", "GetJoint('hinge')", "GetJoint('nothing')", "GetGripperCount()",
        "GetPluginCount()", "GetSensorCount()", "GetAutoDisable()", "GetSelfCollide()", "Scale()",
        "GetWorldEnergyPotential()", "GetWorldEnergyKinetic()", "GetWorldEnergy()", "WindMode()",
        "SensorScopedName('imu')", "GetChildLink('part')", "GetChildLink('base')", "GetChildCollision('box')", "GetChildCollision('nothing')",
    ],
    "Link": [
        "GetEnabled()", "GetGravityMode()", "GetKinematic()", "GetSelfCollide()", "WindMode()", "GetLinearDamping()",
        "GetAngularDamping()", "WorldCoGPose()", "WorldCoGLinearVel()", "WorldLinearVel(V(0.3, 0.2, 0.1))",
        "WorldLinearVel(V(0.3, 0.2, 0.1), Q(0.1, 0.2, 0.3))", "WorldForce()", "WorldTorque()", "RelativeForce()",
        "RelativeTorque()", "WorldInertialPose()", "WorldInertiaMatrix()", "WorldAngularMomentum()",
        "GetWorldEnergyPotential()", "GetWorldEnergyKinetic()", "GetWorldEnergy()", "GetModel()", "GetCollisions()",
        "GetCollision('box')", "GetCollision(0)", "GetSensorCount()", "GetParentJoints()", "GetChildJoints()",
        "GetParentJointsLinks()", "GetChildJointsLinks()", "WorldWindLinearVel()", "RelativeWindLinearVel()",
        "BatteryCount()",
    ],
    "Collision": [
        "GetLaserRetro()", "GetLink()", "GetModel()", "GetShapeType()", "GetMaxContacts()", "IsPlaceable()",
        *(f"GetSurface().FrictionPyramid().{key}()" for key in (
            "MuPrimary", "MuSecondary", "MuTorsion", "PatchRadius", "SurfaceRadius", "UsePatchRadius",
            "PoissonsRatio", "ElasticModulus",
        )),
    ],
    "Inertial": [
        "Mass()", "CoG()", "Pose()", "PrincipalMoments()", "ProductsOfInertia()", "IXX()", "IYY()", "IZZ()", "IXY()",
        "IXZ()", "IYZ()", "MOI()", "MOI(P(0.1, 0.2, 0.3, 0.4, 0.5, 0.6))",
    ],
    "SurfaceParams": [
        "kp", "kd", "cfm", "erp", "maxVel", "minDepth", "slip1", "slip2", "bounce", "bounceThreshold",
        "collideWithoutContact", "collideWithoutContactBitmask", "collideBitmask",
    ],
    "JointController": [
        "GetJoints()", "GetPositions()", "GetVelocities()", "GetForces()", "GetPositionPIDs()", "GetVelocityPIDs()",
        "GetLastUpdateTime()",
    ],
    "LinkState": [
        "GetName()", "Pose()", "Velocity()", "Acceleration()", "Wrench()", "IsZero()", "GetCollisionStateCount()",
        "GetSimTime()", "GetIterations()",
    ],
    "JointState": ["GetName()", "GetAngleCount()", "Position(0)", "Positions()", "IsZero()"],
    "ModelState": [
        "GetName()", "Pose()", "Scale()", "IsZero()", "GetLinkStateCount()", "GetJointStateCount()",
        "HasLinkState('base')", "HasLinkState('no')", "HasJointState('j_child')", "HasJointState('no')",
        "NestedModelStateCount()", "HasNestedModelState('inner')", "GetSimTime()", "GetIterations()",
    ],
    "WorldState": [
        "GetName()", "GetModelStateCount()", "HasModelState('m1')", "HasModelState('no')", "LightStateCount()",
        "HasLightState('sun')", "IsZero()", "GetSimTime()", "GetIterations()",
    ],
    "PresetManager": [
        "CurrentProfile()", "AllProfiles()", "HasProfile('first')", "HasProfile('no')",
    ],
    "Shape": ["GetType()", "HasType(SHAPE)", "HasType(BOX_SHAPE)", "GetParent()", "Scale()", "ComputeVolume()"],
    "BoxShape": ["Size()"],
    "SphereShape": ["GetRadius()"],
    "CylinderShape": ["GetRadius()", "GetLength()"],
    "PlaneShape": ["Normal()", "Size()"],
    "RayShape": ["Start()", "End()", "GetLength()", "GetRetro()", "GetFiducial()", "CollisionName()"],
    "Joint": [
        "DOF()", "GetMsgType()", "Anchor(0)", "GetJointLink(0)", "GetJointLink(1)", "GetParent()", "GetChild()",
        "InitialAnchorPose()", "WorldPose()", "ParentWorldPose()", "AnchorErrorPose()", "GetForceTorque(0)",
    ],
    "Axis": [
        "Position({n})", "GetVelocity({n})", "GetForce({n})", "LowerLimit({n})", "UpperLimit({n})",
        "GetEffortLimit({n})", "GetVelocityLimit({n})", "GetDamping({n})", "GetStiffness({n})",
        "GetSpringReferencePosition({n})", "GlobalAxis({n})", "LocalAxis({n})", "AxisFrame({n})",
        "AxisFrameOffset({n})", "GetStopStiffness({n})", "GetStopDissipation({n})", "GetInertiaRatio({n})",
        "GetWorldEnergyPotentialSpring({n})", "Anchor({n})",
        *(f"GetParam('{key}', {{n}})" for key in (
            "friction", "hi_stop", "lo_stop", "fmax", "vel", "cfm", "erp", "stop_cfm", "stop_erp", "fudge_factor",
            "bounce", "suspension_erp", "suspension_cfm",
        )),
    ],
    "ScrewJoint": ["GetParam('thread_pitch', 0)"],
    "Wrench": ["LinkForce(0)", "LinkForce(1)", "LinkTorque(0)", "LinkTorque(1)"],
    "Sensor": [
        "Name()", "ScopedName()", "Type()", "Pose()", "UpdateRate()", "IsActive()", "Visualize()", "WorldName()",
        "ParentName()", "Category()", "Topic()",
    ],
    "ImuSensor": [
        "AngularVelocity()", "AngularVelocity(True)", "LinearAcceleration()", "LinearAcceleration(True)",
        "Orientation()",
    ],
    "AltimeterSensor": ["Altitude()", "VerticalVelocity()", "ReferenceAltitude()"],
    "GpsSensor": [
        "Latitude()", "Longitude()", "Altitude()", "VelocityEast()", "VelocityNorth()", "VelocityUp()", "VelocityENU()",
    ],
    "MagnetometerSensor": ["MagneticField()"],
    "RaySensor": [
        "AngleMin()", "AngleMax()", "AngleResolution()", "RangeMin()", "RangeMax()", "RangeResolution()", "RayCount()",
        "RangeCount()", "VerticalRayCount()", "VerticalRangeCount()", "VerticalAngleMin()", "VerticalAngleMax()",
        "VerticalAngleResolution()", "Range(0)", "Range(2)", "Range(5)", "Range(99)", "Retro(2)", "Fiducial(2)",
        *(f"LaserShape().{key}" for key in (
            "GetMinRange()", "GetMaxRange()", "GetResRange()", "GetSampleCount()", "GetScanResolution()", "MinAngle()",
            "MaxAngle()", "GetVerticalSampleCount()", "GetVerticalScanResolution()", "VerticalMinAngle()",
            "VerticalMaxAngle()", "RayCount()", "GetRange(2)", "GetRetro(2)", "GetFiducial(2)", "ComputeVolume()",
            "Scale()",
        )),
    ],
    "SonarSensor": ["RangeMin()", "RangeMax()", "Radius()", "Geometry()", "Range()"],
    "ContactSensor": [
        "GetCollisionCount()", "GetCollisionName(0)", "GetCollisionContactCount('s0::base::box')",
    ],
    "ForceTorqueSensor": ["Joint()", "Force()", "Torque()"],
    "LogicalCameraSensor": ["Near()", "Far()", "HorizontalFOV()", "AspectRatio()"],
    "WirelessTransmitter": ["ESSID()", "Freq()", "Gain()", "Power()", "ModelStdDev()"],
}  # fmt: skip
AXES = {"HingeJoint": 1, "SliderJoint": 1, "ScrewJoint": 2, "Hinge2Joint": 2, "UniversalJoint": 2, "GearboxJoint": 2,
        "BallJoint": 1, "FixedJoint": 1}  # fmt: skip


def getters(kind: str) -> list[str]:
    """All of a class."""
    found: list[str] = []
    above: str | None = kind
    while above is not None:
        found = [*GETTERS.get(above, []), *found]
        above = PARENTS.get(above)
    for n in range(AXES.get(kind, 0)):
        found += [getter.replace("{n}", str(n)) for getter in GETTERS["Axis"] if getter != "Anchor(0)" or n]
    return list(dict.fromkeys(found))


UNEVEN_BODY = (
    """<model name='m{i}'><pose>{pose}</pose>
 <link name='base'><pose>0.1 0.2 0.3 0.2 0.1 -0.3</pose>"""
    + INERTIAL
    + """
  <collision name='box'><pose>0.1 0 0 0.3 0.2 0.1</pose><laser_retro>3</laser_retro><geometry><box><size>0.2 0.3 0.4</size></box></geometry></collision>
  <collision name='ball'><pose>0 0.3 0 0.3 0.2 0.1</pose><geometry><sphere><radius>0.15</radius></sphere></geometry></collision>
  <collision name='can'><pose>0 0 0.4 0.5 0.1 0</pose><geometry><cylinder><radius>0.1</radius><length>0.5</length></cylinder></geometry>
   <surface><friction><ode><mu>0.7</mu><mu2>0.6</mu2></ode></friction></surface></collision>
 </link>
 <link name='other'><pose>0 0 -1 0 0 1</pose>"""
    + SMALL
    + """</link>
 <model name='inner'><pose>0 1 0 0 0.4 0</pose><link name='part'><pose>0.1 0 0 0.3 0 0</pose>"""
    + SMALL
    + """
  <collision name='cube'><geometry><box><size>0.1 0.1 0.1</size></box></geometry></collision></link></model>
</model>"""
)

NESTING_BODY = UNEVEN_BODY.replace(INERTIAL, EVEN.format(mass=2, moment=0.2)).replace(
    SMALL, EVEN.format(mass=0.5, moment=0.015)
)
BODY = re.sub("<model name='inner'>.*</model>\\n", "", NESTING_BODY, flags=re.DOTALL)

LINKS = {
    "base": ("Link", "world.ModelByName('m{i}').GetLink('base')"),
    "other": ("Link", "world.ModelByName('m{i}').GetLink('other')"),
}
MODELS = {"m": ("Model", "world.ModelByName('m{i}')")}
NESTED = {
    "inner": ("Model", "world.ModelByName('m{i}').NestedModel('inner')"),
    "part": ("Link", "world.ModelByName('m{i}').NestedModel('inner').GetLink('part')"),
}
COLLISIONS = {
    name: ("Collision", f"world.ModelByName('m{{i}}').GetLink('base').GetCollision('{name}')")
    for name in ("box", "ball", "can")
}
ENTITY_CHANGES = [
    "",
    "m SetLinearVel(V(0.3, -0.2, 0.5))",
    "m ResetPhysicsStates()",
    "m SetAngularVel(V(0.4, 0.5, -0.6))",
    "m ResetPhysicsStates()",
    "m SetWorldTwist(V(-0.3, 0.2, 0.1), V(0.7, -0.1, 0.2))",
    "m SetWorldPose(P({i}, 2, 30, 0.3, 0.2, -0.4))",
    "m SetRelativePose(P({i}, -2, 31, -0.3, 0.5, 0.4))",
    "m ResetPhysicsStates()",
    "m SetInitialRelativePose(P(1, 2, 25, 0, 0, 0.5))",
    "m SetGravityMode(False)",
    "m SetGravityMode(True)",
    "m SetSelfCollide(True)",
    "m SetSelfCollide(False)",
    "m SetAutoDisable(False)",
    "m SetAutoDisable(True)",
    "m SetLaserRetro(2.5)",
    "m SetWindMode(True)",
    "m SetWindMode(False)",
    "m SetCollideMode('none')",
    "m SetCollideMode('all')",
    "m SetEnabled(False)",
    "m SetEnabled(True)",
    "base SetLinearVel(V(1, 2, 3))",
    "base SetAngularVel(V(0.5, -0.4, 0.3))",
    "base SetWorldTwist(V(0.2, 0.1, -0.3), V(-0.5, 0.4, 0.3))",
    "m ResetPhysicsStates()",
    "base SetWorldPose(P({i}, 5, 27, 0.4, 0.3, 0.2))",
    "base SetRelativePose(P(0.2, 0.1, 0.3, 0.1, -0.2, 0.3))",
    "base SetForce(V(10, 5, -3))",
    "base SetTorque(V(0.1, 0.2, -0.3))",
    "base AddForce(V(1, 2, 3))",
    "m ResetPhysicsStates()",
    "base AddRelativeForce(V(1, 2, 3))",
    "base AddForceAtWorldPosition(V(1, 2, 3), V({i}, 5, 27.5))",
    "m ResetPhysicsStates()",
    "base AddForceAtRelativePosition(V(1, 2, 3), V(0.1, 0.2, 0.3))",
    "base AddLinkForce(V(1, 2, 3))",
    "base AddLinkForce(V(1, 2, 3), V(0.1, 0.2, 0.3))",
    "m ResetPhysicsStates()",
    "base AddTorque(V(0.3, 0.2, 0.1))",
    "base AddRelativeTorque(V(0.3, 0.2, 0.1))",
    "m ResetPhysicsStates()",
    "base SetLinearDamping(0.1)",
    "base SetAngularDamping(0.2)",
    "base SetLinearDamping(0.0)",
    "base SetAngularDamping(0.0)",
    "base SetGravityMode(False)",
    "base SetGravityMode(True)",
    "base SetKinematic(True)",
    "base SetKinematic(False)",
    "base SetEnabled(False)",
    "base SetEnabled(True)",
    "base SetSelfCollide(True)",
    "base SetAutoDisable(False)",
    "base SetWindMode(True)",
    "base SetWindEnabled(False)",
    "base SetLaserRetro(4)",
    "base SetCollideMode('none')",
    "base SetCollideMode('all')",
    "base MoveFrame(P(0, 0, 0, 0, 0, 0), P(0.1, 0.2, 0.3, 0.1, 0.2, 0.3))",
    "base ResetPhysicsStates()",
    "m SetWorldPose(P({i}, 2, 32, 0.1, 0.2, -0.4))",
    "m SetScale(V(2, 2, 2))",
]
NESTED_CHANGES = [
    "",
    "m SetGravityMode(False)",
    "m SetGravityMode(True)",
    "m SetWindMode(True)",
    "m SetEnabled(False)",
    "m SetEnabled(True)",
    "m SetLaserRetro(2.5)",
    "m SetWorldPose(P({i}, 2, 30, 0.3, 0.2, -0.4))",
    "inner SetWorldPose(P({i}, 4, 28, 0.2, 0.3, 0.1))",
    "inner SetRelativePose(P(0.1, 1.2, 0.1, 0.2, 0.3, 0.1))",
]
WEIGHT_CHANGES = [
    "",
    "m SetWorldTwist(V(0.2, 0.1, -0.3), V(-0.5, 0.4, 0.3))",
    "base SetForce(V(10, 5, -3))",
    "base AddTorque(V(0.1, 0.2, -0.3))",
    "base SetGravityMode(False)",
    "m SetGravityMode(True)",
    "other SetKinematic(True)",
    "m SetEnabled(False)",
]
COLLISION_CHANGES = [
    "",
    "base SetWorldTwist(V(0.2, 0.1, -0.3), V(-0.5, 0.4, 0.3))",
    "box SetLaserRetro(1.5)",
    "box SetMaxContacts(3)",
    "box SetCategoryBits(0)",
    "box SetCollideBits(0)",
    "boxshape SetSize(V(0.3, 0.5, 0.7))",
    "boxshape SetScale(V(2, 1, 0.5))",
    "box SetScale(V(1, 1, 1))",
    "ballshape SetRadius(0.25)",
    "ballshape SetScale(V(2, 2, 2))",
    "ballshape SetScale(V(0.5, 0.5, 0.5))",
    "canshape SetRadius(0.2)",
    "canshape SetLength(0.8)",
    "canshape SetSize(0.15, 0.6)",
    "canshape SetScale(V(2, 2, 0.5))",
    "canshape SetScale(V(1, 1, 1))",
    *(f"can GetSurface().FrictionPyramid().{key}" for key in (
        "SetMuPrimary(0.3)", "SetMuSecondary(0.2)", "SetMuTorsion(0.1)", "SetPatchRadius(0.05)",
        "SetSurfaceRadius(0.04)", "SetUsePatchRadius(False)", "SetPoissonsRatio(0.4)", "SetElasticModulus(1e6)",
    )),
    "base SetScale(V(2, 2, 2))",
]  # fmt: skip
INERTIAL_CHANGES = [
    "",
    "base SetWorldTwist(V(0.2, 0.1, -0.3), V(-0.5, 0.4, 0.3))",
    "base ResetPhysicsStates()",
    *(f"inertial {change} | base UpdateMass()" for change in (
        "SetMass(3)", "SetCoG(0.1, 0.2, 0.3)", "SetCoG(V(0.2, 0.1, 0.05))", "SetCoG(P(0.02, 0.01, 0.03, 0.2, 0.1, 0.3))",
        "SetInertiaMatrix(0.3, 0.35, 0.4, 0.02, 0.01, -0.03)", "SetIXX(0.31)", "SetIYY(0.36)", "SetIZZ(0.41)",
        "SetIXY(0.03)", "SetIXZ(0.02)", "SetIYZ(-0.01)", "SetMOI(M(0.5, 0.6, 0.7, 0.01, 0.02, 0.03))",
    )),
    "base AddTorque(V(0.3, 0.2, 0.1))",
    "base ResetPhysicsStates()",
    "inertial SetMass(2)",
]  # fmt: skip

CHILD = (
    """<link name='{name}'><pose>{pose}</pose>"""
    + EVEN.format(mass=0.5, moment=0.015)
    + """</link>
<joint name='j_{name}' type='{kind}'><parent>base</parent><child>{name}</child><pose>0.05 -0.04 0.03 0.1 0.2 0.3</pose>{inside}</joint>"""
)
AXIS = "<axis{n}><xyz>{xyz}</xyz><limit><lower>-2</lower><upper>1.5</upper></limit><dynamics/></axis{n}>"


LIMITED = AXIS.format(n="", xyz="0 0.6 0.8")
TWO = AXIS.format(n="", xyz="1 0 0") + AXIS.format(n="2", xyz="0 1 0")
KINDS = {  # kind -> (class, what is in <joint>)
    "revolute": ("HingeJoint", LIMITED), "prismatic": ("SliderJoint", LIMITED), "universal": ("UniversalJoint", TWO),
    "revolute2": ("Hinge2Joint", TWO), "screw": ("ScrewJoint", LIMITED + "<thread_pitch>-20</thread_pitch>"),
    "ball": ("BallJoint", ""), "fixed": ("FixedJoint", ""),
}  # fmt: skip
JOINTED = """<model name='m{i}'><pose>{pose}</pose><link name='base'><pose>0 0 0.2 0.1 0 0.2</pose>""" + (
    EVEN.format(mass=20, moment=0.2) + "</link>"
)
STILL = "m ResetPhysicsStates()"


def _joint_changes(kind: str) -> list[str]:
    """What is done with a joint of a kind."""
    script = [] if kind == "screw" else [
        "", "m SetWorldTwist(V(0.2, 0.1, -0.3), V(-0.5, 0.4, 0.3))", STILL, "child AddForce(V(5, 4, 3))",
              "child AddTorque(V(0.1, -0.2, 0.3))", STILL,
    ]  # fmt: skip
    first = [
        "SetPosition(0, 0.3)", "SetVelocity(0, 0.2)", "SetPosition(0, 0.5)", "SetVelocity(0, 0.2)",
        "SetPosition(0, 0.4, True)", STILL, "SetForce(0, 0.1)", "SetLowerLimit(0, -1.0)", "SetUpperLimit(0, 1.2)",
        "SetEffortLimit(0, 0.2)", "SetForce(0, 0.5)", "SetVelocityLimit(0, 3.0)", STILL, "SetDamping(0, 0.01)",
        "SetStiffness(0, 0.1)", "SetStiffnessDamping(0, 0.2, 0.02, 0.1)", STILL, "SetStiffnessDamping(0, 0.0, 0.0)",
        "SetParam('friction', 0, 0.01)", "SetParam('friction', 0, 0.0)", "SetParam('fmax', 0, 0.05)",
        "SetParam('vel', 0, 0.1)", "SetParam('fmax', 0, 0.0)", STILL, "SetParam('cfm', 0, 0.001)",
        "SetParam('erp', 0, 0.3)", "SetParam('stop_cfm', 0, 0.002)", "SetParam('stop_erp', 0, 0.4)",
        "SetParam('fudge_factor', 0, 0.5)", "SetParam('hi_stop', 0, 1.4)", "SetParam('lo_stop', 0, -1.4)",
        "SetStopStiffness(0, 1000.0)", "SetStopDissipation(0, 10.0)",
    ]  # fmt: skip
    second = [
        "SetPosition(1, 0.3)", "SetVelocity(1, 0.2)", STILL, "SetForce(1, 0.1)", "SetLowerLimit(1, -1.0)",
        "SetUpperLimit(1, 1.2)", "SetDamping(1, 0.01)", "SetStiffnessDamping(1, 0.2, 0.02, 0.1)", STILL,
        "SetStiffnessDamping(1, 0.0, 0.0)",
    ]  # fmt: skip
    if kind == "screw":  # libgz's is a coupling, equal after many steps; SetPosition has no effect in Gazebo
        first, second = ["SetUpperLimit(0, 1.2)", "SetEffortLimit(0, 0.2)", STILL], []
    if AXES[KINDS[kind][0]] == 2:  # Gazebo's parameters of motors are those of the other axis
        first = [c for c in first if "SetParam" not in c or "_stop" in c]
    if kind == "revolute2":  # Gazebo's have no SetPosition, and SetVelocity sets their motor
        first, second = (
            [c for c in part if "Position" not in c and "SetVelocity(" not in c] for part in (first, second)
        )
    if kind not in ("ball", "fixed"):
        script += [c if c == STILL else f"joint {c}" for c in first + (second if AXES[KINDS[kind][0]] == 2 else [])]
    return [*script, "m SetWorldPose(P({i}, 2, 30, 0.3, 0.2, -0.4))"]


DIRECT = """<gravity>0 0 0</gravity><physics type='ode'><max_step_size>0.001</max_step_size>
<ode><solver><type>world</type></solver><constraints><cfm>1e-10</cfm></constraints></ode></physics>"""


def _joint_scene(kind: str) -> Scene:
    name, inside = KINDS[kind]
    child = CHILD.format(name="child", pose="0.3 0.1 0.5 0.1 0.2 -0.2", kind=kind, inside=inside)
    objects = {
        "m": MODELS["m"], "base": LINKS["base"], "child": ("Link", "world.ModelByName('m{i}').GetLink('child')"),
        "joint": (name, "world.ModelByName('m{i}').GetJoint('j_child')"),
    }  # fmt: skip
    return Scene(objects, _joint_changes(kind), each=JOINTED + child + "</model>", world=DIRECT, tolerance=5e-3)


WORLD_CHANGES = [
    "",
    "world SetGravity(V(0.1, 0.2, -3.0))",
    "world SetMagneticField(V(1e-5, 2e-5, -3e-5))",
    "world SetWindEnabled(True)",
    "world Wind()!SetLinearVel(V(1, 2, 3))",
    "world SetWindEnabled(False)",
    "world SetAtmosphereEnabled(False)",
    "world SetAtmosphereEnabled(True)",
    "world Atmosphere()!SetTemperature(280.0)",
    "world Atmosphere()!SetPressure(90000.0)",
    "world Atmosphere()!SetTemperatureGradient(-0.005)",
    "world SetPhysicsEnabled(False)",
    "world SetPhysicsEnabled(True)",
    "world SetSimTime(T(12.5))",
    "world SetPhysicsEnabled(False)",
    *(f"world Physics().SetParam('{key}', {value})" for key, value in (
        ("iters", "30"), ("precon_iters", "2"), ("sor", "1.1"), ("cfm", "0.001"), ("erp", "0.3"),
        ("contact_surface_layer", "0.002"), ("contact_max_correcting_vel", "50.0"), ("max_contacts", "12"),
        ("min_step_size", "0.0002"), ("sor_lcp_tolerance", "0.01"), ("rms_error_tolerance", "0.02"),
        ("contact_residual_smoothing", "0.03"), ("contact_sor_scale", "0.9"), ("thread_position_correction", "True"),
        ("friction_model", "S('cone_model')"), ("solver_type", "S('world')"), ("solver_type", "S('quick')"),
        ("real_time_update_rate", "500.0"), ("real_time_factor", "2.0"), ("max_step_size", "0.002"),
        ("island_threads", "0"),
        ("contact_residual_smoothing", "0.01"),
        ("thread_position_correction", "False"),
    )),
    "world SetPhysicsEnabled(True)",
    "world Physics().SetMaxStepSize(0.001)",
    "world Physics().SetRealTimeUpdateRate(0.0)",
    "world Physics().SetTargetRealTimeFactor(3.0)",
    "world Physics().SetAutoDisableFlag(False)",
    "world Physics().SetMaxContacts(7)",
    "world Physics().GetContactManager().SetNeverDropContacts(True)",
    "world Physics().GetContactManager().ResetCount()",
    "world Physics().GetContactManager().CreateFilter('f', 'box0::link::c')",
    "world Physics().GetContactManager().RemoveFilter('f')",
    "world SetPhysicsEnabled(False)",
    "",
    "world SetPhysicsEnabled(True)",
    "sun SetWorldPose(P(1, 2, 3, 0.1, 0.2, 0.3))",
    "box0 SetWorldPose(P(1, 2, 3, 0.1, 0.2, 0.3))",
    "box0 PlaceOnEntity('m1')",
    "world DisableAllModels()",
    "world EnableAllModels()",
    "world ResetPhysicsStates()",
    "world ResetEntities()",
]  # fmt: skip
BOX = """<light name='sun' type='directional'><pose>0 0 10 0 0 0.3</pose></light>
<model name='ground'><static>true</static><link name='link'><collision name='c'><geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry></collision></link></model>
<model name='box0'><pose>2 0 1.5 0 0 0</pose><link name='link'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision></link></model>"""

SENSING = (
    """<model name='s{i}'><pose>{pose}</pose><link name='base'><pose>0.1 0.2 0.3 0.2 0.1 -0.3</pose>"""
    + EVEN.format(mass=2, moment=0.2)
    + """
 <collision name='box'><pose>0 0 0.1 0 0 0</pose><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision>
 <sensor name='imu' type='imu'><pose>0.1 0.2 0.3 0.1 -0.2 0.3</pose></sensor>
 <sensor name='altimeter' type='altimeter'><pose>0.1 0.2 0.3 0.1 -0.2 0.3</pose></sensor>
 <sensor name='gps' type='gps'><pose>0.1 0.2 0.3 0.1 -0.2 0.3</pose></sensor>
 <sensor name='magnetometer' type='magnetometer'><pose>0.1 0.2 0.3 0.1 -0.2 0.3</pose></sensor>
 <sensor name='ray' type='ray'><pose>0.5 0.2 0.3 0.1 -0.2 0.3</pose><ray><scan><horizontal><samples>5</samples><resolution>1</resolution><min_angle>-1</min_angle><max_angle>0.8</max_angle></horizontal>
  <vertical><samples>2</samples><min_angle>-0.2</min_angle><max_angle>0.1</max_angle></vertical></scan><range><min>0.1</min><max>100</max><resolution>0.01</resolution></range></ray></sensor>
 <sensor name='contact' type='contact'><contact><collision>box</collision></contact></sensor>
 <sensor name='logical' type='logical_camera'><logical_camera><near>0.5</near><far>5</far><horizontal_fov>1.1</horizontal_fov><aspect_ratio>1.3</aspect_ratio></logical_camera></sensor>
 <sensor name='wifi' type='wireless_transmitter'><transceiver><essid>net</essid><frequency>2442</frequency><gain>2.6</gain><power>14.5</power></transceiver></sensor>
 </link>
 <link name='load'><pose>0 0 1 0.1 0.2 0.3</pose>"""
    + SMALL
    + """</link>
 <joint name='hand' type='revolute'><parent>base</parent><child>load</child><pose>0.1 0 0 0.3 0.1 0</pose><axis><xyz>0 0 1</xyz></axis>
  <sensor name='ft' type='force_torque'><force_torque><frame>{frame}</frame><measure_direction>{direction}</measure_direction></force_torque></sensor></joint>
</model>"""
)


def _sensing() -> str:
    """The models of all poses, each with another kind of force-torque sensor."""
    kinds = [("child", "child_to_parent"), ("parent", "child_to_parent"), ("sensor", "child_to_parent"),
             ("child", "parent_to_child"), ("sensor", "parent_to_child")]  # fmt: skip
    return "".join(
        SENSING.format(i=i, pose=pose, frame=frame, direction=direction)
        for i, (pose, (frame, direction)) in enumerate(zip(POSES, kinds, strict=True))
    )


SENSORS = {
    name: (kind, f"sensors.get_sensor('default::s{{i}}::{where}::{name}')")
    for name, kind, where in (
        ("imu", "ImuSensor", "base"), ("altimeter", "AltimeterSensor", "base"), ("gps", "GpsSensor", "base"),
        ("magnetometer", "MagnetometerSensor", "base"), ("ray", "RaySensor", "base"),
        ("contact", "ContactSensor", "base"), ("logical", "LogicalCameraSensor", "base"),
        ("wifi", "WirelessTransmitter", "base"), ("ft", "ForceTorqueSensor", "hand"),
    )
}  # fmt: skip
SENSOR_CHANGES = [
    "",
    "s SetWorldTwist(V(0.2, 0.1, -0.3), V(-0.5, 0.4, 0.3))",
    "s SetWorldPose(P({i}, 2, 30, 0.3, 0.2, -0.4))",
    "imu SetReferencePose()",
    "s SetWorldPose(P({i}, 3, 30, 0.1, 0.4, -0.2))",
    "imu SetWorldToReferenceOrientation(Q(0.1, 0.2, 0.3))",
    "imu SetPose(P(0.1, 0.1, 0.1, 0.2, 0.2, 0.2))",
    "altimeter SetReferenceAltitude(5.0)",
    "altimeter SetPose(P(0.1, 0.1, 0.1, 0.2, 0.2, 0.2))",
    "gps SetPose(P(0.1, 0.1, 0.1, 0.2, 0.2, 0.2))",
    "magnetometer SetPose(P(0.1, 0.1, 0.1, 0.2, 0.2, 0.2))",
    "ray SetPose(P(0.6, 0.1, 0.1, 0.2, 0.2, 0.2))",
    "ray SetActive(True)",
    "imu SetActive(False)",
    "imu SetActive(True)",
    "imu SetUpdateRate(20.0)",
    "world SetMagneticField(V(1e-5, 2e-5, -3e-5))",
    "load AddForce(V(1, 2, 3))",
    "load AddTorque(V(0.01, 0.02, 0.03))",
]

MORE_CHANGES = [
    "",
    "m SetJointPosition('m{i}::j_child', 0.2)",
    STILL,
    "controller SetForce('m{i}::j_child', 0.05)",
    STILL,
    "controller SetPositionPID('m{i}::j_child', PID(2.0, 0.1, 0.2, 3.0, -3.0, 5.0, -5.0))",
    "controller SetVelocityPID('m{i}::j_child', PID(0.2, 0.0, 0.0))",
    "controller Reset()",
    "controller SetJointPosition('m{i}::j_child', 0.1)",
    STILL,
    "base SetStatic(True)",
    "base SetStatic(False)",
    "presets CreateProfile('own')",
    "presets SetProfileParam('own', 'iters', 33)",
    "presets CurrentProfile('own')",
    "presets SetCurrentProfileParam('iters', 44)",
    "presets RemoveProfile('own')",
    "still SetWorldPose(P(1, 2, 3, 0.1, 0.2, 0.3))",
]
PRESETS = (
    """<gravity>0 0 0</gravity><physics type='ode' name='first' default='1'><max_step_size>0.001</max_step_size>
<ode><solver><type>world</type></solver><constraints><cfm>1e-10</cfm></constraints></ode></physics>
<physics type='ode' name='second'><ode><solver><iters>60</iters></solver></ode></physics>
<model name='still'><static>1</static><pose>0 0 0.5 0 0 0.2</pose><link name='link'><pose>0 0 0 0.1 0 0</pose>"""
    + INERTIAL
    + """
<collision name='c'><geometry><box><size>1 1 1</size></box></geometry><surface><bounce><restitution_coefficient>0.3</restitution_coefficient><threshold>2</threshold></bounce>
 <contact><collide_bitmask>7</collide_bitmask><ode><kp>1e7</kp><kd>3</kd><max_vel>0.2</max_vel><min_depth>0.001</min_depth><soft_cfm>0.1</soft_cfm><soft_erp>0.3</soft_erp></ode></contact>
 <friction><ode><mu>2</mu><mu2>3</mu2><slip1>0.1</slip1><slip2>0.2</slip2></ode></friction></surface></collision></link></model>"""
)


SCENES: dict[str, Scene] = {kind: _joint_scene(kind) for kind in KINDS} | {
    "entities": Scene(
        MODELS | LINKS | COLLISIONS, ENTITY_CHANGES, each=BODY, world="<gravity>0 0 0</gravity>"
    ),
    "nested": Scene(
        MODELS | NESTED | LINKS, NESTED_CHANGES, each=NESTING_BODY, world="<gravity>0 0 0</gravity>"
    ),
    "weights": Scene(MODELS | LINKS, WEIGHT_CHANGES, each=BODY),
    "collisions": Scene(
        LINKS | COLLISIONS | {
            f"{name}shape": (kind, COLLISIONS[name][1] + ".GetShape()")
            for name, kind in (("box", "BoxShape"), ("ball", "SphereShape"), ("can", "CylinderShape"))
        },
        COLLISION_CHANGES, each=BODY, world="<gravity>0 0 0</gravity>",
    ),
    "inertials": Scene(
        LINKS | {"inertial": ("Inertial", LINKS["base"][1] + ".GetInertial()")}, INERTIAL_CHANGES, each=UNEVEN_BODY,
        world="<gravity>0 0 0</gravity><physics type='ode'><ode><solver><explicit_gyroscopic>true</explicit_gyroscopic>"
        "</solver></ode></physics>",
    ),
    "world": Scene(
        {
            "world": ("World", "world"), "sun": ("Light", "world.LightByName('sun')"),
            "box0": ("Model", "world.ModelByName('box0')"),
            "plane": ("PlaneShape", "world.ModelByName('ground').GetLink('link').GetCollision('c').GetShape()"),
            "m1": ("Model", "world.ModelByName('m1')"),
        },
        WORLD_CHANGES, each=NESTING_BODY, world=BOX,
    ),
    "more": Scene(
        {
            "m": MODELS["m"], "base": LINKS["base"], "child": ("Link", "world.ModelByName('m{i}').GetLink('child')"),
            "joint": ("HingeJoint", "world.ModelByName('m{i}').GetJoint('j_child')"),
            "controller": ("JointController", "world.ModelByName('m{i}').GetJointController()"),
            "linkstate": ("LinkState", "link_state(world.ModelByName('m{i}').GetLink('child'))"),
            "modelstate": ("ModelState", "model_state(world.ModelByName('m{i}'))"),
            "worldstate": ("WorldState", "world_state(world)"), "presets": ("PresetManager", "world.PresetMgr()"),
            "world": ("World", "world"),
            "still": ("Model", "world.ModelByName('still')"),
            "stilllink": ("Link", "world.ModelByName('still').GetLink('link')"),
            "inertia": ("Inertial", "world.ModelByName('still').GetLink('link').GetInertial()"),
            "surface": ("SurfaceParams", "world.ModelByName('still').GetLink('link').GetCollision('c').GetSurface()"),
        },
        MORE_CHANGES, world=PRESETS, tolerance=5e-3,
        each=JOINTED + CHILD.format(name="child", pose="0.3 0.1 0.5 0.1 0.2 -0.2", kind="revolute", inside=LIMITED) + "</model>",
    ),
    "sensors": Scene(
        {
            "world": ("World", "world"), "s": ("Model", "world.ModelByName('s{i}')"),
            "load": ("Link", "world.ModelByName('s{i}').GetLink('load')"),
        } | SENSORS,
        SENSOR_CHANGES,
        world="<spherical_coordinates><surface_model>EARTH_WGS84</surface_model><latitude_deg>47.3</latitude_deg>"
        "<longitude_deg>8.5</longitude_deg><elevation>400</elevation><heading_deg>30</heading_deg>"
        "</spherical_coordinates>" + BOX + _sensing(),
        tolerance=2e-4,
    ),
}  # fmt: skip


# C++ -----------------------------------------------------------------------------------------------------------------

CXX_HEAD = r"""// Written by tests/classic_values.py.
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <thread>
#include <gazebo/gazebo.hh>
#include <gazebo/common/common.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/physics/ode/ODESurfaceParams.hh>
#include <gazebo/sensors/sensors.hh>
using namespace gazebo;
using namespace gazebo::physics;
using namespace gazebo::sensors;
typedef ignition::math::Vector3d V;
typedef ignition::math::Pose3d P;
typedef ignition::math::Quaterniond Q;
typedef common::Time T;
typedef std::string S;
static ignition::math::Matrix3d M(double xx, double yy, double zz, double xy, double xz, double yz)
{ return ignition::math::Matrix3d(xx, xy, xz, xy, yy, yz, xz, yz, zz); }
const bool True = true, False = false;
const auto SHAPE = Base::SHAPE, BOX_SHAPE = Base::BOX_SHAPE, LINK = Base::LINK;
typedef common::PID PID;
static std::shared_ptr<LinkState> link_state(LinkPtr p) { return std::make_shared<LinkState>(p); }
static std::shared_ptr<JointState> joint_state(JointPtr p) { return std::make_shared<JointState>(p); }
static std::shared_ptr<ModelState> model_state(ModelPtr p) { return std::make_shared<ModelState>(p); }
static std::shared_ptr<WorldState> world_state(WorldPtr p) { return std::make_shared<WorldState>(p); }
typedef std::ostream O;
static void number(O &o, double v) { if (std::isnan(v)) o << "\"nan\""; else if (std::isinf(v)) o << (v > 0 ? "\"inf\"" : "\"-inf\""); else o << std::setprecision(12) << v; }
static void put(O &o, double v) { number(o, v); }
static void put(O &o, float v) { number(o, v); }
static void put(O &o, bool v) { o << (v ? "true" : "false"); }
static void put(O &o, int v) { o << v; }
static void put(O &o, unsigned v) { o << v; }
static void put(O &o, unsigned long v) { o << v; }
static void put(O &o, const std::string &v) { o << '"' << v << '"'; }
static void put(O &o, const V &v) { o << '['; number(o, v.X()); o << ','; number(o, v.Y()); o << ','; number(o, v.Z()); o << ']'; }
static void put(O &o, const ignition::math::Vector2d &v) { o << '['; number(o, v.X()); o << ','; number(o, v.Y()); o << ']'; }
static void put(O &o, const Q &v) { o << '['; number(o, v.W()); o << ','; number(o, v.X()); o << ','; number(o, v.Y()); o << ','; number(o, v.Z()); o << ']'; }
static void put(O &o, const P &v) { o << '['; for (double x : {v.Pos().X(), v.Pos().Y(), v.Pos().Z(), v.Rot().W(), v.Rot().X(), v.Rot().Y()}) { number(o, x); o << ','; } number(o, v.Rot().Z()); o << ']'; }
static void put(O &o, const ignition::math::Matrix3d &m) { o << '['; for (int i = 0; i < 9; ++i) { if (i) o << ','; number(o, m(i / 3, i % 3)); } o << ']'; }
static void put(O &o, const ignition::math::Angle &v) { number(o, v.Radian()); }
static void put(O &o, const common::Time &v) { number(o, v.Double()); }
static void put(O &o, const ignition::math::AxisAlignedBox &b) { o << '['; put(o, b.Min()); o << ','; put(o, b.Max()); o << ']'; }
template<class B> typename std::enable_if<std::is_base_of<Base, B>::value>::type put(O &o, const boost::shared_ptr<B> &b) { if (b) put(o, b->GetScopedName()); else o << "null"; }
static void put(O &o, const PID &v) { o << '['; for (double x : {v.GetPGain(), v.GetIGain(), v.GetDGain(), v.GetIMax(), v.GetIMin(), v.GetCmdMax()}) { number(o, x); o << ','; } number(o, v.GetCmdMin()); o << ']'; }
static void put(O &o, const JointWrench &w) { o << '['; for (const V &v : {w.body1Force, w.body2Force, w.body1Torque}) { put(o, v); o << ','; } put(o, w.body2Torque); o << ']'; }
template<class B> void put(O &o, const std::map<std::string, B> &m) { o << '['; bool more = false; for (auto &one : m) { if (more) o << ','; more = true; put(o, one.first); o << ','; put(o, one.second); } o << ']'; }
template<class B> void put(O &o, const std::vector<B> &v) { o << '['; for (size_t i = 0; i < v.size(); ++i) { if (i) o << ','; put(o, v[i]); } o << ']'; }
static void put(O &o, const boost::any &v)
{
  if (v.type() == typeid(double)) put(o, boost::any_cast<double>(v));
  else if (v.type() == typeid(float)) put(o, boost::any_cast<float>(v));
  else if (v.type() == typeid(int)) put(o, boost::any_cast<int>(v));
  else if (v.type() == typeid(unsigned)) put(o, boost::any_cast<unsigned>(v));
  else if (v.type() == typeid(bool)) put(o, boost::any_cast<bool>(v));
  else if (v.type() == typeid(std::string)) put(o, boost::any_cast<std::string>(v));
  else if (v.type() == typeid(V)) put(o, boost::any_cast<V>(v));
  else o << "\"(" << v.type().name() << ")\"";
}
template<class K, class B> boost::shared_ptr<K> as(const boost::shared_ptr<B> &b) { return boost::dynamic_pointer_cast<K>(b); }
template<class K, class B> std::shared_ptr<K> as(const std::shared_ptr<B> &b) { return std::dynamic_pointer_cast<K>(b); }
#define I std::to_string(i)
#define GET(key, ...) { std::ostringstream s; try { put(s, __VA_ARGS__); } catch (...) { s.str("\"error\""); } emit(key, s.str()); }
#define DO(...) try { __VA_ARGS__; } catch (...) { }
class Probe : public WorldPlugin
{
  WorldPtr world; std::string scene; unsigned count = 0; std::ofstream out; std::map<std::string, std::string> last; bool first = true; unsigned at = 0;
  event::ConnectionPtr begin, end;
  void (Probe::*change)(unsigned) = nullptr; void (Probe::*read)() = nullptr;
  void emit(const std::string &key, const std::string &value)
  {
    std::string &before = last[key];
    if (before == value) return;
    before = value; out << (first ? "" : ",\n") << '"' << key << "\":" << value; first = false;
  }
  void open(const char *what) { out << ",\n\"" << what << "\":{"; first = true; }
public:
  void Load(WorldPtr w, sdf::ElementPtr) override
  {
    world = w; out.open(std::getenv("PROBE_OUT")); scene = std::getenv("PROBE_SCENE"); choose();
    out << "[{\"scene\":0";
    begin = event::Events::ConnectWorldUpdateBegin([this](const common::UpdateInfo &) { this->Begin(); });
    end = event::Events::ConnectWorldUpdateEnd([this]() { this->End(); });
    std::thread([w]() { for (int i = 0; i < 100 && !w->SensorsInitialized(); ++i) common::Time::MSleep(50); common::Time::MSleep(500); w->SetPaused(false); }).detach();
  }
  void Begin() { (this->*change)(at); open("now"); (this->*read)(); out << "}"; }
  void End() { open("then"); (this->*read)(); out << "}"; ++at; if (at == count) { out << "}]\n"; out.close(); std::_Exit(0); } out << "},\n{\"step\":" << at; out.flush(); }
"""


def _cxx(expression: str) -> str:
    """An expression in C++."""
    expression = re.sub(r"'([^']*)'", r'"\1"', expression)
    expression = re.sub(r'"([^"{}]*)\{i\}([^"]*)"', r'(S("\1") + I + "\2")', expression)
    expression = re.sub(r"(?<=[)\w])\.(?=[A-Z])", "->", expression)
    return expression.replace("sensors.get_sensor", "sensors::get_sensor").replace("!", ".")


def cxx_source() -> str:
    """The plugin for Gazebo: it writes what the scene PROBE_SCENE gives to the file PROBE_OUT, both of the environment.

    The getters of a class are one function for all scenes, so that it compiles within minutes.
    """
    lines = [CXX_HEAD]
    for kind in sorted({kind for scene in SCENES.values() for kind, _ in scene.objects.values()}):
        lines.append(
            f'void read_{kind}(const {_pointer(kind)} &o, const S &k) {{ if (!o) {{ emit(k, "null"); return; }}'
        )
        if PARENTS.get(kind) == "Sensor":
            lines.append("o->Update(true);")
        lines += [f'GET(k + ".{_quoted(getter)}", o->{_cxx(getter)})' for getter in getters(kind)]
        lines.append("}")
    for title, scene in SCENES.items():
        lines.append(f"void change_{title}(unsigned at) {{ switch (at) {{")
        for number, line in enumerate(scene.script):
            lines.append(f"case {number}: {{")
            for part in line.split(" | ") if line else []:
                name, _, change = part.partition(" ")
                kind, expression = scene.objects[name]
                call = _cxx(f"o.{change}").replace("{i}", "i")
                lines.append(f"{_loop(expression)} {{ auto o = {_cast(kind, expression)}; DO({call}) }}")
            lines.append("break; }")
        lines.append(f"}}}}\nvoid read_{title}() {{")
        for name, (kind, expression) in scene.objects.items():
            key = f'S("{name}")' + (" + I" if "{i}" in expression else "")
            lines.append(f"{_loop(expression)} read_{kind}({_cast(kind, expression)}, {key});")
        lines.append("}")
    lines.append("void choose() {")
    for title, scene in SCENES.items():
        lines.append(
            f'if (scene == "{title}") {{ count = {len(scene.script)}; change = &Probe::change_{title}; '
            f"read = &Probe::read_{title}; }}"
        )
    lines.append("} };\nGZ_REGISTER_WORLD_PLUGIN(Probe)")
    return "\n".join(lines)


def _loop(expression: str) -> str:
    """What goes through all poses."""
    return f"for (int i = 0; i < {len(POSES) if '{i}' in expression else 1}; ++i)"


def _quoted(text: str) -> str:
    return text.replace("'", "`")


def _in_cxx(kind: str) -> str:
    """The class in C++; all joints are Joint."""
    kind = {"SurfaceParams": "ODESurfaceParams"}.get(kind, "Joint" if kind.endswith("Joint") else kind)
    return f"{'sensors' if kind.endswith(('Sensor', 'Transmitter')) else 'physics'}::{kind}"


def _pointer(kind: str) -> str:
    if kind == "PresetManager":
        return "PresetManagerPtr"
    standard = _in_cxx(kind).startswith("sensors") or kind.endswith("State")
    return f"{'std' if standard else 'boost'}::shared_ptr<{_in_cxx(kind)}>"


def _cast(kind: str, expression: str) -> str:
    if kind in ("World", "Inertial", "PresetManager", "JointController") or kind.endswith("State"):
        return _cxx(expression)
    return f"as<{_in_cxx(kind)}>({_cxx(expression)})"


# Python --------------------------------------------------------------------------------------------------------------

PLUGIN = "import classic_values\nfrom libgz.classic import GZ_REGISTER_WORLD_PLUGIN\n\nGZ_REGISTER_WORLD_PLUGIN(classic_values.probe())\n"


def read_scene(scene: Scene, folder: Path) -> list[dict[str, Any]]:
    """What libgz returns: for each change {"now": ..., "then": ...} with the values that changed.

    Args:
        scene: the scene.
        folder: GAZEBO_PLUGIN_PATH; the plugin is put there.
    """
    import libgz

    (folder / "probe.py").write_text(PLUGIN)
    _current.update(scene=scene, found=[{} for _ in scene.script])
    with libgz.World.from_string(scene.text) as world:
        for _ in scene.script:
            world.Step()
    found: list[dict[str, Any]] = _current["found"]
    return found


_current: dict[str, Any] = {}


def probe() -> Any:
    """The class of the plugin."""
    from libgz.classic import WorldPlugin, common, event, math as classic_math, physics, sensors

    names = {
        "V": classic_math.Vector3d,
        "P": classic_math.Pose3d,
        "Q": classic_math.Quaterniond,
        "M": lambda xx, yy, zz, xy, xz, yz: classic_math.Matrix3d(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        "T": common.Time,
        "S": str,
        "SHAPE": physics.Base.SHAPE,
        "BOX_SHAPE": physics.Base.BOX_SHAPE,
        "LINK": physics.Base.LINK,
        "PID": common.PID,
        "link_state": physics.LinkState,
        "joint_state": physics.JointState,
        "model_state": physics.ModelState,
        "world_state": physics.WorldState,
        "sensors": sensors,
    }

    class Probe(WorldPlugin):
        def Load(self, world: Any, sdf: Any) -> None:
            self.world, self.scene, self.at = world, _current["scene"], 0
            self.last: dict[str, Any] = {}
            self.begin = event.Events.ConnectWorldUpdateBegin(self.Begin)
            self.end = event.Events.ConnectWorldUpdateEnd(self.End)

        def get(self, expression: str) -> Any:
            return eval(expression.replace("!", "."), {**names, "world": self.world})

        def Begin(self, info: Any) -> None:
            objects = self.scene.all_objects()
            for name, change in self.scene.changes(self.scene.script[self.at]):
                change = re.sub(r"\b([a-z]\w*\d)\.", lambda found: f"({objects[found[1]][1]}).", change)
                try:
                    self.get(f"({objects[name][1]}).{change}")
                except Exception as error:
                    _current.setdefault("errors", []).append(f"{name} {change}: {error!r}")
            self.read("now")

        def End(self) -> None:
            self.read("then")
            self.at += 1

        def read(self, when: str) -> None:
            found = _current["found"][self.at].setdefault(when, {})
            for name, (kind, expression) in self.scene.all_objects().items():
                one = self.get(expression)
                if one is None:
                    self.note(found, name, None)
                    continue
                if PARENTS.get(kind) == "Sensor":
                    one.Update(True)
                for getter in getters(kind):
                    try:
                        value = plain(eval(f"one.{getter.replace('!', '.')}", {**names, "one": one}))
                    except Exception as error:
                        value = f"error {error!r}"
                    self.note(found, f"{name}.{_quoted(getter)}", value)

        def note(self, found: dict[str, Any], key: str, value: Any) -> None:
            if key not in self.last or not same(value, self.last[key], 0.0):
                found[key] = self.last[key] = value

    return Probe


def plain(value: Any) -> Any:
    """A value as the plugin in C++ writes it."""
    from libgz.classic import common, math as classic_math, physics
    from libgz.classic.math import AxisAlignedBox

    if isinstance(value, classic_math.Pose3d):
        return plain([*value.pos, *plain(value.rot)])
    if isinstance(value, classic_math.Quaterniond):
        return plain([value.W(), value.X(), value.Y(), value.Z()])
    if isinstance(value, AxisAlignedBox):
        return [plain(value.Min()), plain(value.Max())]
    if isinstance(value, classic_math.Matrix3d):
        return plain([value(i, j) for i in range(3) for j in range(3)])
    if isinstance(value, (common.Time, classic_math.Angle)):
        return plain(float(value) if isinstance(value, common.Time) else value.Radian())
    if isinstance(value, common.PID):
        gains = (value.GetPGain(), value.GetIGain(), value.GetDGain())
        return plain([*gains, value.GetIMax(), value.GetIMin(), value.GetCmdMax(), value.GetCmdMin()])
    if isinstance(value, physics.JointWrench):
        return plain([value.body1Force, value.body2Force, value.body1Torque, value.body2Torque])
    if isinstance(value, dict):
        return [part for key in sorted(value) for part in (key, plain(value[key]))]
    if isinstance(value, physics.Base):
        return value.GetScopedName()
    if isinstance(value, (str, bool)) or value is None:
        return value
    if isinstance(value, Iterable):
        return [plain(one) for one in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if hasattr(value, "__index__"):
        return int(value)
    return str(value)


TOLERANCE = 1e-9


def same(a: Any, b: Any, tolerance: float = TOLERANCE) -> bool:
    """Whether two plain values are equal; rotations `q` and `-q` are the same."""
    if isinstance(a, float) and abs(a) > 1e38:  # a bound of an empty box
        a = "inf" if a > 0 else "-inf"
    if isinstance(b, float) and abs(b) > 1e38:
        b = "inf" if b > 0 else "-inf"
    if isinstance(a, list) and isinstance(b, list):
        if len(a) != len(b):
            return False
        if all(same(x, y, tolerance) for x, y in zip(a, b, strict=True)):
            return True
        turn = {4: 0, 7: 3}.get(len(a))
        if turn is None or not all(isinstance(x, (int, float)) for x in a + b) or tolerance == 0.0:
            return False
        return same(a, [*b[:turn], *(-x for x in b[turn:])], -tolerance) if tolerance > 0 else False
    if isinstance(a, bool) or isinstance(b, bool) or not isinstance(a, (int, float)) or not isinstance(b, (int, float)):
        return bool(a == b and (isinstance(a, bool) == isinstance(b, bool)))
    return abs(a - b) <= abs(tolerance) * max(1.0, abs(a), abs(b))


def read_recorded(name: str) -> list[dict[str, Any]]:
    """What Gazebo 11.1 returned in a scene."""
    with gzip.open(RECORDED / f"{name}.json.gz", "rt", encoding="utf-8") as file:
        found: list[dict[str, Any]] = json.load(file)
    return found


@dataclass
class Difference:
    """A value that differs."""

    step: int
    change: str
    when: str
    key: str
    gazebo: Any
    ours: Any


def differences(scene: Scene, recorded: list[dict[str, Any]], ours: list[dict[str, Any]]) -> Iterable[Difference]:
    """All values that differ."""
    last: tuple[dict[str, Any], dict[str, Any]] = ({}, {})
    for step, change in enumerate(scene.script):
        for when in ("now", "then"):
            for kept, new in zip(last, (recorded[step][when], ours[step].get(when, {})), strict=True):
                kept.update(new)
            for key, value in last[0].items():
                mine = last[1].get(key, "missing")
                if not same(value, mine, scene.tolerance):
                    yield Difference(step, change, when, key, value, mine)
