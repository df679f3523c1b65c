"""Contacts of bodies at rest, solved at once, in Python: the same work as resting.c, operation by operation."""

from __future__ import annotations

import math

__all__ = ["DIRECTIONS", "MOTIONS", "RestingBody", "RestingPoint", "solve_resting"]

MOTIONS, DIRECTIONS = 6, 3  # linear and angular; normal, and two of friction
_SELECTIONS, _MOST_SELECTIONS, _PASSES, _SETTLED = 12, 100, 8, 1e-8  # -, -, -, [m/s]
_UNCHANGED, _TAKEN, _LEFT_OUT = range(3)

_Line = tuple[list[float], int]  # of a matrix: numbers, and the column of the first of them


class RestingBody:
    """A body; the attributes are explained in resting.h.

    Args:
        mass: [kg].
        inertia: about the centre of mass, global [kg m^2].
        momentum: that it would have without contacts, linear [kg m/s] and angular [kg m^2/s].
        nearest: of the bodies that it touches, and itself, the number of the first one.
    """

    __slots__ = ("impulse", "inertia", "mass", "momentum", "nearest")

    def __init__(self, mass: float, inertia: list[list[float]], momentum: list[float], nearest: int) -> None:
        self.mass, self.inertia, self.momentum, self.nearest = mass, inertia, momentum, nearest
        self.impulse = [0.0] * MOTIONS


class RestingPoint:
    """A contact; the attributes are explained in resting.h.

    Args:
        sides: number of either body, or -1 for the world, and the velocity at the point per motion of it, by direction.
        aim: velocity at which the bodies are to separate [m/s].
        softness: velocity that an impulse leaves uncorrected, by direction [1/kg].
        slack: what is added to it, and corrected by repetition [1/kg].
        mu: friction coefficients.
    """

    __slots__ = ("active", "aim", "impulse", "mu", "sides", "slack", "weight")

    def __init__(
        self,
        sides: list[tuple[int, list[list[float]]]],
        aim: float,
        softness: list[float],
        slack: list[float],
        mu: tuple[float, float],
    ) -> None:
        self.sides, self.aim, self.slack, self.mu = sides, aim, slack, mu
        self.active = True
        self.impulse = [0.0] * DIRECTIONS
        self.weight = [0.0 if k and not mu[k - 1] > 0.0 else 1.0 / (softness[k] + slack[k]) for k in range(DIRECTIONS)]

    def target(self, k: int) -> float:
        """Velocity that is to be reached in a direction, with the impulse that was found before [m/s]."""
        return (0.0 if k else self.aim) + self.slack[k] * self.impulse[k]

    def speed(self, k: int, solution: list[float]) -> float:
        """Velocity in a direction [m/s]."""
        total = 0.0
        for body, rows in self.sides:
            if body >= 0:
                for a in range(MOTIONS):
                    total = total + rows[k][a] * solution[MOTIONS * body + a]
        return total


def solve_resting(bodies: list[RestingBody], points: list[RestingPoint]) -> bool:
    """Find the impulses of points and bodies; false if contacts slide."""
    for selection in range(_MOST_SELECTIONS):
        lines = _assemble(bodies, points)
        if not _factorize(lines):
            return False
        for _ in range(_PASSES):
            moved, solution = _repeat(lines, bodies, points)
            if moved <= _SETTLED:
                break
        else:
            return False
        changed = _select_points(points, solution)
        if changed == _LEFT_OUT and selection >= _SELECTIONS:
            return False
        if changed:
            continue
        if not _within_friction(points):
            return False
        _add_up(bodies, points)
        return True
    return False


