"""Kills a server and the process that writes its log, at a random moment, and looks at what is left."""

import os
import random
import signal
import subprocess
import sys
import time

import libgz
from libgz.recording.player import Player
from libgz.recording.reader import LogReader

__all__ = ["WORLD", "kill_while_recording"]

LOST = 0.5  # [s] of the log, at most
# The busiest machine delays the writer: what it was given, and could not take, is not lost by the log.
SLACK = 0.5  # [s]

WORLD = """<gz:world xmlns:gz="g" xmlns:model="m"><model:GroundPlane><id>ground</id></model:GroundPlane>
<model:Pioneer2AT><id>robot1</id><model:SickLMS200><id>laser1</id><xyz>0.15 0 0.2</xyz></model:SickLMS200>
</model:Pioneer2AT></gz:world>"""


def kill_while_recording(folder, seed, server_id):
    """One run; returns how much of it is missing in the log [s]."""
    dice = random.Random(seed)
    world, path = folder / "run.world", folder / f"run{seed}.mcap"
    world.write_text(WORLD)
    command = [sys.executable, "-m", "libgz.apps.gazebo", "-s", str(server_id), "-d", "-1", "--mcap", path, world]
    server = subprocess.Popen(command, start_new_session=True, stderr=subprocess.DEVNULL)
    try:
        with libgz.Observer(server_id, timeout=30.0) as observer:
            while not path.exists() or path.stat().st_size < 1000:
                time.sleep(0.01)
                assert server.poll() is None
            time.sleep(dice.uniform(0.3, 1.2))
            last = observer.state()
            if dice.random() < 0.5:  # the writer alone survives, and finishes the log
                os.kill(server.pid, signal.SIGKILL)
            os.killpg(server.pid, signal.SIGKILL)
    finally:
        server.kill()
        server.wait(10)
    time.sleep(0.05)
    with LogReader(path) as log:
        missing = last.sim_time - log.end
        count = sum(1 for _ in log.messages(("interface",)))
        assert count > 0
        assert {"/gz/tables", "/gz/scene", "/laser/laser1", "/position/robot1", "/sim/default", "/tf"} <= {
            channel.topic for channel in log.channels.values()
        }
    with Player(path, server_id, speed=0.0) as player:
        player.run()
        assert player.at_end
        with libgz.Observer(server_id) as observer:
            assert abs(observer.state().sim_time - log.end) < 0.05
            observer.pose("robot1::canonical")
    path.unlink()
    return missing
