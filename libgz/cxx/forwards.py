"""The functions of the table that are more than a call of the method of the same name.

The first argument of `Class_Method` is the object. What a function returns is converted by its prototype. Functions
that end with `_new` make an object and return its handle.
"""

from __future__ import annotations

import ctypes
import logging
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from libgz.base.errors import GazeboError, NotFoundError, ParameterError, WorldFileError
from libgz.base.geometry import GzPose, GzQuatern
from libgz.cxx.camera import CxxCamera
from libgz.cxx.objects import current, enter, forget, running
from libgz.cxx.ray import CxxRay
from libgz.cxx.stereo_camera import CxxStereoCamera
from libgz.legacy.model import Model
from libgz.legacy.world import LegacyWorld
from libgz.ode.lib import ode
from libgz.ode.types import Mass
from libgz.physics import geoms, surfaces
from libgz.physics.appearance import RENDER_LIGHT, RENDER_OPAQUE, RENDER_TRANSPARENT
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.image_files import open_image
from libgz.physics.joint import BallJoint, HingeJoint, Joint, JointGroup, SliderJoint
from libgz.physics.rays import RayProximity
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint
from libgz.simulation.world import World
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

log = logging.getLogger("libgz.plugin")

MESSAGE = 1  # the level up to which messages are informative, and above which they are diagnostic
SEVERITIES = {0: logging.ERROR, 1: logging.WARNING}  # of GZ_ERR_ERR, GZ_ERR_WARN


def _floats(address: int | None, count: int, kind: Any) -> Any:
    """Numbers of a plugin's memory, copied."""
    if not address or count <= 0:
        return np.empty(0, dtype=kind)
    size = np.dtype(kind).itemsize * count
    return np.frombuffer(ctypes.string_at(address, size), dtype=kind)


# Objects -----------------------------------------------------------------------------------------------------------


def Object_destroyed(handle: int, pointer: int, made: bool) -> None:
    thing = forget(handle)
    if not made or thing is None:
        return
    if isinstance(thing, Body | Geom | Joint | JointGroup | RayProximity | CxxCamera | CxxStereoCamera):
        thing.close()


def Factory_RegisterModel(type: str, classname: str, function: int) -> None:
    if running.registered is not None:
        running.registered.append((classname, function))
    else:
        model = current()
        kind = model.plugin.model_class(classname, function)
        model.world.extension(LegacyWorld).factory.RegisterModel(type, classname, kind)


def Factory_NewModel(world: World, classname: str) -> Model | None:
    return world.extension(LegacyWorld).factory.NewModel(world, classname)


def Error_Print(type: int, level: int, file: str, line: int, text: str) -> None:
    severity = SEVERITIES.get(type, logging.INFO if level <= MESSAGE else logging.DEBUG)
    if log.isEnabledFor(severity):
        log.handle(log.makeRecord(log.name, severity, file, line, text.rstrip("\n"), (), None))


def Image_Load(filename: str | None, width: int, height: int, components: int, data: int) -> int:
    try:
        with open_image(Path(filename or "")) as image:
            bands = len(image.getbands())
            mode = image.mode if image.mode in ("L", "LA", "RGB", "RGBA") else "RGBA" if bands in (2, 4) else "RGB"
            pixels = np.asarray(image.convert(mode))
    except GazeboError as error:
        log.error("failed to open image file %s: %s", filename, error)
        return -1
    model = current()
    model.image = pixels.tobytes()
    numbers = (pixels.shape[1], pixels.shape[0], pixels.shape[2] if pixels.ndim == 3 else 1)
    for address, number in zip((width, height, components), numbers, strict=True):
        ctypes.c_int.from_address(address).value = number
    buffer = ctypes.c_char_p(model.image)
    ctypes.memmove(data, ctypes.addressof(buffer), ctypes.sizeof(ctypes.c_void_p))
    return 0


# Worldfile ---------------------------------------------------------------------------------------------------------


def WorldFileNode_GetString(node: WorldFileNode, key: str, require: int) -> str | None:
    return node.GetString(key, None, require)


def WorldFileNode_GetFilename(node: WorldFileNode, key: str, require: int) -> str | None:
    return node.GetFilename(key, None, require)


