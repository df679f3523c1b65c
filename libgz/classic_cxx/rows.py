"""Where the engine keeps the numbers of a view: the library reads them there, and calls Python for all else."""

from __future__ import annotations

import ctypes
from typing import Any

from libgz.base.records import ClockRecord, TableRecord
from libgz.classic.physics import Joint, Link, Model, World
from libgz.ode.context import StepContext
from libgz.ode.lib import ode
from libgz.sdfworld.model import SdfModel

__all__ = ["clock_of", "owned", "row_of", "start"]

# Of ODE, in the order that hot.cc expects.
FUNCTIONS = (
    "dBodyEnable",
    "dBodyAddForce",
    "dBodyAddTorque",
    "dBodyAddRelForce",
    "dBodyAddRelTorque",
    "dBodyAddForceAtPos",
    "dBodyAddForceAtRelPos",
)
NO_ROW = -1

# A record or clock, which the library keeps alive unseen by the collector: it must refer to nothing else. Then the
# address of the record, the row, the address of the clock; of a model also its frame in the body.
Row = tuple[Any, int, int, int] | tuple[Any, int, int, int, tuple[float, ...]]


def start(library: Any) -> None:
    """Give a library the addresses of ODE's functions."""
    addresses = (ctypes.c_void_p * len(FUNCTIONS))(*map(ode().address, FUNCTIONS))
    function = library["libgz_hot"]
    function.argtypes, function.restype = [ctypes.c_void_p, *[ctypes.c_int64] * 3], None
    offset = StepContext.resting.offset
    function(addresses, offset, ctypes.sizeof(TableRecord), ctypes.sizeof(ClockRecord))


def row_of(view: Any) -> Row | None:
    """Where the numbers of a link, joint, model or world are; None if they are in no table."""
    if isinstance(view, World):
        return view.core.clock, 0, NO_ROW, ctypes.addressof(view.core.clock)
    record = view.GetWorld().core.engine.tables.record
    address = ctypes.addressof(record)
    if isinstance(view, Link):
        body = view.body
        return record, address, NO_ROW if body.closed or body.dummy else body.row, 0
    if isinstance(view, Model):
        canonical = view.core.frame_in_body() if isinstance(view.core, SdfModel) else None
        if canonical is None or canonical[0].closed or canonical[0].dummy:
            return record, address, NO_ROW, 0
        body, frame = canonical
        return record, address, body.row, 0, (*map(float, (*frame.pos, *frame.rot)),)
    if isinstance(view, Joint):
        joint = view.core.plain_joint()
        return record, address, NO_ROW if joint is None else joint.row, 0
    return None


def owned(link: Any) -> bool:
    """Whether the calling thread holds the world of a link, which moves."""
    return not link.IsStatic() and bool(link.GetWorld().core.lock.owned())


def clock_of(holder: Any) -> tuple[int, str]:
    """The address of the sim time of a plugin's world, and the world's name."""
    core = holder.core if isinstance(holder, World) else None
    if core is None:
        world = holder.GetWorld() if hasattr(holder, "GetWorld") else None
        core = world.core if world is not None else None
    return (0, "") if core is None else (ctypes.addressof(core.clock), core.name)
