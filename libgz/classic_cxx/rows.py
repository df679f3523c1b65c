"""Where the engine keeps the numbers of a view: the library reads them there, and calls Python for all else."""

from __future__ import annotations

import ctypes
from typing import Any

from libgz.classic.physics import Joint, Link, Model, World
from libgz.classic_cxx.layouts import FUNCTIONS, RowRecord
from libgz.ode.lib import ode
from libgz.physics.body import Body
from libgz.physics.joint import SliderJoint
from libgz.sdfworld.model import SdfModel

__all__ = ["clock_of", "fill", "owned", "start"]

NO_ROW = -1


def start(library: Any) -> None:
    """Hand a library the addresses of ODE's functions."""
    addresses = (ctypes.c_void_p * len(FUNCTIONS))(*map(ode().address, FUNCTIONS))
    function = library["libgz_hot"]
    function.argtypes, function.restype = [ctypes.c_void_p], None
    function(addresses)


def fill(view: Any, address: int) -> object:
    """Write where the numbers of a link, joint, model or world are into a `RowRecord`.

    Returns:
        What owns them; None if there are none. The library keeps it alive unseen by the collector: it refers to no
        view.
    """
    found = RowRecord.from_address(address)
    ctypes.memset(address, 0, ctypes.sizeof(RowRecord))
    found.row, found.ends[:] = NO_ROW, (NO_ROW, NO_ROW)
    if isinstance(view, World):
        found.clock.contents = clock = view.core.clock
        return clock
    if not isinstance(view, Link | Model | Joint):
        return None
    tables = view.GetWorld().core.engine.tables.record
    found.tables.contents = tables
    if isinstance(view, Link):
        found.row = _row(view.body)
    elif isinstance(view, Model):
        canonical = view.core.frame_in_body() if isinstance(view.core, SdfModel) else None
        if canonical is not None:
            body, frame = canonical
            found.row, found.framed, found.frame[:] = _row(body), 1, (*frame.pos, *frame.rot)
    else:
        record, joint = view.core.record, view.core.plain_joint()
        found.joint.contents = record
        if joint is not None:
            found.row, found.slides = joint.row, isinstance(joint, SliderJoint)
            found.ends[:] = _row(view.core.parent), _row(view.core.child)
        return tables, record
    return tables


def _row(body: Body | None) -> int:
    """The row of a body that moves; NO_ROW for any other."""
    return NO_ROW if body is None or body.closed or body.dummy else body.row


def owned(view: Any) -> bool:
    """Whether the calling thread holds the world of a joint, or of a link that moves."""
    still = isinstance(view, Link) and view.IsStatic()
    return not still and bool(view.GetWorld().core.lock.owned())


def clock_of(holder: Any) -> tuple[int, str]:
    """The address of the clock in the world of a plugin, and that world's name."""
    core = holder.core if isinstance(holder, World) else None
    if core is None:
        world = holder.GetWorld() if hasattr(holder, "GetWorld") else None
        core = world.core if world is not None else None
    return (0, "") if core is None else (ctypes.addressof(core.clock), core.name)
