"""Camera: pictures of a world, with depth and segmentation, in this process."""

from __future__ import annotations

import math
from concurrent.futures import Future
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from libgz.errors import LibraryError, ParameterError
from libgz.geometry import GzPose
from libgz.rendering.scene import SceneWorld, join_scene
from libgz.rendering.shot import RenderOptions, Shot, View

__all__ = ["Camera", "horizontal_view"]

LEAST_VIEW = 0.01  # [rad]
LEAST_NEAR = 0.01  # [m]


class Camera:
    """A camera that looks along +x of its pose, z up.

        with Camera(world, 320, 240) as camera:
            camera.SetPose(GzPose(GzVector(0, 0, 1)))
            camera.Update()
            camera.image, camera.depth, camera.segmentation

    Args:
        world: the World; the first camera of a world opens an OpenGL context, the last one's `close` releases it.
        width, height: of the picture [px].
        hfov: horizontal field of view [rad].
        near, far: nearest and farthest that is drawn [m].

    Raises:
        ParameterError: an argument is out of range.
        LibraryError: the chosen OpenGL does not work here.
    """

    def __init__(
        self,
        world: SceneWorld,
        width: int,
        height: int,
        hfov: float = math.radians(60.0),
        near: float = 0.5,
        far: float = 50.0,
    ) -> None:
        if width < 1 or height < 1:
            raise ParameterError(f"image has zero size: {width} x {height} px")
        if not near >= LEAST_NEAR:
            raise ParameterError(f"near clipping plane is {near:g} m; it must be at least {LEAST_NEAR} m")
        if not far > near:
            raise ParameterError(f"far clipping plane is {far:g} m; it must be beyond the near one, {near:g} m")
        self.width, self.height, self.near, self.far = width, height, near, far
        self.options = RenderOptions()
        self.image: NDArray[np.uint8] = np.zeros((height, width, 3), dtype=np.uint8)
        self.pose = GzPose()
        self.SetFOV(hfov)
        self._shot: Shot | None = None
        self._drawing: Future[None] | None = None
        self._closed = False
        self._scene = join_scene(world)

    @property
    def blind(self) -> bool:
        """Whether OpenGL is switched off, so that there are no pictures."""
        return self._scene.blind

    def SetPose(self, pose: GzPose) -> None:
        """Global pose [m]; pictures from the next `Update` on are taken from there.

        Raises:
            ParameterError: there is a number in it that is none.
        """
        if not all(map(math.isfinite, (*pose.pos, *pose.rot))):
            raise ParameterError(f"the camera's pose is {pose}; it must be finite")
        self.pose = pose

    def GetPose(self) -> GzPose:
        """Global pose [m]."""
        return self.pose

    def SetFOV(self, hfov: float) -> None:
        """Set the horizontal field of view [rad].

        Raises:
            ParameterError: it is not between 0.01 and pi.
        """
        if not LEAST_VIEW <= hfov < math.pi:
            raise ParameterError(f"bad field of view {hfov:g} rad; it must be at least {LEAST_VIEW} and below pi")
        self.hfov = hfov

    def GetFOV(self) -> float:
        """Horizontal field of view [rad]."""
        return self.hfov

    def GetImageSize(self) -> tuple[int, int]:
        """(width, height) [px]."""
        return self.width, self.height

    def Update(self, depth: NDArray[np.float32] | None = None) -> NDArray[np.uint8]:
        """Take a picture of the world as it is now.

        Args:
            depth: out, if wanted: distance ahead, along the camera's axis [m], shape (height, width).

        Returns:
            `image`: shape (height, width, 3), red, green, blue, top row first; the next Update draws into the same.
        """
        self._shot = self._scene.capture(self.view)
        self._scene.draw(self._shot, self.image, depth)
        return self.image

    def Start(self) -> None:
        """Begin a picture of the world as it is now; `Finish` gives it, and `image` is not to be read before."""
        self._shot = self._scene.capture(self.view)
        self._drawing = self._scene.start(self._shot, self.image)

    def Finish(self) -> NDArray[np.uint8]:
        """The picture that `Start` began, waited for if need be."""
        if self._drawing is not None:
            self._drawing.result()
            self._drawing = None
        return self.image

    @property
    def ready(self) -> bool:
        """Whether `Finish` would not have to wait."""
        return self._drawing is None or self._drawing.done()

    @property
    def beside(self) -> bool:
        """Whether pictures are drawn while physics goes on."""
        return self._scene.beside

    @property
    def view(self) -> View:
        """Pose and optics as they are set now."""
        return View(self.pose, self.width, self.height, self.hfov, self.near, self.far, self.options)

    @property
    def depth(self) -> NDArray[np.float32]:
        """Distance ahead, along the axis, in the last picture [m], shape (height, width); infinite for the sky.

        Raises:
            LibraryError: there was no picture yet.
        """
        found = np.empty((self.height, self.width), dtype=np.float32)
        self._scene.draw(self._last_shot(), None, found)
        return found

    @property
    def segmentation(self) -> NDArray[np.int32]:
        """`GetIntId` of the model at each pixel of the last picture, 0 for ground and sky; shape (height, width).

        Raises:
            LibraryError: there was no picture yet.
        """
        return self._scene.segment(self._last_shot())

    def _last_shot(self) -> Shot:
        if self.blind:
            raise LibraryError("OpenGL is switched off (--gl none or LIBGZ_GL): there are no pictures")
        if self._shot is None:
            raise LibraryError("this camera has taken no picture yet; Update() takes one")
        return self._shot

    def __enter__(self) -> Camera:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let the camera go. Can be called twice."""
        if not self._closed:
            self._closed = True
            self.Finish()
            self._shot = None
            self._scene.leave()


def horizontal_view(vertical: float, width: int, height: int) -> float:
    """The horizontal field of view [rad] of a picture [px] whose vertical one is given [rad]; pixels are square."""
    return 2.0 * math.atan(math.tan(vertical / 2.0) * width / height)
