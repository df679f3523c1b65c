"""The parameters of a `<physics>`: where each stands, and what it sets."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from libgz.base.errors import Diagnostics, ParameterError
from libgz.ode.context import SOLVERS
from libgz.sdf.element import Element
from libgz.simulation.world import World

__all__ = ["PHYSICS", "apply_physics", "read_physics"]

FRICTION_MODELS = ("pyramid_model", "cone_model")


class Parameter(NamedTuple):
    """A parameter: the path of its element in `<physics>`, its type, and how a world's value is read and set."""

    path: tuple[str, ...]
    kind: type
    get: Callable[[World], Any]
    set: Callable[[World, Any], None]

    def element(self, physics: Element) -> Element:
        """Its element in a `<physics>`."""
        for name in self.path:
            physics = physics.child(name)
        return physics


def _update_rate(world: World) -> float:
    return world.simSpeed / world.engine.step_time


def _set_update_rate(world: World, value: float) -> None:
    if math.isnan(value):
        raise ParameterError("real_time_update_rate [Hz] is nan; it must be a number, 0 or less for no limit")
    world.simSpeed = value * world.engine.step_time if 0.0 < value < math.inf else 0.0


def _set_step_size(world: World, value: float) -> None:
    rate = _update_rate(world)
    world.engine.step_time = value
    _set_update_rate(world, rate)


def _set_contacts(world: World, value: int) -> None:
    world.engine.max_contacts = value


def _set_solver(world: World, value: str) -> None:
    world.engine.solver = value


def _set_friction_model(world: World, value: str) -> None:
    if value not in FRICTION_MODELS:
        raise ParameterError(f"friction_model is {value!r}; allowed are {' and '.join(FRICTION_MODELS)}")
    world.engine.cone = value == "cone_model"


def _set_exact_rest(world: World, value: bool) -> None:
    world.engine.exact_rest = value


def _set_explicit_gyroscopic(world: World, value: bool) -> None:
    world.engine.explicit_gyroscopic = value


def _set_iterations(world: World, value: int) -> None:
    world.engine.set_quick_step(value, world.engine.over_relaxation)


def _set_over_relaxation(world: World, value: float) -> None:
    world.engine.set_quick_step(world.engine.iterations, value)


def _set_erp(world: World, value: float) -> None:
    world.engine.set_constraints(value, world.engine.cfm, world.engine.correcting_velocity)


def _set_cfm(world: World, value: float) -> None:
    world.engine.set_constraints(world.engine.erp, value, world.engine.correcting_velocity)


def _set_correcting_velocity(world: World, value: float) -> None:
    world.engine.set_constraints(world.engine.erp, world.engine.cfm, value)


def _set_surface_layer(world: World, value: float) -> None:
    world.engine.surface_layer = value


_SOLVER = ("ode", "solver")
_CONSTRAINTS = ("ode", "constraints")

# In the order in which they are applied: the rate counts steps of the new size.
PHYSICS = {
    "max_step_size": Parameter(("max_step_size",), float, lambda world: world.engine.step_time, _set_step_size),
    "real_time_update_rate": Parameter(("real_time_update_rate",), float, _update_rate, _set_update_rate),
    "max_contacts": Parameter(("max_contacts",), int, lambda world: world.engine.max_contacts, _set_contacts),
    "solver_type": Parameter((*_SOLVER, "type"), str, lambda world: world.engine.solver, _set_solver),
    "iters": Parameter((*_SOLVER, "iters"), int, lambda world: world.engine.iterations, _set_iterations),
    "sor": Parameter((*_SOLVER, "sor"), float, lambda world: world.engine.over_relaxation, _set_over_relaxation),
    "friction_model": Parameter(
        (*_SOLVER, "friction_model"), str, lambda world: FRICTION_MODELS[world.engine.cone], _set_friction_model
    ),
    "exact_rest": Parameter((*_SOLVER, "exact_rest"), bool, lambda world: world.engine.exact_rest, _set_exact_rest),
    "explicit_gyroscopic": Parameter(
        (*_SOLVER, "explicit_gyroscopic"),
        bool,
        lambda world: world.engine.explicit_gyroscopic,
        _set_explicit_gyroscopic,
    ),
    "erp": Parameter((*_CONSTRAINTS, "erp"), float, lambda world: world.engine.erp, _set_erp),
    "cfm": Parameter((*_CONSTRAINTS, "cfm"), float, lambda world: world.engine.cfm, _set_cfm),
    "contact_max_correcting_vel": Parameter(
        (*_CONSTRAINTS, "contact_max_correcting_vel"),
        float,
        lambda world: world.engine.correcting_velocity,
        _set_correcting_velocity,
    ),
    "contact_surface_layer": Parameter(
        (*_CONSTRAINTS, "contact_surface_layer"), float, lambda world: world.engine.surface_layer, _set_surface_layer
    ),
}


def read_physics(physics: Element) -> dict[str, Any]:
    """The parameters of a `<physics>`, those that it does not give with their defaults."""
    found: dict[str, Any] = {}
    for key, parameter in PHYSICS.items():
        holder, (*path, name) = physics, parameter.path
        for part in path:
            holder = holder.child(part)
        found[key] = holder.Get(parameter.kind, name)
    found["solver_type"] = found["solver_type"] if found["solver_type"] in SOLVERS else "quick"
    if found["friction_model"] not in FRICTION_MODELS:
        found["friction_model"] = FRICTION_MODELS[0]
    return found


def apply_physics(world: World, physics: Element, diagnostics: Diagnostics) -> None:
    """Apply a `<physics>`, with an error for each value that is not allowed."""
    kind = physics.Get(str, "type")
    if kind != "ode":
        diagnostics.warn(physics, f"type {kind!r} is not supported; ODE is used instead")
    solver = physics.child("ode").child("solver")
    model = solver.Get(str, "friction_model") or FRICTION_MODELS[0]
    if model not in FRICTION_MODELS:
        diagnostics.warn(solver, f"friction_model {model!r} is not supported; {' and '.join(FRICTION_MODELS)} are")
    if solver.Get(int, "precon_iters") > 0:
        diagnostics.warn(solver, "precon_iters has no effect; the quick solver has no preconditioner")
    for key, value in read_physics(physics).items():
        parameter = PHYSICS[key]
        try:
            parameter.set(world, value)
        except ParameterError as error:
            diagnostics.failure(parameter.element(physics), error)
            continue
        used = parameter.get(world)
        if isinstance(value, int | float) and value < 0 and used != value:
            diagnostics.warn(parameter.element(physics), f"{value} is not allowed; {used} is used instead")
