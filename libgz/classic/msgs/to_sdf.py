"""Messages of models as elements of SDF, which plugins spawn on ``~/factory``."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from libgz.classic.msgs.convert import ConvertIgn
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile

__all__ = [
    "CollisionToSDF",
    "GeometryToSDF",
    "InertialToSDF",
    "JointToSDF",
    "LinkToSDF",
    "MaterialToSDF",
    "ModelToSDF",
    "VisualToSDF",
]

VERSION = "1.6"
MOMENTS = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
# What a geometry's element is made of, by its kind: messages of the same names.
SHAPES = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "plane": ("normal", "size"),
    "sphere": ("radius",),
    "mesh": ("filename", "scale"),
}
# Where the name of a field is not that of the element.
ELEMENTS = {"is_static": "static", "filename": "uri", "limit_lower": "lower", "limit_upper": "upper"}
ELEMENTS |= {"limit_effort": "effort", "limit_velocity": "velocity"}
COLORS = ("ambient", "diffuse", "specular", "emissive")


def _value(value: Any) -> str:
    """The text of a number, a name, a vector, a pose or a colour."""
    fields = getattr(value, "DESCRIPTOR", None)
    if fields is None:
        return str(value).lower() if isinstance(value, bool) else escape(str(value))
    if fields.name == "Pose":
        pose = ConvertIgn(value)
        return " ".join(repr(float(number)) for number in (*pose.pos, *pose.rot.Euler()))
    return " ".join(repr(getattr(value, field.name)) for field in fields.fields)


def _fields(message: Any, *names: str) -> Iterator[str]:
    """Elements of those fields that a message has."""
    for name in names:
        if message.HasField(name):
            element = ELEMENTS.get(name, name)
            yield f"<{element}>{_value(getattr(message, name))}</{element}>"


def _named(kind: str, message: Any, *parts: str) -> str:
    return f"<{kind} name={quoteattr(message.name)}>{''.join(parts)}</{kind}>"


def _geometry(message: Any) -> str:
    for kind, fields in SHAPES.items():
        if message.HasField(kind):
            shape = getattr(message, kind)
            return f"<geometry><{kind}>{''.join(_fields(shape, *fields))}</{kind}></geometry>"
    return "<geometry><empty/></geometry>"


def _material(message: Any) -> str:
    script = ""
    if message.HasField("script"):
        uris = "".join(f"<uri>{escape(uri)}</uri>" for uri in message.script.uri)
        script = f"<script>{uris}<name>{escape(message.script.name)}</name></script>"
    return f"<material>{script}{''.join(_fields(message, 'lighting', *COLORS))}</material>"


def _inertial(message: Any) -> str:
    moments = "".join(_fields(message, *MOMENTS))
    return f"<inertial>{''.join(_fields(message, 'mass', 'pose'))}<inertia>{moments}</inertia></inertial>"


def _parts(message: Any, **parts: Any) -> Iterator[str]:
    """Elements of those of its fields that are messages again."""
    for name, made in parts.items():
        if message.HasField(name):
            yield made(getattr(message, name))


def _collision(message: Any) -> str:
    own = _fields(message, "laser_retro", "max_contacts", "pose")
    return _named("collision", message, *own, *_parts(message, geometry=_geometry))


def _visual(message: Any) -> str:
    own = _fields(message, "cast_shadows", "transparency", "laser_retro", "pose")
    return _named("visual", message, *own, *_parts(message, geometry=_geometry, material=_material))


def _link(message: Any) -> str:
    own = _fields(message, "self_collide", "gravity", "kinematic", "enable_wind", "pose")
    parts = (*map(_collision, message.collision), *map(_visual, message.visual))
    return _named("link", message, *own, *_parts(message, inertial=_inertial), *parts)


def _axis(name: str, message: Any) -> str:
    limit = "".join(_fields(message, "limit_lower", "limit_upper", "limit_effort", "limit_velocity"))
    dynamics = "".join(_fields(message, "damping", "friction"))
    own = "".join(_fields(message, "xyz", "use_parent_model_frame"))
    return f"<{name}>{own}<limit>{limit}</limit><dynamics>{dynamics}</dynamics></{name}>"


def _joint(message: Any) -> str:
    kinds = message.DESCRIPTOR.fields_by_name["type"].enum_type.values_by_number
    kind = kinds[message.type].name.lower()
    own = _fields(message, "parent", "child", "pose")
    axes = [
        _axis(f"axis{number or ''}", getattr(message, f"axis{number or 1}"))
        for number in (0, 2)
        if message.HasField(f"axis{number or 1}")
    ]
    return f"<joint name={quoteattr(message.name)} type='{kind}'>{''.join((*own, *axes))}</joint>"


def _model(message: Any) -> str:
    own = _fields(message, "is_static", "self_collide", "enable_wind", "pose")
    parts = (*map(_link, message.link), *map(_joint, message.joint), *map(_model, message.model))
    return _named("model", message, *own, *parts)


def _element(text: str) -> Element:
    file = SdfFile.from_string(f'<sdf version="{VERSION}">{text}</sdf>', parts=True)
    file.diagnostics.raise_errors()
    return next(iter(file.root.children))


def ModelToSDF(message: Any) -> Element:
    """The `<model>` of a msgs.Model: links, joints and inner models, without sensors and plugins."""
    return _element(_model(message))


def LinkToSDF(message: Any) -> Element:
    """The `<link>` of a msgs.Link, without sensors."""
    return _element(_link(message))


def JointToSDF(message: Any) -> Element:
    """The `<joint>` of a msgs.Joint, with its axes."""
    return _element(_joint(message))


def CollisionToSDF(message: Any) -> Element:
    """The `<collision>` of a msgs.Collision, without its surface."""
    return _element(_collision(message))


def VisualToSDF(message: Any) -> Element:
    """The `<visual>` of a msgs.Visual."""
    return _element(_visual(message))


def InertialToSDF(message: Any) -> Element:
    """The `<inertial>` of a msgs.Inertial."""
    return _element(_inertial(message))


def GeometryToSDF(message: Any) -> Element:
    """The `<geometry>` of a msgs.Geometry: box, cylinder, sphere, plane or a whole mesh; others are empty."""
    return _element(_geometry(message))


def MaterialToSDF(message: Any) -> Element:
    """The `<material>` of a msgs.Material: its script and colours."""
    return _element(_material(message))
