"""Frames: poses, axes and joints that a document describes relative to named frames are resolved when it is read.

Afterwards a pose is relative to what its element stands in, that of a joint to its child link, an axis is in its
joint's frame, and joints name links. This is what documents without named frames mean from the start.

Names are searched for in the model or world around an element: its links, joints, frames and nested models, and theirs
by scoped name (`arm::hand`). `__model__` is the model itself, `world` the world.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from libgz.base.errors import Diagnostics, ParameterError, nearest
from libgz.base.geometry import (
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzPose,
    GzQuaternInverse,
    GzVector,
    rotate,
)
from libgz.sdf.description import NEWEST, describe
from libgz.sdf.element import Element
from libgz.sdf.value import exact_pose, format_value

__all__ = ["add_frame", "merge", "prefix_names", "resolve_frames"]

NAMED = ("link", "frame", "joint", "model")  # what a name can mean; of several with one name the first kind
SCOPES = ("model", "world", "sdf")
REFERENCES = ("relative_to", "frame")  # of a pose; the second one up to 1.6
ENDS = ("parent", "child", "gearbox_reference_body")
NAMING = ("placement_frame", "expressed_in")  # attributes with names, beside those of poses
MODEL, WORLD = "__model__", "world"
IDENTITY = GzPose()


def resolve_frames(root: Element, diagnostics: Diagnostics) -> None:
    """Resolve all named frames of a document in place.

    Where a name is unknown, or means itself, what depends on it stays as it is written, with a warning, as in Gazebo
    classic.
    """
    if _needed(root):
        _Scope(root, None, diagnostics).resolve()


def _needed(element: Element, links: Collection[str] = ()) -> bool:
    """Whether an element or one in it may name a frame; `links` are the names that joints in it give their links."""
    inner = links
    if element.HasElement("joint"):
        inner = {WORLD, *(_attribute(link, "name") for link in element.named("link"))}
    for child in element.children:
        name = child.name
        if name == "plugin":
            continue
        refers = name == "pose" and bool(_attribute(child, *REFERENCES))
        refers |= name in ("frame", "model", "xyz") and any(map(child.HasAttribute, ("attached_to", *NAMING)))
        refers |= name in ENDS and element.name == "joint" and child.value.text not in links
        if refers or (child.children and _needed(child, inner)):
            return True
    return False


def prefix_names(model: Element) -> None:
    """Put a model's name before those of its links, joints and frames, wherever they stand in it, as Gazebo does."""
    own = model.Get(str, "name")
    parts = [part.Get(str, "name") for part in model.children if part.name in ("link", "joint", "frame")]
    names = {part: f"{own}::{part}" for part in parts}
    waiting = list(model.children)
    while waiting:
        element = waiting.pop()
        waiting += element.children
        for value in (element.value, *element.attributes.values()):
            if value is not None and value.given and value.text in names:
                value.SetFromString(names[value.text])


def add_frame(model: Element, name: str, attached_to: str = "") -> Element:
    """Add a frame to a model, whose own version may have none yet."""
    description = describe(NEWEST)["model"].children["frame"]
    frame = model.InsertElement(Element("frame", description, file=model.file, line=model.line))
    frame.set_attribute("name", name)
    if attached_to:
        frame.set_attribute("attached_to", attached_to)
    return frame


def merge(model: Element, parent: Element, diagnostics: Diagnostics, name: str = "") -> Element:
    """Move what is in an included model into the model that includes it; a frame takes the place of its own frame.

    Args:
        model: the included model.
        parent: the model around it.
        diagnostics: takes warnings.
        name: the frame's name; "" for one that no document names.

    Returns:
        the frame.
    """
    name = name or f"_merged__{model.Get(str, 'name')}{MODEL}"
    frame = add_frame(parent, name)
    scope = _Scope(model, None, diagnostics)
    pose, place = next(model.named("pose"), None), _attribute(model, "placement_frame")
    target = frame.child("pose")
    try:
        placed = scope.pose_of_name(place, model, "placement_frame") if place else IDENTITY
    except _Unresolved:
        placed = IDENTITY
    target.value.SetFromString(exact_pose(GzCoordPoseAdd(GzCoordPoseSub(IDENTITY, placed), _pose(model))))
    target.set_attribute("relative_to", (_reference(model) if pose is not None else "") or MODEL)
    for element in scope._inside(model):
        if element.name in ("link", "model", "frame") and element.parent is model:
            own = element.child("pose")
            if not _reference(element) and not _attribute(element, "attached_to"):
                own.set_attribute("relative_to", name)
                if element.name == "frame":
                    element.set_attribute("attached_to", name)
        for key in (*REFERENCES, "attached_to", "expressed_in"):
            if element.HasAttribute(key) and element.attributes[key].text == MODEL:
                element.set_attribute(key, name)
        in_model = next(element.named("use_parent_model_frame"), None)
        described = element.description.children if element.description is not None else {}
        if element.name in ("axis", "axis2") and (
            in_model.Get(bool) if in_model is not None else "use_parent_model_frame" not in described
        ):
            element.child("xyz").set_attribute("expressed_in", name)
            if in_model is not None:
                in_model.Set(False)
    for child in list(model.children):
        if child.name in ("link", "joint", "frame", "model", "gripper", "plugin"):
            model.RemoveChild(child)
            parent.InsertElement(child)
    return frame


