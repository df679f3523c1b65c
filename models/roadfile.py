"""Road files: one record per line, separated by blanks.

`waypoint S N E N Z` is a sign: distance along the road, its number, UTM easting and northing, height [m];
`track S I E N Z K p1 ... pK` is a point of the road: distance, number of the waypoint before it, UTM easting and
northing, height, and K heights across the road from right to left, relative to the point [m].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

from libgz.base.errors import ParameterError
from libgz.base.files import read_text
from libgz.base.geometry import GzVector

__all__ = ["RoadFile", "read_road"]


@dataclass(frozen=True)
class TrackPoint:
    """A point of the road."""

    distance: float  # along the road [m]
    position: GzVector  # [m]
    profile: list[float]  # heights across, right to left [m]


@dataclass
class RoadFile:
    """The contents of a road file in the world's coordinates."""

    track: list[TrackPoint] = field(default_factory=list)
    signs: list[tuple[GzVector, str]] = field(default_factory=list)
    damage: list[str] = field(default_factory=list)  # descriptions of the ignored lines


def read_road(path: Path, offset: GzVector) -> RoadFile:
    """Read a road file; `offset` [m] is subtracted from UTM coordinates, not from heights.

    Raises:
        ParameterError: the file cannot be read.
    """
    try:
        lines = read_text(path).splitlines()
    except OSError as error:
        raise ParameterError(f"cannot be read: {error.strerror}") from None
    road = RoadFile()
    for number, line in enumerate(lines, 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            _take(road, words, offset)
        except (ValueError, IndexError):
            road.damage.append(f"line {number} is neither 'waypoint S N E N Z' nor 'track S I E N Z K p1 ... pK'")
    return road


def _take(road: RoadFile, words: list[str], offset: GzVector) -> None:
    """Add one record; ValueError or IndexError if it is invalid."""
    if words[0] == "waypoint":  # its number is a text on the sign
        words = [*words[:2], *words[2:6]]
    values = [float(word) for word in words[1:]]
    if not all(map(math.isfinite, values)):
        raise ValueError("not finite")
    east, north, z = values[2:5]
    position = GzVector(east - offset.x, north - offset.y, z)
    if words[0] == "waypoint":
        road.signs.append((position, words[2]))
    elif words[0] == "track":
        if len(values[6:]) != values[5]:
            raise ValueError(f"{len(values[6:])} heights instead of {words[6]}")
        road.track.append(TrackPoint(values[0], position, values[6:]))
    else:
        raise ValueError(words[0])
