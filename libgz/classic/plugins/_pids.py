"""PID controllers as elements of plugins give them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.math.pid import PID

if TYPE_CHECKING:
    from libgz.sdf.element import Element

__all__ = ["pid_of"]

_NAMES = ("p", "i", "d", "i_max", "i_min", "cmd_max", "cmd_min")


def pid_of(element: Element | None, *, p: float = 0.0, i: float = 0.0, d: float = 0.0, limit: float = 0.0) -> PID:
    """A PID of `<p>`, `<i>`, `<d>`, `<i_max>`, `<i_min>`, `<cmd_max>` and `<cmd_min>` in an element.

    Args:
        element: it may lack any of them, or be missing.
        p, i, d: defaults of the gains.
        limit: default of the command's limits, in both directions; 0: none.
    """
    defaults = (p, i, d, 0.0, 0.0, limit, -limit) if limit > 0.0 else (p, i, d, 0.0, 0.0, -1.0, 0.0)
    if element is None:
        return PID(*defaults)
    return PID(*(element.Get(float, name, default)[0] for name, default in zip(_NAMES, defaults, strict=True)))
