"""PanTiltCamera: a camera head on two hinges, commanded through `ptz`; its images are served through `camera`."""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.base.geometry import GzPose, GzQuaternFromAxis, GzVector, VectorLike
from libgz.interfaces.ptz import Ptz
from libgz.legacy.model import Model
from libgz.models.camera import CameraServer, RobotCameraAttributes, add_frustum, check_optics
from libgz.models.motors import Axis, Servo
from libgz.models.parts import fit
from libgz.models.serving import serve
from libgz.models.wheels import add_hinge
from libgz.ode.types import dParamVel
from libgz.physics.body import Body
from libgz.physics.geoms import CylinderGeom
from libgz.physics.joint import HingeJoint
from libgz.simulation.plan import Plan
from libgz.simulation.rate import OldRate, UpdateRate
from libgz.transport.guard import Guard
from libgz.worldfile.attributes import declaration, number, numbers, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["PanTiltAttributes", "PanTiltCamera"]

PTZ_RATE = 10.0  # [Hz]
MAX_TORQUE = 10.1  # [N m]
LARGEST_COMMAND = 1e3  # [rad]
TILT_ANCHOR = (0.0, 0.0, 0.025)  # [m]
EYE = GzPose(GzVector(0.10, 0.0, 0.0))  # optical centre on the head [m]: in front of the housing, not at the lens
SMALLEST_LIMIT_IN_DEGREES = 5.0  # zoomLimits from this value on are fields of view, not factors


@declaration
class PanTiltAttributes(RobotCameraAttributes):
    """Attributes of a pan-tilt-zoom camera."""

    zoomLimits: tuple[float, ...] = numbers(
        1.0,
        10.0,
        above=0.0,
        help="smallest and largest zoom factor; or fields of view in degrees, if both are 5 or more",
    )
    motionGain: float = number(2.0, unit="1/s", least=0.0, help="pan and tilt velocity per radian of error")
    zoomGain: float = number(2.0, unit="1/s", least=0.0, help="rate at which the zoom approaches the command")


class PtzServer:
    """The ptz interface of a camera.

    Attributes:
        command: pan, tilt and field of view that the client wants [rad].
    """

    STATE: ClassVar[tuple[str, ...]] = ("command",)

    def __init__(self, model: Model) -> None:
        self.model = model
        self.interface = Ptz()
        self.command = (0.0, 0.0, math.pi)

    def Init(self, view: float) -> None:
        """Create the interface with a field of view [rad]."""
        self._guard = Guard(f"ptz.{self.model.GetId()}")
        serve(self.model, self.interface)
        self.interface.data.cmd_zoom = math.pi
        self.interface.data.zoom = view

    def Fini(self) -> None:
        """Destroy the interface."""
        self.interface.destroy()

    def take_command(self) -> None:
        """Read the client's command; numbers that are not finite are ignored."""
        if not self.interface.lock():
            return
        data = self.interface.data
        wanted = (data.cmd_pan, data.cmd_tilt, data.cmd_zoom)
        self.interface.unlock()
        if wanted == self.command or not self.interface.intact():  # an unchanged command was checked before
            return
        number, old = self._guard.number, self.command
        self.command = (
            number("cmd_pan", wanted[0], old[0], LARGEST_COMMAND),
            number("cmd_tilt", wanted[1], old[1], LARGEST_COMMAND),
            number("cmd_zoom", wanted[2], old[2], LARGEST_COMMAND),
        )

    def publish(self, now: float, pan: float, tilt: float, view: float) -> None:
        """Publish angles and field of view [rad] at sim time `now` [s]."""
        if self.interface.lock():
            data = self.interface.data
            data.time, data.pan, data.tilt, data.zoom = now, pan, tilt, view
            self.interface.unlock()
            self.interface.post()


