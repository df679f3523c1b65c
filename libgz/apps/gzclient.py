"""gzclient: Gazebo classic's client without a window: it runs GUI, Visual and System plugins, and takes pictures."""

from __future__ import annotations

import argparse
import logging
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from libgz.apps.console import as_command, set_up_classic_console
from libgz.apps.gzserver import (
    BANNER,
    FAILED,
    Help,
    Parser,
    Version,
    construct_system_plugins,
    drop_system_plugins,
    init_system_plugins,
    load_system_plugins,
    open_log,
    tell_link,
)
from libgz.apps.view_options import pose, size
from libgz.classic.math import Pose3d
from libgz.classic.transport import connect
from libgz.errors import GazeboError
from libgz.rendering.context import CHOICES, prefer
from libgz.rendering.image import write_image
from libgz.simulation.event import everywhere

if TYPE_CHECKING:
    from libgz.classic.gui.client import Client

__all__ = ["main"]

log = logging.getLogger("libgz.classic")

DEPRECATED = "g/gui-plugin is really loading a SystemPlugin. To load a GUI plugin please use --gui-client-plugin"


def _rate(text: str) -> float:
    if not float(text) > 0.0:
        raise ValueError
    return float(text)


_rate.__name__ = "rate"


def make_parser() -> argparse.ArgumentParser:
    """The options of Gazebo 11's gzclient, and ours."""
    parser = Parser(prog="gzclient", description="gzclient -- Run the Gazebo client.", add_help=False)
    add = parser.add_argument
    add("-v", "--version", action=Version, nargs=0, help="print the version and end")
    add("--verbose", action="store_true", help="show all messages; errors and warnings are always shown")
    add("-h", "--help", action=Help, nargs=0, help="print this and end")
    add("--gui-client-plugin", action="append", default=[], help="GUI plugin to load; may be given several times")
    add("-g", "--gui-plugin", action="append", default=[], help="System plugin to load; may be given several times")
    add("--rate", type=_rate, default=60.0, help="frames in a second [Hz] (default 60)")
    add("--timeout", type=_rate, default=30.0, help="how long to look for a server [s] (default 30)")
    add("--picture", metavar="FILE", help="save what the user camera sees, and end")
    add("--pose", type=pose, metavar='"X Y Z R P Y"', help="of the user camera [m], [rad] (default: the world's)")
    add("--size", type=size, default=(800, 600), metavar="WxH", help="of what it sees [px] (default 800x600)")
    add("--gl", choices=CHOICES, default=None, help="as for gazebo")
    return parser


class _Interrupted(BaseException):
    """A signal came while the client was starting. Not KeyboardInterrupt: Python would end with a signal of its own."""


class Run:
    """A run of gzclient."""

    def __init__(self, options: argparse.Namespace, words: Sequence[str]) -> None:
        self.options, self.words = options, ["gzclient", *words]
        self._stopped = False
        self._starting = True  # a signal ends what it waits for; later, the frame that is being drawn is finished

    def _interrupted(self, _number: int, _frame: object) -> None:
        self._stopped = True
        if self._starting:
            raise _Interrupted

    def run(self) -> int:
        """Everything, in classic's order; the exit code."""
        options = self.options
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, self._interrupted)
        if options.gl is not None:
            prefer(options.gl)
        if options.gui_plugin:
            log.warning("%s", DEPRECATED)
        construct_system_plugins(options.gui_plugin)
        try:
            load_system_plugins(self.words)
            log.info("Waiting for master.")
            with connect(timeout=options.timeout) as link:
                open_log("client", link.address.port)
                tell_link(link)
                init_system_plugins()
                return self._show(link.connected)
        finally:
            self._starting = False
            drop_system_plugins()

    def _show(self, connected: Callable[[], bool]) -> int:
        from libgz.classic.gui.client import Client

        options = self.options
        with Client(options.size, options.pose and Pose3d(options.pose), options.gui_client_plugin) as client:
            if options.picture is not None:
                return self._take_picture(client)
            self._starting = False
            for _ in client.run(options.rate):
                if self._stopped:
                    everywhere["SigInt"]()
                    break
                if not connected():
                    log.error("The server has ended.")
                    return FAILED
        return 0

    def _take_picture(self, client: Client) -> int:
        client.frame(image=True)
        camera = client.window.camera
        write_image(Path(self.options.picture), camera.pixels)
        print(f"{self.options.picture}: {camera.ImageWidth()} x {camera.ImageHeight()} px, of {client.world.Name()!r}")
        return 0


@as_command("gzclient", interrupted=0, failed=FAILED)
def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, SIGINT and SIGTERM included; 255 it could not run, or the server ended."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    parser = make_parser()
    set_up_classic_console(verbose="--verbose" in words)
    options, unknown = parser.parse_known_args(words)
    if unknown:
        log.info("left to System plugins: %s", " ".join(unknown))
    if options.verbose:
        sys.stderr.write(BANNER + "\n")
    try:
        return Run(options, words).run()
    except _Interrupted:
        return 0
    except GazeboError as error:
        log.error("%s", error)
        return FAILED


if __name__ == "__main__":
    sys.exit(main())
