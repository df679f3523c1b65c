"""Appearance of an SDF world: materials of visuals, lights, and the scene behind them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.files import is_file
from libgz.base.geometry import GzColor, GzPose, GzVector
from libgz.physics.appearance import RENDER_OPAQUE, RENDER_TRANSPARENT, Appearance, Surface
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import DomeGeom, LightGeom
from libgz.sdf.element import Element
from libgz.sdf.materials import NEUTRAL, Material, find_material, own_texture
from libgz.sdf.paths import find_uri

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = [
    "KINDS",
    "apply_scene",
    "dress",
    "dress_material",
    "link_lights",
    "material_name",
    "put_on",
    "replaces_look",
    "scripted_material",
    "set_light",
    "set_sky",
    "set_transparency",
    "show_image",
]

log = logging.getLogger("libgz.simulation")

Note = Callable[[Element, str], object]  # reports a warning about an element

UNSET = "__default__"
KINDS = ("point", "directional", "spot")
HOUR = 3600.0  # [s]
# Elements of a `<material>`, and what they set.
COLORS = {"ambient": "ambient", "diffuse": "diffuse", "specular": "specular", "emissive": "emission"}

# Images of a `<pbr>` beside that of colours, in the order of a `Surface`.
MAPS = ("normal_map", "metalness_map", "roughness_map", "emissive_map")


# Visuals ---------------------------------------------------------------------------------------------------------


def dress(geom: Geom, element: Element, note: Note) -> None:
    """Apply the material and transparency of a `<visual>` to its geom. Without a material it is white."""
    look = geom.appearance
    if not element.child("geometry").HasElement("mesh") or replaces_look(element):
        put_on(look, Material())
    if element.HasElement("material"):
        dress_material(look, element.child("material"), note)
    set_transparency(look, min(max(element.Get(float, "transparency"), 0.0), 1.0))
    geom.SetRetro(element.Get(float, "laser_retro"))
    look.change(cast_shadows=element.Get(bool, "cast_shadows"))


def replaces_look(element: Element) -> bool:
    """Whether the `<material>` of a `<visual>` takes the place of those in its mesh file, with their images."""
    if not element.HasElement("material"):
        return False
    material = element.child("material")
    return bool(material_name(material)) or any(map(material.HasElement, COLORS))


def dress_material(look: Appearance, element: Element, note: Note) -> None:
    """Apply a `<material>`."""
    name = material_name(element)
    if name:
        found = scripted_material(name, element)
        if found is None:
            note(element.child("script"), f"there is no material {name!r}; it is shown in grey")
        put_on(look, found or NEUTRAL)
    else:
        _put_surface_on(look, element, note)
    for key, attribute in COLORS.items():
        if element.HasElement(key):
            setattr(look, attribute, element.Get(GzColor, key))
    if element.HasElement("lighting") and not element.Get(bool, "lighting"):
        _unlight(look)
    look.version += 1


def _put_surface_on(look: Appearance, element: Element, note: Note) -> None:
    """Apply a `<pbr>`: its image of colours is rendered, the rest is for pages."""
    workflows = [flow for pbr in element.named("pbr") for name in ("metal", "specular") for flow in pbr.named(name)]
    flow = next((flow for flow in workflows if flow.HasElement("albedo_map")), next(iter(workflows), None))
    if flow is None:
        return
    albedo = _map(flow, "albedo_map", note)
    if albedo is not None:
        put_on(look, Material(texture=albedo))
    metalness, roughness = (
        min(max(flow.Get(float, name), 0.0), 1.0) if flow.HasElement(name) else 0.5
        for name in ("metalness", "roughness")
    )
    look.surface = Surface(metalness, roughness, *(_map(flow, name, note) for name in MAPS))


def _map(flow: Element, name: str, note: Note) -> Path | None:
    """An image of a `<pbr>`; None without one, or after a note that it cannot be found."""
    image = next(flow.named(name), None)
    if image is None:
        return None
    folder = Path(image.file).parent if image.file and not image.file.startswith("<") else None
    try:
        found = find_uri(image.Get(str), folder)
    except NotFoundError as error:
        note(image, f"{error}; the plain colours are shown")
        return None
    return found if is_file(found) else None


def material_name(element: Element) -> str:
    """The name in the script of a `<material>`; old worlds have it as plain text. Empty if there is none."""
    script = element.child("script") if element.HasElement("script") else None
    if script is None:
        return ""
    name = script.Get(str, "name")
    name = script.value.GetAsString() if name in ("", UNSET) else name
    return "" if name == UNSET else name


def scripted_material(name: str, element: Element | None) -> Material | None:
    """A material by name, searched for in the scripts that a `<material>` names, too; None if it is not known."""
    script = next(element.named("script"), None) if element is not None else None
    if script is None:
        return find_material(name)
    uris = [uri.Get(str) for uri in script.named("uri")]
    folder = Path(script.file).parent if script.file and not script.file.startswith("<") else None
    return find_material(name, [uri for uri in uris if uri not in ("", UNSET)], folder)


def put_on(look: Appearance, material: Material) -> None:
    """Apply a material's colours and texture to an appearance."""
    look.ambient, look.diffuse = GzColor(*material.ambient), GzColor(*material.diffuse)
    look.specular, look.emission = GzColor(*material.specular), GzColor(*material.emissive)
    look.shininess, look.texture_file = material.shininess, material.texture
    look.texture_matrix, look.alpha_rejection = material.texture_matrix, material.alpha_rejection
    if not material.lit:
        _unlight(look)
    set_transparency(look, look.transparency)


