"""Vectors of three numbers in the Python form of the step: the operations of step.c, in its order."""

from __future__ import annotations

from collections.abc import Sequence

__all__ = ["cross", "dot", "to_global"]


def dot(a: Sequence[float], b: Sequence[float]) -> float:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """The vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def to_global(rotation: Sequence[float], local: Sequence[float]) -> list[float]:
    """A vector in the frame of a geom or body, whose rotation has the 12 numbers of ODE's matrix, as a global one."""
    return [
        rotation[4 * k] * local[0] + rotation[4 * k + 1] * local[1] + rotation[4 * k + 2] * local[2] for k in range(3)
    ]
