"""Shared by the commands with --view: its options, and the process of the viewer."""

from __future__ import annotations

import argparse
import contextlib
import os
from collections.abc import Iterator
from typing import Any

from libgz.apps.console import port_number

__all__ = ["HOST", "PORT", "add_view_options", "view_process"]

HOST, PORT = "127.0.0.1", 8080


def add_view_options(parser: Any, optional: bool) -> None:
    """Add the viewer's options; `optional`: with --view, for a server."""
    add = parser.add_argument
    if optional:
        add("--view", action="store_true", help="show the world in a browser; needs the extra `view`")
    add("--view-port", type=port_number, default=PORT, metavar="PORT", help="first port to try (default 8080)")
    add(
        "--view-host",
        default=HOST,
        metavar="ADDRESS",
        help="address to bind (default 127.0.0.1: only this machine can connect)",
    )
    add("--open", action="store_true", help="open the page in this machine's browser, if there is a display")


@contextlib.contextmanager
def view_process(options: argparse.Namespace, server_id: int | None) -> Iterator[None]:
    """With --view, run the viewer of a server in a process of its own, which prints its address, and end it."""
    if not options.view or server_id is None:
        yield
        return
    from libgz.apps.viewer_process import ViewerProcess  # servers without a viewer do without it

    words = ["-s", str(server_id), "--view-port", str(options.view_port), "--view-host", options.view_host]
    words += ["--open"] if options.open else []
    process = ViewerProcess([*words, "--parent", str(os.getpid())])
    try:
        yield
    finally:
        process.close()
