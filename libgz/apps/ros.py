"""libgz ros: install the packages that launch files name, or make an environment of ROS 2."""

from __future__ import annotations

import argparse
from pathlib import Path

from libgz.apps.console import say
from libgz.ros.environment import VARIABLE, default_environment
from libgz.ros.install import default_prefix, install, uninstall
from libgz.ros.install2 import PREFIX
from libgz.ros.venv import DISTRIBUTIONS, make_environment

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    text = "write the packages that launch files name, for ROS 1 and ROS 2"
    installer = actions.add_parser("install", help=text, description=f"Install: {text}.")
    about = "folder, which is made (default: ~/.local/share/libgz/ros)"
    installer.add_argument("prefix", nargs="?", type=Path, metavar="PREFIX", help=about)
    installer.add_argument("--uninstall", action="store_true", help="remove them again")
    text = "make an environment with rclpy, from the published wheels, for gzserver --ros2"
    maker = actions.add_parser("venv", help=text, description=f"Venv: {text}. It needs a C++ compiler.")
    about = "folder, which is made (default: ~/.local/share/libgz/ros2, where gzserver looks)"
    maker.add_argument("folder", nargs="?", type=Path, metavar="DIR", help=about)
    about = f"of ROS 2: {' or '.join(DISTRIBUTIONS)} (default: %(default)s)"
    maker.add_argument("--distribution", choices=DISTRIBUTIONS, default="kilted", metavar="NAME", help=about)
    maker.add_argument("--python", metavar="FILE", help="the Python to make it with")


def run(options: argparse.Namespace) -> int:
    """Install, uninstall, or make an environment.

    Raises:
        LibraryError: the folder cannot be written, or a step fails.
        NotFoundError: nothing is installed there; there is no Python or compiler.
    """
    if options.action == "venv":
        folder: Path = options.folder or default_environment()
        own = make_environment(folder, options.distribution, options.python, print)
        if options.folder is None:
            say("done; gzserver --ros2 finds it")
        else:
            say(f"done; gzserver --ros2 finds it by:\nexport {VARIABLE}={own}")
        return 0
    prefix: Path = options.prefix or default_prefix()
    if options.uninstall:
        say(f"removed {uninstall(prefix)} files from {prefix}")
        return 0
    say(f"installed {len(install(prefix))} files in {prefix}; in shells for ROS 1:\n. {prefix}/setup.sh")
    say(f"in shells for ROS 2:\n. {prefix}/{PREFIX}/setup.sh")
    return 0