def show_image(look: Appearance, image: Path, color: Sequence[float] | None) -> None:
    """Show an image on a part of a mesh, times the colour that the part has in its file."""
    r, g, b, a = color or (1.0, 1.0, 1.0, 1.0)
    put_on(look, Material((r, g, b, a), (r, g, b, a), texture=image))


def _unlight(look: Appearance) -> None:
    """Show plain colours, independent of the light."""
    glow = look.emission if any(tuple(look.emission)[:3]) else look.diffuse
    look.emission = GzColor(*glow)
    look.ambient, look.specular = GzColor(), GzColor()
    look.diffuse = GzColor(0.0, 0.0, 0.0, look.diffuse.a)


def set_transparency(look: Appearance, transparency: float) -> None:
    """Set the transparency, 0 to 1, in addition to the alpha of the diffuse colour."""
    look.transparency = transparency
    clear = look.diffuse.a * (1.0 - transparency) < 1.0
    look.render_order = RENDER_TRANSPARENT if clear else RENDER_OPAQUE
    look.version += 1


# Lights ----------------------------------------------------------------------------------------------------------


def set_light(light: LightGeom, element: Element, note: Note) -> None:
    """Apply a `<light>` to a light; one without `<attenuation>` fades by SDF's defaults, as in Gazebo."""
    light.SetDiffuseColor(element.Get(GzColor, "diffuse"))
    light.SetSpecularColor(element.Get(GzColor, "specular"))
    light.SetAmbientColor(GzColor())  # ambient light is the scene's
    kind = element.Get(str, "type")
    if kind not in KINDS:
        note(element, f"there is no light of type {kind!r}{nearest(kind, KINDS)}; it is shown as a point light")
    light.kind = kind if kind in KINDS else "point"
    try:
        light.SetDirection(element.Get(GzVector, "direction"))
    except ParameterError as error:
        note(element, f"{error}; it shines downwards")
    light.cast_shadows = element.Get(bool, "cast_shadows")
    fading = element.child("attenuation")
    try:
        light.SetAttenuation([fading.Get(float, key) for key in ("constant", "linear", "quadratic")])
    except ParameterError as error:
        note(fading, f"{error}; the light does not fade")
    light.SetRange(fading.Get(float, "range"))
    if light.kind == "spot" and not element.HasElement("spot"):
        note(element, "the light has no <spot>; as in Gazebo its cone has an angle of 0, and it lights nothing")
    cone = element.child("spot")
    try:
        light.SetSpot(cone.Get(float, "inner_angle"), cone.Get(float, "outer_angle"), cone.Get(float, "falloff"))
    except ParameterError as error:
        note(cone, f"{error}; its cone has an angle of 0")


def link_lights(body: Body, link: Element, note: Note) -> None:
    """Add the lights of a `<link>`, which move with it."""
    for element in link.named("light"):
        light = LightGeom(body, None)
        light.SetRelativePose(element.Get(GzPose, "pose"), updateCoM=False)
        set_light(light, element, note)


# Scene -----------------------------------------------------------------------------------------------------------


def apply_scene(world: World, element: Element) -> None:
    """Apply the colours, the shadows, the fog and the sky of a `<scene>` to a world."""
    world.backdrop.ambient = element.Get(GzColor, "ambient")
    world.skyColor = element.Get(GzColor, "background")
    asked = element.child("shadows").value
    world.backdrop.shadows = asked.Get(bool) if asked.given else None
    if element.HasElement("fog"):
        fog, back = element.child("fog"), world.backdrop
        kind = fog.Get(str, "type")
        world.fogEnable = kind in ("linear", "exp", "exp2")
        world.fogDensity = fog.Get(float, "density")
        back.fog_kind = kind if world.fogEnable else back.fog_kind
        back.fog_color, back.fog_start, back.fog_end = (
            fog.Get(GzColor, "color"),
            fog.Get(float, "start"),
            fog.Get(float, "end"),
        )
    if element.HasElement("sky"):
        set_sky(world, element.child("sky").Get(float, "time"))


def set_sky(world: World, time: float | None) -> None:
    """Show a sky for a time of day [h] behind everything, or none."""
    dome = next((geom for geom in world.engine.geoms.values() if isinstance(geom, DomeGeom)), None)
    if time is None:
        if dome is not None:
            dome.appearance.visible = False
            dome.appearance.version += 1
        return
    if dome is None:
        dome = DomeGeom(Body(world, dummy=True))
        dome.SetTexture2DFile(own_texture("sky.png"))
    dome.appearance.visible = True
    dome.appearance.version += 1
    dome.SetDayTime(time * HOUR)