def _reference(element: Element) -> str:
    """The frame that an element's pose names; empty for none."""
    pose = next(element.named("pose"), None)
    return _attribute(pose, *REFERENCES) if pose is not None else ""


def _attribute(element: Element, *keys: str) -> str:
    return next((element.attributes[key].text for key in keys if element.HasAttribute(key)), "").strip()


def _pose(element: Element) -> GzPose:
    """An element's pose as it is written; the identity, where it has none or one that is an error already."""
    try:
        return element.Get(GzPose, "pose") if element.HasElement("pose") else GzPose()
    except ParameterError:
        return GzPose()


class _Unresolved(ParameterError):
    """A name does not lead to a frame; the warning is added already."""


class _Scope:
    """The names in a model or world. Its poses are relative to it."""

    def __init__(self, holder: Element, outer: _Scope | None, diagnostics: Diagnostics) -> None:
        self.holder, self.outer, self.diagnostics = holder, outer, diagnostics
        self.names: dict[str, Element] = {}
        self.inner: dict[int, _Scope] = {}  # scopes of nested models
        self._poses: dict[int, GzPose] = {}
        self._open: dict[int, Element] = {}  # whose poses are being resolved, in order
        self._lost: set[int] = set()  # whose poses depend on names that lead nowhere; there is a warning already
        self._links: dict[str, str | None] = {}  # links that frames are fixed to, by the frames' names
        self._in_world: dict[str, bool] = {}  # whether frames are fixed to the world
        inside = list(self._inside(holder))
        for kind in NAMED:
            for element in inside:
                if element.name == kind and element.HasAttribute("name"):
                    self.names.setdefault(element.Get(str, "name"), element)
        for element in inside:
            if element.name in SCOPES:
                self.inner[id(element)] = _Scope(element, self, diagnostics)

    def _inside(self, element: Element) -> Iterator[Element]:
        """What stands in the scope, at any depth, but not in plugins, states and nested scopes."""
        for child in element.children:
            if child.name in ("plugin", "state"):
                continue
            yield child
            if child.name not in SCOPES:
                yield from self._inside(child)

    # Names -----------------------------------------------------------------------------------------------------------

    def find(self, name: str) -> tuple[_Scope, Element] | None:
        """The scope and the element of a name."""
        if name in self.names:
            return self, self.names[name]
        head, _, rest = name.partition("::")
        inner = self.inner.get(id(self.names.get(head))) if rest else None
        return inner.find(rest) if inner is not None else None

    def pose_of_name(self, name: str, where: Element, role: str) -> GzPose:
        """The pose of a named frame."""
        if name in ("", MODEL) or (name == WORLD and self.holder.name != "model"):
            return IDENTITY
        if name == WORLD and self.outer is not None:
            outside = self.outer.pose_of(self.holder)
            return GzCoordPoseSub(self.outer.pose_of_name(WORLD, where, role), outside)
        if name in self.names:
            return self.pose_of(self.names[name])
        head, _, rest = name.partition("::")
        inner = self.inner.get(id(self.names.get(head))) if rest else None
        if inner is not None:
            return GzCoordPoseAdd(inner.pose_of_name(rest, where, role), self.pose_of(self.names[head]))
        message = f"{role} names frame {name!r}, which there is not in {self._title()}{nearest(name, self.names)}"
        raise self._unresolved(where, message)

    def _unresolved(self, where: Element, message: str) -> _Unresolved:
        """The error of a name that leads nowhere, after a warning."""
        self.diagnostics.warn(where, f"{message}; what depends on it stays as it is written")
        return _Unresolved(message)

    def _title(self) -> str:
        return f"<{self.holder.name}> {self.holder.Get(str, 'name')!r}"

    # Poses -----------------------------------------------------------------------------------------------------------

    def pose_of(self, element: Element) -> GzPose:
        """The pose of an element that stands in the scope, at any depth."""
        if element is self.holder:
            return IDENTITY
        if id(element) in self._poses:
            return self._poses[id(element)]
        if id(element) in self._lost:
            raise _Unresolved
        if id(element) in self._open:
            names = [one.Get(str, "name") or f"<{one.name}>" for one in self._open.values()]
            circle = names[[*self._open].index(id(element)) :]
            raise self._unresolved(element, f"its pose is relative to itself: {' -> '.join([*circle, circle[0]])}")
        self._open[id(element)] = element
        try:
            name = _reference(element)
            place = next(element.named("pose"), element)
            base = self.pose_of_name(name, place, "it") if name else self.home_of(element)
            pose = self._placed(element, GzCoordPoseAdd(_pose(element), base))
        except _Unresolved:
            self._lost.add(id(element))
            raise
        finally:
            del self._open[id(element)]
        self._poses[id(element)] = pose
        return pose

    def home_of(self, element: Element) -> GzPose:
        """The pose that an element's pose is relative to where it names no frame."""
        if element.name == "joint":
            return self._pose_of_end(element, "child")
        if element.name == "frame":
            attached = _attribute(element, "attached_to")
            if attached:
                return self.pose_of_name(attached, element, "attached_to")
        above = element.parent
        while above is not None and above is not self.holder and not above.HasElement("pose") and above.name != "joint":
            above = above.parent
        return self.pose_of(above) if above is not None else IDENTITY

    def _pose_of_end(self, joint: Element, end: str) -> GzPose:
        name = joint.Get(str, end).strip()
        if name == WORLD:
            return self.pose_of_name(WORLD, joint, f"<{end}>")
        found = self.find(name) or self.find(self._own(name))
        if found is None:
            return IDENTITY  # a link elsewhere, or a joint that cannot be made
        return self.pose_of_name(name if self.find(name) else self._own(name), joint, f"<{end}>")

    def _own(self, name: str) -> str:
        """A name without that of the model itself before it."""
        return name.removeprefix(f"{self.holder.Get(str, 'name')}::")

    def _placed(self, element: Element, pose: GzPose) -> GzPose:
        """The pose of a model of which a frame in it, its placement frame, was given a pose."""
        name = _attribute(element, "placement_frame") if element.name == "model" else ""
        if not name:
            return pose
        place = self.inner[id(element)].pose_of_name(name, element, "placement_frame")
        return GzCoordPoseAdd(GzCoordPoseSub(IDENTITY, place), pose)

    # Links -----------------------------------------------------------------------------------------------------------

    def link_of(self, name: str, where: Element) -> str | None:
        """The scoped name of the link that a frame is fixed to; None where that is unknown or the world."""
        seen: dict[str, None] = {}  # in order
        link = self._link_behind(name, where, seen)
        self._links.update(dict.fromkeys(seen, link))  # else each frame of a chain would follow all of it
        return link

    def _link_behind(self, name: str, where: Element, seen: dict[str, None]) -> str | None:
        scope, way = self, ""
        while True:
            key = f"{way}{name}"
            if key in self._links:
                return self._links[key]
            if key in seen:
                message = f"frame {name!r} is attached to itself: {' -> '.join([*seen, key])}"
                self.diagnostics.warn(where, message)
                seen.clear()  # it is reported of each frame
                return None
            seen[key] = None
            if name in ("", MODEL):
                link = scope._canonical_link()
                return f"{way}{link}" if link is not None else None
            found = scope.find(name)
            if found is None:
                return None
            inner, element = found
            if inner is not scope:
                way += name.removesuffix(element.Get(str, "name"))
                scope = inner
            if element.name == "link":
                return f"{way}{element.Get(str, 'name')}"
            if element.name == "model":
                way, scope, name = f"{way}{element.Get(str, 'name')}::", scope.inner[id(element)], MODEL
            elif element.name == "joint":
                name = element.Get(str, "child").strip()
            else:
                name = _attribute(element, "attached_to") or scope._frame_of_holder(element)

    def _frame_of_holder(self, frame: Element) -> str:
        """What a frame without attached_to is fixed to."""
        above = frame.parent
        while above is not None and above is not self.holder and above.name not in NAMED:
            above = above.parent
        if above is None or above is self.holder:
            return MODEL if self.holder.name == "model" else WORLD
        return above.Get(str, "name")

    def _canonical_link(self) -> str | None:
        """The link that the model's frame is fixed to."""
        given = _attribute(self.holder, "canonical_link")
        if given and self.find(given) is not None:
            return given
        own = next(self.holder.named("link"), None) if self.holder.name == "model" else None
        if own is not None:
            return own.Get(str, "name")
        for model in self.holder.named("model") if self.holder.name == "model" else ():
            link = self.inner[id(model)]._canonical_link()
            if link is not None:
                return f"{model.Get(str, 'name')}::{link}"
        return None

    # Rewriting -------------------------------------------------------------------------------------------------------

    def resolve(self) -> None:
        """Rewrite what names frames, in this scope and those in it: first find all poses, for they depend on names."""
        changes = [*self._all_changes()]
        for element, text in changes:
            element.value.SetFromString(text)
        self._forget()

    def _all_changes(self) -> Iterator[tuple[Element, str]]:
        """(element, its new text)."""
        for element in self._inside(self.holder):
            try:
                if element.name == "joint":
                    yield from self._joint(element)
                    continue
                if element.name == "frame":
                    self._check_frame(element)
                if _reference(element) or _attribute(element, "placement_frame"):
                    yield (
                        self._pose_element(element),
                        exact_pose(GzCoordPoseSub(self.pose_of(element), self.home_of(element))),
                    )
            except _Unresolved:
                continue
        for inner in self.inner.values():
            yield from inner._all_changes()

    def _check_frame(self, frame: Element) -> None:
        """Warn of a frame that nothing may use."""
        self.pose_of(frame)
        attached = _attribute(frame, "attached_to")
        if attached:
            self.pose_of_name(attached, frame, "attached_to")
            self.link_of(frame.Get(str, "name"), frame)

    @staticmethod
    def _pose_element(element: Element) -> Element:
        return element.child("pose")

    def _joint(self, joint: Element) -> Iterator[tuple[Element, str]]:
        links = {}
        for end in ENDS:
            given = next(joint.named(end), None)
            name = given.Get(str).strip() if given is not None else ""
            found = self.find(name) if name else None
            if given is None or name == WORLD or (name != MODEL and (found is None or found[1].name == "link")):
                continue
            link = self.link_of(name, given)
            if link is not None:
                links[end] = link
                yield given, link
            elif self._ends_in_world(name):
                yield given, WORLD
        if "child" in links or _reference(joint):
            link = links.get("child", joint.Get(str, "child").strip())
            home = self.pose_of_name(link, joint, "<child>") if link != WORLD else self._pose_of_end(joint, "child")
            yield self._pose_element(joint), exact_pose(GzCoordPoseSub(self.pose_of(joint), home))
        for key in ("axis", "axis2"):
            for axis in joint.named(key):
                xyz = next(axis.named("xyz"), None)
                name = _attribute(xyz, "expressed_in") if xyz is not None else ""
                if xyz is not None and name:
                    frame = self.pose_of_name(name, xyz, "expressed_in")
                    inverse = GzQuaternInverse(self.pose_of(joint).rot)
                    yield xyz, format_value(rotate(inverse, rotate(frame.rot, xyz.Get(GzVector))))

    def _ends_in_world(self, name: str) -> bool:
        """Whether a frame is fixed to the world."""
        way: dict[str, None] = {}
        while name != WORLD and name not in self._in_world and name not in way:
            way[name] = None
            found = self.find(name)
            if found is None or found[1].name != "frame":
                break
            name = _attribute(found[1], "attached_to") or found[0]._frame_of_holder(found[1])
        ends = name == WORLD or self._in_world.get(name, False)
        self._in_world.update(dict.fromkeys(way, ends))
        return ends

    def _forget(self) -> None:
        """Remove the references that are resolved now; frames keep what they are attached to."""
        for element in self._inside(self.holder):
            element.placed |= bool(_attribute(element, "placement_frame"))
            for key in (*NAMING, *(REFERENCES if element.name == "pose" else ())):
                if element.HasAttribute(key):
                    element.attributes[key].SetFromString("")
                    element.attributes[key].given = False
        for inner in self.inner.values():
            inner._forget()
