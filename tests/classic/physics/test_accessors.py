"""Every accessor of the views of physics, rendering and sensors: what is set is read, and what is read has its type."""

import inspect
import math
import re
from collections.abc import Iterable, Mapping
from numbers import Real

import pytest
from accessor_pairs import accessor_pairs

import libgz
from libgz.classic import physics, rendering, sensors
from libgz.classic.math import Matrix3d, Pose3d, Vector3d
from libgz.classic.server import attach

BALL = "<sphere><radius>0.5</radius></sphere>"
TUBE = "<cylinder><radius>0.5</radius><length>2</length></cylinder>"
CUBE = "<box><size>1 2 3</size></box>"
PLANE = "<plane><normal>0 0 1</normal></plane>"
RAY = "<scan><horizontal><samples>3</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>"
INSIDE = {
    "ray": f"<ray>{RAY}<range><min>0.1</min><max>9</max></range></ray>",
    "gpu_ray": f"<ray>{RAY}<range><min>0.1</min><max>9</max></range></ray>",
    "sonar": "<sonar><min>0.1</min><max>9</max><radius>0.2</radius></sonar>",
    "contact": "<contact><collision>box</collision></contact>",
    "camera": "<camera><image><width>8</width><height>8</height></image></camera>",
    "depth": "<camera><image><width>8</width><height>8</height></image></camera>",
    "multicamera": "<camera name='left'><image><width>8</width><height>8</height></image></camera>",
    "logical_camera": "<logical_camera><near>0.1</near><far>9</far></logical_camera>",
}
KINDS = (*INSIDE, "imu", "gps", "magnetometer", "altimeter")


def shape(tag, name, geometry):
    return f"<{tag} name='{name}'><geometry>{geometry}</geometry></{tag}>"


def sensor(kind):
    return f"<sensor name='{kind}' type='{kind}'><always_on>1</always_on>{INSIDE.get(kind, '')}</sensor>"


WORLD = f"""<sdf version='1.7'><world name='default'>
  <light name='lamp' type='spot'><pose>0 0 9 0 0 0</pose></light>
  <model name='floor'><static>1</static><link name='link'>{shape("collision", "plane", PLANE)}</link></model>
  <model name='robot'>
    <pose>0 0 5 0 0 0</pose>
    <link name='base'>
      <inertial><mass>2</mass></inertial>
      {shape("collision", "box", CUBE)}{shape("visual", "look", CUBE)}
      <battery name='main'><voltage>12</voltage></battery>
      {"".join(map(sensor, KINDS))}
    </link>
    <link name='arm'><pose>0 0 2 0 0 0</pose>
      {shape("collision", "ball", BALL)}{shape("collision", "tube", TUBE)}
    </link>
    <joint name='hinge' type='revolute'><parent>base</parent><child>arm</child>
      <axis><xyz>0 0 1</xyz><limit><lower>-2</lower><upper>2</upper></limit></axis>
      <sensor name='force_torque' type='force_torque'><always_on>1</always_on></sensor>
    </joint>
    <model name='inner'><pose>0 9 0 0 0 0</pose><link name='tip'/></model>
  </model>
</world></sdf>"""


