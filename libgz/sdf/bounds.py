"""Numbers of SDF files that a world cannot be simulated with: where they stand, and what is read in their place."""

from __future__ import annotations

import math

__all__ = ["LARGEST", "in_bounds"]

LARGEST = 1e9  # of coordinates [m] and other lists of numbers; SECURITY.md publishes it
_ABOVE_ZERO = math.ulp(0.0)
_SIZE, _FINITE, _POSITIVE = (0.0, LARGEST), (-LARGEST, LARGEST), (_ABOVE_ZERO, LARGEST)
# (parent, child) -> the least and the most that libgz can use. Gazebo classic has no bounds.
_BOUNDS: dict[tuple[str, str], tuple[float, float]] = {
    ("physics", "max_step_size"): _POSITIVE,
    ("solver", "sor"): _POSITIVE,
    ("solver", "iters"): (-math.inf, 100_000),
    ("constraints", "cfm"): _SIZE,
    ("constraints", "erp"): _SIZE,
    ("constraints", "contact_max_correcting_vel"): (0.0, math.inf),
    ("constraints", "contact_surface_layer"): _SIZE,
    ("velocity_decay", "linear"): (0.0, math.inf),
    ("velocity_decay", "angular"): (0.0, math.inf),
    ("sky", "time"): _FINITE,
    ("atmosphere", "temperature"): _SIZE,
    ("atmosphere", "temperature_gradient"): _FINITE,
    ("atmosphere", "pressure"): _SIZE,
    **{
        ("spherical_coordinates", key): _FINITE for key in ("latitude_deg", "longitude_deg", "elevation", "heading_deg")
    },
    ("waypoint", "time"): _SIZE,
    ("mimic", "multiplier"): _FINITE,
    ("mimic", "offset"): _FINITE,
    ("mimic", "reference"): _FINITE,
    ("grasp_check", "attach_steps"): _SIZE,
    ("grasp_check", "detach_steps"): _SIZE,
    ("grasp_check", "min_contact_count"): _SIZE,
}
# The same for the size of a number, whatever its sign.
_SIZES: dict[tuple[str, str], tuple[float, float]] = {
    ("joint", "thread_pitch"): (1e-5, 1e9),
    ("joint", "gearbox_ratio"): (1e-4, 1e4),
}
_NUMBERS = ("double", "int", "unsigned int")
_LISTS = ("vector3", "vector2d", "pose")


def in_bounds(parent: str, child: str, kind: str, text: str, default: str) -> str:
    """The text of a value within its bounds: of a number beyond them the default, of a list each number at its bound.

    Args:
        parent, child: tags.
        kind, default: of the child in the description of SDF.
        text: a value of that kind.
    """
    if kind in _LISTS:
        words = text.split()
        if all(-LARGEST <= float(word) <= LARGEST for word in words):
            return text
        return " ".join(repr(max(-LARGEST, min(LARGEST, float(word)))) for word in words)
    place = parent, child
    if kind not in _NUMBERS or (place not in _BOUNDS and place not in _SIZES):  # in a plugin the names may be others'
        return text
    value = float(text or 0.0)
    least, most = _BOUNDS.get(place, (-math.inf, math.inf))
    smallest, largest = _SIZES.get(place, (0.0, math.inf))
    return text if least <= value <= most and smallest <= abs(value) <= largest else default
