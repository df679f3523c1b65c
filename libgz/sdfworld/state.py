"""The `<state>` of an SDF world: where things were when it was saved."""

from __future__ import annotations

from libgz.errors import Diagnostics, NotFoundError, ParameterError
from libgz.geometry import GzPose, GzVector
from libgz.physics.body import Body
from libgz.sdf.element import Element
from libgz.sdfworld.model import SdfModel
from libgz.simulation.entity import Entity
from libgz.simulation.world import World

__all__ = ["apply_state"]


def apply_state(world: World, state: Element, diagnostics: Diagnostics) -> None:
    """Apply the poses and velocities of a `<state>` to models, links and lights. Unknown names are warnings.

    Poses are global [m, rad]; velocities [m/s, rad/s]. The sim time is that of the state. Insertions are built by who
    loads the world.

    Raises:
        ParameterError: a number of it is none.
    """
    if state.HasElement("sim_time"):
        seconds, nanoseconds = _numbers(state, "sim_time", 2, "seconds and nanoseconds")
        world.set_sim_time(seconds + 1e-9 * nanoseconds)
    for element in state.named("model"):
        model = _find(world, element, diagnostics)
        if model is not None:
            _apply_model(world, model, element, diagnostics)
    for element in state.named("light"):
        light = _find(world, element, diagnostics)
        if light is not None and element.HasElement("pose"):
            world.SetModelPose(light, element.Get(GzPose, "pose"))
    for deletions in state.named("deletions"):
        for element in deletions.named("name"):
            name = element.Get(str)
            gone = next((model for model in world.entities if model.GetId() == name), None)
            if gone is not None:
                world.DeleteModel(gone)


def _find(world: World, element: Element, diagnostics: Diagnostics) -> Entity | None:
    name = element.Get(str, "name")
    try:
        found: Entity = world.model(name)
        return found
    except NotFoundError as error:
        diagnostics.warn(element, f"of <state>: {error}")
        return None


def _apply_model(world: World, model: Entity, element: Element, diagnostics: Diagnostics) -> None:
    if element.HasElement("pose"):
        world.SetModelPose(model, element.Get(GzPose, "pose"))
    for link in element.named("link"):
        name = link.Get(str, "name")
        try:
            body = model.GetBody(name)
        except NotFoundError as error:
            diagnostics.warn(link, f"of <state>: {error}")
            continue
        _apply_link(body, link)
    for inner in element.named("model"):
        nested = model.nested.get(inner.Get(str, "name")) if isinstance(model, SdfModel) else None
        if nested is not None:
            _apply_model(world, nested, inner, diagnostics)


def _apply_link(body: Body, link: Element) -> None:
    if link.HasElement("pose"):
        body.SetPose(link.Get(GzPose, "pose"))
    if link.HasElement("velocity"):
        numbers = _numbers(link, "velocity", 6, "6 numbers: [m/s], then [rad/s]")
        body.SetLinearVel(GzVector(*numbers[:3]))
        body.SetAngularVel(GzVector(*numbers[3:6]))


def _numbers(element: Element, key: str, count: int, allowed: str) -> list[float]:
    """Numbers of a child; what is missing at its end is 0."""
    text = element.Get(str, key)
    try:
        numbers = [float(word) for word in text.split()]
    except ValueError:
        place = element.child(key).where
        raise ParameterError(f"{place}: <{key}>: {text!r} is not allowed; it must be {allowed}") from None
    return (numbers + [0.0] * count)[:count]
