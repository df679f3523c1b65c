"""libgz ros: install the packages that launch files of ROS name: libgz ros install."""

from __future__ import annotations

import argparse
from pathlib import Path

from libgz.ros.install import default_prefix, install, uninstall

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    text = "write the packages gazebo_ros and gazebo_msgs for a ROS 1"
    installer = actions.add_parser("install", help=text, description=f"Install: {text}.")
    about = "folder, which is made (default: ~/.local/share/libgz/ros)"
    installer.add_argument("prefix", nargs="?", type=Path, metavar="PREFIX", help=about)
    installer.add_argument("--uninstall", action="store_true", help="remove them again")


def run(options: argparse.Namespace) -> int:
    """Install or uninstall.

    Raises:
        LibraryError: the folder cannot be written.
        NotFoundError: nothing is installed there.
    """
    prefix: Path = options.prefix or default_prefix()
    if options.uninstall:
        print(f"removed {uninstall(prefix)} files from {prefix}")
        return 0
    print(f"installed {len(install(prefix))} files in {prefix}; in shells for ROS:\n. {prefix}/setup.sh")
    return 0
