"""PID: a controller."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any, SupportsFloat

from libgz.base.law import Term, largest, law, least, possible, usually, where

__all__ = ["PID"]

NAMES = (
    *("cmd", "cmdMax", "cmdMin", "dErr", "dGain", "iErr"),
    *("iGain", "iMax", "iMin", "pErr", "pErrLast", "pGain"),
)


class PID(ctypes.Structure):
    """A proportional, integral and derivative controller with the signs of Gazebo classic.

    The error is the measured minus the desired value, and the command is -(p error + i integral + d rate): a positive
    error gives a negative command. The integral term (not the error) is limited to `imin` to `imax`. **Their defaults
    of 0 disable it**: set limits, or `imax` below `imin`, which means none. The command is limited to `cmdMin` to
    `cmdMax`; `cmdMax` below `cmdMin`, as by default, means no limits.

    Args:
        p: gain of the error [command / error]; of an angle's error [rad] and a torque [N m], in [N m/rad].
        i: gain of its integral [command / (error s)].
        d: gain of its rate [command s / error].
        imax, imin: limits of the integral term, in units of the command.
        cmdMax, cmdMin: limits of the command.
    """

    _fields_ = [(name, ctypes.c_double) for name in NAMES]
    __hash__ = object.__hash__  # structs have none

    cmd: float
    cmdMax: float
    cmdMin: float
    dErr: float
    dGain: float
    iErr: float
    iGain: float
    iMax: float
    iMin: float
    pErr: float
    pErrLast: float
    pGain: float

    def __init__(
        self,
        p: float = 0.0,
        i: float = 0.0,
        d: float = 0.0,
        imax: float = 0.0,
        imin: float = 0.0,
        cmdMax: float = -1.0,
        cmdMin: float = 0.0,
    ) -> None:
        self.Init(p, i, d, imax, imin, cmdMax, cmdMin)

    def Init(
        self,
        p: float = 0.0,
        i: float = 0.0,
        d: float = 0.0,
        imax: float = 0.0,
        imin: float = 0.0,
        cmdMax: float = -1.0,
        cmdMin: float = 0.0,
    ) -> None:
        """Set gains and limits, and reset errors and command.

        Args:
            p: command per error.
            i: command per error and second.
            d: command per error per second.
            imax, imin: limits of the integral term, in units of the command.
            cmdMax, cmdMin: limits of the command.
        """
        self.pGain, self.iGain, self.dGain = float(p), float(i), float(d)
        self.iMax, self.iMin = float(imax), float(imin)
        self.cmdMax, self.cmdMin = float(cmdMax), float(cmdMin)
        self.Reset()

    def SaveState(self) -> tuple[float, ...]:
        """All values, for a snapshot of the world."""
        return _values(self)

    def LoadState(self, state: Sequence[float]) -> None:
        """Take what SaveState returned."""
        for name, value in zip(NAMES, state, strict=True):
            setattr(self, name, value)

    def Reset(self) -> None:
        """Set all errors and the command to 0."""
        self.pErr = self.pErrLast = self.iErr = self.dErr = self.cmd = 0.0

    @law
    def Update(self, error: float, dt: SupportsFloat) -> float:
        """The next command.

        Args:
            error: the measured minus the desired value.
            dt: time since the last update [s], a number or a `common.Time`. If it is 0, or the error is infinite or
                NaN, the state does not change and the command is 0.
        """
        step: Any = dt if isinstance(dt, Term) else float(dt)
        self.pErr = error
        if not usually((step != 0.0) & (abs(error) <= sys.float_info.max)):
            return 0.0
        whole, gain = self.iErr + step * error, self.iGain
        term = gain * whole
        beyond = (self.iMax >= self.iMin) & ((term < self.iMin) | (term > self.iMax) | (term != term))
        if possible(beyond):
            term = where(beyond, largest(least(term, self.iMax), self.iMin), term)
            # Against wind-up the integral is limited, too.
            whole = where(beyond & (gain != 0.0), term / where(gain == 0.0, 1.0, gain), whole)
        self.iErr = whole
        self.dErr = (error - self.pErrLast) / step
        self.pErrLast = error
        command = -self.pGain * error - term - self.dGain * self.dErr
        limited = self.cmdMax >= self.cmdMin
        if possible(limited):
            command = where(limited, largest(least(command, self.cmdMax), self.cmdMin), command)
        self.cmd = command
        return command  # type: ignore[no-any-return]

    def GetErrors(self) -> tuple[float, float, float]:
        """The error, its integral [s] and its rate [1/s], as of the last update."""
        return self.pErr, self.iErr, self.dErr

    def GetCmd(self) -> float:
        """The last command."""
        return self.cmd

    def SetCmd(self, cmd: float) -> None:
        """Set the last command."""
        self.cmd = cmd

    def GetPGain(self) -> float:
        """The proportional gain."""
        return self.pGain

    def GetIGain(self) -> float:
        """The integral gain."""
        return self.iGain

    def GetDGain(self) -> float:
        """The derivative gain."""
        return self.dGain

    def GetIMax(self) -> float:
        """The upper limit of the integral term."""
        return self.iMax

    def GetIMin(self) -> float:
        """The lower limit of the integral term."""
        return self.iMin

    def GetCmdMax(self) -> float:
        """The upper limit of the command."""
        return self.cmdMax

    def GetCmdMin(self) -> float:
        """The lower limit of the command."""
        return self.cmdMin

    def SetPGain(self, p: float) -> None:
        """Set the proportional gain."""
        self.pGain = float(p)

    def SetIGain(self, i: float) -> None:
        """Set the integral gain."""
        self.iGain = float(i)

    def SetDGain(self, d: float) -> None:
        """Set the derivative gain."""
        self.dGain = float(d)

    def SetIMax(self, i: float) -> None:
        """Set the upper limit of the integral term."""
        self.iMax = float(i)

    def SetIMin(self, i: float) -> None:
        """Set the lower limit of the integral term."""
        self.iMin = float(i)

    def SetCmdMax(self, c: float) -> None:
        """Set the upper limit of the command."""
        self.cmdMax = float(c)

    def SetCmdMin(self, c: float) -> None:
        """Set the lower limit of the command."""
        self.cmdMin = float(c)

    def __repr__(self) -> str:
        gains = f"p={self.pGain!r}, i={self.iGain!r}, d={self.dGain!r}"
        limits = f"imax={self.iMax!r}, imin={self.iMin!r}, cmdMax={self.cmdMax!r}, cmdMin={self.cmdMin!r}"
        return f"PID({gains}, {limits})"

    PGain, IGain, DGain = GetPGain, GetIGain, GetDGain
    IMax, IMin, CmdMax, CmdMin = GetIMax, GetIMin, GetCmdMax, GetCmdMin
    Cmd, Errors = GetCmd, GetErrors


_values: Callable[[PID], tuple[float, ...]] = attrgetter(*NAMES)