def WorldFileNode_SearchFilename(node: WorldFileNode, key: str, path: str | None, require: int) -> str | None:
    return node.SearchFilename(key, path, None, require)


def WorldFileNode_Print(node: WorldFileNode) -> None:
    sys.stdout.write(node.Print() + "\n")


def WorldFile_new(pointer: int) -> int:
    return enter(WorldFile(), pointer)


def _attempt(action: Callable[[], int]) -> int:
    try:
        return action()
    except WorldFileError as error:
        log.error("%s", error)
        return -1


def WorldFile_Load(file: WorldFile, filename: str) -> int:
    return _attempt(lambda: file.Load(filename))


def WorldFile_LoadString(file: WorldFile, text: str) -> int:
    return _attempt(lambda: file.LoadString(text))


def WorldFile_Save(file: WorldFile, filename: str | None) -> int:
    return _attempt(lambda: file.Save(filename))


def WorldFile_GetFilename(file: WorldFile) -> str | None:
    return file.filename


def WorldFile_WarnUnused(file: WorldFile) -> bool:
    return file.GetRootNode().WarnUnused()


# Bodies ------------------------------------------------------------------------------------------------------------


def Body_new(pointer: int, world: World | None, name: str | None, dummy: bool) -> int:
    if world is None:
        raise ParameterError("a Body needs its model's world, not NULL")
    return enter(Body(world, name, dummy), pointer)


def Body_GetBodyId(body: Body) -> int:
    return body.id


def Body_GetWorldId(body: Body) -> int:
    return body.engine.world


def Body_GetSpaceId(body: Body) -> int | None:
    return None if body.model is None else int(body.model.modelSpaceId.id)


def Body_GetGeom(body: Body, index: int) -> Geom:
    return body.geoms[index]


def Body_GetName(body: Body) -> str | None:
    return body.bodyName


def Body_SetPickId(body: Body, number: int) -> None:
    for geom in body.geoms:
        geom.SetPickId(number)


# Geoms -------------------------------------------------------------------------------------------------------------


def _new_geom(kind: Callable[..., Geom]) -> Callable[..., int]:
    def make(pointer: int, body: Body | None, space: int | None, *arguments: Any) -> int:
        if body is None:
            raise ParameterError("a geom needs a Body, not NULL")
        return enter(kind(body, current().session.space(space), *arguments), pointer)

    return make


BoxGeom_new = _new_geom(geoms.BoxGeom)
SphereGeom_new = _new_geom(geoms.SphereGeom)
CylinderGeom_new = _new_geom(geoms.CylinderGeom)
WheelGeom_new = _new_geom(geoms.WheelGeom)
PlaneGeom_new = _new_geom(geoms.PlaneGeom)
RayGeom_new = _new_geom(CxxRay)
LightGeom_new = _new_geom(geoms.LightGeom)
FrustrumGeom_new = _new_geom(geoms.FrustrumGeom)
DomeGeom_new = _new_geom(lambda body, space, resolution: geoms.DomeGeom(body, space))
TerrainGeom_new = _new_geom(surfaces.TerrainGeom)
RoadGeom_new = _new_geom(surfaces.RoadGeom)


def PointSetGeom_new(pointer: int, body: Body, space: int | None, count: int, points: int) -> int:
    numbers = _floats(points, 3 * count, np.float64).reshape(-1, 3)
    return enter(surfaces.PointSetGeom(body, current().session.space(space), count, numbers), pointer)


def PrismGeom_new(
    pointer: int, body: Body | None, space: int | None, count: int, corners: int | None, height: float
) -> int:
    if body is None:
        raise ParameterError("a geom needs a Body, not NULL")
    outline = _floats(corners, 3 * count, np.float64).reshape(-1, 3)[:, :2]
    return enter(geoms.PrismGeom(body, current().session.space(space), outline, height), pointer)


def BaseGeom_new(
    pointer: int, body: Body | None, space: int | None, handle: int | None, mass: int | None, placeable: bool
) -> int:
    if body is None:
        raise ParameterError("a geom needs a Body, not NULL")
    owner = current().session.space(space)
    if handle and owner is not None and not ode().dGeomGetSpace(handle):
        ode().dSpaceAdd(owner.id, handle)
    own = Mass.from_buffer_copy(ctypes.string_at(mass, ctypes.sizeof(Mass))) if mass else None
    return enter(Geom(body, owner, handle, own, placeable), pointer)


