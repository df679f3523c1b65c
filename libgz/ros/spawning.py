"""Models for `spawn_sdf_model` and `spawn_urdf_model`: a text with the name, pose and namespace of the request."""

from __future__ import annotations

from libgz.base.errors import ParameterError
from libgz.classic.math import Pose3d
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile

__all__ = ["prepare_model", "root_tag"]

DECLARED = ("model", "light", "actor", "include")


def root_tag(text: str) -> str:
    """The name of the first element of a text; empty if there is none."""
    at = 0
    while (at := text.find("<", at)) >= 0:
        if text.startswith("<!--", at):
            at = text.find("-->", at)
        elif text[at + 1 : at + 2] in ("?", "!"):
            at = text.find(">", at)
        else:
            word = text[at + 1 :].split(None, 1)[0] if text[at + 1 :].split(None, 1) else ""
            return word.split(">")[0].split("/")[0]
        if at < 0:
            return ""
        at += 1
    return ""


def prepare_model(text: str, name: str, pose: Pose3d, namespace: str) -> Element:
    """The document of a model or light, renamed, moved, and with a namespace for each plugin that has none.

    Args:
        text: SDF or URDF.
        name: its new name.
        pose: that of the frame in which the text's pose is, in the world.
        namespace: of the plugins; empty to leave them as they are.

    Raises:
        ParameterError: there is no model in the text, or more than one.
        WorldFileError: it has errors.
    """
    file = SdfFile.from_string(text)
    file.diagnostics.raise_errors()
    holder = next(file.root.named("world"), file.root)
    entities = [one for one in holder.children if one.name in DECLARED]
    if len(entities) != 1:
        raise ParameterError(f"the text has {len(entities)} models; one can be spawned at a time")
    entity = entities[0]
    entity.set_attribute("name", name)
    own = entity.Get(Pose3d, "pose")
    entity.child("pose").Set(own + pose)
    if namespace:
        _add_namespace(entity, namespace)
    return entity


def _add_namespace(element: Element, namespace: str) -> None:
    """Give each plugin in an element a namespace, unless it has one."""
    for child in element.children:
        if child.name == "plugin" and not child.HasElement("robotNamespace"):
            child.AddElement("robotNamespace").Set(namespace)
        else:
            _add_namespace(child, namespace)
