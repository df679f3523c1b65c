"""Which islands are solved exactly, in Python: the same work as sort_islands and move in step.c.

Islands are bodies that joints and contacts connect.
"""

from __future__ import annotations

import ctypes
import math
from typing import Any, NamedTuple, Protocol

from libgz.ode.context import StepContext
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.python_resting import DIRECTIONS, MOTIONS, RestingBody, RestingPoint, solve_resting
from libgz.ode.python_vectors import cross, dot
from libgz.ode.tables import Tables
from libgz.ode.types import ContactMode, ContactRule, Mass

__all__ = ["Efforts", "Islands", "Touch", "TouchPoint", "default_direction", "is_calm"]

_EXACT_ROWS, _FAST_ROWS, _ROWS_OF_JOINT, _ROWS_OF_POINT = 150, 60, 6, 3
_FLANK = 0.70710678118654752
_CALM_SPEED = 0.1  # [m/s] and [rad/s]
_FALLING_STEPS = 2.0
_SLACK, _SURELY, _RESTING_WORK = 1e-5, 2.0, 400  # explained in step.c, as is _PLAIN
_PLAIN = (
    ContactMode.MU2
    | ContactMode.FDIR1
    | ContactMode.SOFT_ERP
    | ContactMode.SOFT_CFM
    | ContactMode.MOTION_N
    | ContactMode.SLIP1
    | ContactMode.SLIP2
    | ContactMode.APPROX1
)


class TouchPoint(NamedTuple):
    """A contact: a copy of ODE's `Contact`, its joint, and the number of its record or -1."""

    contact: Any
    joint: int
    record: int


class Touch(NamedTuple):
    """Two bodies that touch; the second is 0 for the world."""

    body1: int
    body2: int
    points: list[TouchPoint]


class Efforts(Protocol):
    """Where the efforts of a contact are recorded that is not solved by ODE."""

    def set_efforts(self, record: int, *efforts: list[float]) -> None:
        """Force [N] and torque [N m] on the joint's first body and, unless that is the world, on its second."""


