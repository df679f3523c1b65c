"""The camera of C++ plugins: that of libgz, with the old one's image, depth buffer and saved frames."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError
from libgz.base.geometry import GzPose, GzQuatern, GzQuaternFromEuler, GzVector
from libgz.rendering.camera import Camera
from libgz.rendering.image import write_pnm
from libgz.rendering.shot import RenderOptions
from libgz.simulation.world import World

__all__ = ["CxxCamera"]

log = logging.getLogger("libgz.plugin")

GL_FILL, GL_SMOOTH = 0x1B02, 0x1D01
SWITCHES = (
    "displayBBox",
    "displayAxes",
    "displayCoM",
    "displaySkins",
    "displayRays",
    "displayFrustrums",
    "displayMaterials",
    "displayTextures",
)  # in the order of their bits
TRANSLATE, ZOOM, ROTATE = range(3)  # modes of CalcCameraDelta


class CxxCamera:
    """A camera that is opened by `Init`."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.options = RenderOptions(displaySkins=False)
        self._camera: Camera | None = None
        self._pose = GzPose()
        self._image: NDArray[np.uint8] | None = None  # bottom row first
        self.depth: NDArray[np.float32] | None = None  # ahead of the camera [m], top row first
        self._folder, self._saves, self._saved = Path(), False, 0

    @property
    def camera(self) -> Camera:
        """The camera of libgz.

        Raises:
            ParameterError: `Init` was not called.
        """
        if self._camera is None:
            raise ParameterError("Camera::Init must come before its other methods")
        return self._camera

    def Init(self, width: int, height: int, hfov: float, near: float, far: float) -> None:
        """Open the camera; see `Camera`."""
        self.close()
        self._camera = Camera(self.world, width, height, hfov, near, far)
        self._camera.options = self.options
        self._camera.SetPose(self._pose)
        self._image = np.zeros((height, width, 3), dtype=np.uint8)
        self.depth = None

    def Fini(self) -> int:
        """Release the camera; 0."""
        self.close()
        return 0

    def close(self) -> None:
        """Release the camera. Can be called twice."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None

    def Update(self) -> None:
        """Render an image, and save it if that is enabled."""
        camera = self.camera
        if camera.blind or self._image is None:
            return
        depth = np.empty((camera.height, camera.width), dtype=np.float32)
        image = camera.Update(depth)
        self.depth = depth
        self._image[:] = image[::-1]
        if self._saves:
            self._save(image)

    def _save(self, image: NDArray[np.uint8]) -> None:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            write_pnm(self._folder / f"{self._saved:04d}.pnm", image)
        except (GazeboError, OSError) as error:
            log.error("%s", error)
        self._saved += 1

    def SetPose(self, pose: GzPose) -> None:
        """Set the global pose [m]."""
        self._pose = pose
        if self._camera is not None:
            self._camera.SetPose(pose)

    def GetPose(self) -> GzPose:
        """The global pose [m]."""
        return self._pose

    def SetFOV(self, hfov: float) -> None:
        """Set the horizontal field of view [rad]."""
        self.camera.SetFOV(hfov)

    def GetFOV(self) -> float:
        """The horizontal field of view [rad]."""
        return self.camera.GetFOV()

    def GetImageSize(self) -> tuple[int, int]:
        """Width and height [px]; 0 before `Init`."""
        return self._camera.GetImageSize() if self._camera is not None else (0, 0)

    def GetImageData(self) -> int | None:
        """The address of the image, bottom row first; None before `Init`."""
        return None if self._image is None else self._image.ctypes.data

    def SetRenderOptions(self, switches: int, polygonMode: int, shadeModel: int) -> None:
        """Choose what is rendered; `switches` has a bit for each of SWITCHES."""
        for bit, name in enumerate(SWITCHES):
            setattr(self.options, name, bool(switches >> bit & 1))
        self.options.polygonFill = polygonMode == GL_FILL
        self.options.shadeSmooth = shadeModel == GL_SMOOTH

    def GetZValue(self, x: int, y: int) -> float:
        """What OpenGL's depth buffer has at a pixel, 0 to 1, from its top left corner; 1 for the sky."""
        camera = self.camera
        if self.depth is None or not (0 <= x < camera.width and 0 <= y < camera.height):
            return 1.0
        distance = float(self.depth[y, x])
        if not math.isfinite(distance):
            return 1.0
        return camera.far / (camera.far - camera.near) * (1.0 - camera.near / distance)

    def CalcCameraDelta(self, mode: int, a: GzVector, b: GzVector) -> GzPose:
        """The change of pose by which a point of the image, with its depth value, goes from `a` to `b` [px]."""
        camera = self.camera
        near, far, width, height = camera.near, camera.far, camera.width, camera.height
        p0 = 1.0 / math.tan(camera.hfov / 2.0)
        p5 = p0 * width / height
        p10, p14 = -(far + near) / (far - near), -2.0 * far * near / (far - near)
        ax, ay = 2.0 * a.x / width - 1.0, 1.0 - 2.0 * a.y / height
        bx, by = 2.0 * b.x / width - 1.0, 1.0 - 2.0 * b.y / height
        if mode == ROTATE:
            yaw, pitch = math.atan((bx - ax) / p0), math.atan((by - ay) / p5)
            return GzPose(GzVector(), GzQuaternFromEuler(0.0, pitch, yaw))
        w = p14 / ((2.0 * a.z - 1.0) + p10)  # how far ahead the point is
        x = y = z = 0.0  # in GL's eye frame: right, up, backward
        if mode == TRANSLATE:
            x, y = w * (bx - ax) / p0, w * (by - ay) / p5
        elif mode == ZOOM:
            z = w - abs(ay * w) / (abs(by) + 1e-16)
            z = max(w - 0.5 * far, min(w - 2.0 * near, z))
        return GzPose(GzVector(z, x, -y), GzQuatern())

    def SetSavePath(self, pathname: str | None) -> None:
        """Set the directory of saved images, which are numbered from 0 again."""
        self._folder, self._saved = Path(pathname or "."), 0

    def EnableSaveFrame(self, enable: bool) -> None:
        """Whether each image is saved."""
        self._saves = enable
