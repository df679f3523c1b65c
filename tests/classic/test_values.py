"""All getters of the API after all setters, in five poses: the values of Gazebo 11.1, but for those of EXPECTED.

What differs on purpose has a reason in `libgz/classic/api.tsv`, from which the reference pages are made.
"""

import re
from pathlib import Path

import classic_values
import pytest

from libgz.classic.api import classic_api

# "Class.Getter" of the values that differ in every scene, and scene -> those that differ in it.
EVERYWHERE = {"Link.DirtyPose", "Model.DirtyPose", "Collision.DirtyPose", "Light.DirtyPose"}
JOINT = {"Joint.GetParam", "Joint.LowerLimit", "Joint.UpperLimit", "Model.GetAutoDisable"}
GYROSCOPIC = {"WorldAngularAccel", "RelativeAngularAccel"}
STILL = ("WorldLinear", "WorldAngular", "RelativeLinear", "RelativeAngular")
EXPECTED = {
    "revolute": JOINT,
    "prismatic": JOINT | {"Joint.Anchor"},
    "universal": JOINT,
    "revolute2": JOINT | {"Joint.LocalAxis"},
    "screw": JOINT | {"Joint.LocalAxis"},
    "ball": JOINT,
    "fixed": JOINT | {"Joint.Anchor"},
    "entities": {
        *("Collision.GetChild", "Collision.GetChildCount", "Link.GetSelfCollide", "Model.GetAutoDisable"),
        *("Link.GetLinearDamping", "Link.GetAngularDamping", "Link.WindMode"),
    },
    "nested": {"Model.GetLink"},
    "weights": {
        *("Link.WorldLinearAccel", "Link.RelativeLinearAccel", "Link.WorldForce", "Link.RelativeForce"),
        *("Model.WorldLinearAccel", "Model.RelativeLinearAccel"),
    },
    "world": {
        *("World.MagneticField", "World.GetAutoDisableFlag", "World.GetParam", "World.Pressure", "World.MassDensity"),
        *("Light.BoundingBox", "Model.GetLink", "Model.GetAutoDisable"),
        *("Model.WorldLinearAccel", "Model.RelativeLinearAccel"),
    },
    "more": {
        *("Joint.GetParam", "Joint.GetForceTorque", "Model.GetAutoDisable", "Link.GetKinematic", "World.PauseTime"),
        *("ModelState.GetJointStateCount", "ModelState.HasJointState"),
        *(f"{kind}.{name}Accel" for kind in ("Model", "Link") for name in STILL),  # of what is static, nan in Gazebo
    },
    "sensors": {
        *("World.GetAutoDisableFlag", "Model.GetAutoDisable", "Link.WorldTorque", "Link.RelativeTorque"),
        *(f"Link.{name}" for name in GYROSCOPIC),
        *(f"Model.{name}" for name in GYROSCOPIC),
        *("ImuSensor.AngularVelocity", "ImuSensor.LinearAcceleration", "ImuSensor.Orientation"),
        *(f"GpsSensor.{name}" for name in ("Latitude", "Longitude", "VelocityEast", "VelocityNorth", "VelocityENU")),
        *("MagnetometerSensor.MagneticField", "World.MagneticField", "World.GetParam"),
        *("RaySensor.Range", "RaySensor.GetRange", "ForceTorqueSensor.Torque"),
        *(f"{kind}Sensor.Topic" for kind in ("Imu", "Altimeter", "Gps", "Magnetometer", "Contact")),
    },
    "collisions": {"Collision.GetChild", "Collision.GetChildCount"},
    "inertials": {*(f"Link.{name}" for name in GYROSCOPIC), "Link.WorldTorque", "Link.RelativeTorque"},
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.syspath_prepend(str(Path(classic_values.__file__).parent))
    return tmp_path


def names_of(scene, key):
    """(Class.Getter, the getter's last name) of a value's key."""
    holder, _, getter = key.partition(".")
    kind = scene.all_objects()[holder][0]
    kind = "Joint" if kind.endswith("Joint") else kind
    last = re.findall(r"(\w+)\((?:[^()]|\([^()]*\))*\)", getter)
    name = last[-1] if last else getter  # of an attribute
    return f"{kind}.{name}", name


@pytest.fixture(scope="module")
def reasons():
    """The names of values with a reason why they differ, with their old forms (`GetRange` is `Range`)."""
    names = {row.name for row in classic_api() if row.state in ("differs", "absent")}
    return names | {f"Get{name}" for name in names}


@pytest.mark.parametrize("name", EXPECTED)
def test_values_are_those_of_gazebo(name, folder, reasons):
    scene = classic_values.SCENES[name]
    recorded = classic_values.read_recorded(name)
    ours = classic_values.read_scene(scene, folder)
    found = {}
    for difference in classic_values.differences(scene, recorded, ours):
        title, getter = names_of(scene, difference.key)
        if not (str(difference.ours).startswith("error AttributeError") and getter in reasons):  # absent, with a reason
            found.setdefault(title, difference)
    expected = EXPECTED[name] | EVERYWHERE
    assert set(found) - expected == set(), next(v for k, v in found.items() if k not in expected)
    assert {title for title in found if title.partition(".")[2] not in reasons} == set(), (
        "a reason is missing in api.tsv"
    )


def test_a_difference_is_found(folder):
    """Comparing a scene with changed records fails, in any value."""
    scene = classic_values.SCENES["nested"]
    recorded = classic_values.read_recorded("nested")
    recorded[7]["now"]["m3.WorldPose()"][0] += 1e-7
    keys = {d.key for d in classic_values.differences(scene, recorded, classic_values.read_scene(scene, folder))}
    assert "m3.WorldPose()" in keys
