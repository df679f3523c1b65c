"""libgz clean: remove the files and semaphores of dead servers."""

from __future__ import annotations

import argparse

from libgz.errors import ParameterError
from libgz.transport.stale_files import remove_stale

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "-s", dest="server_id", metavar="ID", type=int, default=None, help="remove those of one server only"
    )


def run(options: argparse.Namespace) -> int:
    """Remove stale files and semaphores, and print their names.

    Raises:
        ParameterError: the server id is negative.
    """
    if options.server_id is not None and options.server_id < 0:
        raise ParameterError(f"server id is {options.server_id}; it must not be negative")
    count = 0
    for item in remove_stale(options.server_id):
        count += 1
        print(f"removed {item.name}")
    if count == 0:
        print("no stale files of dead servers")
    return 0
