"""Messages that describe SDF elements for clients: visuals, geometries, materials, sensors, and a scene's look."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import Any

from libgz.base.geometry import GzColor, GzPose, GzVector
from libgz.classic import msgs
from libgz.sdf.element import Element

__all__ = [
    "collision_visual",
    "entity_visual",
    "fill_geometry",
    "fill_plugins",
    "fill_scene",
    "gui_message",
    "road_messages",
    "visual_messages",
]

MATERIALS = "file://media/materials/scripts/gazebo.material"  # where Gazebo has its own ones
_SHADERS = ("vertex", "pixel", "normal_map_object_space", "normal_map_tangent_space")
_KINDS = ("box", "cylinder", "sphere", "plane", "image", "heightmap", "mesh", "polyline")


def visual_messages(link: Element, name: str, parent: int, static: bool) -> Iterator[Any]:
    """The visuals of a link's element.

    Args:
        link: the element.
        name: the link's scoped name.
        parent: the link's id.
        static: whether the model does not move.
    """
    for element in link.named("visual"):
        own = f"{name}::{element.Get(str, 'name')}"
        message = msgs.Visual(
            name=own,
            id=_number(own),
            parent_name=name,
            parent_id=parent,
            is_static=static,
            scale=msgs.Vector3d(x=1.0, y=1.0, z=1.0),
            type="VISUAL",
        )
        for key, kind in (("cast_shadows", bool), ("transparency", float), ("laser_retro", float)):
            if element.HasElement(key):
                setattr(message, key, element.Get(kind, key))
        msgs.Set(message.pose, element.Get(GzPose, "pose"))
        for geometry in element.named("geometry"):
            fill_geometry(message.geometry, geometry)
        for material in element.named("material"):
            _fill_material(message.material, material)
        fill_plugins(message, element)
        for meta in element.named("meta"):
            message.meta.layer = meta.Get(int, "layer")
        yield message


def _number(name: str) -> int:
    """An id for what the engine has no number of: always the same, and not one of others."""
    return 1 << 31 | zlib.crc32(name.encode()) & 0x7FFFFFFF


def entity_visual(kind: str, message: Any, parent_name: str, parent_id: int) -> Any:
    """What clients hang the visuals of an entity on; they move it by the entity's id.

    Args:
        kind: `MODEL`, `LINK` or `COLLISION`.
        message: the entity's own message.
        parent_name, parent_id: of the entity that it belongs to.
    """
    return msgs.Visual(
        name=message.name,
        id=message.id,
        parent_name=parent_name,
        parent_id=parent_id,
        pose=message.pose,
        type=kind,
    )


def collision_visual(collision: Any, name: str, parent: int, static: bool) -> Any:
    """What shows the shape of a collision, which a message describes, to those who want to see it.

    Args:
        collision: the msgs.Collision.
        name, parent: the link's scoped name and id.
        static: whether the model does not move.
    """
    own = f"{collision.name}__COLLISION_VISUAL__"
    message = msgs.Visual(
        name=own,
        id=_number(own),
        parent_name=name,
        parent_id=parent,
        is_static=static,
        type="COLLISION",
        cast_shadows=False,
    )
    message.pose.CopyFrom(collision.pose)
    message.geometry.CopyFrom(collision.geometry)
    message.material.script.name = "Gazebo/OrangeTransparent"
    message.material.script.uri.append(MATERIALS)
    return message


def gui_message(gui: Element) -> Any:
    """A `<gui>`, its camera and plugins, as a msgs.GUI."""
    message = msgs.GUI(fullscreen=gui.Get(bool, "fullscreen"))
    for camera in gui.named("camera"):
        message.camera.name = camera.Get(str, "name")
        message.camera.view_controller = camera.Get(str, "view_controller")
        message.camera.projection_type = camera.Get(str, "projection_type", "perspective")[0]
        if camera.HasElement("pose"):
            msgs.Set(message.camera.pose, camera.Get(GzPose, "pose"))
        for track in camera.named("track_visual"):
            message.camera.track.name = track.Get(str, "name")
            message.camera.track.min_dist = track.Get(float, "min_dist")
            message.camera.track.max_dist = track.Get(float, "max_dist")
    fill_plugins(message, gui)
    return message


def fill_plugins(message: Any, element: Element) -> None:
    """Describe the `<plugin>` elements of an element in its message."""
    for plugin in element.named("plugin"):
        message.plugin.add(
            name=plugin.Get(str, "name"),
            filename=plugin.Get(str, "filename"),
            innerxml="".join(child.ToString() for child in plugin.children),
        )


def road_messages(world: Element) -> Iterator[Any]:
    """The `<road>` elements of a world as messages of type msgs.Road."""
    for road in world.named("road"):
        message = msgs.Road(name=road.Get(str, "name"), width=road.Get(float, "width"))
        for point in road.named("point"):
            msgs.Set(message.point.add(), point.Get(GzVector))
        for material in road.named("material"):
            _fill_material(message.material, material)
        yield message


def fill_geometry(message: Any, geometry: Element) -> None:
    """Describe a `<geometry>` in a msgs.Geometry."""
    shape = next((child for child in geometry.children if child.name in _KINDS), None)
    if shape is None:
        message.type = message.EMPTY
        return
    message.type = shape.name.upper()
    if shape.name == "box":
        msgs.Set(message.box.size, shape.Get(GzVector, "size"))
    elif shape.name == "sphere":
        message.sphere.radius = shape.Get(float, "radius")
    elif shape.name == "cylinder":
        message.cylinder.radius, message.cylinder.length = shape.Get(float, "radius"), shape.Get(float, "length")
    elif shape.name == "plane":
        msgs.Set(message.plane.normal, shape.Get(GzVector, "normal"))
        message.plane.size.x, message.plane.size.y = _pair(shape.Get(str, "size"))
    elif shape.name == "mesh":
        message.mesh.filename = shape.Get(str, "uri")
        msgs.Set(message.mesh.scale, shape.Get(GzVector, "scale"))
        for part in shape.named("submesh"):
            message.mesh.submesh = part.Get(str, "name")
            message.mesh.center_submesh = part.Get(bool, "center")
    elif shape.name == "image":
        message.image.uri = shape.Get(str, "uri")
        message.image.scale, message.image.height = shape.Get(float, "scale"), shape.Get(float, "height")
        message.image.threshold = shape.Get(int, "threshold")
        message.image.granularity = shape.Get(int, "granularity")
    elif shape.name == "heightmap":
        message.heightmap.filename = shape.Get(str, "uri")
        msgs.Set(message.heightmap.size, shape.Get(GzVector, "size"))
        msgs.Set(message.heightmap.origin, shape.Get(GzVector, "pos"))
        message.heightmap.use_terrain_paging = shape.Get(bool, "use_terrain_paging")
        for texture in shape.named("texture"):
            images = {key: texture.Get(str, key) for key in ("diffuse", "normal")}
            message.heightmap.texture.add(size=texture.Get(float, "size"), **images)
        for blend in shape.named("blend"):
            message.heightmap.blend.add(**{key: blend.Get(float, key) for key in ("min_height", "fade_dist")})
    else:
        part = message.polyline.add(height=shape.Get(float, "height"))
        for point in shape.named("point"):
            corner = part.point.add()
            corner.x, corner.y = _pair(point.Get(str))


def _pair(text: str) -> tuple[float, float]:
    x, y = text.split()
    return float(x), float(y)


def _fill_material(message: Any, material: Element) -> None:
    for script in material.named("script"):
        message.script.name = script.Get(str, "name")
        message.script.uri.extend(uri.Get(str) for uri in script.named("uri"))
    for shader in material.named("shader"):
        if (kind := shader.Get(str, "type")) in _SHADERS:
            message.shader_type = kind.upper()
        if shader.HasElement("normal_map"):
            message.normal_map = shader.Get(str, "normal_map")
    for name in ("ambient", "diffuse", "specular", "emissive"):
        if material.HasElement(name):
            msgs.Set(getattr(message, name), material.Get(GzColor, name))
    if material.HasElement("lighting"):
        message.lighting = material.Get(bool, "lighting")


def fill_scene(message: Any, scene: Element) -> None:
    """Describe a `<scene>` in a msgs.Scene."""
    msgs.Set(message.ambient, scene.Get(GzColor, "ambient"))
    msgs.Set(message.background, scene.Get(GzColor, "background"))
    message.shadows = scene.Get(bool, "shadows")
    message.grid, message.origin_visual = scene.Get(bool, "grid"), scene.Get(bool, "origin_visual")
    for sky in scene.named("sky"):
        message.sky.time = sky.Get(float, "time")
        message.sky.sunrise, message.sky.sunset = sky.Get(float, "sunrise"), sky.Get(float, "sunset")
        for clouds in sky.named("clouds"):
            message.sky.wind_speed, message.sky.wind_direction = (
                clouds.Get(float, "speed"),
                clouds.Get(float, "direction"),
            )
            message.sky.humidity, message.sky.mean_cloud_size = (
                clouds.Get(float, "humidity"),
                clouds.Get(float, "mean_size"),
            )
            msgs.Set(message.sky.cloud_ambient, clouds.Get(GzColor, "ambient"))
    for fog in scene.named("fog"):
        if (kind := fog.Get(str, "type")) in ("linear", "exp", "exp2"):
            message.fog.type = {"linear": "LINEAR", "exp": "EXPONENTIAL", "exp2": "EXPONENTIAL2"}[kind]
            msgs.Set(message.fog.color, fog.Get(GzColor, "color"))
            message.fog.density = fog.Get(float, "density")
            message.fog.start, message.fog.end = fog.Get(float, "start"), fog.Get(float, "end")
