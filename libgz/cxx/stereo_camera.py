"""The stereo camera of C++ plugins: two cameras side by side, with disparities."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzVector
from libgz.cxx.camera import CxxCamera
from libgz.physics.check import positive
from libgz.rendering.disparity import disparities
from libgz.simulation.world import World

__all__ = ["CxxStereoCamera"]

SIDES = ("left", "right")  # by the numbers of the cameras


class CxxStereoCamera:
    """Two cameras that look along +x of one pose, the left one half a baseline along +y, and the right one along -y."""

    def __init__(self, world: World) -> None:
        self.eyes = tuple(CxxCamera(world) for _ in SIDES)
        self.baseline = 0.0
        self._pose = GzPose()
        self._images, self._wanted = [True, True], [True, True]
        self._disparities: list[NDArray[np.float32] | None] = [None, None]  # bottom row first

    def Init(self, width: int, height: int, hfov: float, baseline: float, near: float, far: float) -> None:
        """Open both cameras; see `Camera`."""
        self.baseline = positive(baseline, "baseline [m]")
        for eye in self.eyes:
            eye.Init(width, height, hfov, near, far)
        self._disparities = [np.zeros((height, width), dtype=np.float32) for _ in SIDES]

    def Fini(self) -> int:
        """Release both cameras; 0."""
        self.close()
        return 0

    def close(self) -> None:
        """Release both cameras. Can be called twice."""
        for eye in self.eyes:
            eye.close()

    def Update(self) -> None:
        """Render what is enabled, and save the images if that is enabled."""
        disparity = any(self._wanted)
        for number, (eye, sign) in enumerate(zip(self.eyes, (0.5, -0.5), strict=True)):
            if disparity or self._images[number]:
                eye.SetPose(GzCoordPoseAdd(GzPose(GzVector(0.0, sign * self.baseline, 0.0)), self._pose))
                eye.Update()
        left, right = (eye.depth for eye in self.eyes)
        if not disparity or left is None or right is None:
            return
        found = disparities(left, right, self.eyes[0].camera.view.focal, self.baseline)
        for own, values, wanted in zip(self._disparities, found, self._wanted, strict=True):
            if own is not None and wanted:
                own[:] = values[::-1]

    def SetPose(self, pose: GzPose) -> None:
        """Set the global pose of the middle between both cameras [m]."""
        self._pose = pose

    def GetPose(self) -> GzPose:
        """The global pose [m]."""
        return self._pose

    def GetFOV(self) -> float:
        """The horizontal field of view [rad]."""
        return self.eyes[0].GetFOV()

    def GetSize(self) -> tuple[int, int]:
        """Width and height of each image [px]; 0 before `Init`."""
        return self.eyes[0].GetImageSize()

    def EnableImage(self, camera: int, enable: bool) -> None:
        """Whether the images of a camera are wanted."""
        self._images[_number(camera)] = enable

    def EnableDisparity(self, camera: int, enable: bool) -> None:
        """Whether the disparities of a camera are wanted."""
        self._wanted[_number(camera)] = enable

    def GetImageData(self, camera: int) -> int | None:
        """The address of a camera's image, bottom row first; None before `Init`."""
        return self.eyes[_number(camera)].GetImageData()

    def GetDisparityData(self, camera: int) -> int | None:
        """The address of a camera's disparities [px], float, bottom row first; None before `Init`."""
        values = self._disparities[_number(camera)]
        return None if values is None else values.ctypes.data

    def SetSavePath(self, pathname: str | None) -> None:
        """Set the directory of saved images, which gets a directory for each camera."""
        for eye, side in zip(self.eyes, SIDES, strict=True):
            eye.SetSavePath(str(Path(pathname or ".") / side))

    def EnableSaveFrame(self, enable: bool) -> None:
        """Whether each image is saved."""
        for eye in self.eyes:
            eye.EnableSaveFrame(enable)


def _number(camera: int) -> int:
    if camera not in (0, 1):
        raise ParameterError(f"a stereo camera has cameras 0, the left one, and 1, the right one; not {camera}")
    return camera
