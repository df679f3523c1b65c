"""Changes: models that join a running world, and models that leave it."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from libgz.errors import WorldFileError
from libgz.simulation.plugins import own_traceback
from libgz.worldfile.file import WorldFile

if TYPE_CHECKING:
    from libgz.legacy.model import Model
    from libgz.simulation.world import World

__all__ = ["delete_models", "end_model", "family_of", "insert_models", "unlock_interfaces"]

log = logging.getLogger("libgz.simulation")

PREFIXES = ("gz", "model", "param", "params", "window", "models")  # roots of files declare these


def insert_models(world: World, text: str, label: str) -> list[Model]:
    """Build the models of a text and make their interfaces; all of them, or none.

    Raises:
        WorldFileError: the text is not well-formed, has errors, or holds no model.
        PluginError: an Init failed.
    """
    file = WorldFile()
    file.LoadString(_with_root(text), label)
    if world.file is not None:
        file.filename = world.file.filename  # files that the text names lie beside the world
    count, served = len(world.models), set(world.gz_server.interfaces)
    try:
        root = file.GetRootNode()
        world.visit(root)
        root.note_unused()
        file.diagnostics.raise_errors()
        added = world.models[count:]
        if not added:
            reasons = "\n".join(map(str, file.diagnostics.warnings))
            raise WorldFileError(reasons or f"{label}: there is no <model:...> element in it")
        world.init_models(added, file)
    except BaseException:
        delete_models(world, world.models[count:])
        for key in set(world.gz_server.interfaces) - served:
            world.gz_server.interfaces[key].destroy()
        raise
    for warning in file.diagnostics.warnings:
        log.warning("%s", warning)
    return added


def _with_root(text: str) -> str:
    """A lone model element in a root that declares its prefixes; a text that declares them itself as it is."""
    if "xmlns:" in text:
        return text
    text = text.lstrip()
    if text.startswith("<?xml"):
        text = text.partition("?>")[2]
    declared = " ".join(f"xmlns:{prefix}='{prefix}'" for prefix in PREFIXES)
    return f"<gz:world {declared}>{text}</gz:world>"


def family_of(model: Model) -> list[Model]:
    """A model and all that is attached to it, parents first."""
    return [model, *(relative for child in model.children for relative in family_of(child))]


def delete_models(world: World, models: list[Model]) -> None:
    """Let models go: their interfaces, then their bodies and joints. Those that are gone already are passed over."""
    leaving = [model for model in models if model in world.models]
    for model in leaving:
        _call_fini(model, logging.DEBUG)  # its Init may have failed
        _destroy_interfaces(world, model)
    world.forget(leaving)
    for model in reversed(leaving):
        model.Detach()
        model.close()


def end_model(model: Model) -> None:
    """Call `Fini` at the end of a world; not of a model whose `Init` the failing start of the world never reached."""
    if model.node is not None and model.initialized is None:
        return
    _call_fini(model, logging.DEBUG if model.initialized is False else logging.ERROR)


def _call_fini(model: Model, level: int) -> None:
    """Let a model end; that it failed is told at a level of logging."""
    try:
        model.Fini()
    except Exception as error:  # noqa: BLE001 - a plugin's; the others must still end
        log.log(level, "Fini of model %r failed with\n%s", model.GetId(), own_traceback(error))


def unlock_interfaces(world: World, model: Model) -> None:
    """Give back the locks that a model may hold whose Update failed: clients wait for them without end."""
    for interface in world.gz_server.interfaces.values():
        if interface.model_id == model.GetIntId():
            interface.unlock()


def _destroy_interfaces(world: World, model: Model) -> None:
    """Take down what a Fini forgot."""
    for interface in list(world.gz_server.interfaces.values()):
        if interface.model_id == model.GetIntId():
            interface.destroy()
