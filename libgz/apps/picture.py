"""libgz picture: run a world for a while and save the image of one of its cameras."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

from libgz.apps.console import Parser, say
from libgz.apps.untrusted import add_untrusted_option
from libgz.apps.view_options import GL_HELP, pose, size
from libgz.base.errors import LibraryError, NotFoundError, ParameterError, nearest
from libgz.front import World
from libgz.recording.images import FreeView, ImageSource, cameras_of
from libgz.rendering.choice import CHOICES, prefer
from libgz.rendering.image import write_image

__all__ = ["configure", "run"]

C = TypeVar("C")


def configure(parser: Parser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    parser.add_macro_arguments()
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
    with World.from_file(options.world, arguments=options.arguments) as world:
        world.sim.data.pause = 0
        camera = _camera(world, options)  # before the world runs, so that a wrong name is reported at once
        # Models act at the beginning of a step, so one more step is needed for the image of time T.
        world.step(round(options.time / world.engine.step_time) + 1)
        image = camera.image()
        if not image.size:
            raise LibraryError(f"camera {camera.label} has no image: rendering is disabled (--gl or LIBGZ_GL)")
        write_image(Path(options.output), image)
        say(f"{options.output}: {image.shape[1]} x {image.shape[0]} px, from {camera.label}")
    return 0


def _camera(world: World, options: argparse.Namespace) -> ImageSource:
    """The camera given on the command line."""
    if options.pose is not None:
        return FreeView(world, options.pose, options.size, options.shadows)
    cameras = cameras_of(world, options.shadows)
    # Cameras of SDF worlds have a short name, too, which stands for the first one of that name.
    short = {name.rpartition("::")[2]: camera for name, camera in reversed(cameras.items())}
    what = "id" if world.sdf is None else "name"
    return _choose({**short, **cameras}, list(cameras), options.camera, what)


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