def is_calm(context: StepContext, ode_: OdeLibrary, body: int) -> bool:
    """is_calm in step.c."""
    x, y, z = context.gravity
    calm = _CALM_SPEED + _FALLING_STEPS * context.step * math.sqrt(x * x + y * y + z * z)
    v, w = (get(body).contents for get in (ode_.dBodyGetLinearVel, ode_.dBodyGetAngularVel))
    square = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + (w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    return bool(square <= calm * calm)


class _Member:
    """A body, and what is known of its island if it is the root of that."""

    __slots__ = ("fast", "joined", "root", "rows", "solved", "touching")

    def __init__(self, fast: bool) -> None:
        self.root = self
        self.rows = 0
        self.fast = fast
        self.touching = False
        self.joined = False
        self.solved = False

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

    def __init__(self, context: StepContext, tables: Tables, efforts: Efforts) -> None:
        self._context, self._tables, self._efforts = context, tables, efforts
        self._ode: OdeLibrary = ode()

    def move(self, touches: list[Touch]) -> int:
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

    def _sort(self, touches: list[Touch]) -> tuple[bool, bool, tuple[list[int], list[int]]]:
        """Whether bodies that are awake are solved exactly, and by iteration; all bodies of either kind."""
        context, ode_, tables = self._context, self._ode, self._tables
        members = {}
        for body in tables.bodies.ids[: context.body_count].tolist():
            if body:
                members[body] = _Member(not is_calm(context, ode_, body))
        for joint in tables.joints.ids[: context.joint_count].tolist():
            if joint:
                one, two = (members.get(ode_.dJointGetBody(joint, k) or 0) for k in (0, 1))
                _connect(one, two, _ROWS_OF_JOINT, touching=False)
        for touch in touches:
            one, two = members.get(touch.body1), members.get(touch.body2)
            _connect(one, two, _ROWS_OF_POINT * len(touch.points), touching=True)
        self._solve_resting(members, touches)
        exact = quick = False
        both: tuple[list[int], list[int]] = [], []
        for body, member in members.items():
            root = member.find()
            iterated = root.iterated
            both[iterated].append(body)
            if root.rows and not root.solved and ode_.dBodyIsEnabled(body):
                exact, quick = exact or not iterated, quick or iterated
        return exact or not quick, quick, both

    def _solve_resting(self, members: dict[int, _Member], touches: list[Touch]) -> None:
        """solve_resting in step.c."""
        bodies: dict[_Member, list[int]] = {}
        parts: dict[_Member, list[Touch]] = {}
        for body, member in members.items():
            bodies.setdefault(member.find(), []).append(body)
        for touch in touches:
            parts.setdefault(members[touch.body1].find(), []).append(touch)
        for root, found in parts.items():
            if root.fast or root.joined or self._slides(bodies[root], found):
                continue
            described = self._describe_island(bodies[root], found, small=root.rows <= _EXACT_ROWS)
            if described and solve_resting(*described):
                root.solved = True
                self._apply_solution(bodies[root], found, *described)

    def _slides(self, handles: list[int], touches: list[Touch]) -> bool:
        """slides in step.c."""
        ode_ = self._ode
        whole_mass, whole = 0.0, [0.0] * 3
        for body in handles:
            mass = self._mass(body).mass
            load = self._load(body, mass)
            whole_mass = whole_mass + mass
            whole = [whole[k] + load[k] for k in range(3)]
        size, cfm = math.sqrt(dot(whole, whole)), ode_.dWorldGetCFM(self._context.world)
        found = False
        for touch in touches:
            if touch.body2:
                continue
            mass = self._mass(touch.body1).mass
            for point in touch.points:
                found = True
                if not self._point_slides(touch.body1, mass, size, whole_mass, point.contact, cfm):
                    return False
        return found

    def _point_slides(
        self, body: int, mass: float, load: float, whole_mass: float, contact: Any, world_cfm: float
    ) -> bool:
        """point_slides in step.c."""
        ode_ = self._ode
        place, v, w = (
            get(body).contents for get in (ode_.dBodyGetPosition, ode_.dBodyGetLinearVel, ode_.dBodyGetAngularVel)
        )
        turning = cross(w, [contact.geom.pos[k] - place[k] for k in range(3)])
        velocity = [v[k] + turning[k] for k in range(3)]
        normal, *directions = _directions(contact)
        softness, mu = self._friction(contact, world_cfm)
        press = load + whole_mass * max(0.0, -dot(normal, velocity))
        return any(
            mu[k] > 0.0
            and math.fabs(dot(direction, velocity)) > _SURELY * (mu[k] * press * (1.0 / mass + softness[k + 1]))
            for k, direction in enumerate(directions)
        )

    def _describe_island(
        self, handles: list[int], touches: list[Touch], *, small: bool
    ) -> tuple[list[RestingBody], list[RestingPoint]] | None:
        """describe_island in step.c."""
        ode_ = self._ode
        if any(not ode_.dBodyIsEnabled(body) or ode_.dBodyIsKinematic(body) for body in handles):
            return None
        if any(point.contact.surface.mode & ~_PLAIN for touch in touches for point in touch.points):
            return None
        gravity = self._context.gravity
        handles.sort(key=lambda body: dot(ode_.dBodyGetPosition(body).contents, gravity))
        places = {body: i for i, body in enumerate(handles)}
        nearest = list(range(len(handles)))
        for touch in touches:
            numbers = [places[body] for body in (touch.body1, touch.body2) if body]
            nearest[max(numbers)] = min(nearest[max(numbers)], *numbers)
        if not small and sum((i - first + 1) ** 2 for i, first in enumerate(nearest)) > _RESTING_WORK:
            return None
        bodies = [self._describe_body(body, first) for body, first in zip(handles, nearest, strict=True)]
        points = []
        world_cfm, fastest = (
            get(self._context.world) for get in (ode_.dWorldGetCFM, ode_.dWorldGetContactMaxCorrectingVel)
        )
        for touch in touches:
            pair = [(handle, places.get(handle, -1)) for handle in (touch.body1, touch.body2)]
            mass = min(bodies[place].mass for _, place in pair if place >= 0)
            for point in touch.points:
                points.append(self._describe_point(pair, mass, point.contact, world_cfm, fastest))
        return bodies, points

    def _describe_body(self, body: int, nearest: int) -> RestingBody:
        """describe_body in step.c."""
        ode_, h = self._ode, self._context.step
        r = ode_.dBodyGetRotation(body).contents
        v, w, torque = (
            get(body).contents for get in (ode_.dBodyGetLinearVel, ode_.dBodyGetAngularVel, ode_.dBodyGetTorque)
        )
        m = self._mass(body)
        own = m.I
        turned = [
            [r[4 * i] * own[k] + r[4 * i + 1] * own[4 + k] + r[4 * i + 2] * own[8 + k] for k in range(3)]
            for i in range(3)
        ]
        inertia = [[dot(turned[i], r[4 * k : 4 * k + 3]) for k in range(3)] for i in range(3)]
        angular = [dot(inertia[i], w) for i in range(3)]
        gyroscopic = cross(w, angular)
        load = self._load(body, m.mass)
        momentum = [m.mass * v[i] + load[i] for i in range(3)]
        momentum += [angular[i] + h * (torque[i] - gyroscopic[i]) for i in range(3)]
        return RestingBody(m.mass, inertia, momentum, nearest)

    def _mass(self, body: int) -> Mass:
        m = Mass()
        self._ode.dBodyGetMass(body, ctypes.addressof(m))
        return m

    def _load(self, body: int, mass: float) -> list[float]:
        """find_load in step.c."""
        h, gravity = self._context.step, self._context.gravity
        force = self._ode.dBodyGetForce(body).contents
        falls = self._ode.dBodyGetGravityMode(body)
        return [h * (force[i] + (mass * gravity[i] if falls else 0.0)) for i in range(3)]

    def _friction(self, contact: Any, world_cfm: float) -> tuple[list[float], tuple[float, float]]:
        """find_friction in step.c: softness by direction, and coefficients of friction."""
        h, surface = self._context.step, contact.surface
        mode = surface.mode
        softness = [
            surface.soft_cfm / h,
            (surface.slip1 if mode & ContactMode.SLIP1 else world_cfm) / h,
            (surface.slip2 if mode & ContactMode.SLIP2 else world_cfm) / h,
        ]
        return softness, (surface.mu, surface.mu2 if mode & ContactMode.MU2 else surface.mu)

    def _describe_point(
        self, pair: list[tuple[int, int]], mass: float, contact: Any, world_cfm: float, fastest: float
    ) -> RestingPoint:
        """describe_point in step.c."""
        surface, directions, pos = contact.surface, _directions(contact), contact.geom.pos
        sides: list[tuple[int, list[list[float]]]] = []
        for side, (handle, number) in enumerate(pair):
            if number < 0:
                sides.append((-1, []))
                continue
            place = self._ode.dBodyGetPosition(handle).contents
            arm = [pos[k] - place[k] for k in range(3)]
            rows = [[*direction, *cross(arm, direction)] for direction in directions]
            sides.append((number, [[-value for value in row] for row in rows] if side else rows))
        motion = surface.motionN if surface.mode & ContactMode.MOTION_N else 0.0
        aim = surface.soft_erp * contact.geom.depth / self._context.step + motion
        softness, mu = self._friction(contact, world_cfm)
        slack = [max(0.0, _SLACK / mass - value) for value in softness]
        return RestingPoint(sides, min(aim, fastest), softness, slack, mu)

    def _apply_solution(
        self, handles: list[int], touches: list[Touch], bodies: list[RestingBody], points: list[RestingPoint]
    ) -> None:
        """apply_solution in step.c."""
        ode_, h = self._ode, self._context.step
        for handle, body in zip(handles, bodies, strict=True):
            force, torque = (get(handle).contents for get in (ode_.dBodyGetForce, ode_.dBodyGetTorque))
            ode_.dBodySetForce(handle, *(force[k] + body.impulse[k] / h for k in range(3)))
            ode_.dBodySetTorque(handle, *(torque[k] + body.impulse[3 + k] / h for k in range(3)))
        found = [point for touch in touches for point in touch.points]
        for (_, joint, record), point in zip(found, points, strict=True):
            ode_.dJointDisable(joint)
            if record >= 0:
                self._efforts.set_efforts(record, *(self._effort(point, rows) for n, rows in point.sides if n >= 0))

    def _effort(self, point: RestingPoint, rows: list[list[float]]) -> list[float]:
        """find_effort in step.c: force and torque."""
        effort = [0.0] * MOTIONS
        for a in range(MOTIONS):
            for k in range(DIRECTIONS):
                effort[a] = effort[a] + rows[k][a] * point.impulse[k]
            effort[a] = effort[a] / self._context.step
        return effort

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
    one.joined = one.joined or not touching
    if two is None:
        return
    two = two.find()
    if two is not one:
        two.root = one
        one.rows += two.rows
        one.fast = one.fast or two.fast
        one.touching = one.touching or two.touching
        one.joined = one.joined or two.joined


def default_direction(n: list[float]) -> list[float]:
    """default_direction in step.c: ODE's own choice of the direction in which mu acts."""
    if math.fabs(n[2]) > _FLANK:
        k = 1.0 / math.sqrt(n[1] * n[1] + n[2] * n[2])
        return [0.0, -n[2] * k, n[1] * k]
    k = 1.0 / math.sqrt(n[0] * n[0] + n[1] * n[1])
    return [-n[1] * k, n[0] * k, 0.0]


def _directions(contact: Any) -> list[list[float]]:
    """find_directions in step.c."""
    n = list(contact.geom.normal[:3])
    if contact.surface.mode & ContactMode.FDIR1:
        one = list(contact.fdir1[:3])
    else:
        one = default_direction(n)
    return [n, one, cross(n, one)]
