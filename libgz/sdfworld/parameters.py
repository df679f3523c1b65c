"""The parameters of SDF joints, by their classic keys, as ODE's numbers."""

from __future__ import annotations

from libgz.ode.types import (
    dParamBounce,
    dParamCFM,
    dParamERP,
    dParamFMax,
    dParamFudgeFactor,
    dParamHiStop,
    dParamLoStop,
    dParamStopCFM,
    dParamStopERP,
    dParamSuspensionCFM,
    dParamSuspensionERP,
    dParamVel,
)
from libgz.physics.couplings import PistonJoint, TieJoint
from libgz.physics.joint import BallJoint, FixedJoint, Joint
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint

__all__ = ["PARAMETERS", "ode_number"]

PARAMETERS = {
    "fudge_factor": dParamFudgeFactor,
    "suspension_erp": dParamSuspensionERP,
    "suspension_cfm": dParamSuspensionCFM,
    "stop_erp": dParamStopERP,
    "stop_cfm": dParamStopCFM,
    "erp": dParamERP,
    "cfm": dParamCFM,
    "fmax": dParamFMax,
    "vel": dParamVel,
    "hi_stop": dParamHiStop,
    "lo_stop": dParamLoStop,
    "bounce": dParamBounce,
}
SECOND = 0x100  # from the parameters of ODE's first axis to those of its second


def ode_number(joint: Joint | None, key: str, index: int) -> int | None:
    """ODE's number of a parameter of an axis; None where the joint has no such parameter."""
    base = PARAMETERS.get(key)
    if base is None or isinstance(joint, TieJoint):
        return None
    if isinstance(joint, BallJoint | FixedJoint):
        return base if key in ("erp", "cfm") and index == 0 else None
    if key.startswith("suspension"):
        return base
    if isinstance(joint, UniversalJoint | PistonJoint):
        # Axis 1 of ODE's universal is that of the child, group 1 of its piston the sliding.
        return base + SECOND * (1 - index) if index in (0, 1) else None
    if isinstance(joint, Hinge2Joint):
        return base + SECOND * index if index in (0, 1) else None
    return base if index == 0 else None
