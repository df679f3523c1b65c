"""Runaway bodies: what is done about them, before an assertion of ODE's ends the process."""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING

from libgz.geometry import GzPose, GzQuaternIdent, GzVector
from libgz.physics.check import LARGEST

if TYPE_CHECKING:
    from collections.abc import Iterable

    from libgz.physics.body import Body
    from libgz.physics.engine import Engine

__all__ = ["mend", "tell", "tell_baffled", "tell_gave_up"]

log = logging.getLogger("libgz.physics")

STILL = (0.0, 0.0, 0.0)


def mend(bodies: Iterable[Body], gave_up: bool) -> None:
    """Halt bodies that a step has brought, or made so fast, where no robot comes.

    Args:
        bodies: all of a world.
        gave_up: whether the step was given up, and so left forces behind that were to act in it only.
    """
    for body in bodies:
        if gave_up:
            _drop_forces(body)
        pose = body.GetPose()
        place, turn = pose.pos, pose.rot
        speeds = *body.GetLinearVel(), *body.GetAngularRate()
        if all(abs(number) <= 2.0 * LARGEST for number in (*place, *body.GetCoMPose().pos, *turn, *speeds)):
            continue
        tell(body)
        _drop_forces(body)
        body.SetLinearVel(STILL)
        body.SetAngularVel(STILL)
        sane = all(map(math.isfinite, turn)) and any(turn)
        edge = GzVector(*(_inside(number) for number in place))
        body.SetPose(GzPose(edge, turn if sane else GzQuaternIdent()))


def _inside(number: float) -> float:
    return max(-LARGEST, min(LARGEST, number)) if math.isfinite(number) else 0.0


def _drop_forces(body: Body) -> None:
    body.SetForce(STILL)
    body.SetTorque(*STILL)


def tell(body: Body) -> None:
    """Tell of a body that ran away and was halted, the first time."""
    if body.ran_away:
        return
    body.ran_away = True
    log.error(
        "body %s ran away and was halted: a force, gain or stiffness is too large or a mass too small for steps this "
        "long, or joints and contacts contradict each other",
        _name(body),
    )


def _name(body: Body) -> str:
    names = [body.model.GetId()] if body.model is not None else []
    return "::".join((*names, body.bodyName or "unnamed"))


def tell_gave_up(engine: Engine) -> None:
    """Tell that ODE gave a step up, the first time."""
    if not engine.gave_up:
        engine.gave_up = True
        log.error(
            "step %d was given up, and nothing moved in it: ODE cannot solve it; joints and contacts contradict each "
            "other, or numbers are too large",
            engine.steps,
        )


def tell_baffled(engine: Engine, rows: tuple[int, ...]) -> None:
    """Tell of a pair of geoms for which ODE failed, the first time; row -1 is a ray."""
    if rows in engine.baffling:
        return
    engine.baffling.add(rows)
    geoms = [engine.geoms.get(row) for row in rows]
    names = [f"{type(geom).__name__} of {_name(geom.body)}" if geom else "a ray" for geom in geoms]
    log.error(
        "ODE could not tell where %s meets %s: for this step it meets nothing; is a size extreme, or a mesh broken?",
        *names,
    )
