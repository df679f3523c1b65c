"""libgz convert: a worldfile's world as SDF 1.6 for Gazebo classic and gz-sim."""

from __future__ import annotations

import argparse
import logging
import sys
from pathlib import Path

from libgz.convert.sdf import RAY_TYPES, Converted, convert
from libgz.errors import GazeboError
from libgz.files import write_whole
from libgz.front import World
from libgz.worldfile.file import WorldFile

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add = parser.add_argument
    add("worldfile", type=Path, metavar="WORLDFILE", help="the worldfile to convert")
    add("-o", dest="output", type=Path, required=True, metavar="FILE", help="the SDF file to write")
    add("--report", type=Path, metavar="FILE", help="write what has no counterpart to a file, too")
    add(
        "--rays",
        choices=RAY_TYPES,
        default="ray",
        help="type of lasers and sonars: ray, which Gazebo classic casts as libgz does (default), or gpu_ray, which "
        "gz-sim runs as well",
    )


def run(options: argparse.Namespace) -> int:
    """Load the world, write it, and say on stderr what has no counterpart.

    Raises:
        WorldFileError: the worldfile has errors.
        GazeboError: a file cannot be written.
    """
    output: Path = options.output
    logging.getLogger("libgz").setLevel(logging.ERROR)  # its warnings are `libgz check`'s business
    world = World()
    try:
        world.Load(WorldFile.from_file(options.worldfile))
        converted = convert(world, meshes=f"{output.stem}_meshes", rays=options.rays)
    finally:
        world.close()
    try:
        _write(converted, output, options.report)
    except OSError as error:
        raise GazeboError(f"cannot write {error.filename}: {error.strerror}") from None
    for note in converted.notes:
        print(note, file=sys.stderr)
    return 0


def _write(converted: Converted, output: Path, report: Path | None) -> None:
    for name, data in converted.meshes.items():
        path = output.parent / name
        path.parent.mkdir(exist_ok=True)
        write_whole(path, data)
    write_whole(output, converted.sdf)
    if report is not None:
        write_whole(report, "".join(f"{note}\n" for note in converted.notes).encode())
