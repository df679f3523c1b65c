"""gzclient: Gazebo classic's client: shows the world in a browser, runs GUI and other plugins, saves images."""

from __future__ import annotations

import argparse
import contextlib
import logging
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from libgz.apps.classic_command import FAILED, Parser, SystemPlugins, log_link, open_log, read_command_line
from libgz.apps.console import as_command, number_above_zero, say
from libgz.apps.untrusted import add_untrusted_option, confined
from libgz.apps.view import make_viewer, observed_server
from libgz.apps.view_options import GL_HELP, pose, size
from libgz.apps.view_process import add_view_options
from libgz.base.errors import GazeboError, LibraryError, ServerGoneError
from libgz.classic.gui import get_main_window
from libgz.classic.gui.client import Client
from libgz.classic.math import Pose3d
from libgz.classic.transport import TopicManager, connect
from libgz.rendering.choice import CHOICES
from libgz.rendering.image import write_image
from libgz.ros.packages import add_exported_folders
from libgz.simulation.event import everywhere
from libgz.simulation.watchdog import Watchdog
from libgz.transport.observer import Observer

__all__ = ["main"]

log = logging.getLogger("libgz.classic")

DEPRECATED = "g/gui-plugin is really loading a SystemPlugin. To load a GUI plugin please use --gui-client-plugin"


def make_parser() -> Parser:
    """The options of Gazebo 11's gzclient, and those for images."""
    parser = Parser("gzclient", "gzclient -- Run the Gazebo client: show the world in a browser, and run GUI plugins.")
    add_untrusted_option(parser)
    add = parser.add_argument
    add("--gui-client-plugin", action="append", default=[], help="load a GUI plugin; may be repeated")
    add("-g", "--gui-plugin", action="append", default=[], help="load a System plugin; may be repeated")
    add("--rate", type=number_above_zero("rate"), default=60.0, help="frames per second [Hz] (default 60)")
    add("--timeout", type=number_above_zero("timeout"), default=30.0, help="time to wait for a server [s] (default 30)")
    add("--picture", metavar="FILE", help="save an image of the user camera, and exit")
    add("--pose", type=pose, metavar='"X Y Z R P Y"', help="pose of the user camera [m], [rad] (default: the world's)")
    add("--size", type=size, default=(800, 600), metavar="WxH", help="size of its image [px] (default 800x600)")
    add("--no-view", action="store_true", help="do not show the world in a browser")
    add_view_options(parser, optional=False)
    add("--gl", choices=CHOICES, default=None, help=GL_HELP)
    return parser


class _Interrupted(BaseException):
    """A signal during the start. Not KeyboardInterrupt, for which Python would exit with a signal of its own."""


class Run:
    """A run of gzclient."""

    def __init__(self, options: argparse.Namespace, words: Sequence[str]) -> None:
        self.options, self.words = options, ["gzclient", *words]
        self._stopped = False
        self._starting = True  # until the first frame a signal interrupts; later, the current frame is completed

    def _interrupted(self, _number: int) -> None:
        self._stopped = True
        if self._starting:
            raise _Interrupted
        window = get_main_window()
        if window is not None:
            window.close()

    def run(self) -> int:
        """Run the client, with classic's order of events; return the exit code."""
        options = self.options
        if options.gui_plugin:
            log.warning("%s", DEPRECATED)
        with Watchdog(self._interrupted), SystemPlugins(options.gui_plugin) as plugins:
            add_exported_folders()  # of ROS, if there is any: the world's meshes may lie in its packages
            try:
                plugins.load(self.words)
                log.info("Waiting for master.")
                with connect(timeout=options.timeout) as link:
                    open_log("client", link.address.port)
                    log_link(link)
                    plugins.init()
                    return self._show(link.connected)
            finally:
                self._starting = False

    def _show(self, connected: Callable[[], bool]) -> int:
        options = self.options
        with (
            Client(options.size, options.pose and Pose3d(options.pose), options.gui_client_plugin) as client,
            contextlib.ExitStack() as stack,
        ):
            if options.picture is not None:
                return self._save_image(client)
            viewer = None if options.no_view else self._open_view(client, stack)
            self._starting = False
            for _ in client.run(options.rate):
                if viewer is not None:
                    viewer.tick()
                if not connected() and not self._stopped:
                    log.error("The server has ended.")
                    return FAILED
            if self._stopped:
                everywhere["SigInt"]()
        return 0

    def _open_view(self, client: Client, stack: contextlib.ExitStack) -> Any:
        """The page with the world and the panels of GUI plugins; None where it cannot be shown."""
        from libgz.view.server import ServerControls

        server_id = observed_server(TopicManager.Instance().TopicInfo(f"/gazebo/{client.world.Name()}/world_stats"))
        if server_id is None:
            log.info("The world is not shown in a browser: its server does not run on this machine.")
            return None
        try:
            observer = stack.enter_context(Observer(server_id))
            controls = ServerControls(server_id)
            viewer = make_viewer(observer, controls, self.options, overlays=lambda: client.window.places)
        except (LibraryError, ServerGoneError) as error:
            log.info("The world is not shown in a browser: %s", error)
            return None
        stack.enter_context(viewer)
        viewer.frame()
        say(f"open {viewer.url}", flush=True)
        return viewer

    def _save_image(self, client: Client) -> int:
        client.frame(image=True)
        camera = client.window.camera
        write_image(Path(self.options.picture), camera.pixels)
        size = f"{camera.ImageWidth()} x {camera.ImageHeight()} px"
        say(f"{self.options.picture}: {size}, of {client.world.Name()!r}")
        return 0


@as_command("gzclient", failed=FAILED)
def main(arguments: Sequence[str] | None = None) -> int:
    """The command.

    Exit codes: 0 done, also after SIGINT or SIGTERM; 130 or 143 after a second one, when a plugin kept it from ending;
    255 failed, or the server ended.
    """
    words, options = read_command_line(make_parser(), arguments, plugins=("gui_plugin",))
    if options.rest:
        log.warning("%s has no effect: the server runs the world", " ".join(options.rest))
    try:
        with confined("gzclient", options):
            return Run(options, words).run()
    except _Interrupted:
        return 0
    except GazeboError as error:
        log.error("%s", error)
        return FAILED


if __name__ == "__main__":
    sys.exit(main())
