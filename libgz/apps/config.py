"""libgz config: compiler flags for C programs that use libgazebo: cc client.c $(libgz config --cflags --libs)."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from pathlib import Path

from libgz.apps.console import wire_version
from libgz.base.errors import ParameterError
from libgz.clib import FOLDER
from libgz.clib.install import install
from libgz.clib.library import FOR_I386, library_folder
from libgz.cxx.build import cxxflags, for_installation
from libgz.transport.layout import LIBGAZEBO_VERSION

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--cflags", action="store_true", help="the directory of gazebo.h")
    parser.add_argument(
        "--cxxflags", action="store_true", help="what C++ plugin models need: c++ $(...) -shared MyRobot.cc"
    )
    parser.add_argument("--libs", action="store_true", help="the library, which is compiled at first use")
    parser.add_argument("--m32", action="store_true", help="for 32-bit programs, which `gazebo --abi i386` serves")
    parser.add_argument(
        "--install",
        type=Path,
        metavar="PREFIX",
        help="write gazebo.h, libgazebo and gazebo.pc below a directory, for pkg-config and configure scripts",
    )
    parser.add_argument(
        "--wire-version",
        type=wire_version,
        default=LIBGAZEBO_VERSION,
        metavar="V",
        help="version of the installed structs: 0x060 (default), or 0x050 as in Gazebo 0.5, for Player 1.6.5",
    )


def run(options: argparse.Namespace) -> int:
    """Print the flags; without options, all of them. Or install, and print the files.

    Raises:
        LibraryError: the library cannot be compiled or installed.
        ParameterError: the options exclude each other.
    """
    if options.install is not None:
        if options.cflags or options.libs or options.cxxflags:
            raise ParameterError(
                "--install excludes --cflags, --cxxflags and --libs; pkg-config prints them after the installation"
            )
        return _install(options.install, options.wire_version, i386=options.m32)
    if options.wire_version != LIBGAZEBO_VERSION:
        raise ParameterError("--wire-version needs --install PREFIX")
    words = []
    both = not (options.cflags or options.libs or options.cxxflags)
    if options.m32:
        if options.cxxflags:
            raise ParameterError("--m32 excludes --cxxflags: plugins run in the server, a program of this machine")
        words.append(FOR_I386)
    if options.cxxflags:
        words += cxxflags()
    if options.cflags or both:
        words.append(f"-I{FOLDER}")
    if options.libs or both:
        words += [f"-L{library_folder(i386=options.m32)}", "-lgazebo", "-lm"]
    print(shlex.join(words))
    return 0


def _install(prefix: Path, version: int, *, i386: bool) -> int:
    """Install below a prefix, and print what is there and how pkg-config finds it."""
    written = install(prefix, version, *for_installation(), i386=i386)
    for path in written:
        print(path)
    (description,) = (path for path in written if path.suffix == ".pc")
    if str(description.parent) not in os.environ.get("PKG_CONFIG_PATH", "").split(os.pathsep):
        command = f"export PKG_CONFIG_PATH={shlex.quote(str(description.parent))}"
        print(f"before configure and pkg-config, where they do not look there: {command}", file=sys.stderr)
    return 0
