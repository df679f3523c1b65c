"""Conversion of robot descriptions (URDF) to SDF 1.6, as XML: what Gazebo classic made of them.

Elements of the result have the lines of those that they come from, for messages.
"""

from __future__ import annotations

import copy
import math

import numpy as np
from lxml import etree

from libgz.base.errors import Diagnostics, nearest
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector
from libgz.sdf.description import NEWEST
from libgz.sdf.robot import (
    TRUE,
    WORLD,
    Extension,
    Robot,
    RobotJoint,
    RobotLink,
    RobotShape,
    describes,
    value_of,
)
from libgz.sdf.xml import PLACE, child_of, copy_place, local_name

__all__ = ["sdf_of"]

LUMP = "_fixed_joint_lump__"  # in the names of shapes that were lumped into another link
MATERIALS = "file://media/materials/scripts/gazebo.material"
# Elements of <gazebo reference='LINK'> -> where their value stands in a collision.
SURFACE = {
    "mu1": "surface/friction/ode/mu",
    "mu2": "surface/friction/ode/mu2",
    "fdir1": "surface/friction/ode/fdir1",
    "kp": "surface/contact/ode/kp",
    "kd": "surface/contact/ode/kd",
    "maxVel": "surface/contact/ode/max_vel",
    "minDepth": "surface/contact/ode/min_depth",
    "laserRetro": "laser_retro",
    "maxContacts": "max_contacts",
}
# Elements of <gazebo reference='JOINT'> -> where their value stands in a joint.
JOINT = {
    "stopCfm": "physics/ode/limit/cfm",
    "stopErp": "physics/ode/limit/erp",
    "springReference": "axis/dynamics/spring_reference",
    "springStiffness": "axis/dynamics/spring_stiffness",
    "fudgeFactor": "physics/ode/fudge_factor",
}
# The same, of what is true or false.
JOINT_FLAGS = {
    "provideFeedback": "physics/provide_feedback",
    "implicitSpringDamper": "physics/ode/implicit_spring_damper",
    "cfmDamping": "physics/ode/implicit_spring_damper",
}
LINK_FLAGS = {"turnGravityOff", "selfCollide", "dampingFactor", "material", "visual", "collision"}
ROBOT_FLAGS = {"static"}
NOTED = {"canonicalBody", "preserveFixedJoint", "disableFixedJointLumping"}  # which have been read, or mean nothing
OWN = {*SURFACE, *JOINT, *JOINT_FLAGS, *LINK_FLAGS, *ROBOT_FLAGS, *NOTED}  # the others are SDF already
POSED = ("sensor", "projector", "light")  # elements of a link that have a pose in it
# Elements that name links -> those in them that do. Plugins of sensors keep theirs, which are frames of TF.
NAMING = {
    "gripper": ("gripper_link", "palm_link"),
    "joint": ("parent", "child"),
    "plugin": ("bodyName", "frameName"),
}


def sdf_of(xml: etree._Element, label: str, diagnostics: Diagnostics) -> etree._Element:
    """The `<sdf>` element of a robot.

    Args:
        xml: its `<robot>` element, which must not be used any more.
        label: the document's name in messages.
        diagnostics: takes errors and warnings, with their lines.
    """
    robot = Robot(xml, label, diagnostics)
    root = etree.Element("sdf", version=NEWEST)
    copy_place(root, xml)
    _Writer(robot).write(_add(root, "model", xml))
    etree.indent(root)
    return root


