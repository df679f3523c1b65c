"""libgz convert: convert a worldfile to SDF 1.6 for Gazebo classic and gz-sim."""

from __future__ import annotations

import argparse
import logging
import sys
from pathlib import Path

from libgz.apps.console import say, writing
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.files import write_whole
from libgz.convert.sdf import RAY_TYPES, Converted, convert
from libgz.front import World
from libgz.worldfile.file import WorldFile
from libgz.worldfile.search import find_worldfile

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    add = parser.add_argument
    add("worldfile", type=Path, metavar="WORLDFILE", help="the worldfile to convert")
    add("-o", dest="output", type=Path, required=True, metavar="FILE", help="the SDF file to write")
    add(
        "--report",
        type=Path,
        metavar="FILE",
        help="also write the list of what has no counterpart in SDF to a file",
    )
    add(
        "--rays",
        choices=RAY_TYPES,
        default="ray",
        help="sensor type of lasers and sonars: ray, which behaves in Gazebo classic as in libgz (default), or "
        "gpu_ray, which gz-sim also supports",
    )


def run(options: argparse.Namespace) -> int:
    """Load the world, write it, and list on stderr what has no counterpart in SDF.

    Raises:
        WorldFileError: the worldfile has errors.
        GazeboError: a file cannot be written.
    """
    output: Path = options.output
    logging.getLogger("libgz").setLevel(logging.ERROR)  # warnings are reported by `libgz check`
    world = World()
    try:
        world.Load(WorldFile.from_file(find_worldfile(options.worldfile)))
        converted = convert(world, meshes=f"{output.stem}_meshes", rays=options.rays)
    finally:
        world.close()
    with writing():
        _write(converted, output, options.report)
    for note in converted.notes:
        say(note, file=sys.stderr)
    return 0


def _write(converted: Converted, output: Path, report: Path | None) -> None:
    for name, data in converted.meshes.items():
        path = output.parent / name
        path.parent.mkdir(exist_ok=True)
        write_whole(path, data)
    write_whole(output, converted.sdf)
    if report is not None:
        write_whole(report, "".join(f"{note}\n" for note in converted.notes).encode())
