"""JointLimits: parameters, stops and springs of an SDF joint."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.errors import ParameterError, nearest
from libgz.physics.check import finite
from libgz.physics.couplings import Gears, Thread
from libgz.physics.engine import Engine
from libgz.physics.joint import HingeJoint, Joint, SliderJoint
from libgz.sdfworld.axis import HALF_TURN, UNLIMITED, Axis, JointPlan
from libgz.sdfworld.parameters import PARAMETERS, ode_number

if TYPE_CHECKING:
    from libgz.physics.body import Body

__all__ = ["JointLimits"]

TURN = 2.0 * math.pi
# h^2 k / m and h d / m up to which an implicit spring and damper are pushed with; beyond 4 and 2 that would blow up.
GENTLE = 0.05
# What makes sense to ODE; what lies outside is taken as the nearest.
RANGES = {
    **dict.fromkeys(("erp", "stop_erp", "suspension_erp", "fudge_factor", "bounce"), (0.0, 1.0)),
    **dict.fromkeys(("cfm", "stop_cfm", "suspension_cfm"), (0.0, 1e10)),
    "fmax": (0.0, 1e16),
    "vel": (-1e6, 1e6),
}
COUPLINGS = {"thread_pitch": (1e-5, 1e9), "gearbox_ratio": (1e-4, 1e4)}


class JointLimits:
    """Base of SdfJoint: what holds its axes, and what a user can set of that."""

    engine: Engine
    name: str
    kind: str
    plan: JointPlan
    axes: list[Axis]
    implicit: bool
    parent: Body | None
    child: Body | None
    joint: Joint | None
    _coupling: Thread | Gears | None
    acts: bool  # whether `update` has anything to do
    _engine_pushes: bool  # whether the engine does what its springs do
    _laid: dict[int, float]  # axis -> turns [rad] that its stops were laid for
    _given: dict[tuple[str, int], float]  # ODE's parameters as users set them, by key and axis
    _step_time: float  # [s] that `_refresh` has looked at
    _held: dict[int, bool]  # axis -> whether two stops at one place stand for its spring

    def position(self, index: int = 0) -> float:
        """Angle [rad] or position [m] of an axis."""
        raise NotImplementedError

    def velocity(self, index: int = 0) -> float:
        """Rate of an axis [rad/s] or [m/s]."""
        raise NotImplementedError

    def _push(self, effort: float, index: int) -> None:
        """Push along an axis for one step."""
        raise NotImplementedError

    def detach(self) -> None:
        """Let both links go."""
        raise NotImplementedError

    @property
    def attached(self) -> bool:
        """Whether it holds links together."""
        raise NotImplementedError

    def let_go_of_deleted(self) -> None:
        """Hold nothing any more if one of the links was deleted."""
        raise NotImplementedError

    @property
    def broken(self) -> bool:
        """Whether a link that it held was deleted."""
        gone = self._coupling is not None and self._coupling.broken
        return gone or (self.joint is not None and self.joint.closed)

    @property
    def dof(self) -> int:
        """How many positions there are."""
        return 2 if self.kind == "screw" else len(self.axes)

    def axis_at(self, index: int) -> Axis:
        """An axis; a screw's second motion has none of its own.

        Raises:
            ParameterError: there is none of this index.
        """
        if not 0 <= index < len(self.axes):
            raise ParameterError(f"joint {self.name!r} has no axis {index}; it has {len(self.axes)}")
        return self.axes[index]

    def _set_parameters(self) -> None:
        """Stops, friction, what the file says of ODE's parameters, and what users have set."""
        given = dict(self._given)
        for index, axis in enumerate(self.axes):
            self._set_stops(index)
            if axis.friction > 0.0:
                self.set_param("friction", axis.friction, index)
        for key, value in self.plan.parameters.items():
            for index in range(max(1, len(self.axes))):
                if ode_number(self.joint, key, index) is not None and (value != 0.0 or key not in ("fmax", "vel")):
                    self.set_param(key, value, index)
        for (key, index), value in given.items():  # what users had set before the joint was made anew
            if ode_number(self.joint, key, index) is not None:
                self.set_param(key, value, index)

    def get_param(self, key: str, index: int = 0) -> float:
        """A parameter by its classic key; see `set_param`.

        Raises:
            ParameterError: there is no such key, or this kind of joint has none.
        """
        if key in ("hi_stop", "lo_stop", "friction"):
            axis = self.axis_at(index)
            return {"hi_stop": axis.upper, "lo_stop": axis.lower, "friction": axis.friction}[key]
        if key in ("thread_pitch", "gearbox_ratio"):
            return self.plan.pitch if key == "thread_pitch" else self.plan.ratio
        number = self._number(key, index)
        return self.joint.GetParam(number) if self.attached and self.joint is not None else 0.0

    def set_param(self, key: str, value: float, index: int = 0) -> None:
        """Set a parameter by its classic key.

        fmax [N m or N] and vel [rad/s or m/s] are the motor; hi_stop, lo_stop [rad or m]; friction [N m or N]; erp,
        cfm, stop_erp, stop_cfm, suspension_erp, suspension_cfm, fudge_factor, bounce; thread_pitch [rad/m];
        gearbox_ratio.

        Raises:
            ParameterError: there is no such key, this kind of joint has none, or the value is NaN.
        """
        number = float(value)
        if math.isnan(number):
            raise ParameterError(f"joint {self.name!r}: {key} is NaN")
        self.let_go_of_deleted()
        if key in ("hi_stop", "lo_stop"):
            setattr(self.axis_at(index), "upper" if key == "hi_stop" else "lower", number)
            self._set_stops(index)
            self._refresh()
        elif key == "friction":
            # Friction is a motor that wants to stand still.
            self.axis_at(index).friction = number
            self.set_param("vel", 0.0, index)
            self.set_param("fmax", number, index)
        elif key in ("thread_pitch", "gearbox_ratio"):
            self._set_coupling(key, number)
        else:
            ode_parameter = self._number(key, index)
            least, most = RANGES.get(key, (-math.inf, math.inf))
            number = min(max(number, least), most)
            self._given[key, index] = number
            if self.joint is not None:
                self.joint.SetParam(ode_parameter, number)

    def _number(self, key: str, index: int) -> int:
        number = ode_number(self.joint, key, index)
        if number is None:
            known = ", ".join((*PARAMETERS, "friction", "thread_pitch", "gearbox_ratio"))
            raise ParameterError(
                f"joint {self.name!r}: a {self.kind} joint has no {key!r} of axis {index}; keys are {known}"
                + nearest(key, PARAMETERS)
            )
        return number

    def check_coupling(self, key: str, value: float) -> None:
        """Refuse what no screw or gearbox can be.

        Raises:
            ParameterError: it is zero, or absurdly small or large.
        """
        least, most = COUPLINGS[key]
        if not least <= abs(value) <= most:
            raise ParameterError(f"joint {self.name!r}: {key} is {value:g}; its size must be {least:g} to {most:g}")

    def _set_coupling(self, key: str, value: float) -> None:
        self.check_coupling(key, value)
        if key == "thread_pitch":
            self.plan.pitch = value
            if isinstance(self._coupling, Thread):
                self._coupling.pitch = value
        else:
            self.plan.ratio = value
            if isinstance(self._coupling, Gears):
                self._coupling.set_ratio(value)

    # Stops and springs -------------------------------------------------------------------------------------------

    def _turns(self, index: int) -> float:
        """Whole turns of an axis [rad], which ODE does not count."""
        turning = not isinstance(self.joint, SliderJoint) and not (self.kind == "screw" and index == 1)
        return TURN * round(self.position(index) / TURN) if turning else 0.0

    def _set_stops(self, index: int) -> None:
        """Hand an axis' limits to ODE, in its own count of turns."""
        axis, turns = self.axes[index], self._turns(index)
        low = axis.lower - turns if abs(axis.lower) < UNLIMITED else -math.inf
        high = axis.upper - turns if abs(axis.upper) < UNLIMITED else math.inf
        if turns or (axis.wide and not isinstance(self.joint, SliderJoint)):
            # A stop that is half a turn away or more is none, unless the axis lies beyond it: it turns towards it.
            low = min(low, math.pi) if low >= -math.pi else -math.inf
            high = max(high, -math.pi) if high <= math.pi else math.inf
        self._lay_stops(index, low, high)
        self._held[index] = False
        self._laid[index] = turns

    def _lay_stops(self, index: int, low: float, high: float) -> None:
        low_number, high_number = ode_number(self.joint, "lo_stop", index), ode_number(self.joint, "hi_stop", index)
        if self.joint is None or low_number is None or high_number is None:
            return
        for number, value in ((high_number, high), (low_number, low), (high_number, high)):
            self.joint.SetParam(number, value)

    def set_spring(self, index: int, stiffness: float, damping: float, reference: float = 0.0) -> None:
        """Spring [N m/rad or N/m] and damper [N m s/rad or N s/m] about a reference [rad or m]."""
        axis = self.axis_at(index)
        axis.stiffness, axis.damping = finite(stiffness, "stiffness"), finite(damping, "damping")
        self.let_go_of_deleted()
        axis.reference = finite(reference, "reference")
        if self.joint is not None:
            self._set_stops(index)
        self._refresh()

    def _refresh(self) -> None:
        """Note who pushes: the engine for the explicit springs of hinges and sliders, for all else `update`.

        An implicit spring that is gentle is pushed with, too: solved with the constraints it would lose energy.
        """
        self._engine_pushes, self._step_time = False, self.engine.step_time
        if isinstance(self.joint, HingeJoint | SliderJoint):
            axis = self.axes[0]
            self._engine_pushes = not self.implicit or self._gentle(axis)
            share = float(self._engine_pushes)
            self.joint.set_spring(share * axis.stiffness, share * abs(axis.damping), axis.reference)
            if self._engine_pushes and self._held.get(0):
                self._let_go(0)
        turning = not isinstance(self.joint, SliderJoint)
        springs = any(axis.springs for axis in self.axes) and (self.implicit or not self._engine_pushes)
        self.acts = self._coupling is not None or springs or (turning and any(axis.wide for axis in self.axes))

    def _gentle(self, axis: Axis) -> bool:
        """Whether spring and damper are far from what would be unstable with steps of this length."""
        ends = [b for b in (self.parent, self.child) if b is not None and not b.dummy and not b.kinematic]
        if not ends:
            return False
        turning, step = isinstance(self.joint, HingeJoint), self.engine.step_time
        inertias = [min(b.GetMass().I[i] for i in (0, 5, 10)) if turning else b.mass for b in ends]
        inertia = 1.0 / sum(1.0 / value for value in inertias)
        return max(step * step * abs(axis.stiffness), step * abs(axis.damping)) <= GENTLE * inertia

    def update(self) -> None:
        """What the joint does by itself in the coming step: springs, dampers, threads, gears."""
        if not self.attached:
            return
        if self.implicit and self.engine.step_time != self._step_time:
            self._refresh()
        if isinstance(self._coupling, Thread):
            self._coupling.update()
        elif self._coupling is not None:
            self._coupling.update(self.engine.step_time)
        if self.joint is None:
            return
        for index, axis in enumerate(self.axes):
            if axis.springs and not self._engine_pushes and not (self.implicit and self._hold(index, axis)):
                spring = axis.stiffness * (axis.reference - self.position(index))
                self._push(spring - abs(axis.damping) * self.velocity(index), index)
            if axis.wide and not self._held.get(index) and self._turns(index) != self._laid.get(index):
                self._set_stops(index)

    def _hold(self, index: int, axis: Axis) -> bool:
        """Let two stops at one place stand for spring and damper, unless a limit is met; whether that can be done.

        erp = h k / (h k + d), cfm = 1 / (h k + d), as for contacts.
        """
        at, turns = self.position(index), self._turns(index)
        target = axis.reference - turns if axis.stiffness else at - turns
        if ode_number(self.joint, "lo_stop", index) is None or (turns and abs(target) > HALF_TURN):
            return False
        if not axis.lower < at < axis.upper:
            if self._held.get(index):
                self._let_go(index)
            return True
        spring = self.engine.step_time * axis.stiffness
        total = spring + abs(axis.damping)
        self.set_param("stop_erp", spring / total, index)
        self.set_param("stop_cfm", 1.0 / total, index)
        self._lay_stops(index, target, target)
        self._held[index] = True
        return True

    def _let_go(self, index: int) -> None:
        """Let the stops be stops again."""
        self._set_stops(index)
        for key, default in (("stop_erp", 0.2), ("stop_cfm", 0.0)):
            self.set_param(key, self.plan.parameters.get(key, default), index)