class _Writer:
    """Writes a robot as a `<model>`."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.collisions: dict[str, str] = {}  # the name that a collision would have unlumped -> its name

    def write(self, model: etree._Element) -> None:
        robot = self.robot
        model.set("name", robot.name)
        if child_of(robot.xml, "origin") is not None:
            _set(model, "pose", _pose_text(robot.origin(robot.xml)), robot.xml)
        kept = list(robot.kept_links())
        names = {link.name for link, _ in kept}
        for link, pose in kept:
            self._write_link(model, link, pose)
        for link, _ in kept:
            if link.joint is not None:
                self._write_joint(model, link.joint, names)
        for extension in robot.extensions:
            self._write_robot_extension(model, extension)
        holders = [holder for holder in model.iter(etree.Element) if local_name(holder) != "sensor"]
        for element in [child for holder in holders for child in holder.iterchildren(etree.Element)]:
            if local_name(element) in (*NAMING, "sensor"):
                self._rename(element)
        transmissions = list(robot.xml.iterfind("transmission"))
        if transmissions:
            count = len(transmissions)
            self.robot.warn(
                transmissions[0],
                f"transmissions are for controllers of ROS; {'this one has' if count == 1 else f'these {count} have'} "
                "no effect: plugins, topics and programs move joints by their names",
            )

    # Links -----------------------------------------------------------------------------------------------------------

    def _write_link(self, model: etree._Element, link: RobotLink, pose: GzPose) -> None:
        xml = _add(model, "link", link.xml)
        xml.set("name", link.name)
        _set(xml, "pose", _pose_text(pose), link.xml)
        if link.inertial is not None:
            inertial = link.inertial
            holder = _add(xml, "inertial", inertial.xml)
            _set(holder, "pose", _pose_text(inertial.pose), inertial.xml)
            _set(holder, "mass", _text(inertial.mass), inertial.xml)
            for i, j in zip(*np.triu_indices(3), strict=True):
                key = f"i{'xyz'[i]}{'xyz'[j]}"
                _set(holder, f"inertia/{key}", _text(inertial.inertia[i, j]), inertial.xml)
        for kind, shapes in (("collision", link.collisions), ("visual", link.visuals)):
            count = 0
            for shape in shapes:
                count += self._write_shape(xml, kind, link, shape, count)
        if link.extensions:  # Gazebo writes these first, so that what <gazebo> says of them in SDF is the second
            _set(xml, "gravity", "true", link.xml)
            _add(xml, "velocity_decay", link.xml)
        for extension in link.extensions:
            self._write_link_extension(xml, extension)

    def _write_shape(self, link: etree._Element, kind: str, owner: RobotLink, shape: RobotShape, count: int) -> bool:
        """Whether there is one: a shape without geometry is left out."""
        geometry = self._geometry(shape.xml)
        if geometry is None:
            return False
        plain = f"{shape.xml.get('name') or shape.owner}_{kind}" + (f"_{count}" if count else "")
        name = plain if plain.startswith(owner.name) else f"{owner.name}{LUMP}{plain}"
        xml = _add(link, kind, shape.xml)
        xml.set("name", name)
        if kind == "collision":
            self.collisions.setdefault(f"{shape.owner}_collision", name)
        _set(xml, "pose", _pose_text(shape.pose), shape.xml)
        xml.append(geometry)
        extensions = [extension for extension in owner.extensions if extension.reference == shape.owner]
        material = child_of(shape.xml, "material") if kind == "visual" else None
        named = any(local_name(child) == "material" for extension in extensions for child in extension.children())
        if material is not None and not named:
            self._write_colour(xml, material)
        for extension in extensions:
            self._extend_shape(xml, kind, extension)
        return True

    def _geometry(self, shape: etree._Element) -> etree._Element | None:
        robot, holder = self.robot, child_of(shape, "geometry")
        inside = [] if holder is None else list(holder.iterchildren(etree.Element))
        if not inside:
            robot.warn(shape, "there is no shape in <geometry>; it is left out")
            return None
        source, kind = inside[0], local_name(inside[0])
        wanted: dict[str, tuple[str, ...]] = {"box": ("size",), "sphere": ("radius",), "mesh": ("filename",)}
        wanted |= {"cylinder": ("radius", "length"), "capsule": ("radius", "length")}
        if kind not in wanted:
            robot.warn(source, f"is no shape of URDF; it is left out{nearest(kind, wanted)}")
            return None
        for key in (key for key in wanted[kind] if source.get(key) is None):
            robot.warn(source, f"attribute {key!r} is missing: the shape is left out")
            return None
        result = etree.Element("geometry")
        copy_place(result, source)
        xml = _add(result, kind, source)
        if kind == "mesh":
            scale = source.get("scale", "1 1 1")
            if len(scale.split()) == 1:
                scale = " ".join(3 * [scale])  # some write one number for all axes
            source.set("scale", scale)
            _set(xml, "scale", _text(*robot.numbers(source, "scale", 3, (1.0, 1.0, 1.0))), source)
            uri = source.get("filename", "").strip()
            _set(xml, "uri", uri.replace("package://", "model://", 1), source)
        elif kind == "box":
            _set(xml, "size", _text(*robot.numbers(source, "size", 3, (1.0, 1.0, 1.0))), source)
        else:
            for key in wanted[kind]:
                _set(xml, key, _text(robot.number(source, key, 1.0)), source)
        return result

    def _write_colour(self, visual: etree._Element, given: etree._Element) -> None:
        """Write the colour of a material, given here or under its name."""
        name = given.get("name", "")
        material = given if describes(given) else self.robot.materials.get(name)
        if material is None:
            if name:
                known = nearest(name, self.robot.materials)
                self.robot.warn(given, f"there is no material {name!r} with a colour{known}")
            return
        colour = child_of(material, "color")
        if colour is None:
            self.robot.warn(given, "textures of URDF are not rendered; <color> and <gazebo><material> are")
            return
        text = _text(*self.robot.numbers(colour, "rgba", 4, (1.0, 1.0, 1.0, 1.0)))
        for key in ("ambient", "diffuse"):
            _set(visual, f"material/{key}", text, colour)

    def _extend_shape(self, shape: etree._Element, kind: str, extension: Extension) -> None:
        """Write what a `<gazebo>` of a link says of its collisions, or of its visuals."""
        for child in extension.children():
            key = local_name(child)
            if key == kind:
                for part in child.iterchildren(etree.Element):
                    old = child_of(shape, local_name(part))
                    if old is not None:
                        shape.remove(old)
                    shape.append(copy.deepcopy(part))
        for child in extension.children():
            key = local_name(child)
            if kind == "collision" and key in SURFACE:
                text = value_of(child) if key == "fdir1" else self._number(child)
                _set(shape, SURFACE[key], text, child)
            elif kind == "visual" and key == "material" and value_of(child):
                _set(shape, "material/script/uri", MATERIALS, child)
                _set(shape, "material/script/name", value_of(child), child)

    def _write_link_extension(self, link: etree._Element, extension: Extension) -> None:
        for child in extension.children():
            key = local_name(child)
            if key == "turnGravityOff":
                _set(link, "gravity", "false" if self._flag(child) else "true", child)
            elif key == "selfCollide":
                _set(link, "self_collide", "true" if self._flag(child) else "false", child)
            elif key == "dampingFactor":
                for part in ("linear", "angular"):
                    _set(link, f"velocity_decay/{part}", self._number(child), child)
            elif key not in OWN:
                copied = copy.deepcopy(child)
                if key in POSED and extension.reference in self.robot.lumped:
                    self._move(copied, extension.pose)
                link.append(copied)

    def _write_robot_extension(self, model: etree._Element, extension: Extension) -> None:
        for child in extension.children():
            key = local_name(child)
            if key == "static":
                _set(model, "static", "true" if self._flag(child) else "false", child)
            elif key not in OWN:
                model.append(copy.deepcopy(child))
            elif key not in NOTED:
                self.robot.warn(child, "has no effect in <gazebo> without the reference of a link or joint")

    # Joints ----------------------------------------------------------------------------------------------------------

    def _write_joint(self, model: etree._Element, joint: RobotJoint, links: set[str]) -> None:
        robot = self.robot
        if joint.kind == "floating":
            return
        if joint.kind == "planar":
            robot.warn(joint.xml, f"SDF has no planar joints; link {joint.child!r} moves freely, as in Gazebo classic")
            return
        hinged = joint.kind == "fixed" and joint.asks("disableFixedJointLumping")
        hinged = hinged and not joint.asks("preserveFixedJoint")
        kinds = {"continuous": "revolute", "fixed": "revolute" if hinged else "fixed"}
        xml = _add(model, "joint", joint.xml)
        xml.set("name", joint.name)
        xml.set("type", kinds.get(joint.kind, joint.kind))
        _set(xml, "parent", joint.parent, joint.xml)
        _set(xml, "child", joint.child, joint.xml)
        if hinged:
            _set(xml, "axis/xyz", "0 0 1", joint.xml)
            for key in ("lower", "upper"):
                _set(xml, f"axis/limit/{key}", "0", joint.xml)
        elif joint.kind != "fixed":
            self._write_axis(xml, joint, links)
        if joint.extensions:
            _holder(xml, "physics", joint.xml)  # as in links
        for extension in joint.extensions:
            self._extend_joint(xml, extension)

    def _write_axis(self, xml: etree._Element, joint: RobotJoint, links: set[str]) -> None:
        robot, source = self.robot, joint.xml
        given = child_of(source, "axis")
        direction = robot.numbers(given, "xyz", 3, (1.0, 0.0, 0.0)) if given is not None else (1.0, 0.0, 0.0)
        _set(xml, "axis/xyz", _text(*direction), source if given is None else given)
        limit, dynamics = child_of(source, "limit"), child_of(source, "dynamics")
        if limit is not None:
            self._write_limit(xml, joint, limit)
        elif joint.kind in ("revolute", "prismatic"):
            robot.warn(source, f"<limit> is missing, which {joint.kind} joints must have; it moves without limits")
        if dynamics is not None:
            for key in ("damping", "friction"):
                _set(xml, f"axis/dynamics/{key}", _text(robot.number(dynamics, key)), dynamics)
        mimic = child_of(source, "mimic")
        if mimic is not None:
            self._write_mimic(xml, joint, mimic, links)

    def _write_limit(self, xml: etree._Element, joint: RobotJoint, limit: etree._Element) -> None:
        robot = self.robot
        if joint.kind != "continuous":
            low, high = robot.bound(limit, "lower", 0.0), robot.bound(limit, "upper", 0.0)
            if low > high:
                robot.warn(limit, f"lower is {low:g} and upper {high:g}; they are exchanged")
                low, high = high, low
            _set(xml, "axis/limit/lower", _text(low), limit)
            _set(xml, "axis/limit/upper", _text(high), limit)
        for key in ("effort", "velocity"):
            if limit.get(key) is not None:
                _set(xml, f"axis/limit/{key}", _text(robot.bound(limit, key, -1.0)), limit)

    def _write_mimic(self, xml: etree._Element, joint: RobotJoint, mimic: etree._Element, links: set[str]) -> None:
        robot, name = self.robot, mimic.get("joint", "")
        leader = robot.joints.get(name)
        if leader is None or leader is joint:
            known = nearest(name, robot.joints)
            robot.warn(mimic, f"joint is {name!r}, which is not another joint{known}; it has no effect")
            return
        if leader.kind not in ("revolute", "continuous", "prismatic") or leader.child not in links:
            robot.warn(mimic, f"joint {name!r} does not move, so it cannot be followed; it has no effect")
            return
        holder = _add(_holder(xml, "axis", mimic), "mimic", mimic)
        holder.set("joint", name)
        for key, default in (("multiplier", 1.0), ("offset", 0.0)):
            _set(holder, key, _text(robot.number(mimic, key, default)), mimic)

    def _extend_joint(self, joint: etree._Element, extension: Extension) -> None:
        for child in extension.children():
            key = local_name(child)
            if key in JOINT:
                _set(joint, JOINT[key], self._number(child), child)
            elif key in JOINT_FLAGS:
                _set(joint, JOINT_FLAGS[key], "true" if self._flag(child) else "false", child)
            elif key not in OWN and extension.reference not in self.robot.links:
                joint.append(copy.deepcopy(child))

    # Values, names and poses in extensions ---------------------------------------------------------------------------

    def _flag(self, xml: etree._Element) -> bool:
        """Gravity is turned off by anything but false; what else is set needs the word true."""
        word = value_of(xml).lower()
        return word not in ("false", "no", "0") if local_name(xml) == "turnGravityOff" else word in TRUE

    def _number(self, xml: etree._Element) -> str:
        text = value_of(xml)
        try:
            float(text)
        except ValueError:
            self.robot.error(xml, f"{text!r} is not allowed; it must be a number")
            return "0"
        return text

    def _move(self, xml: etree._Element, above: GzPose) -> None:
        """Express the pose of an element in the link that it was lumped into."""
        pose = child_of(xml, "pose")
        if pose is not None and any(text.strip() for key, text in pose.attrib.items() if key != PLACE):
            return  # it is relative to something else
        old = _pose_of(pose)
        if old is None:
            return  # the reader reports it
        if pose is None:
            pose = _add(xml, "pose", xml)
        pose.text = _pose_text(GzCoordPoseAdd(old, above))

    def _rename(self, xml: etree._Element) -> None:
        """Replace names of lumped links, and of their collisions, by those that have their parts now."""
        lumped = self.robot.lumped
        for contact in xml.iterfind("contact") if local_name(xml) == "sensor" else ():
            for collision in contact.iterfind("collision"):
                collision.text = self.collisions.get((collision.text or "").strip(), collision.text)
        for key in NAMING.get(local_name(xml), ()):
            for part in xml.iterfind(key):
                name = value_of(part)
                if name not in lumped or (local_name(xml) == "joint" and name == WORLD):
                    continue
                part.text, pose = lumped[name]
                part.attrib.pop("value", "")
                if key == "child":
                    self._move(xml, pose)
                elif local_name(xml) == "plugin":
                    _move_offset(xml, pose)
        for part in xml.iterfind("projector") if local_name(xml) == "plugin" else ():
            link, slash, rest = value_of(part).partition("/")
            if slash and link in lumped:
                part.text = f"{lumped[link][0]}/{rest}"


def _move_offset(plugin: etree._Element, above: GzPose) -> None:
    """Express a plugin's offset in the link that its own was lumped into [m, rad]."""
    parts = [child_of(plugin, key) for key in ("xyzOffset", "rpyOffset")]
    try:
        position, angles = ([float(w) for w in value_of(p).split()] if p is not None else 3 * [0.0] for p in parts)
        offset = GzPose(GzVector(*position), GzQuaternFromEuler(*angles))
    except (TypeError, ValueError):
        return  # it is not what this plugin means by these names
    moved = GzCoordPoseAdd(offset, above)
    for key, values in (("xyzOffset", moved.pos), ("rpyOffset", GzQuaternToEuler(moved.rot))):
        old = child_of(plugin, key)
        if old is not None:
            old.attrib.pop("value", "")
        _set(plugin, key, _text(*values), plugin)


