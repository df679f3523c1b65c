"""spawner: controller_manager's script, which loads and starts controllers, and stops them at its end."""

from __future__ import annotations

import argparse
import logging
import os
import signal
import sys
import threading
from collections.abc import Sequence

from libgz.apps.console import Parser, as_command, set_up_messages
from libgz.base.errors import GazeboError
from libgz.ros.client import RosClient
from libgz.ros.names import read_names

__all__ = ["main"]

log = logging.getLogger("libgz.ros")

MESSAGES = "controller_manager_msgs"
STRICT, BEST_EFFORT = 2, 1


def make_parser() -> Parser:
    """The options of controller_manager's spawner."""
    parser = Parser(prog="spawner", description="Load and start controllers of a robot, until it is interrupted")
    parser.add_argument(
        "controllers", nargs="+", metavar="CONTROLLER", help="its name, and namespace of its parameters"
    )
    parser.add_argument("--stopped", action="store_true", help="load, but do not start them")
    parser.add_argument("--namespace", default="", metavar="NS", help="namespace of the controller manager")
    ignored = "accepted without effect: it waits for the controller manager as long as needed"
    for option in ("--timeout", "--shutdown-timeout", "--wait-for"):
        parser.add_argument(option, metavar="VALUE", help=ignored)
    parser.add_argument("--no-timeout", action="store_true", help=ignored)
    return parser


def _spawn(options: argparse.Namespace, client: RosClient) -> list[str]:
    """Load and start; the names of the loaded controllers.

    Raises:
        GazeboError: one cannot be loaded or started.
    """
    space = f"{options.namespace.rstrip('/')}/controller_manager" if options.namespace else "controller_manager"
    listed = client.call(f"{space}/list_controllers", f"{MESSAGES}/ListControllers", waiting=log.info).controller
    present = {one.name for one in listed}
    for name in options.controllers:
        if name in present:
            log.info("Controller %s is loaded already", name)
        elif not client.call(f"{space}/load_controller", f"{MESSAGES}/LoadController", name=name).ok:
            raise GazeboError(f"Failed to load {name}; the server's log says why")
        else:
            log.info("Loaded %s", name)
    if not options.stopped:
        _switch(client, space, start=options.controllers)
        log.info("Started %s", ", ".join(options.controllers))
    return [name for name in options.controllers if name not in present]


def _switch(client: RosClient, space: str, start: Sequence[str] = (), stop: Sequence[str] = ()) -> None:
    kind, strictness = f"{MESSAGES}/SwitchController", STRICT if start else BEST_EFFORT
    answer = client.call(
        f"{space}/switch_controller",
        kind,
        strictness=strictness,
        start_controllers=list(start),
        stop_controllers=list(stop),
    )
    if not answer.ok:
        raise GazeboError(f"Failed to start {', '.join(start)}; the server's log says why")


@as_command("spawner", failed=1)
def main(arguments: Sequence[str] | None = None) -> int:
    """The command. Exit codes: 0 done, 1 failed."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    set_up_messages(1, None)
    options = make_parser().parse_args([word for word in words if ":=" not in word])
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    try:
        client = RosClient(read_names(words, name=f"spawner_{os.getpid()}"))
        loaded = _spawn(options, client)
    except GazeboError as error:
        log.error("%s", error)
        return 1
    ended.wait()
    space = f"{options.namespace.rstrip('/')}/controller_manager" if options.namespace else "controller_manager"
    try:
        _switch(client, space, stop=loaded)
        for name in loaded:
            client.call(f"{space}/unload_controller", f"{MESSAGES}/UnloadController", name=name)
    except GazeboError as error:  # the server ended first
        log.info("%s", error)
    return 0


if __name__ == "__main__":
    sys.exit(main())