def BaseGeom_GetGeomId(geom: Geom) -> int:
    return geom.id


def BaseGeom_GetPlaceable(geom: Geom) -> bool:
    return geom.placeableGeom


def BaseGeom_GetBody(geom: Geom) -> Body:
    return geom.body


def BaseGeom_GetBodyMassMatrix(geom: Geom) -> int | None:
    mass = geom.GetBodyMassMatrix()
    if mass is None:
        return None
    current().mass = mass
    return ctypes.addressof(mass)


def BaseGeom_SetContact(geom: Geom, kp: float, kd: float, bounce: float, mu1: float, mu2: float) -> None:
    geom.SetHardness(kp, kd)
    geom.SetFriction(mu1, mu2)
    geom.SetBounce(bounce)


def BaseGeom_SetExtraRotation(geom: Geom, rotation: GzQuatern) -> None:
    geom.extra_rotation = rotation
    geom.place()


def Geom_SetTexture2D(geom: Geom, width: int, height: int, data: int | None) -> int:
    if width <= 0 or height <= 0 or not data:
        raise ParameterError(f"SetTexture2D needs an image; this one is {width} x {height} px")
    folder = current().session.folder()
    path = folder / f"texture{geom.number}_{geom.appearance.version}.png"
    Image.frombytes("RGB", (width, height), ctypes.string_at(data, 3 * width * height)).save(path)
    return geom.SetTexture2DFile(path)


def Geom_GetTransparency(geom: Geom) -> float:
    return float(geom.GetTransparency())


def Geom_GetRenderOrder(geom: Geom) -> int:
    return geom.appearance.render_order


def Geom_SetRenderOrder(geom: Geom, order: int) -> None:
    if order not in (RENDER_LIGHT, RENDER_OPAQUE, RENDER_TRANSPARENT):
        raise ParameterError(f"a renderOrder is {RENDER_LIGHT}, {RENDER_OPAQUE} or {RENDER_TRANSPARENT}, not {order}")
    geom.appearance.change(render_order=order)


def RayGeom_Get(geom: geoms.RayGeom) -> tuple[float, ...]:
    start, direction = geom.Get()
    return (*start, *direction)


def TerrainGeom_Load(
    geom: surfaces.TerrainGeom, vertices: int, count: int, strip: int, strips: int, triangles: int, corners: int
) -> None:
    geom.Load(
        _floats(vertices, 12 * count, np.float32).reshape(-1, 12),
        _floats(strip, strips, np.uint32),
        _floats(triangles, corners - corners % 3, np.uint32),
    )


# Joints ------------------------------------------------------------------------------------------------------------


def _new_joint(kind: Callable[..., Joint]) -> Callable[..., int]:
    def make(pointer: int, world: int | None, group: JointGroup | None) -> int:
        own = current().world
        if world != own.engine.world:
            raise ParameterError("a joint needs its model's world: this->world, or this->world->worldId")
        return enter(kind(own, group), pointer)

    return make


HingeJoint_new = _new_joint(HingeJoint)
Hinge2Joint_new = _new_joint(Hinge2Joint)
UniversalJoint_new = _new_joint(UniversalJoint)
BallJoint_new = _new_joint(BallJoint)
SliderJoint_new = _new_joint(SliderJoint)


def JointGroup_new(pointer: int) -> int:
    return enter(JointGroup(), pointer)


def JointGroup_GetGroupId(group: JointGroup) -> int:
    return group.native


def Joint_GetJointId(joint: Joint) -> int:
    return joint.id


def Joint_SetFixed(joint: Joint) -> None:
    if not hasattr(joint, "SetFixed"):
        raise ParameterError(f"{joint!r} is no fixed joint: equal stops make a joint stiff")
    joint.SetFixed()


# Sensors -----------------------------------------------------------------------------------------------------------


