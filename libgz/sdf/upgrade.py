"""Conversion to SDF 1.6 with absolute file names, so that elements of several documents can be joined in one."""

from __future__ import annotations

import contextlib
from pathlib import Path

from libgz.base.errors import NotFoundError
from libgz.base.files import is_file
from libgz.sdf.description import NEWEST
from libgz.sdf.element import Element
from libgz.sdf.paths import find_uri

__all__ = ["NEWEST", "suited", "upgraded"]

MOVED_UP = ("gravity", "magnetic_field")  # from <physics> to <world>
NAMES_OF_FILES = ("uri", "diffuse", "normal")  # of meshes, height maps and their textures, scripts of materials
IN_MODEL = "use_parent_model_frame"  # of an axis, up to 1.6
NOISES = {"rate": "angular_velocity", "accel": "linear_acceleration"}  # of an <imu>


def upgraded(element: Element, folder: Path | None = None) -> Element:
    """A copy of an element and all in it, with the meaning in SDF 1.6 that the original has in its own version.

    What was only created to be read, with its defaults, is left out.

    Args:
        element: the original.
        folder: of the file that will hold the copy: names of files in it stay relative.
    """
    copy = element.Clone()
    copy.prune()
    _make_absolute(copy, folder)
    for world in [copy] if copy.name == "world" else copy.find("world"):
        _move_up(world)
    for name in ("axis", "axis2"):
        for axis in copy.find(name):
            known = axis.description is None or IN_MODEL in axis.description.children
            if not known and not any(True for _ in axis.named(IN_MODEL)):
                _add(axis, IN_MODEL).Set(True)  # up to 1.4 axes are in the model's frame
    for imu in copy.find("imu"):
        _spread_noise(imu)
    _remove_frames(copy)
    return copy


def suited(element: Element, version: str) -> Element:
    """The same element in words of another version than 1.6, changed in place; `upgraded` has returned it.

    Args:
        element: with the meaning of SDF 1.6.
        version: of the document that will hold it.
    """
    for name in ("axis", "axis2") if version > NEWEST else ():
        for axis in element.find(name):
            own = next(axis.named(IN_MODEL), None)
            if own is not None:
                if own.Get(bool):
                    axis.child("xyz").set_attribute("expressed_in", "__model__")
                axis.RemoveChild(own)
    return element


def _remove_frames(element: Element) -> None:
    """Remove the frames: all that was relative to them was resolved when the document was read."""
    for child in list(element.children):
        if child.name == "frame" and child.HasAttribute("name"):
            element.RemoveChild(child)
        elif child.name != "plugin":
            _remove_frames(child)


def _make_absolute(element: Element, folder: Path | None) -> None:
    """Make the names of files absolute that are relative to the document's own folder."""
    for name in NAMES_OF_FILES:
        for found in element.find(name):
            text = found.Get(str).strip()
            if not text or not found.file or found.file.startswith("<"):
                continue
            home = Path(found.file).parent.resolve()
            if "://" in text:
                _set_beside(found, text, home)
            elif (folder is None or home != folder.resolve()) and is_file(home / text):
                found.Set(str(home / text))


def _set_beside(found: Element, uri: str, home: Path) -> None:
    """Make a URI absolute that is found only because its model or package is around the document."""
    try:
        find_uri(uri)
    except NotFoundError:
        with contextlib.suppress(NotFoundError):
            found.Set(str(find_uri(uri, home)))


def _add(parent: Element, name: str) -> Element:
    return parent.InsertElement(Element(name, file=parent.file, line=parent.line))


def _move_up(world: Element) -> None:
    described = world.description.children if world.description is not None else {}
    for physics in world.named("physics"):
        for name in MOVED_UP:
            old = next(physics.named(name), None)
            if name in described or old is None:
                continue
            physics.RemoveChild(old)
            if not world.HasElement(name):
                world.InsertElement(old)


def _spread_noise(imu: Element) -> None:
    """Replace one noise for all axes by one for each."""
    for noise in list(imu.named("noise")):
        imu.RemoveChild(noise)
        for old, new in NOISES.items():
            source = next(noise.named(old), None)
            if source is None:
                continue
            holder = _add(imu, new)
            for axis in "xyz":
                target = _add(_add(holder, axis), "noise")
                target.set_attribute("type", noise.Get(str, "type"))
                for value in source.children:
                    target.InsertElement(value.Clone())
