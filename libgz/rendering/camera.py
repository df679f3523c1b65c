"""Camera: images of a world, with depth and segmentation, rendered in this process."""

from __future__ import annotations

import math
from concurrent.futures import Future

import numpy as np
from numpy.typing import NDArray

from libgz.base.closing import Closing
from libgz.base.errors import LibraryError, ParameterError
from libgz.base.geometry import GzPose, GzPoseOf
from libgz.rendering.lens import Lens
from libgz.rendering.scene import Scene, SceneWorld
from libgz.rendering.shot import RenderOptions, Shot, View

__all__ = ["LONGEST_SIDE", "MOST_PIXELS", "Camera", "horizontal_view"]

LEAST_VIEW = 0.01  # [rad]
LEAST_NEAR = 0.01  # [m]
LONGEST_SIDE = 16384  # [px], as OpenGL has it at most
MOST_PIXELS = 8192 * 8192


class Camera(Closing):
    """A camera that looks along +x of its pose, z up.

        with Camera(world, 320, 240) as camera:
            camera.SetPose(GzPose(GzVector(0, 0, 1)))
            camera.Update()
            camera.image, camera.depth, camera.segmentation

    Attributes:
        lens: what its lens does to images; None for a plain pinhole.
        pending: the image that `Start` began, until `Finish`.

    Args:
        world: the World; the first camera of a world opens an OpenGL context, the last one's `close` releases it.
        width, height: of the image [px].
        hfov: horizontal field of view [rad].
        near, far: clipping distances [m].

    Raises:
        ParameterError: an argument is out of range, or all cameras together have too many pixels.
        LibraryError: the chosen OpenGL does not work here.
    """

    STATE = ("width", "height", "near", "far", "hfov", "pose", "image")

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
        if max(width, height) > LONGEST_SIDE or width * height > MOST_PIXELS:
            raise ParameterError(
                f"image is {width} x {height} px; allowed are {LONGEST_SIDE} px a side and {MOST_PIXELS} px in all"
            )
        if not near >= LEAST_NEAR:
            raise ParameterError(f"near clipping plane is {near:g} m; it must be at least {LEAST_NEAR} m")
        if not far > near:
            raise ParameterError(f"far clipping plane is {far:g} m; it must be beyond the near one, {near:g} m")
        self._scene = world.extension(Scene)
        self._scene.pixels.set(self, width * height)
        self.width, self.height, self.near, self.far = width, height, near, far
        self.options = RenderOptions()
        self._image: NDArray[np.uint8] = np.zeros((height, width, 3), dtype=np.uint8)
        self.pose = GzPose()
        self.lens: Lens | None = None
        self._plain: NDArray[np.uint8] = np.zeros((0, 0, 3), dtype=np.uint8)  # what the lens turns into the image
        self.SetFOV(hfov)
        self._shot: Shot | None = None  # of the last image
        self.pending: Future[None] | None = None
        self._closed = False
        self._scene.join()

    @property
    def blind(self) -> bool:
        """Whether OpenGL is switched off, so that there are no images."""
        return self._scene.blind

    def SetPose(self, pose: GzPose) -> None:
        """Set the global pose [m] for the next `Update`.

        Raises:
            ParameterError: a number in it is not finite.
        """
        pose = GzPoseOf(pose)
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
        """Render an image of the world as it is now.

        Args:
            depth: out, optional: distance ahead, along the camera's axis [m], shape (height, width).

        Returns:
            `image`: shape (height, width, 3), red, green, blue, top row first; the next Update overwrites it.
        """
        view, lens = self.view, self.lens
        plain = depth if depth is None or lens is None else np.empty((view.height, view.width), dtype=np.float32)
        self._shot = self._scene.render(view, self._target(), plain)
        self._apply_lens()
        if depth is not None and lens is not None and plain is not None:
            depth[:] = lens.nearest(plain, math.inf)
        return self.image

    def _target(self) -> NDArray[np.uint8]:
        """The array that is rendered into."""
        if self.lens is None:
            return self._image
        size = (self.lens.height, self.lens.width, 3)
        if self._plain.shape != size:
            self._plain = np.zeros(size, dtype=np.uint8)
        return self._plain

    def _apply_lens(self) -> None:
        if self.lens is not None:
            self.lens.image(self._plain, self._image)

    @property
    def image(self) -> NDArray[np.uint8]:
        """The last image, shape (height, width, 3); one that `Start` began is waited for."""
        return self.Finish()

    @image.setter
    def image(self, image: NDArray[np.uint8]) -> None:
        self.Finish()
        self._image = image

    def Start(self) -> None:
        """Begin to render an image of the world as it is now, beside what comes next."""
        self.Finish()
        self._shot, self.pending = self._scene.start(self.view, self._target())

    def Finish(self) -> NDArray[np.uint8]:
        """The image that `Start` began; wait until it is complete."""
        pending, self.pending = self.pending, None
        if pending is not None:
            pending.result()
            self._apply_lens()
        return self._image

    @property
    def ready(self) -> bool:
        """Whether `Finish` can return without waiting."""
        return self.pending is None or self.pending.done()

    @property
    def threaded(self) -> bool:
        """Whether images may be served later than the step in which they were taken."""
        return self._scene.threaded

    @property
    def view(self) -> View:
        """The current pose and optics; with a lens those of the plain image that it turns into the camera's."""
        lens = self.lens
        if lens is not None:
            return View(self.pose, lens.width, lens.height, lens.hfov, self.near, self.far, self.options)
        return View(self.pose, self.width, self.height, self.hfov, self.near, self.far, self.options)

    def shaded(self) -> NDArray[np.uint8]:
        """The last image again, with shadows unless the world's scene forbids them; shape (height, width, 3).

        Raises:
            LibraryError: there is no image yet.
        """
        found = self._scene.shade(self._last_shot())
        if self.lens is None:
            return found
        image = np.zeros_like(self.image)
        self.lens.image(found, image)
        return image

    @property
    def depth(self) -> NDArray[np.float32]:
        """Distance ahead, along the axis, in the last image [m], shape (height, width); infinite for the sky.

        Raises:
            LibraryError: there is no image yet.
        """
        found = self._scene.depth(self._last_shot())
        return found if self.lens is None else self.lens.nearest(found, math.inf).astype(np.float32)

    @property
    def segmentation(self) -> NDArray[np.int32]:
        """`GetIntId` of the model at each pixel of the last image, 0 for ground and sky; shape (height, width).

        Raises:
            LibraryError: there is no image yet.
        """
        found = self._scene.segment(self._last_shot())
        return found if self.lens is None else self.lens.nearest(found, 0).astype(np.int32)

    def _last_shot(self) -> Shot:
        if self.blind:
            raise LibraryError("OpenGL is switched off (--gl none or LIBGZ_GL): there are no images")
        if self._shot is None:
            raise LibraryError("this camera has no image yet; call Update() first")
        return self._shot

    def close(self) -> None:
        """Close the camera. Can be called twice."""
        if not self._closed:
            self._closed = True
            self.Finish()
            self._shot = None
            self._scene.leave()
            self._scene.pixels.set(self, 0)


def horizontal_view(vertical: float, width: int, height: int) -> float:
    """The horizontal field of view [rad] of an image [px] whose vertical one is given [rad]; pixels are square."""
    return 2.0 * math.atan(math.tan(vertical / 2.0) * width / height)
