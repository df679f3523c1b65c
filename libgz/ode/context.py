"""What the step works on."""

from __future__ import annotations

import ctypes
import sys
from ctypes import c_double, c_int64, c_uint64, c_void_p
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "CONTACT",
    "MAX_CONTACTS",
    "MOST_CONTACTS",
    "NO_HIT",
    "SOLVERS",
    "STEP_NEEDS_RECOVERY",
    "Publication",
    "RayScan",
    "StepContext",
]

SOLVERS = ("world", "quick", "tree")  # ODE's exact and iterative ones, and tree.c
MAX_CONTACTS = 10  # of a pair of geoms
MOST_CONTACTS = 250  # of a pair of geoms under the classic rule, which keeps the deepest of them
NO_HIT = sys.float_info.max  # [m], the range of a ray that hits nothing
_VECTOR = (np.float64, (3,))
# A contact point of a step: rows of its geoms; where it is [m], the unit normal, which points into the first geom, how
# deep it is [m]; force [N] and torque about the centre of mass [N m] on the body of either geom. All global.
CONTACT = np.dtype(
    [
        ("geom1", np.int64),
        ("geom2", np.int64),
        ("position", *_VECTOR),
        ("normal", *_VECTOR),
        ("depth", np.float64),
        ("force1", *_VECTOR),
        ("torque1", *_VECTOR),
        ("force2", *_VECTOR),
        ("torque2", *_VECTOR),
    ]
)


class StepContext(ctypes.Structure):
    """What the step works on; mirrors `context` in step.h, where the fields are explained."""

    _fields_ = [
        ("world", c_void_p),
        ("space", c_void_p),
        ("contacts", c_void_p),
        ("ray", c_void_p),
        ("probe", c_void_p),
        ("stand_in", c_void_p),
        ("no_cylinder_pairs", c_int64),
        ("step", c_double),
        ("solver", c_int64),
        ("contact_rule", c_int64),
        ("count_turns", c_int64),
        ("seed", c_uint64),
        ("steps", c_int64),
        ("contact_count", c_int64),
        ("max_contacts", c_int64),
        ("cone", c_int64),
        ("gravity", c_double * 3),
        ("record_contacts", c_int64),
        ("record_count", c_int64),
        ("record_capacity", c_int64),
        ("records", c_void_p),
        ("pending", c_void_p),
        ("surface", c_void_p),
        ("owner", c_void_p),
        ("body_count", c_int64),
        ("bodies", c_void_p),
        ("com", c_void_p),
        ("body_state", c_void_p),
        ("record_motion", c_int64),
        ("body_motion", c_void_p),
        ("joint_count", c_int64),
        ("joints", c_void_p),
        ("joint_types", c_void_p),
        ("joint_state", c_void_p),
        ("springs", c_void_p),
        ("reset_row", c_int64),
        ("abandoned", c_int64),
        ("max_distance", c_double),
        ("own_memory", c_int64),
        ("diverged", c_int64),
        ("collision_failed", c_int64),
        ("failed_rows", c_int64 * 2),
        ("exact_rest", c_int64),
        ("touch_count", c_int64),
        ("touch_capacity", c_int64),
        ("touches", c_void_p),
        ("overlap_count", c_int64),
        ("overlap_capacity", c_int64),
        ("overlaps", c_void_p),
        ("parted", c_int64),
        ("resting", c_int64),
        ("next_checked", c_int64),
        ("point_count", c_int64),
        ("point_capacity", c_int64),
        ("points", c_void_p),
        ("earlier_count", c_int64),
        ("earlier_capacity", c_int64),
        ("earlier", c_void_p),
        ("held_count", c_int64),
        ("held", c_void_p),
        ("work", c_void_p),
        ("alone", c_int64),
        ("iterating", c_int64),
        ("explicit_gyroscopic", c_int64),
        ("field_count", c_int64),
        ("fields", c_void_p),
    ]


class HeightField(ctypes.Structure):
    """A height field that rays read; mirrors `height_field` in step.h."""

    _fields_ = [
        ("geom", c_void_p),
        ("heights", c_void_p),
        ("rows", c_int64),
        ("columns", c_int64),
        ("width", c_double),
        ("length", c_double),
    ]


class HeldEffort(ctypes.Structure):
    """An effort on a hinge or slider that acts in each step; mirrors `held_effort` in step.h."""

    _fields_ = [
        ("joint", c_void_p),
        ("type", c_int64),
        ("effort", c_double),
        ("wakes", c_int64),
    ]


class Publication(ctypes.Structure):
    """Where states are published for other processes; mirrors `publication` in motion.c, which explains the fields."""

    _fields_ = [
        ("target", c_void_p),
        ("header", c_void_p),
        ("header_size", c_int64),
        ("sequence_offset", c_int64),
        ("bodies_offset", c_int64),
        ("joints_offset", c_int64),
        ("fixed_offset", c_int64),
        ("fixed", c_void_p),
        ("fixed_size", c_int64),
        ("stale", c_int64),
        ("copied", c_int64),
    ]


STEP_NEEDS_RECOVERY = 2  # what a step returns besides 1 and 0; the context holds what happened


class RayScan(NamedTuple):
    """Rays of a sensor, and what they hit.

    Attributes:
        frame: position [m] and quaternion of the sensor, shape (7,), global.
        rays: start [m], unit direction and length [m] of each ray in that frame, shape (n, 7).
        owner: number of the body whose geoms the rays do not see; 0 for none.
        ranges: out, distance from the start [m], shape (n,); the largest float where nothing was hit.
        rows: out, row of the geom that was hit, shape (n,); -1 for none.
    """

    frame: NDArray[np.float64]
    rays: NDArray[np.float64]
    owner: int
    ranges: NDArray[np.float64]
    rows: NDArray[np.int64]
