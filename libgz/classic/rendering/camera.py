"""Camera: images of a world as Gazebo classic's plugins get them."""

from __future__ import annotations

import itertools
import logging
import math
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.closing import Closing
from libgz.base.errors import GazeboError, ParameterError
from libgz.base.geometry import (
    GzCoordPositionAdd,
    GzCoordPositionSub,
    GzPose,
    GzPoseOf,
    GzVector,
    QuaternLike,
    VectorLike,
    place_of,
    rotate,
)
from libgz.classic.common import Time
from libgz.classic.math import Angle, Planed, Pose3d, Quaterniond, Vector2i, Vector3d
from libgz.classic.names import takes_names
from libgz.classic.rendering.image_format import bytes_per_pixel, check_format, pack
from libgz.classic.rendering.mount import Mount
from libgz.classic.rendering.visual import Visual
from libgz.rendering.camera import LEAST_NEAR, Camera as CoreCamera
from libgz.rendering.image import write_image
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.physics.world import World
    from libgz.classic.rendering.scene import Scene

__all__ = ["Camera", "render_frame"]

log = logging.getLogger("libgz.classic")


def render_frame(world: World, cameras: Iterable[Camera]) -> None:
    """Render an image with each camera: event PreRender, the images, Render, their callbacks, PostRender."""
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


