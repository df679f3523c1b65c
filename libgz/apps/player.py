"""libgz player: serve programs that speak Player's protocol from the interfaces of a server: libgz player robot.cfg."""

from __future__ import annotations

import argparse
import contextlib
import logging
import subprocess
from collections.abc import Iterator

from libgz.apps.console import say, whole_number
from libgz.apps.untrusted import add_untrusted_option
from libgz.base.errors import ServerError
from libgz.base.python import start_module
from libgz.player.configuration import PORT, Configuration, read_configuration
from libgz.player.messages import VERSIONS
from libgz.player.server import LOOPBACK, PlayerServer
from libgz.player.simulator import Simulator

__all__ = ["configure", "run"]

log = logging.getLogger("libgz.player")

PATIENCE = 20.0  # [s] for the simulation to end


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("file", metavar="FILE", help="configuration file of Player 1.4 to 3")
    parser.add_argument(
        "-p",
        dest="port",
        metavar="PORT",
        type=_port,
        default=PORT,
        help=f"port of devices without one (default {PORT})",
    )
    parser.add_argument(
        "-s",
        dest="server_id",
        metavar="ID",
        type=whole_number("server id"),
        help="id of the running server (default: the file's worldfile is run, or else its server_id, or 0)",
    )
    parser.add_argument("-k", dest="key", metavar="KEY", default="", help="key that clients must send first")
    parser.add_argument(
        "--host", default=LOOPBACK, help=f"address to listen on (default {LOOPBACK}; 0.0.0.0: every address)"
    )
    parser.add_argument(
        "--protocol",
        choices=("auto", *VERSIONS[1:]),
        default="auto",
        help="version of clients of Player 2 and 3 (2.1: 3.0, too; default: 2.0 or 2.1, as they show)",
    )
    add_untrusted_option(parser)


def _port(text: str) -> int:
    number = whole_number("port")(text)
    if not 0 < number < 65536:
        raise argparse.ArgumentTypeError(f"port is {text}; allowed are 1 to 65535")
    return number


def run(options: argparse.Namespace) -> int:
    """Serve until Ctrl-C or SIGTERM.

    Raises:
        GazeboError: the file has errors, a port is in use, or the simulation does not start.
    """
    configuration = read_configuration(options.file, options.port)
    for warning in configuration.diagnostics.summary():
        log.warning("%s", warning)
    if len(options.key) > 31:
        raise ServerError("the key has more than 31 characters, which clients cannot send")
    version = "" if options.protocol == "auto" else options.protocol
    with _simulation(configuration, options.server_id) as server_id:
        simulator = Simulator(server_id)
        with PlayerServer(configuration, simulator, host=options.host, key=options.key, version=version) as server:
            for line in _summary(configuration, options.host, server_id):
                say(line, flush=True)
            with contextlib.suppress(KeyboardInterrupt):
                server.run()
    return 0


def _summary(configuration: Configuration, host: str, server_id: int) -> Iterator[str]:
    for port in configuration.ports:
        devices = [d for d in configuration.devices if d.port == port]
        words = ", ".join(f"{d.driver.kind}:{d.index} ({d.id or d.driver.name})" for d in devices)
        yield f"Player on {host}:{port}, from server {server_id}: {words}"


@contextlib.contextmanager
def _simulation(configuration: Configuration, server_id: int | None) -> Iterator[int]:
    """The id of the server: the given one, that of a server which runs the file's world, or the file's own.

    Raises:
        ServerError: the world did not start.
    """
    worldfile, own = configuration.simulation
    if server_id is not None or not worldfile:
        yield own if server_id is None else server_id
        return
    path = f"./{worldfile}" if worldfile.startswith("-") else worldfile  # a file must not name options
    options = "-s", "auto", "-d", "0", path
    with start_module(
        "libgz.apps.gazebo", *options, stdout=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        try:
            words = (process.stdout.readline() if process.stdout else "").split()
            if not words:
                raise ServerError(f"{worldfile} did not start; its messages are above")
            yield int(words[-1])
        finally:
            process.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(PATIENCE)
            process.kill()
