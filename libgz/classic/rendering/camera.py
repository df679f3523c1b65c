"""Camera: pictures of a world as Gazebo classic's plugins get them."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from libgz.classic.common import Time
from libgz.classic.math import Angle, Pose3d, Quaterniond, Vector2i, Vector3d
from libgz.classic.rendering.image_format import bytes_per_pixel, check_format, pack
from libgz.classic.rendering.mount import Mount
from libgz.errors import GazeboError, ParameterError
from libgz.geometry import GzCoordPositionAdd, GzCoordPositionSub, GzPose, GzVector, QuaternLike, VectorLike, rotate
from libgz.rendering.camera import LEAST_NEAR, Camera as CoreCamera
from libgz.rendering.image import write_image
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.physics.world import World
    from libgz.classic.rendering.scene import Scene
    from libgz.classic.rendering.visual import Visual

__all__ = ["Camera", "cameras_of", "draw_frame"]

log = logging.getLogger("libgz.classic")

_cameras: WeakKeyDictionary[Any, list[Camera]] = WeakKeyDictionary()  # of each world


def cameras_of(world: World) -> list[Camera]:
    """The cameras of a world, oldest first."""
    return _cameras.setdefault(world.core, [])


def draw_frame(world: World, cameras: Iterable[Camera]) -> None:
    """Draw a picture with each camera: event PreRender, the pictures, Render, their callbacks, PostRender."""
    events, cameras = world.core.events, list(cameras)
    events["PreRender"]()
    for camera in cameras:
        camera.Update()
        camera.Render()
    events["Render"]()
    for camera in cameras:
        camera.PostRender()
    events["PostRender"]()
    events["PreRenderEnded"]()


class Camera:
    """A camera that looks along +x of its pose, z up: a view on a `libgz.rendering.camera.Camera`.

        camera = Camera(world, "eye", 320, 240)
        camera.SetWorldPose(Pose3d(-3, 0, 1, 0, 0.2, 0))
        draw_frame(world, [camera])
        camera.ImageData()

    Args:
        world: the classic world.
        name: of the camera.
        width, height: of the picture [px].
        hfov: horizontal field of view [rad].
        near, far: nearest and farthest that is drawn [m].
        image_format: layout of `ImageData`, one of SDF's `<image><format>`.

    Attributes:
        pixels: the last picture, shape (height, width, 3), red, green, blue, top row first.
        filters: functions that change `pixels` in place after each drawing, such as noise.
        distortion: what `LensDistortion` gives.

    Raises:
        ParameterError: an argument is out of range.
        LibraryError: the chosen OpenGL does not work here.
    """

    def __init__(
        self,
        world: World,
        name: str,
        width: int = 320,
        height: int = 240,
        hfov: float = 1.047,
        near: float = 0.1,
        far: float = 100.0,
        image_format: str = "R8G8B8",
    ) -> None:
        self._world, self._name = world, name
        self._format = check_format(image_format)
        self.view = CoreCamera(world.core, width, height, float(hfov), near, far)
        self.mount = Mount(self)
        self.filters: list[Callable[[NDArray[np.uint8]], object]] = []
        self.distortion: Any = None
        self._new_frame = Event("NewImageFrame")
        self._capture, self._saving, self._folder, self._saved = True, False, Path(), 0
        self._rate, self._fps, self._last = 30.0, 0.0, 0.0
        self._fresh = False
        cameras_of(world).append(self)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._name!r}>"

    def close(self) -> None:
        """Let the camera go. Can be called twice."""
        if self in cameras_of(self._world):
            cameras_of(self._world).remove(self)
        self._new_frame.clear()
        self.view.close()

    Fini = close

    def __enter__(self) -> Camera:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def Name(self) -> str:
        """Its name."""
        return self._name

    GetName = Name

    def ScopedName(self) -> str:
        """Its name after the world's, joined by ``::``."""
        return f"{self._world.Name()}::{self._name}"

    GetScopedName = ScopedName

    def GetScene(self) -> Scene:
        """The scene that it looks at."""
        from libgz.classic.rendering.scene import scene_of

        return scene_of(self._world)

    def Initialized(self) -> bool:
        """Whether it can take pictures: OpenGL is not switched off."""
        return not self.view.blind

    GetInitialized = Initialized

    # Drawing -----------------------------------------------------------------------------------------------------

    def Update(self) -> None:
        """Go along with what it is attached to, looks after, or moves along."""
        self.mount.update()

    def Render(self, force: bool = False) -> None:
        """Take a picture of the world as it is now; `draw_frame` does it with the events around it."""
        if not self.view.blind:
            self._draw()
            self._drawn()

    def _draw(self) -> None:
        self.view.Update()

    def _drawn(self) -> None:
        for change in self.filters:
            change(self.pixels)
        now = time.monotonic()
        if self._last and now > self._last:
            rate = 1.0 / (now - self._last)
            self._fps = 0.9 * self._fps + 0.1 * rate if self._fps else rate
        self._last, self._fresh = now, True

    def PostRender(self) -> None:
        """Hand the last picture to those who wait for it, and to a file if that is wanted; once for each picture."""
        if not self._fresh or not self._capture:
            return
        self._fresh = False
        if self._saving:
            self._save_next()
        self._deliver()

    def _deliver(self) -> None:
        if self._new_frame:
            self._new_frame(
                self.ImageData(), self.ImageWidth(), self.ImageHeight(), self.ImageDepth(), self.ImageFormat()
            )

    @property
    def wanted(self) -> bool:
        """Whether anybody waits for its pictures."""
        return self._capture and (self._saving or bool(self._new_frame))

    def ConnectNewImageFrame(self, callback: Callable[..., object]) -> Connection:
        """Call ``callback(data, width, height, depth, format)`` with each picture, as long as the result is kept."""
        return self._new_frame.Connect(callback)

    def DisconnectNewImageFrame(self, connection: Connection) -> None:
        """End a connection."""
        connection.Disconnect()

    def SetCaptureData(self, value: bool) -> None:
        """Whether pictures are handed out; classic's user camera did so on request only, here all do at first."""
        self._capture = bool(value)

    def CaptureData(self) -> bool:
        """Whether pictures are handed out."""
        return self._capture

    GetCaptureData = CaptureData

    def LastRenderWallTime(self) -> Time:
        """Wall-clock time of the last picture."""
        return Time(time.time() - (time.monotonic() - self._last)) if self._last else Time()

    GetLastRenderWallTime = LastRenderWallTime

    def AvgFPS(self) -> float:
        """Pictures in a second of wall-clock time, on average."""
        return self._fps

    GetAvgFPS = AvgFPS

    def RenderRate(self) -> float:
        """Pictures in a second that it is to take [Hz]."""
        return self._rate

    GetRenderRate = RenderRate

    def SetRenderRate(self, hz: float) -> None:
        """Set how many pictures in a second it is to take [Hz]; whoever draws keeps to it."""
        self._rate = float(hz)

    # The picture -------------------------------------------------------------------------------------------------

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """The last picture, shape (height, width, 3), red, green, blue, top row first."""
        return self.view.image

    def ImageData(self, i: int = 0) -> bytes:
        """The last picture, top row first, in the layout `ImageFormat`."""
        return pack(self.pixels, self._format)

    GetImageData = ImageData

    def ImageWidth(self, i: int = 0) -> int:
        """[px]."""
        return self.view.width

    def ImageHeight(self, i: int = 0) -> int:
        """[px]."""
        return self.view.height

    ViewportWidth = GetViewportWidth = GetImageWidth = ImageWidth
    ViewportHeight = GetViewportHeight = GetImageHeight = ImageHeight

    def SetImageSize(self, width: int, height: int) -> None:
        """Change the picture's size [px].

        Raises:
            ParameterError: one of them is below 1.
        """
        if width < 1 or height < 1:
            raise ParameterError(f"camera {self._name!r}: image has zero size: {width} x {height} px")
        self.view.width, self.view.height = int(width), int(height)
        self.view.image = np.zeros((self.view.height, self.view.width, 3), dtype=np.uint8)

    def ImageDepth(self) -> int:
        """Bytes of a pixel."""
        return bytes_per_pixel(self._format)

    GetImageDepth = ImageDepth

    def ImageFormat(self) -> str:
        """The layout of `ImageData`: R8G8B8, L8, ..."""
        return self._format

    GetImageFormat = ImageFormat

    def SetImageFormat(self, name: str) -> None:
        """Choose the layout of `ImageData`.

        Raises:
            ParameterError: there is no such layout.
        """
        self._format = check_format(name)

    def ImageByteSize(self) -> int:
        """Bytes of a picture."""
        return self.view.width * self.view.height * self.ImageDepth()

    GetImageByteSize = ImageByteSize

    def AspectRatio(self) -> float:
        """Width over height."""
        return self.view.width / self.view.height

    GetAspectRatio = AspectRatio

    def SaveFrame(self, filename: str) -> bool:
        """Write the last picture to a file, in the format of its name; whether that worked."""
        path = Path(filename)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_image(path, self.pixels)
        except (GazeboError, OSError) as error:
            log.error("camera %r: %s", self._name, error)
            return False
        return True

    def EnableSaveFrame(self, enable: bool) -> None:
        """Whether each picture is written to a file: ``<pathname>/<name>-0000.jpg`` and so on."""
        self._saving = bool(enable)

    def SetSaveFramePathname(self, pathname: str) -> None:
        """The folder for the pictures; it is made when it is needed."""
        self._folder, self._saved = Path(pathname), 0

    def _save_next(self) -> None:
        self._saving = self.SaveFrame(str(self._folder / f"{self._name.replace('::', '_')}-{self._saved:04d}.jpg"))
        self._saved += 1

    # Optics ------------------------------------------------------------------------------------------------------

    def HFOV(self) -> Angle:
        """Horizontal field of view [rad]."""
        return Angle(self.view.hfov)

    GetHFOV = HFOV

    def SetHFOV(self, angle: float | Angle) -> None:
        """Set the horizontal field of view [rad]."""
        self.view.SetFOV(float(angle))

    def VFOV(self) -> Angle:
        """Vertical field of view [rad]; pixels are square."""
        return Angle(2.0 * math.atan(math.tan(self.view.hfov / 2.0) / self.AspectRatio()))

    GetVFOV = VFOV

    def NearClip(self) -> float:
        """Nearest that is drawn [m]."""
        return self.view.near

    GetNearClip = NearClip

    def FarClip(self) -> float:
        """Farthest that is drawn [m]."""
        return self.view.far

    GetFarClip = FarClip

    def SetClipDist(self, near: float | None = None, far: float | None = None) -> None:
        """Set the nearest and the farthest that is drawn [m].

        Raises:
            ParameterError: they are not 0.01 m or more, the second beyond the first.
        """
        near, far = self.view.near if near is None else float(near), self.view.far if far is None else float(far)
        if not LEAST_NEAR <= near < far:
            raise ParameterError(f"clip distances are {near:g} and {far:g} m; allowed is {LEAST_NEAR} <= near < far")
        self.view.near, self.view.far = near, far

    def LensDistortion(self) -> Any:
        """The distortion of its lens; None if it has none."""
        return self.distortion

    GetDistortion = LensDistortion

    # Place -------------------------------------------------------------------------------------------------------

    def WorldPose(self) -> Pose3d:
        """Global pose [m]."""
        return Pose3d(self.view.GetPose())

    GetWorldPose = WorldPose

    def WorldPosition(self) -> Vector3d:
        """Global position [m]."""
        return self.WorldPose().Pos()

    GetWorldPosition = WorldPosition

    def WorldRotation(self) -> Quaterniond:
        """Global rotation."""
        return self.WorldPose().Rot()

    GetWorldRotation = WorldRotation

    def SetWorldPose(self, pose: GzPose) -> None:
        """Move it to a global pose [m]."""
        self.view.SetPose(GzPose(GzVector(*pose.pos), pose.rot))

    def SetWorldPosition(self, pos: VectorLike) -> None:
        """Move it to a global position [m]; its rotation stays."""
        self.SetWorldPose(GzPose(GzVector(*pos), self.view.pose.rot))

    def SetWorldRotation(self, quat: QuaternLike) -> None:
        """Turn it to a global rotation; its place stays."""
        self.SetWorldPose(Pose3d(self.view.pose.pos, quat))

    def Translate(self, direction: VectorLike) -> None:
        """Move it by a vector in its own frame [m]."""
        pose = self.view.pose
        self.SetWorldPosition(GzCoordPositionAdd(direction, pose.pos, pose.rot))

    def _axis(self, x: float, y: float, z: float) -> Vector3d:
        return Vector3d(*rotate(self.view.pose.rot, (x, y, z)))

    def Direction(self) -> Vector3d:
        """Where it looks, a global unit vector."""
        return self._axis(1.0, 0.0, 0.0)

    GetDirection = Direction

    def Up(self) -> Vector3d:
        """Upwards in the picture, a global unit vector."""
        return self._axis(0.0, 0.0, 1.0)

    GetUp = Up

    def Right(self) -> Vector3d:
        """To the right in the picture, a global unit vector."""
        return self._axis(0.0, -1.0, 0.0)

    GetRight = Right

    def Project(self, pt: VectorLike) -> Vector2i:
        """The pixel at which a global point [m] is seen, from the upper left; (-1, -1) for one behind the camera."""
        forward, left, up = GzCoordPositionSub(pt, self.view.pose.pos, self.view.pose.rot)
        if forward <= 0.0:
            return Vector2i(-1, -1)
        scale = self.view.view.focal / forward
        x, y = self.view.width / 2.0 - scale * left, self.view.height / 2.0 - scale * up
        return Vector2i(math.floor(x), math.floor(y))

    def CameraToViewportRay(self, screenx: float, screeny: float) -> tuple[Vector3d, Vector3d]:
        """(start [m], global unit vector) of what is seen at a pixel."""
        focal = self.view.view.focal
        left, up = self.view.width / 2.0 - screenx, self.view.height / 2.0 - screeny
        return self.WorldPosition(), self._axis(focal, left, up).Normalize()

    def WorldPointOnPlane(
        self, x: float, y: float, normal: VectorLike = (0.0, 0.0, 1.0), offset: float = 0.0
    ) -> Vector3d | None:
        """Where the plane normal . p = offset [m] is seen at a pixel; None where it is not."""
        start, way = self.CameraToViewportRay(x, y)
        n = Vector3d(*normal)
        slope = n.Dot(way)
        distance = (offset - n.Dot(start)) / slope if slope else -1.0
        return start + way * distance if distance >= 0.0 else None

    # Motion ------------------------------------------------------------------------------------------------------

    def AttachToVisual(
        self, visual: Visual | str | int, inheritOrientation: bool = True, minDist: float = 0.0, maxDist: float = 0.0
    ) -> bool:
        """Carry it along with a visual, at the place that it has to it now; whether there is such a visual."""
        found = self._find(visual)
        if found is not None:
            self.mount.attach(found, inheritOrientation)
        return found is not None

    def TrackVisual(self, visual: Visual | str) -> bool:
        """Let it look at a visual from now on, wherever it goes; an empty name ends it."""
        found = self._find(visual)
        self.mount.track(found)
        return found is not None

    def TrackedVisual(self) -> Visual | None:
        """What it looks after."""
        return self.mount.tracked

    GetTrackedVisual = TrackedVisual

    def _find(self, visual: Visual | str | int) -> Visual | None:
        if not isinstance(visual, str | int):
            return visual
        found = self.GetScene().GetVisual(visual) if visual != "" else None
        if found is None and visual != "":
            log.error("camera %r: there is no visual %r", self._name, visual)
        return found

    def MoveToPosition(self, pose: GzPose, time: float) -> bool:
        """Move it to a global pose [m] in so many seconds of wall-clock time; whether it does not move yet."""
        return self.MoveToPositions([pose], time)

    def MoveToPositions(
        self, poses: Sequence[GzPose], time: float, onComplete: Callable[[], object] | None = None
    ) -> bool:
        """Move it through global poses [m] in so many seconds of wall-clock time; whether it does not move yet."""
        return self.mount.move_through(poses, time, onComplete)

    def IsAnimating(self) -> bool:
        """Whether it moves."""
        return self.mount.moving
