"""libgz config: compiler flags for C programs that use libgazebo: cc client.c $(libgz config --cflags --libs)."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from pathlib import Path

from libgz.apps.console import say, wire_version
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
        "--install-classic",
        nargs="?",
        type=Path,
        const=Path(),
        metavar="PREFIX",
        help="build the library of Gazebo 11's C++ API, and install it for cmake's find_package(gazebo) and for "
        "pkg-config below a directory (default: one below your home)",
    )
    parser.add_argument(
        "--uninstall",
        action="store_true",
        help="with --install-classic [PREFIX]: remove what it has installed there",
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
    if options.install_classic is not None:
        if options.cflags or options.libs or options.cxxflags or options.install is not None or options.m32:
            raise ParameterError("--install-classic goes with PREFIX and --uninstall only")
        return _install_classic(options.install_classic, remove=options.uninstall)
    if options.uninstall:
        raise ParameterError("--uninstall needs --install-classic [PREFIX]")
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
    say(shlex.join(words))
    return 0


def _install(prefix: Path, version: int, *, i386: bool) -> int:
    """Install below a prefix, and print what is there and how pkg-config finds it."""
    written = install(prefix, version, *for_installation(), i386=i386)
    for path in written:
        say(path)
    (description,) = (path for path in written if path.suffix == ".pc")
    if str(description.parent) not in os.environ.get("PKG_CONFIG_PATH", "").split(os.pathsep):
        command = f"export PKG_CONFIG_PATH={shlex.quote(str(description.parent))}"
        text = f"before configure and pkg-config, where they do not look there: {command}"
        say(text, file=sys.stderr)
    return 0


def _install_classic(prefix: Path, *, remove: bool) -> int:
    """Install Gazebo's C++ API, and say how build systems find it; or remove it."""
    from libgz.classic_cxx.library import default_prefix, install, uninstall

    chosen = prefix if prefix != Path() else default_prefix()
    if remove:
        removed = uninstall(chosen)
        say(f"{len(removed)} files removed from {chosen}" if removed else f"{chosen} has no installation")
        return 0 if removed else 1
    place, written = install(chosen, lambda line: say(line, file=sys.stderr, flush=True))
    say(f"{place}: {len(written)} files; cmake's find_package(gazebo) finds them")
    description = place / "lib" / "pkgconfig"
    if str(description) not in os.environ.get("PKG_CONFIG_PATH", "").split(os.pathsep):
        say(f"for pkg-config: export PKG_CONFIG_PATH={shlex.quote(str(description))}", file=sys.stderr)
    return 0
