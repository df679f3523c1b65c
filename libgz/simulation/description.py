"""Description: what observers are to know of geoms, bodies and joints, as plain data that can be written as JSON.

A pose is a list of seven numbers, position [m] and quaternion (u, x, y, z); a colour has red, green, blue and alpha.
Shapes are described from the same attributes as they are rendered from: no file is read a second time.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzCoordPoseSub, GzPose, GzQuaternInverse, GzVector, GzVectorSub, rotate
from libgz.ode.types import JointType
from libgz.physics.appearance import RENDER_TRANSPARENT
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import (
    BoxGeom,
    CapsuleGeom,
    CylinderGeom,
    DomeGeom,
    FrustrumGeom,
    HeightfieldGeom,
    LightGeom,
    PlaneGeom,
    RayGeom,
    SkinGeom,
    SphereGeom,
    TriMeshGeom,
    WheelGeom,
)
from libgz.physics.joint import Joint
from libgz.physics.rays import RayProximity

__all__ = [
    "SHAPES",
    "Store",
    "describe_body",
    "describe_joint",
    "describe_rays",
    "in_body",
    "offset_in",
    "plain",
    "pose_list",
    "shape_of",
]

# Keeps arrays in a file, numbers as float32 and indices as uint32, and returns how to refer to them.
Store = Callable[[dict[str, NDArray[Any]]], dict[str, Any]]


def pose_list(pose: GzPose) -> list[float]:
    """Position [m] and quaternion (u, x, y, z)."""
    return [*pose.pos, *pose.rot]


def plain(value: Any) -> Any:
    """The same data as lists, dicts, strings and numbers; numbers that JSON does not have become None."""
    if isinstance(value, dict):
        return {str(key): plain(part) for key, part in value.items()}
    if isinstance(value, bool | str | None):
        return value
    if isinstance(value, int | np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value.absolute())
    return [plain(part) for part in value]


# Shapes ----------------------------------------------------------------------------------------------------------


def _mesh(geom: TriMeshGeom, store: Store) -> dict[str, Any]:
    arrays: dict[str, NDArray[Any] | None] = {"vertices": geom.vertices, "triangles": geom.triangles}
    arrays |= {"normals": geom.normals, "texture_coordinates": geom.texture_coordinates, "colors": geom.colors}
    arrays["image"] = geom.image() if geom.image is not None else None
    return {"data": store({name: array for name, array in arrays.items() if array is not None})}


def _skin(geom: SkinGeom, store: Store) -> dict[str, Any]:
    """The mesh as it is bent now, and what bends it."""
    arrays = {"rest": geom.rest, "weights": geom.weights, "places": geom.places, "inverse_binds": geom.inverse_binds}
    bones = {"bodies": [body.number for body in geom.bones], "data": store(arrays)}
    return {**_mesh(geom, store), "bones": bones}


def _heightfield(geom: HeightfieldGeom, store: Store) -> dict[str, Any]:
    return {"size": geom.size, "data": store({"heights": geom.heights})}


def _ray(geom: RayGeom, _store: Store) -> dict[str, Any]:
    start, direction = geom.Get()
    return {"start": start, "direction": direction, "length": geom.GetLength()}


# A kind without a row is described like its nearest base class with one.
SHAPES: dict[type[Geom], tuple[str, Callable[[Any, Store], dict[str, Any]]]] = {
    BoxGeom: ("box", lambda geom, _: {"size": geom.size}),
    SphereGeom: ("sphere", lambda geom, _: {"radius": geom.radius}),
    CylinderGeom: ("cylinder", lambda geom, _: {"radius": geom.radius, "length": geom.length}),
    CapsuleGeom: ("capsule", lambda geom, _: {"radius": geom.radius, "length": geom.length}),
    WheelGeom: ("wheel", lambda geom, _: {"radius": geom.radius, "tire_radius": geom.tire_radius}),
    PlaneGeom: ("plane", lambda geom, _: {"normal": geom.normal, "altitude": geom.altitude}),
    SkinGeom: ("mesh", _skin),
    TriMeshGeom: ("mesh", _mesh),
    HeightfieldGeom: ("heightfield", _heightfield),
    RayGeom: ("ray", _ray),
    FrustrumGeom: ("frustum", lambda g, _: {"fov": g.fov, "aspect": g.aspect, "near": g.near_clip, "far": g.far_clip}),
    DomeGeom: ("dome", lambda geom, _: {"time_of_day": 86400.0 * geom.day_share}),
    LightGeom: (
        "light",
        lambda geom, _: {
            "light": geom.kind,
            "direction": geom.direction,
            "attenuation": geom.attenuation,
            "spot": geom.spot,
            "range": geom.range,
        },
    ),
}


def shape_of(geom: Geom, store: Store) -> dict[str, Any]:
    """Kind and sizes of a geom; kind ``other`` for one that has no row in `SHAPES`."""
    for kind in type(geom).__mro__:
        if kind in SHAPES:
            name, sizes = SHAPES[kind]
            return {"kind": name, **sizes(geom, store)}
    return {"kind": "other"}


def _describe_geom(geom: Geom, name: str, store: Store) -> dict[str, Any]:
    look = geom.appearance
    ambient, diffuse, specular, emission, shininess = geom.material()
    clear = look.render_order == RENDER_TRANSPARENT
    return {
        "id": geom.number,
        "name": name,
        **shape_of(geom, store),
        "pose": pose_list(geom.GetRelativePose()),
        "collides": bool(geom.id) and geom.space is not None,
        "visible": look.visible,
        "cast_shadows": look.cast_shadows,
        "scale": look.scale,
        "material": {
            "ambient": ambient,
            "diffuse": diffuse[:3],
            "specular": specular,
            "emission": emission,
            "shininess": shininess,
            "opacity": diffuse[3] if clear else 1.0,
        },
        "texture": None
        if look.texture_file is None
        else {
            "file": look.texture_file,
            "size": tuple(look.texture_size)[:2],
            "matrix": look.texture_matrix,
            "alpha_rejection": look.alpha_rejection,
        },
        "pbr": None if look.surface is None else look.surface._asdict(),
        "skin": None
        if look.skin_file is None
        else {"file": look.skin_file, "pose": pose_list(look.skin_pose), "scale": look.skin_scale},
        "hidden_by_skins": look.skin_null,
        "hidden_by_skin": look.skin_instead,
        "retro": look.retro,
        "fiducial": look.fiducial,
    }


def describe_body(body: Body, row: int, names: dict[Geom, str], store: Store) -> dict[str, Any]:
    """A body with its shapes; `row` is its place in the table of bodies, `names` are those of geoms."""
    mass = body.GetMass()
    return {
        "id": body.number,
        "name": body.bodyName or "",
        "row": row,
        "static": body.dummy,
        "mass": mass.mass,
        "inertia": [mass.I[i] for i in (0, 5, 10, 1, 2, 6)],
        "shapes": [_describe_geom(geom, names.get(geom, ""), store) for geom in body.geoms],
    }


# Joints and rays -------------------------------------------------------------------------------------------------


def in_body(body: Body | None, point: GzVector, directions: Iterable[GzVector]) -> dict[str, Any]:
    """A global point [m] and directions in the frame of a body; of the world for None."""
    pose = body.GetPose() if body is not None else GzPose()
    back = GzQuaternInverse(pose.rot)
    return {
        "frame": body.number if body is not None else 0,
        "anchor": rotate(back, GzVectorSub(point, pose.pos)),
        "axes": [rotate(back, direction) for direction in directions],
    }


def describe_joint(joint: Joint) -> dict[str, Any]:
    """A joint between bodies, by its own names: the first body, and the second one, 0 for the world."""
    bodies = [body for body in joint.bodies if body is not None]
    moving = [body for body in bodies if not body.dummy]
    place: dict[str, Any] = {"frame": 0, "anchor": GzVector(), "axes": []}
    if len(moving) >= max(1, joint.bodies_needed):
        names = [name for name in ("GetAxis", "GetAxis1", "GetAxis2") if hasattr(joint, name)]
        anchored = joint.kind not in (JointType.SLIDER, JointType.FIXED)
        anchor = joint.GetAnchor() if anchored else moving[0].GetPose().pos
        place = in_body(moving[0], anchor, [getattr(joint, name)() for name in names])
    return {
        "name": joint.name or "",
        "kind": JointType(joint.kind).name.lower(),
        "row": joint.row,
        "bodies": [body.number if body is not None else 0 for body in joint.bodies],
        **place,
    }


def describe_rays(body: Body, store: Store) -> list[dict[str, Any]]:
    """The bundles of rays that are fixed to a body, and the fields of view of its cameras."""
    found: list[dict[str, Any]] = []
    for bundle in body.engine.ray_bundles:
        if bundle.body is body and isinstance(bundle, RayProximity):
            found.append({"kind": "rays", "body": body.number, "data": store({"rays": bundle.rays})})
    for geom in body.geoms:
        if isinstance(geom, FrustrumGeom):
            optics = {"fov": geom.fov, "aspect": geom.aspect, "near": geom.near_clip, "far": geom.far_clip}
            pose = pose_list(geom.GetRelativePose())
            found.append({"kind": "camera", "body": body.number, "pose": pose, **optics})
    return found


def offset_in(pose: GzPose, body: Body) -> list[float]:
    """A global pose in the frame of a body."""
    return pose_list(GzCoordPoseSub(pose, body.GetPose()))
