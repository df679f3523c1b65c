"""Which islands are solved exactly, in Python: the same work as sort_islands and move in step.c.

Islands are bodies that joints and contacts connect.
"""

from __future__ import annotations

import math

from libgz.ode.context import StepContext
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.tables import Tables
from libgz.ode.types import ContactRule

__all__ = ["Islands", "is_calm"]

_EXACT_ROWS, _FAST_ROWS, _ROWS_OF_JOINT, _ROWS_OF_POINT = 150, 60, 6, 3
_CALM_SPEED = 0.1  # [m/s] and [rad/s]
_FALLING_STEPS = 2.0


def is_calm(context: StepContext, ode_: OdeLibrary, body: int) -> bool:
    """is_calm in step.c."""
    x, y, z = context.gravity
    calm = _CALM_SPEED + _FALLING_STEPS * context.step * math.sqrt(x * x + y * y + z * z)
    v, w = (get(body).contents for get in (ode_.dBodyGetLinearVel, ode_.dBodyGetAngularVel))
    square = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + (w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    return bool(square <= calm * calm)


class _Member:
    """A body, and what is known of its island if it is the root of that."""

    __slots__ = ("fast", "root", "rows", "touching")

    def __init__(self, fast: bool) -> None:
        self.root = self
        self.rows = 0
        self.fast = fast
        self.touching = False

    @property
    def iterated(self) -> bool:
        """Whether the island of this root is solved by iteration."""
        return self.rows > ((0 if self.touching else _FAST_ROWS) if self.fast else _EXACT_ROWS)

    def find(self) -> _Member:
        """The root."""
        member = self
        while member.root is not member:
            member = member.root
        return member


class Islands:
    """Moves a world by the exact solver, the quick one, or both."""

    def __init__(self, context: StepContext, tables: Tables) -> None:
        self._context, self._tables = context, tables
        self._ode: OdeLibrary = ode()

    def move(self, touches: list[tuple[int, int, int]]) -> int:
        """Move everything; 0 when ODE ran out of memory."""
        context, ode_ = self._context, self._ode
        exact, quick = not context.quick, bool(context.quick)
        both: tuple[list[int], list[int]] = [], []  # bodies that are solved exactly, and by iteration
        if context.exact_rest and context.quick and context.contact_rule == ContactRule.CLASSIC:
            exact, quick, both = self._sort(touches)
        if not quick:
            return int(ode_.dWorldStep(context.world, context.step))
        if not exact:
            return int(ode_.dWorldQuickStep(context.world, context.step))
        aside = self._set_aside(both[1])
        done = ode_.dWorldStep(context.world, context.step)
        self._bring_back(aside)
        aside = self._set_aside(both[0])
        done = ode_.dWorldQuickStep(context.world, context.step) and done
        self._bring_back(aside)
        return int(done)

    def _sort(self, touches: list[tuple[int, int, int]]) -> tuple[bool, bool, tuple[list[int], list[int]]]:
        """Whether bodies that are awake are solved exactly, and by iteration; all bodies of either kind."""
        context, ode_, tables = self._context, self._ode, self._tables
        members = {}
        for body in tables.bodies.ids[: context.body_count].tolist():
            if body:
                members[body] = _Member(not is_calm(context, ode_, body))
        for joint in tables.joints.ids[: context.joint_count].tolist():
            if joint:
                one, two = (ode_.dJointGetBody(joint, k) or 0 for k in (0, 1))
                _connect(members.get(one), members.get(two), _ROWS_OF_JOINT, touching=False)
        for one, two, count in touches:
            _connect(members.get(one), members.get(two), _ROWS_OF_POINT * count, touching=True)
        exact = quick = False
        both: tuple[list[int], list[int]] = [], []
        for body, member in members.items():
            root = member.find()
            iterated = root.iterated
            both[iterated].append(body)
            if root.rows and ode_.dBodyIsEnabled(body):
                exact, quick = exact or not iterated, quick or iterated
        return exact or not quick, quick, both

    def _set_aside(self, bodies: list[int]) -> list[int]:
        """Disable those that are awake; returns them."""
        aside = [body for body in bodies if self._ode.dBodyIsEnabled(body)]
        for body in aside:
            self._ode.dBodyDisable(body)
        return aside

    def _bring_back(self, bodies: list[int]) -> None:
        """bring_back in step.c."""
        ode_ = self._ode
        for body in bodies:
            if not ode_.dBodyGetAutoDisableFlag(body):
                ode_.dBodyEnable(body)
                continue
            steps, time = ode_.dBodyGetAutoDisableSteps(body), ode_.dBodyGetAutoDisableTime(body)
            ode_.dBodySetAutoDisableFlag(body, 0)  # which enables the body
            ode_.dBodySetAutoDisableFlag(body, 1)
            ode_.dBodySetAutoDisableSteps(body, steps)
            ode_.dBodySetAutoDisableTime(body, time)


def _connect(one: _Member | None, two: _Member | None, rows: int, *, touching: bool) -> None:
    """connect in step.c."""
    one, two = one or two, two if one else None
    if one is None:
        return
    one = one.find()
    one.rows += rows
    one.touching = one.touching or touching
    if two is None:
        return
    two = two.find()
    if two is not one:
        two.root = one
        one.rows += two.rows
        one.fast = one.fast or two.fast
        one.touching = one.touching or two.touching
