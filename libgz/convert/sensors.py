"""Lasers, sonars and cameras as SDF sensors of links."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from lxml import etree

from libgz.base.geometry import GzPose, GzQuaternFromAxis, GzVector
from libgz.convert.element import Notes, add, name_of, pose
from libgz.legacy.model import Model
from libgz.models.camera import CameraAttributes
from libgz.models.sicklms200 import EYE_HEIGHT, SickAttributes, SickLMS200
from libgz.models.sonars import MAX_RANGE, SonarRing
from libgz.models.stereohead import StereoHeadAttributes
from libgz.physics.body import Body
from libgz.physics.geoms import FrustrumGeom
from libgz.worldfile.attributes import read

__all__ = ["add_sensors"]

SONAR_RATE = 10.0  # [Hz]
HEAD = "head"  # the body that carries the lens of a pan-tilt camera


def add_sensors(
    model: Model, links: Mapping[Body, etree._Element], ray_type: str, owner: str, notes: Notes
) -> set[str]:
    """Add the sensors of a model to its links; the interfaces for which there are sensors.

    Args:
        model: a loaded model.
        links: link of each body.
        ray_type: SDF's type for lasers and sonars, `ray` or `gpu_ray`.
        owner: name of the model in notes.
        notes: receives what has no counterpart.
    """
    served: set[str] = set()
    if isinstance(model, SickLMS200) and model.GetBody() in links:
        _add_laser(links[model.GetBody()], model, ray_type)
        served.add("laser")
    for ring in _rings(model):
        if ring.rays.body in links:
            _add_sonars(links[ring.rays.body], model, ring, ray_type)
            served.add("sonar")
    if issubclass(model.attributes, CameraAttributes) and model.node is not None:
        body, eye = _eye(model)
        if body in links:
            served |= _add_cameras(links[body], model, read(model.attributes, model.node), eye)
    return served


def _rings(model: Model) -> Iterator[SonarRing]:
    """The sonars among a model's Python attributes, and in lists among them."""
    for value in vars(model).values():
        for one in value if isinstance(value, list | tuple) else (value,):
            if isinstance(one, SonarRing):
                yield one


def _sensor(link: etree._Element, name: str, type: str, rate: float, place: GzPose) -> etree._Element:
    taken = {str(sensor.get("name")) for sensor in link.iterfind("sensor")}
    sensor = add(link, "sensor", name=name_of(name, taken), type=type)
    add(sensor, "pose", pose(place))
    add(sensor, "always_on", True)
    add(sensor, "update_rate", rate)
    return sensor


def _add_rays(sensor: etree._Element, samples: int, angles: tuple[float, float], ranges: tuple[float, float]) -> None:
    ray = add(sensor, "ray")
    horizontal = add(add(ray, "scan"), "horizontal")
    add(horizontal, "samples", samples)
    add(horizontal, "resolution", 1)
    add(horizontal, "min_angle", angles[0])
    add(horizontal, "max_angle", angles[1])
    range_ = add(ray, "range")
    add(range_, "min", ranges[0])
    add(range_, "max", ranges[1])


def _add_laser(link: etree._Element, model: SickLMS200, ray_type: str) -> None:
    rate = read(SickAttributes, model.node).scanRate if model.node is not None else SickAttributes().scanRate
    sensor = _sensor(link, model.GetId(), ray_type, rate, GzPose(GzVector(0.0, 0.0, EYE_HEIGHT)))
    _add_rays(sensor, model.rangeCount, (model.minAngle, model.maxAngle), (model.rangeMin, model.rangeMax))


def _add_sonars(link: etree._Element, model: Model, ring: SonarRing, ray_type: str) -> None:
    """One sensor with one ray for each sonar, as in libgz."""
    for i, (x, y, z, direction) in enumerate(ring.poses.tolist()):
        place = GzPose(GzVector(x, y, z), GzQuaternFromAxis(0.0, 0.0, 1.0, direction))
        sensor = _sensor(link, f"{model.GetId()}_sonar{i}", ray_type, SONAR_RATE, place)
        _add_rays(sensor, 1, (0.0, 0.0), (0.0, MAX_RANGE))


def _eye(model: Model) -> tuple[Body, GzPose]:
    """(body, pose in it) of a camera's optical centre: its frustum, if it has one, else the middle of its housing."""
    for body in model.bodies:
        for geom in body.geoms:
            if isinstance(geom, FrustrumGeom):
                return body, geom.GetRelativePose()
    body = next((body for body in model.bodies if body.bodyName == HEAD), model.GetBody())
    return body, body.geoms[0].GetRelativePose() if body.geoms else GzPose()


def _add_cameras(link: etree._Element, model: Model, values: CameraAttributes, eye: GzPose) -> set[str]:
    """One camera; two of a stereo head."""
    if not isinstance(values, StereoHeadAttributes):
        _add_camera(link, model.GetId(), values, eye)
        return {"camera"}
    for side, name in ((0.5, "left"), (-0.5, "right")):
        place = GzPose(GzVector(eye.pos.x, eye.pos.y + side * values.baseline, eye.pos.z), eye.rot)
        _add_camera(link, f"{model.GetId()}_{name}", values, place)
    return {"camera"}


def _add_camera(link: etree._Element, name: str, values: CameraAttributes, place: GzPose) -> None:
    sensor = _sensor(link, name, "camera", values.updateRate, place)
    camera = add(sensor, "camera")
    add(camera, "horizontal_fov", min(values.hfov, math.pi))
    image = add(camera, "image")
    add(image, "width", int(values.imageSize[0]))
    add(image, "height", int(values.imageSize[1]))
    add(image, "format", "R8G8B8")
    clip = add(camera, "clip")
    add(clip, "near", values.nearClip)
    add(clip, "far", values.farClip)