def _assemble(bodies: list[RestingBody], points: list[RestingPoint]) -> list[_Line]:
    lines: list[_Line] = []
    for i, body in enumerate(bodies):
        first = MOTIONS * body.nearest
        for a in range(MOTIONS):
            line = [0.0] * (MOTIONS * i + a + 1 - first)
            if a < 3:
                line[-1] = body.mass
            else:
                line[-1 - (a - 3) :] = body.inertia[a - 3][: a - 2]
            lines.append((line, first))
    for point in points:
        if not point.active:
            continue
        (one, _), (two, _) = point.sides
        for side, number in enumerate((one, two)):
            if number >= 0:
                _add_block(lines, point, side, side)
        if one >= 0 and two >= 0:
            _add_block(lines, point, int(one < two), int(one > two))
    return lines


def _add_block(lines: list[_Line], point: RestingPoint, one: int, two: int) -> None:
    body, rows = point.sides[one]
    other, columns = point.sides[two]
    for a in range(MOTIONS):
        line, first = lines[MOTIONS * body + a]
        at = MOTIONS * other - first
        for k in range(DIRECTIONS):
            left = point.weight[k] * rows[k][a]
            for b in range(a + 1 if one == two else MOTIONS):
                line[at + b] = line[at + b] + left * columns[k][b]


def _factorize(lines: list[_Line]) -> bool:
    for i, (line, first) in enumerate(lines):
        for j in range(first, i):
            above, begin = lines[j]
            total = line[j - first]
            for k in range(max(first, begin), j):
                total = total - line[k - first] * above[k - begin]
            line[j - first] = total * above[j - begin]
        total = line[i - first]
        for k in range(first, i):
            total = total - line[k - first] * line[k - first]
        if not total > 0.0:
            return False
        line[i - first] = 1.0 / math.sqrt(total)
    return True


def _substitute(lines: list[_Line], solution: list[float]) -> None:
    for i, (line, first) in enumerate(lines):
        total = solution[i]
        for k in range(first, i):
            total = total - line[k - first] * solution[k]
        solution[i] = total * line[i - first]
    for i in range(len(lines) - 1, -1, -1):
        line, first = lines[i]
        solution[i] = solution[i] * line[i - first]
        for k in range(first, i):
            solution[k] = solution[k] - line[k - first] * solution[i]


def _repeat(lines: list[_Line], bodies: list[RestingBody], points: list[RestingPoint]) -> tuple[float, list[float]]:
    """One solution with the impulses that were found before; how much velocity the slack changed [m/s], and all."""
    solution = [value for body in bodies for value in body.momentum]
    for point in points:
        if not point.active:
            continue
        for k in range(DIRECTIONS):
            part = point.weight[k] * point.target(k)
            for body, rows in point.sides:
                if body >= 0:
                    for a in range(MOTIONS):
                        at = MOTIONS * body + a
                        solution[at] = solution[at] + rows[k][a] * part
    _substitute(lines, solution)
    moved = 0.0
    for point in points:
        if not point.active:
            continue
        for k in range(DIRECTIONS):
            impulse = point.weight[k] * (point.target(k) - point.speed(k, solution))
            change = point.slack[k] * math.fabs(impulse - point.impulse[k])
            point.impulse[k] = impulse
            if not change <= moved:
                moved = change
    return moved, solution


def _select_points(points: list[RestingPoint], solution: list[float]) -> int:
    """Leave out what pulls, and take back what bodies would enter."""
    changed = _UNCHANGED
    for point in points:
        active = point.impulse[0] >= 0.0 if point.active else point.speed(0, solution) < point.aim
        if active != point.active and changed != _LEFT_OUT:
            changed = _TAKEN if active else _LEFT_OUT
        point.active = active
        if not active:
            point.impulse = [0.0] * DIRECTIONS
    return changed


def _within_friction(points: list[RestingPoint]) -> bool:
    return not any(
        math.fabs(point.impulse[k + 1]) > point.mu[k] * point.impulse[0] for point in points for k in range(2)
    )


def _add_up(bodies: list[RestingBody], points: list[RestingPoint]) -> None:
    for point in points:
        for body, rows in point.sides:
            if body >= 0:
                total = bodies[body].impulse
                for k in range(DIRECTIONS):
                    for a in range(MOTIONS):
                        total[a] = total[a] + rows[k][a] * point.impulse[k]
