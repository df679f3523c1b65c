"""SonarSensor: the distance of the nearest collision in a cone or a sphere."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzCoordPoseAdd, GzPose
from libgz.classic import msgs
from libgz.classic.math import Vector3d
from libgz.classic.physics.ray_shape import ray_table
from libgz.classic.sensors.read import choice, clip, known_children, number
from libgz.classic.sensors.sensor import LinkSensor, SensorOwner
from libgz.simulation.event import Connection

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["SonarSensor"]

RINGS = 10  # of rays in the cone, 6, 12, 18 ... around the middle one: gaps are 1/10 of the radius
SPHERE = 2000  # rays, 4 degrees apart


class SonarSensor(LinkSensor):
    """A sonar. Its cone begins at the sensor and opens downwards, along -z; a sphere is around it.

    Rays fill the space, and the nearest hit counts. Objects thinner than the gaps between rays, a tenth of the cone's
    radius at its base, may be missed.
    """

    STATE = (
        "_reached",
        "_rows",
        "_range",
        "_contact",
    )

    topic_suffix: ClassVar[str | None] = "sonar"
    topic_added = True
    message_type: ClassVar[Any] = msgs.SonarStamped

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        sonar = sdf.child("sonar")
        self._min, self._max = clip(sonar, "min", "max")
        self._radius = number(sonar, "radius", 0.0, unit="m") if sonar.HasElement("radius") else 0.5
        known = sonar.HasElement("geometry") or "geometry" in known_children(sonar)
        self._geometry = choice(sonar, "geometry", ("cone", "sphere"), "cone") if known else "cone"
        self._place()
        self._reached: NDArray[np.float64] = np.zeros(len(self._rays))
        self._rows: NDArray[np.int64] = np.zeros(len(self._rays), dtype=np.int64)
        self._range = self._max
        self._contact = Vector3d()

    def _place(self) -> None:
        ways = sphere_rays() if self._geometry == "sphere" else cone_rays(self._radius / (self._max - self._min))
        self._rays = ray_table(ways, (0.0, self._max), self._pose)

    def SetPose(self, pose: GzPose) -> None:
        """Set the pose in its link [m]."""
        super().SetPose(pose)
        self._place()

    def LoadState(self, _state: object) -> None:
        """Place the rays where its pose is now."""
        self._place()

    def SaveState(self) -> None:
        """Its pose is all."""

    def ConnectUpdate(self, callback: Callable[..., object]) -> Connection:
        """Call `callback` with a msgs.SonarStamped after each measurement, as long as the connection is kept."""
        return self.listen(self._message_event, callback)

    def measure(self, elapsed: float) -> None:
        """Find the nearest collision; the sonar's own link is left out."""
        pose = self.link.pose()
        frame = np.array((*pose.pos, *pose.rot))
        self.world.core.engine.scan(frame, self._rays, self.link.body.number, self._reached, self._rows)
        nearest = int(np.argmin(self._reached))
        hit = self._reached[nearest] < self._max
        self._range = float(self._reached[nearest]) if hit else self._max
        along = self._rays[nearest, :3] + self._rays[nearest, 3:6] * self._range
        self._contact = pose_point(pose, along) if hit else Vector3d()

    def message(self) -> Any:
        """The last measurement as a msgs.SonarStamped."""
        msg = self.stamped()
        sonar = msg.sonar
        sonar.frame, sonar.geometry = self.ParentName(), self._geometry
        msgs.Set(sonar.world_pose, self.world_pose())
        sonar.range_min, sonar.range_max, sonar.radius = self._min, self._max, self._radius
        sonar.range = self._range
        msgs.Set(sonar.contact, self._contact)
        return msg

    def Range(self) -> float:
        """Distance of the nearest collision [m]; the maximum for none."""
        return self._range

    def RangeMin(self) -> float:
        """Nearest that is measured [m]."""
        return self._min

    def RangeMax(self) -> float:
        """Farthest that is measured [m]."""
        return self._max

    def Radius(self) -> float:
        """Radius of the cone at its far end [m]."""
        return self._radius

    def Geometry(self) -> str:
        """``cone`` or ``sphere``."""
        return self._geometry

    GetRange, GetRangeMin, GetRangeMax, GetRadius, GetGeometry = Range, RangeMin, RangeMax, Radius, Geometry


def cone_rays(slope: float) -> NDArray[np.float64]:
    """Unit vectors around -z, up to the rim of a cone of radius `slope` at height 1; shape (n, 3)."""
    ends = [(0.0, 0.0)]
    for ring in range(1, RINGS + 1):
        for i in range(6 * ring):
            angle = 2.0 * math.pi * i / (6 * ring)
            ends.append((slope * ring / RINGS * math.cos(angle), slope * ring / RINGS * math.sin(angle)))
    rays = np.column_stack([np.array(ends), -np.ones(len(ends))])
    unit: NDArray[np.float64] = rays / np.linalg.norm(rays, axis=1)[:, None]
    return unit


def sphere_rays() -> NDArray[np.float64]:
    """Unit vectors all around, evenly spread along a spiral; shape (n, 3)."""
    i = np.arange(SPHERE)
    z = 1.0 - (2.0 * i + 1.0) / SPHERE
    angle = i * math.pi * (3.0 - math.sqrt(5.0))  # the golden angle
    across = np.sqrt(1.0 - z * z)
    return np.column_stack([across * np.cos(angle), across * np.sin(angle), z])


def pose_point(pose: GzPose, point: NDArray[np.float64]) -> Vector3d:
    """A point in a frame [m], global."""
    return Vector3d(*GzCoordPoseAdd(GzPose(Vector3d(*point.tolist())), pose).pos)
