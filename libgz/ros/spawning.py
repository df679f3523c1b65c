"""Models for `spawn_sdf_model` and `spawn_urdf_model`: a text with the name, pose and namespace of the request."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Future

from libgz.base.errors import GazeboError, ParameterError
from libgz.classic.math import Pose3d
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile

__all__ = ["failure", "prepare_model", "root_tag"]

log = logging.getLogger("libgz.ros")

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


def failure(inserted: Future[None]) -> str:
    """Why an insertion has failed; empty if it has not, or is still to be made."""
    error = inserted.exception() if inserted.done() else None
    return f"{error}" if isinstance(error, GazeboError) else f"{type(error).__name__}: {error}" if error else ""


def prepare_model(
    text: str, name: str, pose: Pose3d, namespace: str, free: Callable[[str], str] | None = None
) -> Element:
    """The document of a model or light, renamed, moved, and with a namespace for each plugin that has none.

    Of several it is the first model, as in the original.

    Args:
        text: SDF or URDF.
        name: its new name; empty to keep its own.
        pose: that of the frame in which the text's pose is, in the world.
        namespace: of the plugins; empty to leave them as they are.
        free: for ROS 2: makes its own name one that no other has; the namespace replaces those that plugins have.

    Raises:
        ParameterError: there is none in the text.
        WorldFileError: it has errors.
    """
    file = SdfFile.from_string(text)
    file.diagnostics.raise_errors()
    holder = next(file.root.named("world"), file.root)
    entities = sorted((one for one in holder.children if one.name in DECLARED), key=lambda one: one.name == "light")
    if not entities:
        raise ParameterError("the text has no model or light")
    entity = entities[0]
    if len(entities) > 1:
        log.warning("spawned is the first of %d in the text: %s", len(entities), entity.Get(str, "name"))
    if name:
        entity.set_attribute("name", name)
    elif free is not None:
        entity.set_attribute("name", free(entity.Get(str, "name")))
    own = entity.Get(Pose3d, "pose")
    entity.child("pose").Set(own + pose)
    if namespace:
        _add_namespace(entity, namespace, replaced=free is not None)
    return entity


def _add_namespace(element: Element, namespace: str, replaced: bool) -> None:
    """Give each plugin in an element a namespace; `replaced`: also those that have one."""
    for child in element.children:
        if child.name != "plugin":
            _add_namespace(child, namespace, replaced)
        elif replaced or not child.HasElement("robotNamespace"):
            space = "robotNamespace"
            (child.GetElement(space) if child.HasElement(space) else child.AddElement(space)).Set(namespace)