class PanTiltCamera(Model):
    """Three bodies: a base, a middle part that pans on it, and a head that tilts on the middle part."""

    STATE: ClassVar[tuple[str, ...]] = ("rate", "zoom", "ptz", "camera", "_shown_view", "_moved")

    behaviour = "motors that turn and hold its head (it tilts by its weight); zoom"
    attributes = PanTiltAttributes
    interfaces = ("ptz", "camera")
    active_while_paused = True  # the image that is due is taken

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
        self.pan = self._add_hinge("pan", middle, base, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        self.tilt = self._add_hinge("tilt", self.head, middle, TILT_ANCHOR, (0.0, 1.0, 0.0))
        self._panServo, self._tiltServo = (
            Servo(Axis(hinge), values.motionGain, MAX_TORQUE) for hinge in (self.pan, self.tilt)
        )
        self.pan.commanded, self.tilt.commanded = self.panLimits, self.tiltLimits
        for body in (middle, self.head):
            body.SetFiniteRotationMode(1)
        old = "updateTimes" in self.world.engine.quirks
        self.rate = OldRate(1.0 / PTZ_RATE, last=-1.0 / PTZ_RATE) if old else UpdateRate(PTZ_RATE)
        self._moved = self.rate.last  # sim time of the last `_move` [s]
        self.ptz = PtzServer(self)
        self.camera = CameraServer(self, values)
        self.frustum = add_frustum(self, self.head, values, EYE)

    def add_lens(self, head: Body, x: float, z: float) -> None:
        """The lens at (x, 0, z) on the head [m], looking along x; it has no mass."""
        along_x = GzQuaternFromAxis(0.0, 1.0, 0.0, math.pi / 2.0)
        fit(CylinderGeom(head, self.modelSpaceId, 0.024, 0.01), (x, 0.0, z), 0.0, rotation=along_x)

    def _add_hinge(self, name: str, moving: Body, base: Body, anchor: VectorLike, axis: VectorLike) -> HingeJoint:
        hinge = add_hinge(self, moving, base, anchor, axis, name)
        hinge.SetParam(dParamVel, 0.0)
        return hinge

    @property
    def fieldOfView(self) -> float:
        """The horizontal field of view at the present zoom [rad]."""
        return self.values.hfov / self.zoom

    @property
    def _shown_view(self) -> float | None:
        """The field of view that the frustum has [rad]; None without one."""
        return self.frustum.fov if self.frustum is not None else None

    @_shown_view.setter
    def _shown_view(self, view: float | None) -> None:
        if self.frustum is not None and view is not None:
            self.frustum.SetFOV(view)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.ptz.Init(self.fieldOfView)
        self.camera.Init()

    def Fini(self) -> None:  # noqa: D102
        self.ptz.Fini()
        self.camera.Fini()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        with plan.due(self.rate):
            plan.do(self._move)
        self.camera.plan_update(plan, self._look)

    def _look(self) -> None:
        """Take an image with the present zoom."""
        view = self.fieldOfView
        self.camera.take(self.head.global_pose(EYE), view)
        if self.frustum is not None:
            self.frustum.SetFOV(view)

    def _move(self, step: float) -> None:
        """Set motors and zoom; while the world is paused, that stays due."""
        if step == 0.0:
            self.rate.last = self._moved
            return
        now, before = self.world.GetSimTime(), self._moved
        self._moved = now
        self.ptz.take_command()
        pan, tilt, view = self.ptz.command
        self._panServo.turn_to(_clamp(pan, self.panLimits))
        self._tiltServo.turn_to(_clamp(tilt, self.tiltLimits))
        wanted = _clamp(self.values.hfov / view if view > 0.0 else math.inf, self.zoomLimits)
        elapsed = now - before if math.isfinite(before) else 0.0
        self.zoom += (wanted - self.zoom) * min(1.0, self.values.zoomGain * elapsed)
        self.ptz.publish(now, self.pan.GetAngle(), self.tilt.GetAngle(), self.fieldOfView)


def _clamp(value: float, limits: tuple[float, float]) -> float:
    return min(max(value, limits[0]), limits[1])