def _pose_of(xml: etree._Element | None) -> GzPose | None:
    """The pose that an element has as text; the zero pose if there is none, None if it cannot be read."""
    words = (xml.text or "").split() if xml is not None else []
    try:
        numbers = [float(word) for word in words] or 6 * [0.0]
    except ValueError:
        return None
    if len(numbers) != 6 or not all(map(math.isfinite, numbers)):
        return None
    return GzPose(GzVector(*numbers[:3]), GzQuaternFromEuler(*numbers[3:]))


def _text(*numbers: float) -> str:
    """Numbers as text, to their last bits."""
    return " ".join(repr(float(number) + 0.0).removesuffix(".0") for number in numbers)


def _pose_text(pose: GzPose) -> str:
    return _text(*pose.pos, *GzQuaternToEuler(pose.rot))


def _add(parent: etree._Element, tag: str, source: etree._Element) -> etree._Element:
    """Add a child, which has the line of its source."""
    child = etree.SubElement(parent, tag)
    copy_place(child, source)
    return child


def _holder(xml: etree._Element, way: str, source: etree._Element) -> etree._Element:
    """The element at the end of a way, whose steps are made where they are missing."""
    for tag in way.split("/"):
        found = child_of(xml, tag)
        xml = _add(xml, tag, source) if found is None else found
    return xml


def _set(xml: etree._Element, way: str, text: str, source: etree._Element) -> None:
    """Set the text at the end of a way; one that is there already is replaced."""
    target = _holder(xml, way, source)
    target.text = text
    copy_place(target, source)
