"""Loader: models out of the elements of a worldfile."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, cast

from libgz.errors import GazeboError, InterfaceError, NotFoundError, ParameterError, nearest
from libgz.geometry import GzPose
from libgz.legacy.factory import ModelFactory
from libgz.legacy.origin import to_world
from libgz.legacy.poses import Poses
from libgz.legacy.settings import is_settings
from libgz.legacy.world_joints import move_with_world_joints
from libgz.simulation.plugins import find_plugin, load_plugin, own_traceback
from libgz.transport.paths import check_id
from libgz.worldfile.spelling import NAMES_ONLY

if TYPE_CHECKING:
    from libgz.legacy.model import Model
    from libgz.physics.body import Body
    from libgz.simulation.world import World
    from libgz.worldfile.file import WorldFile
    from libgz.worldfile.node import WorldFileNode

__all__ = ["Loader"]

log = logging.getLogger("libgz.simulation")


class Loader(Poses):
    """Base of World: builds models."""

    factory: ModelFactory

    def adopt(self, model: Model) -> None:
        """Take a model in that is built."""
        raise NotImplementedError

    def visit(self, node: WorldFileNode) -> None:
        """Load the models of an element and of what is in it; a model inside a model is its child."""
        if node.GetNSPrefix() == "model":
            self.LoadModel(node)
            return
        self._note_slip(node)
        for child in node.children:
            self.visit(child)

    def _note_slip(self, node: WorldFileNode) -> None:
        """Warn of an element that does nothing, but has almost the name of one that does."""
        if node.parent is not None and node.name in node.parent.asked:
            return  # an attribute
        if node.prefix in ("param", "params") and not is_settings(node):
            node.warn("holds no settings of the world, and nothing in it counts; only <param:Global> does")
            _skip(node)
        elif node.prefix is None and self.factory.knows(node.name):
            node.warn(f"is not used; a model needs the prefix: <model:{node.name}>")
            _skip(node)

    def LoadModel(self, node: WorldFileNode, parent: Model | None = None) -> Model | None:
        """Build the model of an element, and those inside it; None if there is none to build.

        What is wrong becomes an error of the worldfile: an unknown model a warning, anything else an error.
        """
        try:
            model = self._new_model(node)
            if model is not None:
                self._load_model(model, node, parent)
        except GazeboError as error:
            node.error(str(error))
            model = None
        except Exception as error:
            log.debug("the Load that failed", exc_info=True)
            node.error(f"Load failed with\n{own_traceback(error)}")
            model = None
        if model is None:
            _skip(node, models=True)
            return None
        for child in node.children:
            if child.GetNSPrefix() == "model":
                self.LoadModel(child, model)
            else:
                self.visit(child)
        return model

    def _new_model(self, node: WorldFileNode) -> Model | None:
        """The model object of an element, its plugin loaded; None for an unknown class."""
        plugin = node.GetString("plugin")
        if plugin is not None:
            filename = node.file.filename
            path = find_plugin(plugin, filename)
            log.info("loading %s...", path)
            self.factory.register_plugin(load_plugin(path))
        model = self.factory.NewModel(cast("World", self), node.GetName())
        if model is not None and not hasattr(model, "modelSpaceId"):
            raise ParameterError(
                f"{type(model).__name__} must be a subclass of Model; its __init__, if any, must call "
                "super().__init__(world)"
            )
        if model is None:
            hint = NAMES_ONLY.get(node.name) or nearest(node.name, self.factory.names())
            hint = hint or "; `libgz models` lists those there are"
            node.warn(f"unknown model class, skipped with all that is in it{hint}")
        return model

    def _load_model(self, model: Model, node: WorldFileNode, parent: Model | None) -> None:
        """Steps 3 to 7 of loading one model: id, parent, Load, pose, weld."""
        model.node = node
        model.SetName(node.GetName())
        model.SetId((node.GetString("id", node.GetName()) or "").strip())
        _check_id(model, node)
        if parent is not None:
            model.SetParent(parent, _parent_body(node, parent))
        try:
            model.MasterLoad(cast("WorldFile", node.file), node)
            model.initPose = to_world(model, GzPose(node.GetPosition("xyz"), node.GetRotation("rpy")))
            move_with_world_joints(model, lambda: self.SetModelPose(model, model.initPose))
            model.Attach()
        except BaseException:
            model.Detach()
            model.close()
            raise
        if model.fixed:
            model.modelSpaceId.set_fixed()
        self.adopt(model)
        log.debug("loaded %s %r", model.GetName(), model.GetId())


def _check_id(model: Model, node: WorldFileNode) -> None:
    """An error if the model's interfaces cannot have its id."""
    try:
        for kind in model.interfaces:
            check_id(kind, model.GetId())
    except InterfaceError as error:
        (node.GetChild("id") or node).error(str(error))


def _parent_body(node: WorldFileNode, parent: Model) -> Body:
    """The body that an element names; if there is none, an error, and another body so that loading finds more."""
    try:
        return parent.GetBody((node.GetString("parentBody", "canonical") or "").strip())
    except NotFoundError as error:
        node.error(str(error))
        return parent.GetBody()


def _skip(node: WorldFileNode, models: bool = False) -> None:
    """Mark an element that is not built, and what is in it, so that none of it is called unused; models, too, if told.

    Models inside an element that is none are built all the same.
    """
    node.used = True
    for child in node.children:
        if models or child.prefix != "model":
            _skip(child, models)
