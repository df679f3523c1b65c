"""Guard: checks of the numbers that clients write."""

from __future__ import annotations

import logging
import math

from libgz.base.records import SwitchRecord
from libgz.transport.tally import Tally

__all__ = ["Guard"]

log = logging.getLogger("libgz.transport")


class Guard:
    """Accepts numbers in range, clamps large ones, and ignores NaN and infinities.

    It warns of each problem at the first time, and then at growing counts.

    Args:
        label: the interface, for messages.
    """

    def __init__(self, label: str) -> None:
        self.label = label
        self._tally = Tally()
        self._switches: dict[str, SwitchRecord] = {}

    def number(self, name: str, value: float, previous: float, limit: float) -> float:
        """`value` clamped to +-limit, or `previous` where it is not finite."""
        if -limit <= value <= limit:
            return value
        if not math.isfinite(value):
            self.warn(name, "is {}", "is ignored", value)
            return previous
        self.warn(name, "is {0:g}", "is clamped to {1:g}", value, limit)
        return math.copysign(limit, value)

    def switch(self, name: str, value: int, previous: bool) -> bool:
        """`value` as a bool if it is 0 or 1, or `previous`: other numbers are no command but overwritten memory."""
        if value == 0 or value == 1:
            return bool(value)
        record = self._switches.get(name)
        times = 1 if record is None else 1 + record.ignored
        self.warn(name, "is {}, neither 0 nor 1", "is ignored", value, times=times)
        if record is not None:
            record.ignored, record.most_ignored = 0, self._tally.unlogged((name, "is ignored"))
        return previous

    def switch_record(self, name: str) -> SwitchRecord:
        """How often native code may ignore numbers in a switch before `switch` has to warn."""
        return self._switches.setdefault(name, SwitchRecord(0, self._tally.unlogged((name, "is ignored"))))

    def warn(self, name: str, problem: str, consequence: str, *values: object, times: int = 1) -> None:
        """Warn about a field: the first time for each consequence, and then at growing counts.

        Args:
            name: the field.
            problem: what is wrong with it, such as "is {}".
            consequence: what the server does about it, such as "is ignored".
            values: what the client wrote, for both formats; they are formatted only when the warning is logged.
            times: how often it happened since the last call.
        """
        cause = (name, consequence)
        if self._tally.due(cause, times):
            text = f"{problem}, and {consequence}".format(*values) if values else f"{problem}, and {consequence}"
            log.warning("a client wrote %s: %s %s%s", self.label, name, text, self._tally.times(cause))
