"""libgz view: show a running world in a browser, as a process of its own."""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import logging
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from libgz.apps.console import number_above_zero, say, whole_number
from libgz.apps.untrusted import add_untrusted_option
from libgz.apps.view_process import add_view_options
from libgz.apps.viewer_process import TOKEN
from libgz.base.errors import GazeboError, LibraryError, ServerGoneError
from libgz.base.extras import install
from libgz.transport.observer import Observer
from libgz.transport.paths import server_directory

__all__ = ["configure", "make_viewer", "observed_server", "open_page", "run", "running_servers"]

log = logging.getLogger("libgz.view")

M_MMAP_THRESHOLD, LARGE_BLOCK = -3, 1 << 18  # of malloc.h; [byte]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_untrusted_option(parser)
    parser.add_argument(
        "-s",
        dest="server_id",
        metavar="ID",
        type=whole_number("server id"),
        help="server id (default: the running one)",
    )
    parser.add_argument(
        "--timeout", type=number_above_zero("timeout"), default=10.0, metavar="S", help="time to wait for a server [s]"
    )
    parser.add_argument(
        "--rate", type=number_above_zero("rate"), default=30.0, metavar="R", help="frames per second (default 30)"
    )
    parser.add_argument("--watch-only", action="store_true", help="nobody can control, whatever the address")
    parser.add_argument(
        "--skins",
        choices=("fine", "plain"),
        default="fine",
        help="what robots of worldfiles look like: fine, or plain as cameras serve them (default fine)",
    )
    parser.add_argument("--parent", type=int, help=argparse.SUPPRESS)  # end with this process
    parser.add_argument("--report-opened", action="store_true", help=argparse.SUPPRESS)  # print when a page is open
    add_view_options(parser, optional=False)


def running_servers() -> list[int]:
    """The ids of this user's servers whose worlds can be seen, lowest first."""
    folder, prefix = Path(server_directory(0)).parent, Path(server_directory(0)).name[:-1]
    ids = sorted(
        int(path.name[len(prefix) :])
        for path in folder.glob(f"{prefix}*")
        if path.name[len(prefix) :].isdecimal() and (path / ".observer.tables").exists()
    )
    found = []
    for server_id in ids:
        try:
            Observer(server_id).close()
            found.append(server_id)
        except GazeboError as error:
            log.debug("server %d: %s", server_id, error)
    return found


def observed_server(info: Any) -> int | None:
    """The id of the server on this machine that publishes a topic, by its TopicInfo; None if there is none."""
    ports = {int(end.port) for end in info.publisher}
    for server_id in running_servers():
        with contextlib.suppress(GazeboError), Observer(server_id) as observer:
            if ports & _listening_ports(observer.pid):
                return server_id
    return None


def _listening_ports(pid: int) -> set[int]:
    """The ports of TCP at which a process of this user listens."""
    found, sockets = {}, set()
    for name in ("tcp", "tcp6"):
        with contextlib.suppress(OSError):
            for line in Path(f"/proc/{pid}/net/{name}").read_text().splitlines()[1:]:
                words = line.split()
                if words[3] == "0A":  # it listens
                    found[f"socket:[{words[9]}]"] = int(words[1].rpartition(":")[2], 16)
    with contextlib.suppress(OSError):
        for descriptor in Path(f"/proc/{pid}/fd").iterdir():
            with contextlib.suppress(OSError):  # closed meanwhile
                sockets.add(str(descriptor.readlink()))
    return {port for name, port in found.items() if name in sockets}


def _server_id(options: argparse.Namespace) -> int:
    """The server that was meant.

    Raises:
        ServerGoneError: there is none, or more than one.
    """
    if options.server_id is not None:
        return int(options.server_id)
    end = time.monotonic() + options.timeout
    while True:
        found = running_servers()
        if len(found) == 1:
            return found[0]
        if found:
            raise ServerGoneError(f"servers {', '.join(map(str, found))} are running; choose one with -s ID")
        if time.monotonic() >= end:
            raise ServerGoneError(
                "no server is running; start one with gazebo or gzserver, or with their option --view"
            )
        time.sleep(0.1)


def make_viewer(source: Any, controls: Any, options: argparse.Namespace, **more: Any) -> Any:
    """A viewer.

    Raises:
        LibraryError: the extra is not installed.
    """
    try:
        from libgz.view.viewer import Viewer
    except ImportError as error:
        raise LibraryError(f"the viewer needs the extra `view`: {install('view')} ({error})") from None
    token = os.environ.pop(TOKEN, None)
    return Viewer(source, controls, host=options.view_host, port=options.view_port, token=token, **more)


def open_page(url: str) -> bool:
    """Open an address in the user's browser, where there is a display; whether that was tried.

    Every user of the machine can see it, as a part of a command.
    """
    import webbrowser

    display = sys.platform == "darwin" or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    return display and webbrowser.open(url)


def _stopped(viewer: Any, options: argparse.Namespace) -> Callable[[], bool]:
    """Whether the process that started this one has ended; reports the first page, too, if that is wanted."""
    parent, opened = options.parent, not options.report_opened

    def stopped() -> bool:
        nonlocal opened
        if not opened and viewer.pages:
            opened = True
            say("a page is open", flush=True)
        return parent is not None and os.getppid() != parent

    return stopped


def _return_large_blocks() -> None:
    """Have malloc return large blocks to the system at once: those of messages that pages do not read leave gaps."""
    libc = ctypes.CDLL(None)
    if hasattr(libc, "mallopt"):  # glibc
        libc.mallopt(M_MMAP_THRESHOLD, LARGE_BLOCK)


def run(options: argparse.Namespace) -> int:
    """Show the world until Ctrl-C.

    Raises:
        ServerGoneError: no server runs.
        LibraryError: the extra is not installed.
    """
    from libgz.view.server import ServerControls

    _return_large_blocks()
    server_id = _server_id(options)
    with Observer(server_id, options.timeout) as observer:
        controls = ServerControls(server_id, frozenset() if options.watch_only else None)
        with make_viewer(observer, controls, options, rate=options.rate, skins=options.skins) as viewer:
            viewer.frame()
            say(f"open {viewer.url}", flush=True)
            if options.open:
                open_page(viewer.url_for_once())
            try:
                viewer.run(_stopped(viewer, options))
            except KeyboardInterrupt:
                say()
    return 0
