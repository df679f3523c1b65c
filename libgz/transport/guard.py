"""Guard: checks of the numbers that clients write."""

from __future__ import annotations

import logging
import math

__all__ = ["Guard"]

log = logging.getLogger("libgz.transport")


class Guard:
    """Accepts numbers in range, clamps large ones, and ignores NaN and infinities; it warns once of each problem.

    Args:
        label: the interface, for messages.
    """

    def __init__(self, label: str) -> None:
        self.label = label
        self._reported: set[tuple[str, str]] = set()

    def number(self, name: str, value: float, previous: float, limit: float) -> float:
        """`value` clamped to +-limit, or `previous` where it is not finite."""
        if -limit <= value <= limit:
            return value
        if not math.isfinite(value):
            self.warn(name, f"is {value}", "is ignored")
            return previous
        self.warn(name, f"is {value:g}", f"is clamped to {limit:g}")
        return math.copysign(limit, value)

    def warn(self, name: str, problem: str, consequence: str) -> None:
        """Warn about a field, once for each consequence.

        Args:
            name: the field.
            problem: what is wrong with it, such as "is nan".
            consequence: what the server does about it, such as "is ignored".
        """
        if (name, consequence) not in self._reported:
            self._reported.add((name, consequence))
            log.warning("a client wrote %s: %s %s, and %s", self.label, name, problem, consequence)