@pytest.fixture
def world(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    with libgz.World.from_string(WORLD) as core:
        core.step(2)
        yield attach(core).world


def robot(world):
    return world.ModelByName("robot")


def base(world):
    return robot(world).GetLink("base")


def visual(world):
    return rendering.get_scene("default").GetVisual("robot::base::look")


def camera(world):
    return rendering.Camera(world, "eye", 8, 8)


# Class -> how to get an object of it from the world.
HOLDERS = {
    physics.World: lambda world: world,
    physics.Model: robot,
    physics.Wind: lambda world: world.Wind(),
    physics.Atmosphere: lambda world: world.Atmosphere(),
    physics.Link: base,
    physics.Collision: lambda world: base(world).GetCollision("box"),
    physics.Joint: lambda world: robot(world).GetJoint("hinge"),
    physics.Light: lambda world: world.LightByName("lamp"),
    physics.PhysicsEngine: lambda world: world.Physics(),
    physics.PresetManager: lambda world: world.PresetMgr(),
    physics.ContactManager: lambda world: world.Physics().GetContactManager(),
    physics.JointController: lambda world: robot(world).GetJointController(),
    physics.Inertial: lambda world: base(world).GetInertial(),
    physics.SurfaceParams: lambda world: base(world).GetCollision("box").GetSurface(),
    physics.FrictionPyramid: lambda world: base(world).GetCollision("box").GetSurface().FrictionPyramid(),
    physics.BoxShape: lambda world: base(world).GetCollision("box").GetShape(),
    physics.SphereShape: lambda world: robot(world).GetLink("arm").GetCollision("ball").GetShape(),
    physics.CylinderShape: lambda world: robot(world).GetLink("arm").GetCollision("tube").GetShape(),
    physics.PlaneShape: lambda world: world.ModelByName("floor").GetLink().GetCollision("plane").GetShape(),
    physics.RayShape: lambda world: world.Physics().CreateShape("ray"),
    physics.MultiRayShape: lambda world: sensors.get_sensor("ray").LaserShape(),
    physics.WorldState: physics.WorldState,
    rendering.Visual: visual,
    rendering.Scene: lambda world: rendering.get_scene("default"),
    rendering.Light: lambda world: rendering.get_scene("default").GetLight("lamp"),
    rendering.Camera: camera,
    rendering.DepthCamera: lambda world: rendering.DepthCamera(world, "eye", 8, 8),
    rendering.UserCamera: lambda world: rendering.UserCamera(world, "eye", 8, 8),
    sensors.SensorManager: lambda world: sensors.SensorManager.Instance(),
    sensors.AltimeterSensor: lambda world: sensors.get_sensor("altimeter"),
    sensors.CameraSensor: lambda world: sensors.get_sensor("camera"),
    sensors.ContactSensor: lambda world: sensors.get_sensor("contact"),
    sensors.DepthCameraSensor: lambda world: sensors.get_sensor("depth"),
    sensors.ForceTorqueSensor: lambda world: sensors.get_sensor("force_torque"),
    sensors.GpsSensor: lambda world: sensors.get_sensor("gps"),
    sensors.GpuRaySensor: lambda world: sensors.get_sensor("gpu_ray"),
    sensors.ImuSensor: lambda world: sensors.get_sensor("imu"),
    sensors.LogicalCameraSensor: lambda world: sensors.get_sensor("logical_camera"),
    sensors.MagnetometerSensor: lambda world: sensors.get_sensor("magnetometer"),
    sensors.MultiCameraSensor: lambda world: sensors.get_sensor("multicamera"),
    sensors.RaySensor: lambda world: sensors.get_sensor("ray"),
    sensors.SonarSensor: lambda world: sensors.get_sensor("sonar"),
}
# Setters whose value is not read back, with the reason.
NOT_READ_BACK: dict[type, dict[str, str]] = {
    physics.World: {"SetName": "the name of a world is that of its topics, and cannot be changed"},
    physics.Link: {
        "SetInertial": "test_link.py sets and reads it",
        "SetRelativePose": "the model frame moves with its first link",
    },
    physics.Joint: {"GetChild": "the argument has no effect", "SetForce": "efforts of several calls add up"},
    physics.Collision: {"WorldLinearVel": "the argument is a point"},
    physics.Inertial: {"MOI": "the argument is a frame"},
    physics.Light: {"SetAttenuation": "it has three values"},
    rendering.Visual: {"Load": "the argument is an element"},
    sensors.ContactSensor: {"Contacts": "the argument is the name of a collision"},
}
# Values for setters where those for the annotation do not fit.
VALUES: dict[type, dict[str, tuple]] = {
    physics.Joint: {
        "SetAttribute": (1.0, 2.0),
        "SetParam": (1.0, 2.0),
        **{f"Set{name}": (-2.5, -3.0) for name in ("LowStop", "LowerLimit")},
        **{f"Set{name}": (2.5, 3.0) for name in ("HighStop", "UpperLimit")},
    },
    physics.PhysicsEngine: {"SetParam": (30, 40)},
    physics.Wind: {"SetParam": (Vector3d(1, 2, 3), Vector3d(0, 1, 0))},
    physics.Atmosphere: {"SetParam": (290.0, 300.0)},
    physics.PresetManager: {
        "CurrentProfile": ("default_physics",),
        "SetCurrentProfileParam": (30, 40),
        "SetProfileParam": (30, 40),
    },
    physics.Inertial: {
        **{f"SetI{axis}{axis}": (2.0, 2.5) for axis in "XYZ"},
        **{f"SetI{axes}": (0.1, 0.2) for axes in ("XY", "XZ", "YZ")},
        "SetMOI": (Matrix3d(2, 0, 0, 0, 2, 0, 0, 0, 2), Matrix3d(3, 0, 0, 0, 3, 0, 0, 0, 3)),
    },
    rendering.Light: {"SetLightType": ("point", "directional")},
    rendering.Camera: {"SetImageFormat": ("L8", "R8G8B8")},
}
# Arguments of a setter and its getters before the value.
BEFORE: dict[type, dict[str, tuple]] = {
    physics.Joint: {"SetAttribute": ("fmax", 0), "SetParam": ("fmax", 0)},
    physics.PhysicsEngine: {"SetParam": ("iters",)},
    physics.Wind: {"SetParam": ("linear_velocity",)},
    physics.Atmosphere: {"SetParam": ("temperature",)},
    physics.PresetManager: {"SetCurrentProfileParam": ("iters",), "SetProfileParam": ("default_physics", "iters")},
}
# Arguments of getters, by name; elsewhere 0 for an int.
ARGUMENTS: dict[type, dict[str, tuple]] = {
    physics.World: {
        "BaseByName": ("robot",),
        "GetModelBelowPoint": ((0, 0, 9),),
        "StripWorldName": ("default::robot",),
        "UniqueModelName": ("robot",),
        "EntityBelowPoint": ((0, 0, 9),),
        "EntityByName": ("robot::base",),
        "ModelByName": ("robot",),
    },
    physics.Model: {
        "AttachPlugin": ("libInitialVelocityPlugin.so", "start"),
        "CreateJoint": ("made", "fixed"),
        "CreateLink": ("made",),
    },
    physics.Joint: {"GetAttribute": ("fmax", 0), "GetParam": ("fmax", 0)},
    physics.PhysicsEngine: {"CreateJoint": ("revolute",), "CreateShape": ("ray",), "GetParam": ("iters",)},
    physics.Wind: {"GetParam": ("linear_velocity",), "Param": ("linear_velocity",)},
    physics.Atmosphere: {"GetParam": ("temperature",), "Param": ("temperature",)},
    physics.PresetManager: {
        "CreateProfile": ("made",),
        "ProfileParam": ("default_physics", "iters"),
        "GetProfileParam": ("default_physics", "iters"),
    },
    physics.ContactManager: {"CreateFilter": ("made", "robot::base::box"), "HasFilter": ("made",)},
    rendering.Scene: {
        "CreateDepthCamera": ("deep",),
        "CreateUserCamera": ("made",),
        "DrawLine": ((0, 0, 0), (1, 0, 0), "way"),
        "StripSceneName": ("default::robot",),
    },
    rendering.Camera: {
        "MoveToPosition": (Pose3d(), 1.0),
        "MoveToPositions": ([Pose3d()], 1.0),
        "Project": ((3, 0, 0),),
    },
}
# Methods that return a value and are not called here, with the reason.
NOT_CALLED: dict[type, dict[str, str]] = {
    physics.Wind: dict.fromkeys(("RelativeLinearVel", "WorldLinearVel"), "test_air.py calls them for links"),
    rendering.Visual: {
        "AttachMesh": "tests of rendering attach meshes",
        "IsAncestorOf": "test_aids.py has visuals in visuals",
        "IsDescendantOf": "test_aids.py has visuals in visuals",
    },
    rendering.Scene: dict.fromkeys(("GetModelVisualAt", "GetVisualAt"), "tests of rendering pick visuals"),
    rendering.UserCamera: {"GetVisual": "tests of rendering pick visuals"},
    rendering.Camera: {"SaveFrame": "there is no frame"},
    sensors.CameraSensor: {"SaveFrame": "there is no frame"},
    sensors.MultiCameraSensor: {"SaveFrame": "there is no frame"},
    sensors.Sensor: {"GetNoise": "these sensors have none; test_noise.py has"},
    sensors.SensorManager: {"CreateSensor": "tests of sensors create them at run time"},
}
NOT_HELD = {
    physics.Base,  # base classes
    physics.Entity,
    physics.Shape,
    physics.MeshShape,  # test_more_names.py has worlds with them
    physics.HeightmapShape,
    physics.PolylineShape,
    physics.State,  # test_more_names.py has what they add to State, whose accessors WorldState shares
    physics.CollisionState,
    physics.JointState,
    physics.LightState,
    physics.LinkState,
    physics.ModelState,
    physics.Contact,  # dataclasses
    physics.JointWrench,
    physics.TrajectoryInfo,
    physics.Gripper,  # it has no setters
    physics.Actor,  # a Model; test_actor.py has what it adds
}
INFINITE = {"Range": "a light without a <range>", "DepthData": "there is nothing to see"}
# Names that types have in annotations of classes with a method of the type's own name.
ALIASES = {"CameraView": "Camera", "DepthCameraView": "DepthCamera", "JointView": "Joint", "UserCamera_": "UserCamera"}


def own(table, kind):
    """The rows of a class and of its base classes."""
    return {name: row for above in reversed(kind.__mro__) for name, row in table.get(above, {}).items()}


@pytest.mark.parametrize("kind", HOLDERS, ids=lambda kind: f"{kind.__module__.split('.')[2]}-{kind.__name__}")
def test_what_is_set_is_read(kind, world):
    holder = HOLDERS[kind](world)
    assert type(holder) is kind
    failed = []
    for pair in accessor_pairs(
        holder, exceptions=own(NOT_READ_BACK, kind), values=own(VALUES, kind), before=own(BEFORE, kind)
    ):
        try:
            pair.check()
        except Exception as error:  # noqa: BLE001 - all are reported together
            failed.append(f"{pair}: {error!r}")
    assert not failed, "\n".join(failed)


def getters(kind):
    """Name -> signature of all methods in CamelCase that return a value; other names of a method are left out."""
    seen = set()
    for name in dir(kind):
        method = inspect.getattr_static(kind, name)
        if name[0].isupper() and inspect.isfunction(method) and method not in seen:
            seen.add(method)
            signature = inspect.signature(method)
            if not name.startswith(("Set", "Connect", "Disconnect")) and signature.return_annotation != "None":
                yield name, signature


def is_of(value, annotation):
    """Whether a value has the type of an annotation, and all numbers in it are finite."""
    wanted = {ALIASES.get(word, word) for word in re.findall(r"\w+", annotation)}
    names = {above.__name__ for above in type(value).__mro__} | ({"None"} if value is None else set())
    if "Any" not in wanted and not names & wanted and not (type(value) is int and "float" in wanted):
        return False
    return is_finite(value)


def is_finite(value):
    """Whether all numbers in a value are finite."""
    if isinstance(value, Real):
        return math.isfinite(value)
    if hasattr(value, "pos"):
        return is_finite(value.pos) and is_finite(value.rot)
    if isinstance(value, Mapping):
        value = value.values()
    if isinstance(value, Iterable) and not isinstance(value, str | bytes):
        return all(is_finite(part) for part in value)
    return True


@pytest.mark.parametrize("kind", HOLDERS, ids=lambda kind: f"{kind.__module__.split('.')[2]}-{kind.__name__}")
def test_what_is_read_has_its_type(kind, world):
    holder, arguments, left_out = HOLDERS[kind](world), own(ARGUMENTS, kind), own(NOT_CALLED, kind)
    failed = []
    for name, signature in getters(kind):
        if name in left_out:
            continue
        parameters = list(signature.parameters.values())[1:]
        required = [p for p in parameters if p.default is p.empty and p.kind is not p.VAR_POSITIONAL]
        try:
            kinds = [str(parameter.annotation).split(" | ") for parameter in required]
            any_one = tuple("none" if "str" in words and "int" not in words else 0 for words in kinds)
            found = getattr(holder, name)(*arguments.get(name, any_one))
        except Exception as error:  # noqa: BLE001 - all are reported together
            failed.append(f"{name}{signature}: {error!r}")
            continue
        nothing_seen = ("GetRange", "GetRanges") if kind is sensors.GpuRaySensor else ()
        if not (is_of(found, str(signature.return_annotation)) or name in (*INFINITE, *nothing_seen)):
            failed.append(f"{name}{signature}: returned {found!r}")
    assert not failed, "\n".join(failed)


def test_the_lists_of_exceptions_hold_nothing_out_of_date():
    for table in (ARGUMENTS, NOT_CALLED):
        for kind, rows in table.items():
            assert all(hasattr(kind, name) for name in rows), kind
    exported = {getattr(physics, name) for name in physics.__all__}
    assert {kind for kind in exported if inspect.isclass(kind)} - set(HOLDERS) == NOT_HELD
