"""Shared by gazebo and libgz play: the options for the server that they start."""

from __future__ import annotations

import argparse

from libgz.apps.console import whole_number

__all__ = ["add_server_options"]


def add_server_options(parser: argparse.ArgumentParser) -> None:
    """Add -s, the server id, which is None for `auto`, and -f."""
    parser.add_argument(
        "-s",
        dest="server_id",
        metavar="ID",
        type=_server_id,
        default=0,
        help="server id, different for each running server; `auto` selects a free id and prints it (default 0)",
    )
    parser.add_argument("-f", dest="force", action="store_true", help="take over a stale server id")


def _server_id(text: str) -> int | None:
    return None if text == "auto" else whole_number("server id")(text)


_server_id.__name__ = "server id"
