"""libgz picture: run a world for a while and save what one of its cameras sees."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.apps.view_options import pose, size
from libgz.errors import LibraryError, NotFoundError, ParameterError, nearest
from libgz.front import World
from libgz.interfaces.camera import Camera
from libgz.interfaces.guicam import Guicam
from libgz.interfaces.stereo import Stereo
from libgz.rendering.camera import Camera as FreeCamera
from libgz.rendering.context import CHOICES, prefer
from libgz.rendering.image import write_image

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("world", help="the worldfile, legacy or SDF")
    parser.add_argument("--camera", metavar="ID", help="id of the camera, or sensor (default: the world's first)")
    parser.add_argument(
        "--pose", type=pose, metavar='"X Y Z R P Y"', help="draw what a free camera sees from there [m], [rad]"
    )
    parser.add_argument("--size", type=size, default=(640, 480), metavar="WxH", help="of that picture [px]")
    parser.add_argument("-o", dest="output", metavar="FILE", default="picture.png", help="default picture.png")
    parser.add_argument(
        "--time", type=float, default=0.0, metavar="T", help="save the last picture up to this sim time [s] (default 0)"
    )
    parser.add_argument("--gl", choices=CHOICES, default=None, help="as for gazebo")


def run(options: argparse.Namespace) -> int:
    """Run the world and save the picture.

    Raises:
        GazeboError: the world cannot run, has no such camera, or the file cannot be written.
    """
    if not 0.0 <= options.time < float("inf"):
        raise ParameterError(f"--time is {options.time:g} s; it must not be negative")
    if options.gl is not None:
        prefer(options.gl)
    with World.from_file(options.world) as world:
        world.sim.data.pause = 0
        # What is wrong with the camera's name is told before the world runs.
        look, seen_by = _look(world, options)
        # Models act at the beginning of a step: one step more, and the picture of time T is there.
        world.step(round(options.time / world.engine.step_time) + 1)
        image = look()
        if not image.size:
            raise LibraryError(f"camera {seen_by} took no picture: OpenGL is switched off (--gl or LIBGZ_GL)")
        write_image(Path(options.output), image)
        print(f"{options.output}: {image.shape[1]} x {image.shape[0]} px, seen by {seen_by}")
    return 0


def _look(world: World, options: argparse.Namespace) -> tuple[Callable[[], NDArray[np.uint8]], str]:
    """What takes the picture that is asked for, and who sees it."""
    if options.pose is not None:
        width, height = options.size
        free = FreeCamera(world, width, height, near=0.05, far=200.0)
        free.SetPose(options.pose)
        free.options.displayGrid = world.sdf is not None  # as classic's window did
        return (lambda: free.Update() if not free.blind else np.zeros((0, 0, 3), np.uint8)), "a free camera"
    if world.sdf is not None:
        return _look_by_sensor(world, options.camera)
    camera = _find(world, options.camera)
    return (lambda: camera.left_image if isinstance(camera, Stereo) else camera.image), repr(camera.id)


def _look_by_sensor(world: World, name: str | None) -> tuple[Callable[[], NDArray[np.uint8]], str]:
    from libgz.classic.sensors import CameraSensor  # not needed by legacy worlds
    from libgz.classic.server import attach

    sensors = attach(world).sensors
    cameras = [s for s in (sensors.sensors.values() if sensors is not None else ()) if isinstance(s, CameraSensor)]
    for camera in cameras:
        if name in (None, camera.Name(), camera.ScopedName()):

            def take(camera: CameraSensor = camera) -> NDArray[np.uint8]:
                camera.Update(True)
                return np.zeros((0, 0, 3), np.uint8) if camera.Camera().core.blind else camera.Camera().pixels

            return take, repr(camera.ScopedName())
    if not cameras:
        raise NotFoundError("this world has no cameras; --pose draws what a free camera sees")
    names = [camera.ScopedName() for camera in cameras]
    raise NotFoundError(f"no camera has the name {name!r}; there are {', '.join(names)}{nearest(str(name), names)}")


def _find(world: World, id: str | None) -> Camera | Guicam | Stereo:
    cameras = [i for i in world.gz_server.interfaces.values() if isinstance(i, Camera | Guicam | Stereo)]
    for camera in cameras:
        if id in (None, camera.id):
            return camera
    if not cameras:
        raise NotFoundError("this world has no cameras; --pose draws what a free camera sees")
    ids = [camera.id for camera in cameras]
    raise NotFoundError(f"no camera has the id {id!r}; there are {', '.join(ids)}{nearest(str(id), ids)}")
