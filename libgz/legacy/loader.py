"""ModelLoader: builds models from the elements of a worldfile."""

from __future__ import annotations

import logging
from collections.abc import Callable
from weakref import WeakKeyDictionary, WeakSet

from libgz.base.errors import (
    USER_ERRORS,
    GazeboError,
    InterfaceError,
    NotFoundError,
    ParameterError,
    nearest,
    pass_interrupt,
)
from libgz.base.geometry import GzCoordPoseSub, GzPose
from libgz.base.trust import UntrustedError, check_trusted
from libgz.legacy.factory import ModelFactory
from libgz.legacy.model import Model
from libgz.legacy.origin import to_world
from libgz.legacy.plugin_search import find_plugin, load
from libgz.legacy.settings import is_settings
from libgz.legacy.world_joints import move_with_world_joints
from libgz.physics.body import Body
from libgz.simulation.journal import Origin
from libgz.simulation.plugins import own_place, own_traceback
from libgz.simulation.problems import note_threads_of
from libgz.simulation.world import World
from libgz.transport.paths import check_id
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode
from libgz.worldfile.spelling import NAMES_ONLY

__all__ = ["ModelLoader"]

log = logging.getLogger("libgz.simulation")


class ModelLoader:
    """Builds the models of a world.

    Args:
        world: where.
        factory: the model classes by name.
        origin_of: where a model of an element comes from.

    Attributes:
        built: the elements of all models that were built.
        places: of the bodies of models, in their frames when they were built [m].
    """

    def __init__(
        self, world: World, factory: ModelFactory, origin_of: Callable[[WorldFileNode], Origin | None]
    ) -> None:
        self.world = world
        self.factory = factory
        self.origin_of = origin_of
        self.built: WeakSet[WorldFileNode] = WeakSet()
        self.places: WeakKeyDictionary[Model, list[GzPose]] = WeakKeyDictionary()

    def visit(self, node: WorldFileNode) -> None:
        """Load the models of an element and of what is in it; a model inside a model is its child."""
        if node.GetNSPrefix() == "model":
            self.load_model(node)
            return
        self._warn_of_slip(node)
        for child in node.children:
            self.visit(child)

    def _warn_of_slip(self, node: WorldFileNode) -> None:
        """Warn of an element without effect that has almost the name of one with an effect."""
        if node.parent is not None and node.name in node.parent.asked:
            return  # an attribute
        if node.prefix in ("param", "params") and not is_settings(node):
            node.warn("has no effect: it holds no settings of the world; only <param:Global> does")
            _skip(node)
        elif node.prefix is None and self.factory.knows(node.name):
            node.warn(f"is not used; a model needs the prefix: <model:{node.name}>")
            _skip(node)

    def load_model(self, node: WorldFileNode, parent: Model | None = None) -> Model | None:
        """Build the model of an element, and those inside it; None if there is none to build.

        Problems are reported on the worldfile: an unknown model is a warning, anything else an error.
        """
        model = self.load_one(node, parent)
        if model is None:
            _skip(node, models=True)
            return None
        for child in node.children:
            if child.GetNSPrefix() == "model":
                self.load_model(child, model)
            else:
                self.visit(child)
        return model

    def load_one(self, node: WorldFileNode, parent: Model | None = None) -> Model | None:
        """Build the model of an element without those inside it; None if there is none to build."""
        model = None
        try:
            model = self._new_model(node)
            if model is not None:
                self._load_model(model, node, parent)
        except GazeboError as error:
            node.error(f"{error}{own_place(error)}")
            model = None
        except USER_ERRORS as error:
            pass_interrupt(error)
            log.debug("Load failed", exc_info=True)
            if isinstance(error, MemoryError | RecursionError) or (model is not None and _is_builtin(model)):
                node.file.diagnostics.failure(node.place, error)
            else:
                called = model.Load if model is not None else None
                node.error(f"Load failed with\n{own_traceback(error, called=called)}")
            model = None
        return model

    def load_again(self, old: Model) -> Model:
        """Build another model of a model's element and class name, without those inside it.

        Raises:
            GazeboError: that fails.
            Exception: the class's own code fails.
        """
        node = old.node
        if node is None:
            raise ParameterError("it was made by code, not from a file")
        errors = node.file.diagnostics.found
        before = dict(errors)
        try:
            model = self._made(node)
            if model is None:
                raise NotFoundError(f"there is no model class {node.GetName()!r} any more")
            parent = old.parent
            self._load_model(model, node, parent if isinstance(parent, Model) else None)
            found = [str(error) for error in node.file.diagnostics.errors if error not in before]
            if found:
                self.world.remove([model])
                raise ParameterError("\n".join(found))
        finally:
            errors.clear()
            errors.update(before)
        return model

    def _new_model(self, node: WorldFileNode) -> Model | None:
        """The model object of an element, its plugin loaded; None for an unknown class."""
        plugin, registered = node.GetString("plugin"), ""
        if plugin is not None:
            filename = node.file.filename
            try:
                check_trusted(f"plugin {plugin!r}")
            except UntrustedError as error:
                node.warn(f"{error}, and so is the model with all that is in it")
                return None
            path = find_plugin(plugin, filename)
            log.info("loading %s...", path)
            note_threads_of(path)
            loaded = load(path)
            self.factory.register_plugin(loaded)
            registered = ", ".join(name for name, _ in loaded.registered)
        model = self._made(node)
        if model is None:
            hint = NAMES_ONLY.get(node.name) or nearest(node.name, self.factory.names())
            if registered:
                hint = f"; its plugin has {registered}{hint}"
            hint = hint or "; `libgz models` lists those there are"
            node.warn(f"unknown model class, skipped with all that is in it{hint}")
        return model

    def _made(self, node: WorldFileNode) -> Model | None:
        """The model object of an element whose plugin is loaded; None for an unknown class."""
        model = self.factory.NewModel(self.world, node.GetName())
        if model is not None and not hasattr(model, "modelSpaceId"):
            raise ParameterError(
                f"{type(model).__name__} must be a subclass of Model; its __init__, if any, must call "
                "super().__init__(world)"
            )
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
            model.MasterLoad(WorldFile.of(node), node)
            frame = model.GetPose()
            self.places[model] = [GzCoordPoseSub(body.GetPose(), frame) for body in model.bodies]
            model.initPose = to_world(model, GzPose(node.GetPosition("xyz"), node.GetRotation("rpy")))
            move_with_world_joints(model, lambda: self.world.SetModelPose(model, model.initPose))
            model.Attach()
        except BaseException:
            model.Detach()
            model.close()
            raise
        if model.fixed:
            model.modelSpaceId.set_fixed()
        model.origin = self.origin_of(node)
        self.built.add(node)
        self.world.adopt(model)
        log.debug("loaded %s %r", model.GetName(), model.GetId())


def _is_builtin(model: Model) -> bool:
    """Whether a model is one of those of libgz."""
    return type(model).__module__.startswith("libgz.models.")


def _check_id(model: Model, node: WorldFileNode) -> None:
    """An error if the model's interfaces cannot have its id."""
    try:
        for kind in model.interfaces:
            check_id(kind, model.GetId())
    except InterfaceError as error:
        (node.GetChild("id") or node).error(str(error))


def _parent_body(node: WorldFileNode, parent: Model) -> Body:
    """The body that an element names; if there is none, an error, and the canonical body, so that loading continues."""
    try:
        return parent.GetBody((node.GetString("parentBody", "canonical") or "").strip())
    except NotFoundError as error:
        node.error(str(error))
        return parent.GetBody()


def _skip(node: WorldFileNode, models: bool = False) -> None:
    """Mark an element that is not built, and what is in it, so that none of it is reported as unused.

    Models inside an element that is not a model are built all the same, unless `models` is set.
    """
    node.used = True
    for child in node.children:
        if models or child.prefix != "model":
            _skip(child, models)
