"""Whether C++ sources are those of a plugin of Gazebo classic, or of a model of Gazebo 0.x."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

__all__ = ["is_classic"]

_CLASSIC = re.compile(
    r"GZ_REGISTER_(WORLD|MODEL|SENSOR|SYSTEM|VISUAL|GUI)_PLUGIN"
    r"|#\s*include\s*[<\"](gazebo/(gazebo|physics/|common/|sensors/|transport/|rendering/|msgs/|util/|gui/)|sdf/|ignition/)"
)


def is_classic(sources: Sequence[Path]) -> bool:
    """Whether one of the sources names a header or macro that only Gazebo classic has; what is no text has none."""
    return any(_CLASSIC.search(path.read_text(errors="replace")) for path in sources if path.is_file())
