"""libgz picture: run a world for a while and save the image of one of its cameras."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.apps.view_options import GL_HELP, pose, size
from libgz.classic.sensors import CameraSensor
from libgz.classic.server import attach
from libgz.errors import LibraryError, NotFoundError, ParameterError, nearest
from libgz.front import World
from libgz.geometry import GzPose
from libgz.interfaces.camera import Camera
from libgz.interfaces.guicam import Guicam
from libgz.interfaces.stereo import Stereo
from libgz.models.camera import eye_of
from libgz.rendering.camera import Camera as FreeCamera
from libgz.rendering.context import CHOICES, prefer
from libgz.rendering.image import write_image

__all__ = ["configure", "run"]

C = TypeVar("C")
Image: TypeAlias = NDArray[np.uint8]
_EMPTY: Image = np.zeros((0, 0, 3), np.uint8)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add = parser.add_argument
    add("world", help="the worldfile, legacy or SDF")
    add("--camera", metavar="ID", help="id of the camera model, or name of the sensor (default: the first one)")
    add("--pose", type=pose, metavar='"X Y Z R P Y"', help="use a free camera at this pose [m], [rad]")
    add("--size", type=size, default=(640, 480), metavar="WxH", help="image size of the free camera [px]")
    add("-o", dest="output", metavar="FILE", default="picture.png", help="the file to write (default picture.png)")
    add("--time", type=float, default=0.0, metavar="T", help="save the last image up to this sim time [s] (default 0)")
    add(
        "--shadows",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="with shadows, and light computed at each pixel, unless an SDF scene forbids them (default); "
        "--no-shadows: the image exactly as the camera serves it",
    )
    add("--gl", choices=CHOICES, default=None, help=GL_HELP)


def run(options: argparse.Namespace) -> int:
    """Run the world and save the image.

    Raises:
        GazeboError: the world cannot run, it has no such camera, or the file cannot be written.
    """
    if not 0.0 <= options.time < float("inf"):
        raise ParameterError(f"--time is {options.time:g} s; it must not be negative")
    if options.gl is not None:
        prefer(options.gl)
    with World.from_file(options.world) as world:
        world.sim.data.pause = 0
        camera = _camera(world, options)  # before the world runs, so that a wrong name is reported at once
        # Models act at the beginning of a step, so one more step is needed for the image of time T.
        world.step(round(options.time / world.engine.step_time) + 1)
        image = camera.image()
        if not image.size:
            raise LibraryError(f"camera {camera.label} has no image: rendering is disabled (--gl or LIBGZ_GL)")
        write_image(Path(options.output), image)
        print(f"{options.output}: {image.shape[1]} x {image.shape[0]} px, from {camera.label}")
    return 0


class _Camera(Protocol):
    """A source of the image to save."""

    label: str  # its name in messages

    def image(self) -> Image:
        """The present image, shape (height, width, 3); empty if rendering is disabled."""


class _FreeCamera:
    """A camera at a pose in the world."""

    label = "a free camera"

    def __init__(self, world: World, pose: GzPose, size: tuple[int, int], shadows: bool) -> None:
        self._camera = FreeCamera(world, *size, near=0.05, far=200.0)
        self._camera.SetPose(pose)
        self._camera.options.shadows = shadows
        self._camera.options.displayGrid = world.sdf is not None  # as in classic's window

    def image(self) -> Image:
        return _EMPTY if self._camera.blind else self._camera.Update()


class _SensorCamera:
    """A camera sensor of an SDF world."""

    def __init__(self, sensor: CameraSensor, shadows: bool) -> None:
        self._sensor, self.label, self._shadows = sensor, repr(sensor.ScopedName()), shadows

    def image(self) -> Image:
        camera = self._sensor.Camera()
        if self._shadows:
            camera.core.options.shadows = True
        self._sensor.Update(True)
        return _EMPTY if camera.core.blind else camera.pixels


class _ModelCamera:
    """A camera model of a legacy world."""

    def __init__(self, world: World, interface: Camera | Guicam | Stereo, shadows: bool) -> None:
        self._interface, self.label = interface, repr(interface.id)
        self._eye = eye_of(world.model(interface.id)) if shadows else None

    def image(self) -> Image:
        interface = self._interface
        served = interface.left_image if isinstance(interface, Stereo) else interface.image
        return self._eye.shaded() if self._eye is not None and served.size else served


def _camera(world: World, options: argparse.Namespace) -> _Camera:
    """The camera given on the command line."""
    if options.pose is not None:
        return _FreeCamera(world, options.pose, options.size, options.shadows)
    if world.sdf is not None:
        manager = attach(world).sensors
        sensors = [s for s in (manager.sensors.values() if manager is not None else ()) if isinstance(s, CameraSensor)]
        scoped = {sensor.ScopedName(): sensor for sensor in sensors}
        short = {sensor.Name(): sensor for sensor in reversed(sensors)}  # the first one of a name
        sensor = _choose({**scoped, **short}, list(scoped), options.camera, "name")
        return _SensorCamera(sensor, options.shadows)
    cameras = {i.id: i for i in world.gz_server.interfaces.values() if isinstance(i, Camera | Guicam | Stereo)}
    return _ModelCamera(world, _choose(cameras, list(cameras), options.camera, "id"), options.shadows)


def _choose(cameras: Mapping[str, C], names: list[str], wanted: str | None, what: str) -> C:
    """The camera of a name; without one, the first of `names`.

    Raises:
        NotFoundError: there is no such camera.
    """
    if not names:
        raise NotFoundError("this world has no cameras; --pose renders the view of a free camera")
    if wanted is not None and wanted not in cameras:
        raise NotFoundError(
            f"no camera has the {what} {wanted!r}; there are {', '.join(names)}{nearest(wanted, names)}"
        )
    return cameras[names[0] if wanted is None else wanted]
