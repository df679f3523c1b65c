"""Whether C++ sources are those of a plugin of Gazebo classic, or of a model of Gazebo 0.x."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

__all__ = ["OLD_NAMES", "asks_for_old_names", "is_classic", "version_flags"]

OLD_NAMES = ("-DGAZEBO_MAJOR_VERSION=7",)  # the compiler's option for them

_CLASSIC = re.compile(
    r"GZ_REGISTER_(WORLD|MODEL|SENSOR|SYSTEM|VISUAL|GUI)_PLUGIN"
    r"|#\s*include\s*[<\"]((gazebo-[\d.]+/)?gazebo/(gazebo|physics/|common/|sensors/|transport/|rendering/|msgs/|util/|gui/)|sdf/|ignition/)"
)

_OLD = re.compile(
    r"(?<!ignition::)(?<!ign::)\bmath::(Vector3|Pose|Quaternion|Matrix[34]|Vector2d|Angle|Box)\b(?!d)"
    r"|(->|\.)Get(World|Relative)(Pose|LinearVel|AngularVel|CoGPose)\(|->GetSimTime\(|->GetPhysicsEngine\("
)


def is_classic(sources: Sequence[Path]) -> bool:
    """Whether one of the sources names a header or macro that only Gazebo classic has; what is no text has none."""
    return any(_CLASSIC.search(path.read_text(errors="replace")) for path in sources if path.is_file())


def _own_version(sources: Sequence[Path]) -> bool:
    """Whether sources choose between versions themselves."""
    return any("GAZEBO_MAJOR_VERSION" in path.read_text(errors="replace") for path in sources if path.is_file())


def version_flags(sources: Sequence[Path]) -> list[str]:
    """The compiler's option for the names of Gazebo 7, if sources use common ones of them and ask for no version."""
    texts = [path.read_text(errors="replace") for path in sources if path.is_file()]
    return list(OLD_NAMES) if any(map(_OLD.search, texts)) and not _own_version(sources) else []


def asks_for_old_names(sources: Sequence[Path], errors: Sequence[str]) -> bool:
    """Whether errors of a compiler may come from names of Gazebo 7: missing getters, or gazebo::math.

    Sources that choose between versions may know no version above 7.
    """
    missing = re.compile(r"no member named '?(Get|Set|Disconnect)|'?(gazebo::)?math'? has not been declared")
    return _own_version(sources) or any(map(missing.search, errors))
