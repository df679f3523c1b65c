"""Guard: what clients write is never trusted."""

from __future__ import annotations

import logging
import math

__all__ = ["Guard"]

log = logging.getLogger("libgz.transport")


class Guard:
    """Lets sane numbers through, clamps large ones, drops NaN and infinities, and says each thing once.

    Args:
        label: the interface, for messages.
    """

    def __init__(self, label: str) -> None:
        self.label = label
        self._told: set[tuple[str, str]] = set()

    def number(self, name: str, value: float, previous: float, limit: float) -> float:
        """`value` within +-limit, or `previous` where it is not a number."""
        if -limit <= value <= limit:
            return value
        if not math.isfinite(value):
            self.tell(name, f"is {value}, and is ignored")
            return previous
        self.tell(name, f"is {value:g}, and is clamped to {limit:g}")
        return math.copysign(limit, value)

    def tell(self, name: str, what: str) -> None:
        """Warn about a field, once for each kind of error."""
        kind = what.split(",")[-1]
        if (name, kind) not in self._told:
            self._told.add((name, kind))
            log.warning("a client wrote %s: %s %s", self.label, name, what)
