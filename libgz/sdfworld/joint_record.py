"""The numbers of a joint that native code reads and writes, too: efforts, parameters as they were set, axes.

C++ plugins apply efforts and set parameters in every step; `libgz.classic_cxx` makes its structs of these declarations.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping, Sequence
from ctypes import c_double, c_int64
from typing import TYPE_CHECKING, Any

from libgz.base.law import Operation, law
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
from libgz.simulation.recorder import Recorder, recorded_as

if TYPE_CHECKING:
    from libgz.physics.engine import Engine

__all__ = ["PARAMETERS", "RANGES", "AxisRecord", "JointRecord"]

# Classic's keys of parameters, and ODE's numbers of them for the first axis.
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
# What makes sense to ODE; values outside are replaced by the nearest bound.
RANGES = {
    **dict.fromkeys(("erp", "stop_erp", "suspension_erp", "fudge_factor", "bounce"), (0.0, 1.0)),
    **dict.fromkeys(("cfm", "stop_cfm", "suspension_cfm"), (0.0, 1e10)),
    "fmax": (0.0, 1e16),
    "vel": (-1e6, 1e6),
}
MOST_AXES = 2
_PLACES = {key: number for number, key in enumerate(PARAMETERS)}
_KEYS = tuple((key, index) for key in PARAMETERS for index in range(MOST_AXES))
# Where the efforts are in the record, in words of 8 bytes.
_AT, _BEFORE, _BEFORE_AT = MOST_AXES, MOST_AXES + 1, 2 * MOST_AXES + 1
_UNSET = (math.nan,) * len(_KEYS)


def _note(recorder: Recorder, record: JointRecord, effort: Any, index: int, _engine: Any) -> None:
    recorder.kept.append(record)
    recorder.add(Operation.NOTE, one=recorder.address(effort), type=index, result=ctypes.addressof(record))


class AxisRecord(ctypes.Structure):
    """Numbers of an axis; `Axis` explains them."""

    _fields_ = [
        ("lower", c_double),
        ("upper", c_double),
        ("effort", c_double),
        ("velocity", c_double),
        ("damping", c_double),
        ("friction", c_double),
        ("stiffness", c_double),
        ("reference", c_double),
        ("stop_stiffness", c_double),
        ("stop_dissipation", c_double),
    ]

    lower: float
    upper: float
    effort: float
    velocity: float
    damping: float
    friction: float
    stiffness: float
    reference: float
    stop_stiffness: float
    stop_dissipation: float


class JointRecord(ctypes.Structure):
    """Efforts [N m] or [N] of the last two steps that had some, and the numbers of these steps; parameters; axes.

    Args:
        axes: those of the joint.
        dof: how many positions it has.

    Attributes:
        numbers: the doubles of the record; single ones are read and written faster than through its fields.
    """

    _fields_ = [
        ("applied", c_double * MOST_AXES),
        ("applied_at", c_int64),
        ("before", c_double * MOST_AXES),
        ("before_at", c_int64),
        ("parameters", c_double * len(_KEYS)),  # as users set them, by key and axis; NaN: not set
        ("axes", ctypes.POINTER(AxisRecord) * MOST_AXES),  # null: none
        ("dof", c_int64),
    ]
    EFFORTS = 2 * (8 * MOST_AXES + 8)  # [byte]: what a state has of them
    _WORDS = EFFORTS // 8

    applied: Any
    applied_at: int
    before: Any
    before_at: int

    def __init__(self, axes: Sequence[AxisRecord], dof: int) -> None:
        super().__init__(applied_at=-1, before_at=-1, dof=dof)
        self.parameters[:] = _UNSET
        for number, axis in enumerate(axes[:MOST_AXES]):
            self.axes[number].contents = axis
        # Without a reference to the record, which lives as long as its attributes.
        memory = (c_double * self._WORDS).from_address(ctypes.addressof(self))
        self.numbers = memoryview(memory).cast("B").cast("d")
        self._steps = memoryview(memory).cast("B").cast("q")

    @recorded_as(_note)
    def add_effort(self, effort: float, index: int, engine: Engine) -> None:
        """Note an effort on an axis in the present step; those of one step add up."""
        step = engine.steps
        numbers, steps = self.numbers, self._steps
        if steps[_AT] != step:
            numbers[_BEFORE], numbers[_BEFORE + 1], steps[_BEFORE_AT] = numbers[0], numbers[1], steps[_AT]
            numbers[0] = numbers[1] = 0.0
            steps[_AT] = step
        numbers[index] += effort

    def held(self, effort: float, steps: int, last: int) -> None:
        """Note an effort on the first axis that acted in a number of steps, the last of which has a number."""
        numbers, places = self.numbers, self._steps
        if steps > 1:
            numbers[_BEFORE], numbers[_BEFORE + 1], places[_BEFORE_AT] = effort, 0.0, last - 1
        else:
            numbers[_BEFORE], numbers[_BEFORE + 1], places[_BEFORE_AT] = numbers[0], numbers[1], places[_AT]
        numbers[0], numbers[1], places[_AT] = effort, 0.0, last

    def effort(self, index: int) -> float:
        """The effort on an axis in the last step that had some."""
        return self.numbers[index] if 0 <= index < MOST_AXES else 0.0

    def efforts_of(self, step: int) -> tuple[float, ...]:
        """The efforts of a step."""
        if step == self.applied_at:
            return tuple(self.applied)
        return tuple(self.before) if step == self.before_at else (0.0, 0.0)

    @property
    def efforts(self) -> bytes:
        """All of them, for a state."""
        return ctypes.string_at(ctypes.addressof(self), self.EFFORTS)

    @efforts.setter
    def efforts(self, packed: bytes) -> None:
        ctypes.memmove(ctypes.addressof(self), packed, min(len(packed), self.EFFORTS))

    @law
    def parameter(self, key: str, index: int) -> float:
        """A parameter as it was set; NaN if it was not."""
        return self.parameters[MOST_AXES * _PLACES[key] + min(index, MOST_AXES - 1)]  # type: ignore[no-any-return]

    @law
    def set_parameter(self, key: str, index: int, value: float) -> None:
        """Note a parameter of an axis."""
        self.parameters[MOST_AXES * _PLACES[key] + min(index, MOST_AXES - 1)] = value

    @property
    def given(self) -> dict[tuple[str, int], float]:
        """All parameters that were set, by key and axis."""
        return {key: value for key, value in zip(_KEYS, self.parameters, strict=True) if value == value}

    @given.setter
    def given(self, values: Mapping[tuple[str, int], float]) -> None:
        self.parameters[:] = _UNSET
        for (key, index), value in values.items():
            self.set_parameter(key, index, value)
