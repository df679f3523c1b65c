"""libgz picture: run a world for a while and save what one of its cameras sees."""

from __future__ import annotations

import argparse
from pathlib import Path

from libgz.errors import LibraryError, NotFoundError, ParameterError, nearest
from libgz.interfaces.camera import Camera
from libgz.interfaces.guicam import Guicam
from libgz.interfaces.stereo import Stereo
from libgz.rendering.context import CHOICES, prefer
from libgz.rendering.image import write_image
from libgz.simulation.world import World

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("world", help="the worldfile")
    parser.add_argument("--camera", metavar="ID", help="id of the camera (default: the world's first)")
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
        camera = _find(world, options.camera)
        # Models act at the beginning of a step: one step more, and the picture of time T is there.
        world.step(round(options.time / world.engine.step_time) + 1)
        image = camera.left_image if isinstance(camera, Stereo) else camera.image
        if not image.size:
            raise LibraryError(f"camera {camera.id!r} took no picture: OpenGL is switched off (--gl or LIBGZ_GL)")
        write_image(Path(options.output), image)
        print(f"{options.output}: {image.shape[1]} x {image.shape[0]} px, seen by {camera.id!r}")
    return 0


def _find(world: World, id: str | None) -> Camera | Guicam | Stereo:
    cameras = [i for i in world.gz_server.interfaces.values() if isinstance(i, Camera | Guicam | Stereo)]
    for camera in cameras:
        if id in (None, camera.id):
            return camera
    if not cameras:
        raise NotFoundError("this world has no cameras")
    ids = [camera.id for camera in cameras]
    raise NotFoundError(f"no camera has the id {id!r}; there are {', '.join(ids)}{nearest(str(id), ids)}")
