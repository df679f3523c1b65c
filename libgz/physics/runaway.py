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

__all__ = ["mend", "tell"]

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
    names = [body.model.GetId()] if body.model is not None else []
    log.error(
        "body %s ran away and was halted: a force, gain or stiffness is too large or a mass too small for steps this "
        "long, or joints and contacts contradict each other",
        "::".join((*names, body.bodyName or "unnamed")),
    )
