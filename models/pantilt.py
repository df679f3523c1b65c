"""PanTiltCamera: a camera head on two hinges, commanded through `ptz`, seeing through `camera`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from libgz.geometry import GzColor, GzPose, GzQuaternFromAxis, GzVector
from libgz.interfaces.ptz import Ptz
from libgz.legacy.model import Model
from libgz.models.camera import CameraServer, RobotCameraAttributes, add_frustum, check_optics
from libgz.ode.types import dParamFMax, dParamVel
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import CylinderGeom
from libgz.physics.joint import HingeJoint
from libgz.simulation.rate import OldRate, UpdateRate
from libgz.transport.guard import Guard
from libgz.worldfile.attributes import number, numbers, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["PanTiltAttributes", "PanTiltCamera"]

PTZ_RATE = 10.0  # [Hz]
MAX_TORQUE = 10.1  # [N m]
TILT_ANCHOR = (0.0, 0.0, 0.025)  # [m]
EYE = GzPose(GzVector(0.10, 0.0, 0.0))  # optical centre on the head [m]: before the housing, not at the lens
SMALLEST_LIMIT_IN_DEGREES = 5.0  # zoomLimits from here on are fields of view, not factors


@dataclass(frozen=True)
class PanTiltAttributes(RobotCameraAttributes):
    """What the element of a pan-tilt-zoom camera may hold."""

    zoomLimits: tuple[float, ...] = numbers(
        1.0,
        10.0,
        above=0.0,
        help="smallest and largest zoom factor; or fields of view in degrees, if both are 5 or more",
    )
    motionGain: float = number(2.0, unit="1/s", least=0.0, help="speed of pan and tilt per radian of error")
    zoomGain: float = number(2.0, unit="1/s", least=0.0, help="how fast the zoom approaches what is commanded")


class PanTiltCamera(Model):
    """Three bodies: a base, a middle that pans on it, a head that tilts on that."""

    attributes = PanTiltAttributes
    interfaces = ("ptz", "camera")

    panLimits: ClassVar[tuple[float, float]]  # [rad]
    tiltLimits: ClassVar[tuple[float, float]]  # [rad], down positive

    def build(self) -> tuple[Body, Body, Body]:
        """Build base, middle and head, the base canonical."""
        raise NotImplementedError

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = values = read(PanTiltAttributes, node)
        check_optics(node, values)
        low, high = sorted(values.zoomLimits)
        if low >= SMALLEST_LIMIT_IN_DEGREES:
            low, high = (values.hfov / math.radians(limit) for limit in (high, low))
        self.zoomLimits = (low, max(low, high))
        self.zoom = self.zoomLimits[0]
        base, middle, self.head = self.build()
        self.pan = self._hinge("pan", middle, base, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        self.tilt = self._hinge("tilt", self.head, middle, TILT_ANCHOR, (0.0, 1.0, 0.0))
        for body in (middle, self.head):
            body.SetFiniteRotationMode(1)
        old = "updateTimes" in self.world.engine.quirks
        self.rate = OldRate(1.0 / PTZ_RATE, last=-1.0 / PTZ_RATE) if old else UpdateRate(PTZ_RATE)
        self.command = (0.0, 0.0, math.pi)
        self.ptz = Ptz()
        self.camera = CameraServer(self, values)
        self.frustum = add_frustum(self, self.head, values, EYE)

    def add_part(self, body: Body, geom: Geom, pose: GzPose, mass: float, color: GzColor | None) -> None:
        """Place one geom of the housing."""
        geom.SetRelativePose(pose)
        geom.SetMass(mass)
        if color is not None:
            geom.SetColor(color)

    def add_lens(self, head: Body, x: float, z: float) -> None:
        """The lens, looking along x; it weighs nothing."""
        lens = CylinderGeom(head, self.modelSpaceId, 0.024, 0.01)
        along_x = GzQuaternFromAxis(0.0, 1.0, 0.0, math.pi / 2.0)
        self.add_part(head, lens, GzPose(GzVector(x, 0.0, z), along_x), 0.0, None)

    def _hinge(
        self, name: str, moving: Body, base: Body, anchor: tuple[float, ...], axis: tuple[float, ...]
    ) -> HingeJoint:
        hinge = HingeJoint(self.world, name=name)
        hinge.Attach(moving, base)
        hinge.SetAnchor(anchor)
        hinge.SetAxis(axis)
        hinge.SetParam(dParamVel, 0.0)
        hinge.SetParam(dParamFMax, MAX_TORQUE)
        return hinge

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.guard = Guard(f"ptz.{self.GetId()}")
        self.ptz.create(self.world.gz_server, self.GetId(), self.GetName(), self.GetIntId(), self.GetParentIntId())
        self.ptz.data.cmd_zoom = math.pi
        self.ptz.data.zoom = self.values.hfov / self.zoom
        self.camera.init()

    def Fini(self) -> None:  # noqa: D102
        self.ptz.destroy()
        self.camera.fini()

    def Update(self, step: float) -> None:  # noqa: D102
        now = self.world.GetSimTime()
        before = self.rate.last
        if step != 0.0 and self.rate.due(now):
            self._move(now, before)
        view = self.values.hfov / self.zoom
        if self.camera.update(self.head.global_pose(EYE), view) and self.frustum is not None:
            self.frustum.SetFOV(view)

    def _move(self, now: float, before: float) -> None:
        """One tick of the motors and the zoom; the last one was at `before` [s]."""
        self._take_command()
        pan, tilt, view = self.command
        self.pan.SetParam(dParamVel, self.values.motionGain * (_clamp(pan, self.panLimits) - self.pan.GetAngle()))
        self.tilt.SetParam(dParamVel, self.values.motionGain * (_clamp(tilt, self.tiltLimits) - self.tilt.GetAngle()))
        wanted = _clamp(self.values.hfov / view if view > 0.0 else math.inf, self.zoomLimits)
        elapsed = now - before if math.isfinite(before) else 0.0
        self.zoom += (wanted - self.zoom) * min(1.0, self.values.zoomGain * elapsed)
        self._publish(now)

    def _take_command(self) -> None:
        """What the client wants, if its lock can be had and its numbers are sane."""
        if not self.ptz.lock():
            return
        data = self.ptz.data
        wanted = (data.cmd_pan, data.cmd_tilt, data.cmd_zoom)
        self.ptz.unlock()
        names = ("cmd_pan", "cmd_tilt", "cmd_zoom")
        checked = [self.guard.number(n, w, old, 1e3) for n, w, old in zip(names, wanted, self.command, strict=True)]
        self.command = (checked[0], checked[1], checked[2])

    def _publish(self, now: float) -> None:
        if self.ptz.lock():
            data = self.ptz.data
            data.time, data.pan, data.tilt = now, self.pan.GetAngle(), self.tilt.GetAngle()
            data.zoom = self.values.hfov / self.zoom
            self.ptz.unlock()
            self.ptz.post()


def _clamp(value: float, limits: tuple[float, float]) -> float:
    return min(max(value, limits[0]), limits[1])
