"""Steps so long that sim time is beyond what messages, records and logs can hold: clients and files may set them."""

from pathlib import Path

from libgz import World
from libgz.classic import physics
from libgz.recording.capture import Capture
from libgz.recording.reader import LogReader

EVERYTHING = Path(__file__).parents[2] / "data" / "worlds" / "everything.sdf"


def test_sensors_and_logs_survive_long_steps(tmp_path):
    path = tmp_path / "log.mcap"
    with World.from_file(EVERYTHING) as world, Capture(world, path) as log:
        for step_time in (1e-3, *[1e9] * 12, 1e-3):
            world.engine.step_time = step_time
            world.step(1)
            log.take()
        assert world.GetSimTime() > 1.2e10
        assert physics.get_world(world.name).SimTime().sec == 2**31 - 1
        data = world.get_state()
        world.set_state(data)
        world.step(1)
    with LogReader(path) as log:
        assert log.end == (2**63 - 1) / 1e9