@takes_names
class Camera(Closing):
    """A camera that looks along +x of its pose, z up: a view on a `libgz.rendering.camera.Camera`.

        camera = Camera(world, "eye", 320, 240)
        camera.SetWorldPose(Pose3d(-3, 0, 1, 0, 0.2, 0))
        render_frame(world, [camera])
        camera.ImageData()

    Args:
        world: the classic world.
        name: of the camera.
        width, height: of the image [px].
        hfov: horizontal field of view [rad].
        near, far: clipping distances [m].
        image_format: layout of `ImageData`, one of SDF's `<image><format>`.

    Attributes:
        core: the camera that renders.
        filters: functions that change `pixels` in place after each image, such as noise.
        distortion: the value of `LensDistortion`.

    Raises:
        ParameterError: an argument is out of range.
        LibraryError: the chosen OpenGL does not work here.
    """

    core_type: ClassVar[type[CoreCamera]] = CoreCamera
    STATE: ClassVar[tuple[str, ...]] = ("_format", "_capture", "_saving", "_saved", "_rate", "_fresh", "mount", "core")

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
        from libgz.classic.rendering.scene import scene_of  # which makes cameras itself

        self._world, self._name = world, name
        self._format = check_format(image_format)
        self.core = self.core_type(world.core, width, height, float(hfov), near, far)
        self.mount = Mount(self.core)
        self.filters: list[Callable[[NDArray[np.uint8]], object]] = []
        self.distortion: Any = None
        self._new_frame = Event("NewImageFrame")
        self._capture, self._saving, self._folder, self._saved = True, False, Path(), 0
        self._rate, self._fps, self._last = 30.0, 0.0, 0.0
        self._fresh = False
        self._scene = scene_of(world)
        self._scene.add_camera(self)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._name!r}{place_of(self)}>"

    def close(self) -> None:
        """Close the camera. Can be called twice."""
        self._scene.remove_camera(self)
        self._new_frame.clear()
        self.core.close()

    Fini = close

    def Name(self) -> str:
        """Its name."""
        return self._name

    GetName = Name

    def ScopedName(self) -> str:
        """``world::name``."""
        return f"{self._world.Name()}::{self._name}"

    GetScopedName = ScopedName

    def GetScene(self) -> Scene:
        """The scene of its world."""
        return self._scene

    def Initialized(self) -> bool:
        """Whether it can take images: OpenGL is not switched off."""
        return not self.core.blind

    GetInitialized = Initialized

    # Rendering ---------------------------------------------------------------------------------------------------

    def Update(self) -> None:
        """Move with the visual that it is attached to, or along its path; turn to the visual that it tracks."""
        self.mount.update()

    def Render(self, force: bool = False) -> None:
        """Take an image of the world as it is now; `render_frame` does so with the events around it."""
        if not self.core.blind:
            self._take_image()
            self._finish_image()

    def _take_image(self) -> None:
        self.core.Update()

    def _finish_image(self) -> None:
        for change in self.filters:
            change(self.pixels)
        now = time.monotonic()
        if self._last and now > self._last:
            rate = 1.0 / (now - self._last)
            self._fps = 0.9 * self._fps + 0.1 * rate if self._fps else rate
        self._last, self._fresh = now, True

    def PostRender(self) -> None:
        """Pass the last image to its callbacks, and to a file if enabled; once for each image."""
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
        """Whether its images have a callback, or are saved."""
        return self._capture and (self._saving or bool(self._new_frame))

    def ConnectNewImageFrame(self, callback: Callable[..., object]) -> Connection:
        """Call ``callback(data, width, height, depth, format)`` with each image, as long as the result is kept."""
        return self._new_frame.Connect(callback)

    def DisconnectNewImageFrame(self, connection: Connection) -> None:
        """End a connection."""
        connection.Disconnect()

    def SetCaptureData(self, value: bool) -> None:
        """Set whether images are passed to callbacks; by default they are, unlike those of classic's user camera."""
        self._capture = bool(value)

    def CaptureData(self) -> bool:
        """Whether images are passed to callbacks."""
        return self._capture

    GetCaptureData = CaptureData

    def LastRenderWallTime(self) -> Time:
        """Wall-clock time of the last image."""
        return Time(time.time() - (time.monotonic() - self._last)) if self._last else Time()

    GetLastRenderWallTime = LastRenderWallTime

    def AvgFPS(self) -> float:
        """Mean number of images per second of wall-clock time."""
        return self._fps

    GetAvgFPS = AvgFPS

    def RenderRate(self) -> float:
        """Requested number of images per second [Hz]."""
        return self._rate

    GetRenderRate = RenderRate

    def SetRenderRate(self, hz: float) -> None:
        """Set the requested number of images per second [Hz]; the caller of `Render` has to observe it."""
        self._rate = float(hz)

    # Image -------------------------------------------------------------------------------------------------------

    @property
    def pixels(self) -> NDArray[np.uint8]:
        """The last image, shape (height, width, 3), red, green, blue, top row first."""
        return self.core.image

    def ImageData(self, i: int = 0) -> bytes:
        """The last image, top row first, in the layout `ImageFormat`."""
        return pack(self.pixels, self._format)

    GetImageData = ImageData

    def ImageWidth(self, i: int = 0) -> int:
        """[px]."""
        return self.core.width

    def ImageHeight(self, i: int = 0) -> int:
        """[px]."""
        return self.core.height

    ViewportWidth = GetViewportWidth = GetImageWidth = TextureWidth = GetTextureWidth = ImageWidth
    ViewportHeight = GetViewportHeight = GetImageHeight = TextureHeight = GetTextureHeight = ImageHeight

    def SetImageSize(self, width: int, height: int) -> None:
        """Change the image's size [px].

        Raises:
            ParameterError: one of them is below 1.
        """
        if width < 1 or height < 1:
            raise ParameterError(f"camera {self._name!r}: image has zero size: {width} x {height} px")
        self.core.width, self.core.height = int(width), int(height)
        self.core.image = np.zeros((self.core.height, self.core.width, 3), dtype=np.uint8)

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
        """Bytes of an image."""
        return self.core.width * self.core.height * self.ImageDepth()

    GetImageByteSize = ImageMemorySize = ImageByteSize

    def SetImageWidth(self, w: int) -> None:
        """Change the image's width [px]."""
        self.SetImageSize(w, self.core.height)

    def SetImageHeight(self, h: int) -> None:
        """Change the image's height [px]."""
        self.SetImageSize(self.core.width, h)

    def ShowWireframe(self, s: bool) -> None:
        """Set whether its images show edges of triangles instead of faces."""
        self.core.options.polygonFill = not s

    def ToggleShowWireframe(self) -> None:
        """Show edges of triangles instead of faces, or faces again."""
        self.ShowWireframe(self.core.options.polygonFill)

    def IsVisible(self, visual: Visual | str) -> bool:
        """Whether the middle or a corner of a visual's box lies in the image; what is before it does not matter."""
        found = self._find(visual)
        if found is None:
            return False
        box, pose = found.BoundingBox(), found.WorldPose()
        low, high = box.Min(), box.Max()
        corners = itertools.product(*zip(low, high, strict=True))
        points = [box.Center(), *(Vector3d(*corner) for corner in corners)]
        pixels = (self.Project(GzCoordPositionAdd(point, pose.pos, pose.rot)) for point in points)
        return any(0 <= pixel.x < self.core.width and 0 <= pixel.y < self.core.height for pixel in pixels)

    def AspectRatio(self) -> float:
        """Width over height."""
        return self.core.width / self.core.height

    GetAspectRatio = AspectRatio

    def SaveFrame(self, filename: str) -> bool:
        """Write the last image to a file, in the format of its suffix; whether that worked."""
        path = Path(filename)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_image(path, self.pixels)
        except (GazeboError, OSError) as error:
            log.error("camera %r: %s", self._name, error)
            return False
        return True

    def EnableSaveFrame(self, enable: bool) -> None:
        """Set whether each image is written to a file: ``<pathname>/<name>-0000.jpg`` and so on."""
        self._saving = bool(enable)

    def SetSaveFramePathname(self, pathname: str) -> None:
        """Set the folder for the images; it is made when needed."""
        self._folder, self._saved = Path(pathname), 0

    def _save_next(self) -> None:
        self._saving = self.SaveFrame(str(self._folder / f"{self._name.replace('::', '_')}-{self._saved:04d}.jpg"))
        self._saved += 1

    # Optics ------------------------------------------------------------------------------------------------------

    def HFOV(self) -> Angle:
        """Horizontal field of view [rad]."""
        return Angle(self.core.hfov)

    GetHFOV = HFOV

    def SetHFOV(self, angle: float | Angle) -> None:
        """Set the horizontal field of view [rad]."""
        self.core.SetFOV(float(angle))

    def VFOV(self) -> Angle:
        """Vertical field of view [rad]; pixels are square."""
        return Angle(2.0 * math.atan(math.tan(self.core.hfov / 2.0) / self.AspectRatio()))

    GetVFOV = VFOV

    def NearClip(self) -> float:
        """Near clipping distance [m]."""
        return self.core.near

    GetNearClip = NearClip

    def FarClip(self) -> float:
        """Far clipping distance [m]."""
        return self.core.far

    GetFarClip = FarClip

    def SetClipDist(self, near: float | None = None, far: float | None = None) -> None:
        """Set the clipping distances [m].

        Raises:
            ParameterError: they are not 0.01 m or more, the second beyond the first.
        """
        near, far = self.core.near if near is None else float(near), self.core.far if far is None else float(far)
        if not LEAST_NEAR <= near < far:
            raise ParameterError(f"clip distances are {near:g} and {far:g} m; allowed is {LEAST_NEAR} <= near < far")
        self.core.near, self.core.far = near, far

    def LensDistortion(self) -> Any:
        """The distortion of its lens; None if it has none."""
        return self.distortion

    GetDistortion = LensDistortion

    # Pose --------------------------------------------------------------------------------------------------------

    def WorldPose(self) -> Pose3d:
        """Global pose [m]."""
        return Pose3d(self.core.GetPose())

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
        pose = GzPoseOf(pose)
        self.core.SetPose(GzPose(GzVector(*pose.pos), pose.rot))

    def SetWorldPosition(self, pos: VectorLike) -> None:
        """Move it to a global position [m]; its rotation stays."""
        self.SetWorldPose(GzPose(GzVector(*pos), self.core.pose.rot))

    def SetWorldRotation(self, quat: QuaternLike) -> None:
        """Turn it to a global rotation; its position stays."""
        self.SetWorldPose(Pose3d(self.core.pose.pos, quat))

    def Roll(self, angle: float | Angle) -> None:
        """Turn it about its viewing direction [rad]."""
        self._turn(float(angle), 0.0, 0.0)

    def Pitch(self, angle: float | Angle) -> None:
        """Turn it about its y axis [rad]; positive is down."""
        self._turn(0.0, float(angle), 0.0)

    def Yaw(self, angle: float | Angle) -> None:
        """Turn it about its z axis [rad]; positive is left."""
        self._turn(0.0, 0.0, float(angle))

    def _turn(self, *angles: float) -> None:
        self.SetWorldRotation(self.WorldRotation() * Quaterniond(*angles))

    RotatePitch, RotateYaw = Pitch, Yaw

    def Translate(self, direction: VectorLike) -> None:
        """Move it by a vector in its own frame [m]."""
        pose = self.core.pose
        self.SetWorldPosition(GzCoordPositionAdd(direction, pose.pos, pose.rot))

    def _axis(self, x: float, y: float, z: float) -> Vector3d:
        return Vector3d(*rotate(self.core.pose.rot, (x, y, z)))

    def Direction(self) -> Vector3d:
        """Its viewing direction, a global unit vector."""
        return self._axis(1.0, 0.0, 0.0)

    GetDirection = Direction

    def Up(self) -> Vector3d:
        """Up in the image, a global unit vector."""
        return self._axis(0.0, 0.0, 1.0)

    GetUp = Up

    def Right(self) -> Vector3d:
        """Right in the image, a global unit vector."""
        return self._axis(0.0, -1.0, 0.0)

    GetRight = Right

    def Project(self, pt: VectorLike) -> Vector2i:
        """The pixel of a global point [m], from the upper left; (-1, -1) for one behind the camera."""
        forward, left, up = GzCoordPositionSub(pt, self.core.pose.pos, self.core.pose.rot)
        if forward <= 0.0:
            return Vector2i(-1, -1)
        scale = self.core.view.focal / forward
        x, y = self.core.width / 2.0 - scale * left, self.core.height / 2.0 - scale * up
        return Vector2i(math.floor(x), math.floor(y))

    def CameraToViewportRay(self, screenx: float, screeny: float) -> tuple[Vector3d, Vector3d]:
        """(start [m], global unit vector) of the line of sight through a pixel."""
        focal = self.core.view.focal
        left, up = self.core.width / 2.0 - screenx, self.core.height / 2.0 - screeny
        return self.WorldPosition(), self._axis(focal, left, up).Normalize()

    GetCameraToViewportRay = CameraToViewportRay

    def WorldPointOnPlane(
        self, x: float, y: float, plane: Planed | VectorLike = (0.0, 0.0, 1.0), offset: float = 0.0
    ) -> Vector3d | None:
        """The point of the plane normal . p = offset [m] at a pixel; None if it is not visible there.

        Args:
            x, y: the pixel.
            plane: a plane, or its normal.
            offset: of the plane whose normal is given.
        """
        start, direction = self.CameraToViewportRay(x, y)
        if isinstance(plane, Planed):
            offset = plane.Offset()
        n = Vector3d(*(plane.Normal() if isinstance(plane, Planed) else plane))
        slope = n.Dot(direction)
        distance = (offset - n.Dot(start)) / slope if slope else -1.0
        return start + direction * distance if distance >= 0.0 else None

    GetWorldPointOnPlane = WorldPointOnPlane

    # Motion ------------------------------------------------------------------------------------------------------

    def AttachToVisual(
        self, visual: Visual | str | int, inheritOrientation: bool = True, minDist: float = 0.0, maxDist: float = 0.0
    ) -> bool:
        """Attach it to a visual, at its present relative pose; whether there is such a visual."""
        found = self._find(visual)
        if found is not None:
            self.mount.attach(found, inheritOrientation)
        return found is not None

    def TrackVisual(self, visual: Visual | str) -> bool:
        """Keep looking at a visual from now on; an empty name ends that."""
        found = self._find(visual)
        self.mount.track(found)
        return found is not None

    def TrackedVisual(self) -> Visual | Any:
        """The visual that it tracks."""
        return self.mount.tracked

    GetTrackedVisual = TrackedVisual

    def SetTrackIsStatic(self, isStatic: bool) -> None:
        """Set whether it keeps to TrackPosition while it tracks a visual."""
        self.mount.is_static = bool(isStatic)

    def TrackIsStatic(self) -> bool:
        """Whether it keeps to TrackPosition while it tracks a visual."""
        return self.mount.is_static

    def SetTrackPosition(self, pos: VectorLike) -> None:
        """Set where it is while it tracks a visual [m], if it is static then."""
        self.mount.position = GzVector(*pos)

    def TrackPosition(self) -> Vector3d:
        """Where it is while it tracks a visual [m], if it is static then."""
        return Vector3d(*self.mount.position)

    def SetTrackUseModelFrame(self, useModelFrame: bool) -> None:
        """Set whether TrackPosition is relative to the visual."""
        self.mount.in_model_frame = bool(useModelFrame)

    def TrackUseModelFrame(self) -> bool:
        """Whether TrackPosition is relative to the visual."""
        return self.mount.in_model_frame

    def SetTrackInheritYaw(self, inheritYaw: bool) -> None:
        """Set whether TrackPosition turns with the visual's yaw."""
        self.mount.inherit_yaw = bool(inheritYaw)

    def TrackInheritYaw(self) -> bool:
        """Whether TrackPosition turns with the visual's yaw."""
        return self.mount.inherit_yaw

    def SetTrackMinDistance(self, dist: float) -> None:
        """Set the least distance from the visual that it tracks [m], if it is not static; 0: no limit."""
        self.mount.least = float(dist)

    def TrackMinDistance(self) -> float:
        """The least distance from the visual that it tracks [m]."""
        return self.mount.least

    def SetTrackMaxDistance(self, dist: float) -> None:
        """Set the largest distance from the visual that it tracks [m], if it is not static; 0: no limit."""
        self.mount.most = float(dist)

    def TrackMaxDistance(self) -> float:
        """The largest distance from the visual that it tracks [m]."""
        return self.mount.most

    def _find(self, visual: Visual | str | int) -> Visual | None:
        if not isinstance(visual, str | int):
            return visual
        found = self.GetScene().GetVisual(visual) if visual != "" else None
        if found is None and visual != "":
            log.error("camera %r: there is no visual %r", self._name, visual)
        return found

    def MoveToPosition(self, pose: GzPose, time: float) -> bool:
        """Move it to a global pose [m] in `time` seconds of wall-clock time; False if it is already moving."""
        return self.MoveToPositions([pose], time)

    def MoveToPositions(
        self, poses: Sequence[GzPose], time: float, onComplete: Callable[[], object] | None = None
    ) -> bool:
        """Move it through global poses [m] in `time` seconds of wall-clock time; False if it is already moving."""
        return self.mount.move_through(poses, time, onComplete)

    def IsAnimating(self) -> bool:
        """Whether it is moving."""
        return self.mount.moving
