"""A Player server in this process, over interfaces of this process's own server."""

import pytest
from player_clients import free_port

from libgz.interfaces.catalog import new_interface
from libgz.player.configuration import read_configuration
from libgz.player.drivers import DRIVERS
from libgz.player.server import PlayerServer
from libgz.player.simulator import Simulator

# All drivers, each on index 0 but for the cameras.
INDICES = {"left": 1, "right": 2, "left_disparity": 3, "right_disparity": 4}
ALL = "\n".join(
    f'driver ( name "{d.name}" gz_id "one" provides ["{d.key and d.key + "::"}{d.kind}:{INDICES.get(d.key, 0)}"] )'
    for d in DRIVERS
)


@pytest.fixture
def interfaces(server):
    """An interface of each type, with the id `one`."""
    for kind in sorted({driver.source for driver in DRIVERS} - {"", "sim"}):
        new_interface(kind).create(server, "one", "Tester", 7)
    new_interface("sim").create(server, "default", "", 0)
    return {kind: interface for (kind, _), interface in server.interfaces.items()}


@pytest.fixture
def serve(interfaces, server, tmp_path):
    """Starts a Player server of a configuration, on a free port."""
    opened = []

    def start(text=ALL, **options):
        path = tmp_path / "robot.cfg"
        path.write_text(text)
        opened.append(PlayerServer(read_configuration(path, free_port()), Simulator(server.server_id), **options))
        return opened[-1]

    yield start
    for one in opened:
        one.close()