def RayProximity_new(pointer: int, world: World | None, body: Body | None, count: int) -> int:
    if world is None or body is None:
        raise ParameterError("a RayProximity needs a world and a Body, not NULL")
    rays = RayProximity(world, body, count)
    current().sensors.append(rays)
    return enter(rays, pointer)


def RayProximity_GetRay(rays: RayProximity, index: int) -> tuple[float, ...]:
    start, direction = rays.GetRay(index)
    return (*start, *direction)


def Camera_new(pointer: int, world: World | None) -> int:
    if world is None:
        raise ParameterError("a Camera needs its model's world, not NULL")
    return enter(CxxCamera(world), pointer)


def Camera_Init(
    camera: CxxCamera, width: int, height: int, hfov: float, near: float, far: float, method: str | None, depth: int
) -> int:
    try:
        camera.Init(width, height, hfov, near, far)
    except GazeboError as error:
        log.error("%s", error)
        return -1
    return 0


def Camera_GetImageSize(camera: CxxCamera) -> tuple[float, ...]:
    width, height = camera.GetImageSize()
    return (width, height, 0.0, 0.0, 0.0, 0.0)


def StereoCamera_new(pointer: int, world: World | None) -> int:
    if world is None:
        raise ParameterError("a StereoCamera needs its model's world, not NULL")
    return enter(CxxStereoCamera(world), pointer)


def StereoCamera_Init(
    camera: CxxStereoCamera,
    width: int,
    height: int,
    hfov: float,
    baseline: float,
    near: float,
    far: float,
    method: str | None,
    depth: int,
) -> int:
    try:
        camera.Init(width, height, hfov, baseline, near, far)
    except GazeboError as error:
        log.error("%s", error)
        return -1
    return 0


def StereoCamera_GetSize(camera: CxxStereoCamera) -> tuple[float, ...]:
    width, height = camera.GetSize()
    return (width, height, 0.0, 0.0, 0.0, 0.0)


# Models and the world ----------------------------------------------------------------------------------------------


def Model_new(pointer: int, fields: int, world: World | None) -> int:
    model = current()
    if model.pointer:
        raise ParameterError("a model cannot create another one with new; World::LoadModel does")
    return model.constructed(pointer, fields)


def Model_SetId(model: Model, id: str | None) -> None:
    if id is None:
        raise ParameterError("SetId needs a text, not NULL")
    model.SetId(id)


def Model_SetName(model: Model, name: str | None) -> None:
    if name is None:
        raise ParameterError("SetName needs a text, not NULL")
    model.SetName(name)


def Model_GetBody(model: Model, name: str | None) -> Body | None:
    try:
        return model.GetBody(name)
    except NotFoundError:
        return None


def Model_GetBodyAt(model: Model, index: int) -> Body:
    return model.bodies[index]


def Model_MasterLoad(model: Model, file: WorldFile, node: WorldFileNode) -> int:
    model.MasterLoad(file, node)
    return 0


def Model_Load(model: Model, file: WorldFile, node: WorldFileNode) -> int:
    return model.Load(file, node) or 0


def Model_Init(model: Model, file: WorldFile, node: WorldFileNode) -> int:
    return model.Init(file, node) or 0


def Model_Fini(model: Model) -> int:
    return model.Fini() or 0


def _the_server_s(name: str) -> Callable[..., int]:
    def refuse(world: World, *arguments: Any) -> int:
        raise ParameterError(f"World::{name} is for servers: the world of a plugin is loaded, and it runs")

    return refuse


World_Load = _the_server_s("Load")
World_Initialize = _the_server_s("Initialize")
World_Finalize = _the_server_s("Finalize")
World_Step = _the_server_s("Step")


def World_GetModel(world: World, index: int) -> Any:
    return world.models[index]


def World_GetSpaceId(world: World) -> int:
    return world.engine.top.id


def World_LoadModel(world: World, node: WorldFileNode, parent: Model | None) -> int:
    if node is None:
        raise ParameterError("World::LoadModel needs an element, not NULL")
    return 0 if world.extension(LegacyWorld).loader.load_model(node, parent) is not None else -1


def World_SetModelPose(world: World, model: Model | None, pose: GzPose) -> None:
    if model is None:
        raise ParameterError("World::SetModelPose needs a model, not NULL")
    world.SetModelPose(model, pose)
