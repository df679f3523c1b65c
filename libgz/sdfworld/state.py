"""The `<state>` of an SDF world: applied to the world when it is loaded."""

from __future__ import annotations

from libgz.base.errors import Diagnostics, NotFoundError
from libgz.physics.body import Body
from libgz.sdf.element import Element
from libgz.sdf.state import SdfState
from libgz.sdf.xml import parse_document
from libgz.simulation.entity import Entity
from libgz.simulation.world import World

__all__ = ["apply_state"]


def apply_state(world: World, element: Element, diagnostics: Diagnostics) -> None:
    """Set the sim time, and the poses and velocities of models, links and lights; remove the deleted models.

    A name that the world does not have is a warning. Insertions are built by the caller.

    Raises:
        ParameterError: a number is invalid.
    """
    text = element.ToString().encode()  # names with prefixes are read without those declarations, as in the file
    state = SdfState.parse(parse_document(text, element.file, Diagnostics()))
    if element.HasElement("sim_time"):
        world.set_sim_time(state.sim_time)
    parts = _Parts(world, element, diagnostics)
    for name, pose in state.model_poses.items():
        model = parts.model(name)
        if model is not None:
            world.SetModelPose(model, pose)
    for name, pose in state.poses.items():
        body, light = (parts.link(name), None) if "::" in name else (None, parts.model(name))
        if body is not None:
            body.SetPose(pose)
        elif light is not None:
            world.SetModelPose(light, pose)
    for name, (linear, angular) in state.velocities.items():
        body = parts.link(name)
        if body is not None:
            body.SetLinearVel(linear)
            body.SetAngularVel(angular)
    for name in state.deletions:
        deleted = parts.entities.pop(name, None)
        if deleted is not None:
            world.DeleteModel(deleted)


class _Parts:
    """Models, lights and links of a world by scoped name; an unknown name is a warning, added once."""

    def __init__(self, world: World, state: Element, diagnostics: Diagnostics) -> None:
        self._world, self._state, self._diagnostics = world, state, diagnostics
        self.entities = {entity.GetId(): entity for entity in reversed(world.entities)}  # the first ones of a name
        self._models: dict[str, Entity | None] = {}
        self._links: dict[str, Body | None] = {}

    def model(self, name: str) -> Entity | None:
        """Return a model or light; None if there is none."""
        if name not in self._models:
            try:
                self._models[name] = self.entities.get(name) or self._world.model(name)
            except NotFoundError as error:
                self._models[name] = None
                self._diagnostics.warn(self._state, str(error))
        return self._models[name]

    def link(self, name: str) -> Body | None:
        """Return a link; None if there is none."""
        if name not in self._links:
            owner, _, link = name.rpartition("::")
            model = self.model(owner)
            try:
                self._links[name] = model.GetBody(link) if model is not None else None
            except NotFoundError as error:
                self._links[name] = None
                self._diagnostics.warn(self._state, str(error))
        return self._links[name]
