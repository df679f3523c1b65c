"""libgz config: compiler flags for C programs that use libgazebo: cc client.c $(libgz config --cflags --libs)."""

from __future__ import annotations

import argparse
import shlex

from libgz.clib import FOLDER
from libgz.clib.library import library_folder

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--cflags", action="store_true", help="the directory of gazebo.h")
    parser.add_argument("--libs", action="store_true", help="the library, which is compiled at first use")


def run(options: argparse.Namespace) -> int:
    """Print the flags; without options, all of them.

    Raises:
        LibraryError: the library cannot be compiled.
    """
    words = []
    both = not (options.cflags or options.libs)
    if options.cflags or both:
        words.append(f"-I{FOLDER}")
    if options.libs or both:
        words += [f"-L{library_folder()}", "-lgazebo", "-lm"]
    print(shlex.join(words))
    return 0
