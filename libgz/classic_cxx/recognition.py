"""Whether C++ sources are those of a plugin of Gazebo classic, or of a model of Gazebo 0.x."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

__all__ = ["is_classic", "version_flags"]

_CLASSIC = re.compile(
    r"GZ_REGISTER_(WORLD|MODEL|SENSOR|SYSTEM|VISUAL|GUI)_PLUGIN"
    r"|#\s*include\s*[<\"](gazebo/(gazebo|physics/|common/|sensors/|transport/|rendering/|msgs/|util/|gui/)|sdf/|ignition/)"
)

_OLD = re.compile(
    r"(?<!ignition::)(?<!ign::)\bmath::(Vector3|Pose|Quaternion|Vector2d|Angle|Box)\b(?!d)"
    r"|(->|\.)Get(World|Relative)(Pose|LinearVel|AngularVel|CoGPose)\(|->GetSimTime\(|->GetPhysicsEngine\("
)


def is_classic(sources: Sequence[Path]) -> bool:
    """Whether one of the sources names a header or macro that only Gazebo classic has; what is no text has none."""
    return any(_CLASSIC.search(path.read_text(errors="replace")) for path in sources if path.is_file())


def version_flags(sources: Sequence[Path]) -> list[str]:
    """The compiler's option for the names of Gazebo 7, if sources use them and ask for no version themselves."""
    texts = [path.read_text(errors="replace") for path in sources if path.is_file()]
    asks = any("GAZEBO_MAJOR_VERSION" in text for text in texts)
    return ["-DGAZEBO_MAJOR_VERSION=7"] if not asks and any(map(_OLD.search, texts)) else []
