"""What observers are to know of the joints and sensors of SDF models."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from libgz.base.geometry import GzPose
from libgz.physics.body import Body
from libgz.physics.joint import Joint
from libgz.sdf.element import Element
from libgz.sdfworld.axis import UNLIMITED
from libgz.sdfworld.joint import SdfJoint
from libgz.simulation.description import in_body, pose_list

__all__ = ["describe_sdf_joint", "describe_sensors", "ode_joints"]


def ode_joints(joints: Iterable[SdfJoint]) -> list[Joint]:
    """The joints of ODE behind joints of a file; a gearbox has none."""
    return [found for joint in joints if (found := joint.joint) is not None and not found.closed]


def describe_sdf_joint(joint: SdfJoint) -> dict[str, Any]:
    """A joint of a file: its kind by SDF's name, parent and child, and its place in the child or else the parent."""
    ode = joint.joint
    bodies = [body for body in (joint.child, joint.parent) if body is not None]
    place: dict[str, Any] = {"frame": 0, "anchor": (0.0, 0.0, 0.0), "axes": []}
    if not any(body.closed for body in bodies):
        place = in_body(
            next(iter(bodies), None), joint.frame().pos, [joint.axis(index) for index in range(len(joint.axes))]
        )
    return {
        "name": joint.name,
        "kind": joint.kind,
        "row": -1 if ode is None or ode.closed else ode.row,
        "bodies": [body.number if body is not None else 0 for body in (joint.parent, joint.child)],
        **place,
        "limits": [
            [bound if abs(bound) < UNLIMITED else None for bound in (axis.lower, axis.upper)] for axis in joint.axes
        ],
    }


def describe_sensors(body: Body, link: Element) -> list[dict[str, Any]]:
    """The sensors of a `<link>`: kind, place in the body, and what is needed to show their rays, cones or views."""
    return [
        {
            "kind": sensor.Get(str, "type"),
            "name": sensor.Get(str, "name"),
            "body": body.number,
            "pose": pose_list(sensor.Get(GzPose, "pose") if sensor.HasElement("pose") else GzPose()),
            "rate": sensor.Get(float, "update_rate"),
            "visualize": sensor.Get(bool, "visualize"),
            "topic": _topic(sensor),
            "rays": [_rays(ray) for ray in sensor.named("ray")],
            "cones": [
                {key: sonar.Get(float, key) for key in ("min", "max", "radius")} for sonar in sensor.named("sonar")
            ],
            "cameras": [_camera(camera) for camera in sensor.named("camera")]
            + [_logical_camera(camera) for camera in sensor.named("logical_camera")],
        }
        for sensor in link.named("sensor")
    ]


def _topic(sensor: Element) -> str:
    """The topic that a sensor's file names; empty for none."""
    value = sensor.Get(str, "topic") if sensor.HasElement("topic") else ""
    return "" if value.startswith("__default") else value


def _rays(ray: Element) -> dict[str, Any]:
    """A fan of rays about the sensor's x axis: angles [rad], ranges [m]."""
    scan, span = ray.child("scan"), ray.child("range")
    found: dict[str, Any] = {"min": span.Get(float, "min"), "max": span.Get(float, "max")}
    for name in ("horizontal", "vertical"):
        row = scan.child(name)
        vertical = name == "vertical" and not scan.HasElement(name)
        samples, low, high = (1, 0.0, 0.0) if vertical else _row(row)
        found[name] = {"samples": samples, "min_angle": low, "max_angle": high}
    return found


def _row(row: Element) -> tuple[int, float, float]:
    return row.Get(int, "samples"), row.Get(float, "min_angle"), row.Get(float, "max_angle")


def _camera(camera: Element) -> dict[str, Any]:
    image, clip = camera.child("image"), camera.child("clip")
    width, height = image.Get(int, "width"), image.Get(int, "height")
    return {
        "pose": pose_list(camera.Get(GzPose, "pose") if camera.HasElement("pose") else GzPose()),
        "fov": camera.Get(float, "horizontal_fov"),
        "aspect": width / height if height > 0 else 1.0,
        "near": clip.Get(float, "near"),
        "far": clip.Get(float, "far"),
    }


def _logical_camera(camera: Element) -> dict[str, Any]:
    names = {"fov": "horizontal_fov", "aspect": "aspect_ratio", "near": "near", "far": "far"}
    return {"pose": pose_list(GzPose()), **{key: camera.Get(float, name) for key, name in names.items()}}
