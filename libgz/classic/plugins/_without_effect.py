"""WithoutEffect: base class of Gazebo's plugins that need what libgz does not have."""

from __future__ import annotations

import logging
from typing import Any, ClassVar

log = logging.getLogger("libgz.classic")

__all__ = ["WithoutEffect"]


class WithoutEffect:
    """Logs once, when it is loaded, that it has no effect, and why. The world runs as without it."""

    STATE: ClassVar[tuple[str, ...]] = ()
    reason: ClassVar[str] = ""

    def Load(self, *values: Any) -> None:
        """Log the reason, with the place in the world's file."""
        where = getattr(values[-1], "where", "")
        log.warning("%s%s has no effect: %s", f"{where}: " if where else "", type(self).__name__, self.reason)
