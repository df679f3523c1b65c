"""Robot: a robot description (URDF) as a tree of links and joints, with fixed joints lumped as Gazebo classic did."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from libgz.base.errors import Diagnostics, Place, nearest
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzQuatern, GzQuaternFromEuler, GzVector, rotate
from libgz.sdf.value import repaired, starts_with_numbers
from libgz.sdf.xml import child_of, local_name, place_of

__all__ = [
    "WORLD",
    "Extension",
    "Inertial",
    "Robot",
    "RobotJoint",
    "RobotLink",
    "RobotShape",
    "describes",
    "value_of",
]

WORLD = "world"  # the name of a root link that stands for the world
LIGHTEST = 1e-6  # [kg] links of this mass or less are left out
SHAPES = ("collision", "visual")
KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
# Elements of <robot> that have a meaning here or are for other programs.
KNOWN = ("link", "joint", "gazebo", "material", "transmission", "origin", "ros2_control", "sensor", "group", "verbose")
TRUE = ("true", "yes", "1")
# Elements of <gazebo reference='JOINT'> that decide what becomes of a fixed joint.
KEEPING = ("preserveFixedJoint", "disableFixedJointLumping")


@dataclass
class Inertial:
    """Mass of a link.

    Attributes:
        mass: [kg].
        pose: of the inertial frame, whose origin is the centre of mass, in the link [m].
        inertia: about the centre of mass, along the axes of that frame [kg m²], shape (3, 3).
        xml: where it is described.
    """

    mass: float
    pose: GzPose
    inertia: NDArray[np.float64]
    xml: etree._Element

    def in_link(self) -> NDArray[np.float64]:
        """The inertia about the centre of mass, along the axes of the link."""
        turn = _matrix(self.pose.rot)
        return np.asarray(turn @ self.inertia @ turn.T)

    def moved(self, pose: GzPose) -> Inertial:
        """The same in a frame in which the link has this pose."""
        return Inertial(self.mass, GzCoordPoseAdd(self.pose, pose), self.inertia, self.xml)

    def plus(self, other: Inertial) -> Inertial:
        """Both together, by the parallel axis theorem; the axes stay those of this one."""
        mass = self.mass + other.mass
        if mass == 0.0:
            return self
        centre = (self.mass * _array(self.pose.pos) + other.mass * _array(other.pose.pos)) / mass
        total = np.zeros((3, 3))
        for part in (self, other):
            arm = _array(part.pose.pos) - centre
            total += part.in_link() + part.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
        turn = _matrix(self.pose.rot)
        return Inertial(mass, GzPose(GzVector(*centre), self.pose.rot), turn.T @ total @ turn, self.xml)


@dataclass
class RobotShape:
    """A `<collision>` or `<visual>`.

    Attributes:
        xml: its element.
        owner: the name of the link that it was described in.
        pose: in the link that has it now [m].
    """

    xml: etree._Element
    owner: str
    pose: GzPose


@dataclass
class Extension:
    """A `<gazebo>` element.

    Attributes:
        xml: the element.
        reference: the link or joint that it names; empty for the robot.
        pose: of that link in the link that has the extension now [m].
    """

    xml: etree._Element
    reference: str
    pose: GzPose = field(default_factory=GzPose)

    def children(self) -> Iterator[etree._Element]:
        """The elements in it."""
        return self.xml.iterchildren(etree.Element)


@dataclass
class RobotJoint:
    """A `<joint>`.

    Attributes:
        pose: of the child link in the parent link [m].
        lumped: whether its child is lumped into its parent.
    """

    xml: etree._Element
    name: str
    kind: str
    parent: str
    child: str
    pose: GzPose
    extensions: list[Extension] = field(default_factory=list)
    lumped: bool = False

    def asks(self, key: str) -> bool:
        """Whether a `<gazebo>` of it sets a flag."""
        found = (child for extension in self.extensions for child in extension.children())
        return any(local_name(child) == key and value_of(child).lower() in TRUE for child in found)


@dataclass
class RobotLink:
    """A `<link>`, with what was lumped into it.

    Attributes:
        joint: the joint to its parent; None for the root.
        joints: those to its children, by name.
    """

    xml: etree._Element
    name: str
    inertial: Inertial | None
    collisions: list[RobotShape]
    visuals: list[RobotShape]
    extensions: list[Extension] = field(default_factory=list)
    joint: RobotJoint | None = None
    joints: list[RobotJoint] = field(default_factory=list)


class Robot:
    """A robot description.

    Args:
        xml: the `<robot>` element.
        label: the document's name in messages.
        diagnostics: takes its errors and warnings.

    Attributes:
        links, joints: by name; `lumped` links are among them.
        root: the link without a parent; None if the description has errors.
        extensions: the `<gazebo>` elements of the robot as a whole.
        lumped: name of a link that was lumped -> (name of the link that has its parts now, its pose in that one).
        materials: name -> `<material>`.
    """

    def __init__(self, xml: etree._Element, label: str, diagnostics: Diagnostics) -> None:
        self.xml, self.label, self.diagnostics = xml, label, diagnostics
        for element in xml.iter(etree.Element):
            if element.prefix is None:
                element.tag = local_name(element)  # the document's own namespace means nothing
        self.name = xml.get("name", "")
        self.links: dict[str, RobotLink] = {}
        self.joints: dict[str, RobotJoint] = {}
        self.extensions: list[Extension] = []
        self.lumped: dict[str, tuple[str, GzPose]] = {}
        self.root: RobotLink | None = None
        if not self.name:
            self.error(xml, "attribute 'name' is missing and must be given")
        self.materials = {m.get("name", ""): m for m in self._materials()}
        self._read_links()
        self._read_joints()
        self._read_extensions()
        self.root = self._find_root()
        if self.root is not None:
            self._lump(self.root)

    def error(self, xml: etree._Element, message: str) -> None:
        """Add an error at an element."""
        self.diagnostics.error(self._place(xml), message)

    def warn(self, xml: etree._Element, message: str) -> None:
        """Add a warning at an element."""
        self.diagnostics.warn(self._place(xml), message)

    def _place(self, xml: etree._Element) -> Place:
        return place_of(xml, self.label)

    # Values ----------------------------------------------------------------------------------------------------------

    def numbers(self, xml: etree._Element, key: str, count: int, default: tuple[float, ...]) -> tuple[float, ...]:
        """Finite numbers of an attribute; the default where there are none.

        As in SDF, units and commas are ignored, missing numbers are 0 and others too many, with a warning; what has
        no numbers is an error.
        """
        text = xml.get(key)
        if text is None:
            return default
        needed = "a number" if count == 1 else f"{count} numbers"
        values = _finite(text)
        if len(values) == count:
            return values
        usable = repaired({1: "double", 3: "vector3", 4: "color"}[count], text, "") if starts_with_numbers(text) else ""
        values = _finite(usable)
        if not values:
            self.error(xml, f"{key} is {text!r}; it must be {needed}")
            return default
        self.warn(xml, f"{key} {text!r} is read as {usable!r}; it should be {needed}")
        return (*values, *default[len(values) :])

    def number(self, xml: etree._Element, key: str, default: float = 0.0) -> float:
        """A finite number of an attribute; the default, with an error, where it is none."""
        return self.numbers(xml, key, 1, (default,))[0]

    def bound(self, xml: etree._Element, key: str, default: float) -> float:
        """A number of an attribute, which may be infinite."""
        text = xml.get(key, "").strip()
        if text.lstrip("+-").lower() in ("inf", "infinity"):
            return float(text)
        return self.number(xml, key, default)

    def origin(self, xml: etree._Element) -> GzPose:
        """The pose of its `<origin>` [m, rad]."""
        origin = child_of(xml, "origin")
        if origin is None:
            return GzPose()
        zeros = (0.0, 0.0, 0.0)
        angles = self.numbers(origin, "rpy", 3, zeros)
        return GzPose(GzVector(*self.numbers(origin, "xyz", 3, zeros)), GzQuaternFromEuler(*angles))

    # Reading ---------------------------------------------------------------------------------------------------------

    def _materials(self) -> Iterator[etree._Element]:
        """Those of the links, too, where they say more than a name; those of the robot come last, and so count."""
        yield from filter(describes, self.xml.iterfind("link/visual/material"))
        yield from self.xml.iterfind("material")

    def _named(self, tag: str) -> Iterator[tuple[etree._Element, str]]:
        known: dict[str, etree._Element] = {}
        for xml in self.xml.iterfind(tag):
            name = xml.get("name", "")
            if not name:
                self.error(xml, "attribute 'name' is missing and must be given")
            elif name in known:
                other, here = self._place(known[name]), self._place(xml)
                where = f"line {other.line}" if other.file == here.file else f"{other.file}:{other.line}"
                self.error(xml, f"there is a {tag} {name!r} already, at {where}; names must differ")
            else:
                known[name] = xml
                yield xml, name

    def _read_links(self) -> None:
        for xml, name in self._named("link"):
            shapes = {k: [RobotShape(s, name, self.origin(s)) for s in xml.iterfind(k)] for k in SHAPES}
            self.links[name] = RobotLink(xml, name, self._read_inertial(xml), shapes["collision"], shapes["visual"])
        if not self.links:
            self.error(self.xml, "there is no <link>; a robot must have one")
        for child in self.xml.iterchildren(etree.Element):
            if local_name(child) not in KNOWN:
                message = f"is not part of URDF and has no effect{nearest(local_name(child), KNOWN)}"
                self.diagnostics.no_effect(self._place(child), functools.partial(str, message))

    def _read_inertial(self, link: etree._Element) -> Inertial | None:
        xml = child_of(link, "inertial")
        if xml is None:
            return None
        mass, inertia = child_of(xml, "mass"), child_of(xml, "inertia")
        if mass is None or mass.get("value") is None:
            self.warn(xml, "<mass value='...'> is missing: the link is read as one without mass")
            return None
        if inertia is None:
            self.warn(xml, "<inertia> is missing: zero moments are read")
            return Inertial(self.number(mass, "value"), self.origin(xml), np.zeros((3, 3)), xml)
        for key in ("ixx", "iyy", "izz"):
            if inertia.get(key) is None:
                self.warn(inertia, f"attribute {key!r} is missing: 0 is read")
        xx, xy, xz, yy, yz, zz = (self.number(inertia, key) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
        matrix = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return Inertial(self.number(mass, "value"), self.origin(xml), matrix, xml)

    def _read_joints(self) -> None:
        for xml, name in self._named("joint"):
            kind = xml.get("type", "")
            if kind not in KINDS:
                allowed = f"{', '.join(KINDS[:-1])} or {KINDS[-1]}{nearest(kind, KINDS)}"
                self.error(xml, f"type is {kind!r}; it must be {allowed}")
                continue
            above, below = self._end(xml, "parent"), self._end(xml, "child")
            if not (above and below):
                continue
            joint = RobotJoint(xml, name, kind, above, below, self.origin(xml))
            child, before = self.links[joint.child], self.links[joint.child].joint
            if before is not None:
                taken = f"link {joint.child!r} is the child of joint {before.name!r}, too"
                self.error(xml, f"{taken}; a link must have one parent")
                continue
            child.joint = self.joints[name] = joint
            self.links[joint.parent].joints.append(joint)
        for link in self.links.values():
            link.joints.sort(key=lambda joint: joint.name)  # as urdfdom has them, whose order numbers the shapes

    def _end(self, joint: etree._Element, tag: str) -> str:
        """The link that a joint names; empty, with an error, if there is none."""
        xml = child_of(joint, tag)
        name = xml.get("link", "") if xml is not None else ""
        if xml is None or not name:
            self.error(joint if xml is None else xml, f"<{tag} link='...'> is missing and must be given")
            return ""
        if name not in self.links:
            self.error(xml, f"there is no link {name!r}{nearest(name, self.links)}")
            return ""
        return name

    def _read_extensions(self) -> None:
        for xml in self.xml.iterfind("gazebo"):
            name = xml.get("reference", "")
            extension = Extension(xml, name)
            owners = [owner for owner in (self.links.get(name), self.joints.get(name)) if owner is not None]
            if not name:
                self.extensions.append(extension)
            elif not owners:
                known = nearest(name, (*self.links, *self.joints))
                self.warn(xml, f"reference is {name!r}, which is no link or joint; it has no effect{known}")
            for owner in owners:
                owner.extensions.append(extension)

    def _find_root(self) -> RobotLink | None:
        roots = [link for link in self.links.values() if link.joint is None]
        if len(roots) > 1:
            names = ", ".join(link.name for link in roots)
            self.error(roots[1].xml, f"links {names} have no parent; all but one must be the child of a joint")
        elif not roots and self.links:
            link = next(iter(self.links.values()))
            self.error(link.xml, "each link is the child of a joint: the joints are a loop")
        elif roots:
            reached = {link.name for link in self.walk(roots[0])}
            lost = next((link for link in self.links.values() if link.name not in reached), None)
            if lost is not None:
                self.warn(
                    lost.xml, "is not connected to the root link: the joints around it are a loop; it is left out"
                )
            return roots[0]
        return None

    # Lumping ---------------------------------------------------------------------------------------------------------

    def walk(self, link: RobotLink) -> Iterator[RobotLink]:
        """A link and all behind it, parents first."""
        waiting = [link]
        while waiting:
            one = waiting.pop()
            yield one
            waiting += [self.links[joint.child] for joint in reversed(one.joints)]

    def _lump(self, root: RobotLink) -> None:
        """Move what fixed joints hold into the links that hold it."""
        links = list(self.walk(root))
        for link in links:
            joint = link.joint
            if joint is None:
                continue
            holder, above = self.lumped.get(joint.parent, (joint.parent, GzPose()))
            if joint.parent in self.lumped:
                joint.parent, joint.pose = holder, GzCoordPoseAdd(joint.pose, above)
            if joint.kind == "fixed" and holder != WORLD and not any(map(joint.asks, KEEPING)):
                self.lumped[link.name] = holder, joint.pose
                self._lump_into(self.links[holder], link, joint)
        for link in links:
            link.joints = []
        for joint in sorted(self.joints.values(), key=lambda each: each.name):
            if not joint.lumped:
                self.links[joint.parent].joints.append(joint)

    def _lump_into(self, holder: RobotLink, link: RobotLink, joint: RobotJoint) -> None:
        joint.lumped = True
        if link.inertial is not None:
            moved = link.inertial.moved(joint.pose)
            still = Inertial(0.0, GzPose(), np.zeros((3, 3)), link.inertial.xml)
            holder.inertial = (holder.inertial or still).plus(moved)
        for shape in (*link.collisions, *link.visuals):
            shape.pose = GzCoordPoseAdd(shape.pose, joint.pose)
        holder.collisions += link.collisions
        holder.visuals += link.visuals
        for extension in link.extensions:
            extension.pose = joint.pose
        holder.extensions += link.extensions
        for child in (child for extension in joint.extensions for child in extension.children()):
            if joint.name not in self.links and local_name(child) not in KEEPING:
                self.warn(
                    child,
                    f"has no effect: joint {joint.name!r} is fixed, and {link.name!r} becomes part of {holder.name!r}; "
                    "<preserveFixedJoint>true</preserveFixedJoint> keeps it",
                )

    # Links that remain -----------------------------------------------------------------------------------------------

    def kept_links(self) -> Iterator[tuple[RobotLink, GzPose]]:
        """(link, pose in the model) of all that remain: not the world, and none without mass nor what is behind it."""
        if self.root is None:
            return
        waiting = [(self.root, GzPose())]
        while waiting:
            link, pose = waiting.pop()
            if link is not self.root or link.name != WORLD:
                if link.inertial is None or abs(link.inertial.mass) <= LIGHTEST:
                    self._warn_of_lost(link)
                    continue
                yield link, pose
            waiting += [(self.links[j.child], GzCoordPoseAdd(j.pose, pose)) for j in reversed(link.joints)]

    def _warn_of_lost(self, link: RobotLink) -> None:
        behind = [one.name for one in self.walk(link)][1:]
        more = f", and with it {', '.join(behind[:5])}{' and more' if len(behind) > 5 else ''}" if behind else ""
        what = "there is no <inertial>" if link.inertial is None else "its mass is zero"
        self.warn(link.xml, f"{what}, so link {link.name!r} is left out{more}, as Gazebo classic did")


def describes(material: etree._Element) -> bool:
    """Whether a `<material>` has more than a name."""
    return any(child_of(material, tag) is not None for tag in ("color", "texture"))


def value_of(xml: etree._Element) -> str:
    """The value of an element of `<gazebo>`: its attribute `value`, or its text."""
    return (xml.get("value") or xml.text or "").strip()


def _finite(text: str) -> tuple[float, ...]:
    """The numbers of a text; none if one of them is not finite, or no number."""
    try:
        values = tuple(map(float, text.split()))
    except ValueError:
        return ()
    return values if all(map(math.isfinite, values)) else ()


def _matrix(turn: GzQuatern) -> NDArray[np.float64]:
    return np.array([tuple(rotate(turn, axis)) for axis in np.eye(3)]).T


def _array(vector: GzVector) -> NDArray[np.float64]:
    return np.array(tuple(vector))
