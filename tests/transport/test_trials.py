"""Long trials: many clients for a long time, and servers that are killed at random times."""

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest
from trials.table import trial

import libgz
from libgz.base.files import installed_worlds
from libgz.transport.semaphores import SemaphoreSet

pytestmark = pytest.mark.trial

STEP = 0.02  # [s]
SECONDS = 60.0  # of wall-clock time
CLIENTS = 8
KILLS = 200
TIMEOUT = 2.0  # [s] of each wait of the clients whose server is killed

# A client that waits for every step and reads two interfaces under their locks. A position sample is torn if its
# numbers differ: the probe below writes sim time into all of them.
WATCHER = f"""
import json, sys, time
import libgz

server_id, client_id, seconds = int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3])
with libgz.Client(server_id, client_id, timeout=20.0) as client:
    sim, probe = client.sim(), client.position("probe")
    print("ready", flush=True)
    sys.stdin.readline()
    client.wait(timeout=5.0)
    end, last = time.monotonic() + seconds, None
    wakes = worst = torn = missed = 0
    while time.monotonic() < end:
        if not client.wait(timeout=5.0):
            raise SystemExit("no post for 5 s")
        with sim.locked() as data:
            now = data.sim_time
        with probe.locked() as data:
            stamp = data.time
            values = {{*data.pos, *data.rot, *data.vel_pos, *data.vel_rot}}
        torn += values != {{stamp}}
        wakes += 1
        if last is not None:
            gap = round((now - last) / {STEP}) - 1
            worst, missed = max(worst, gap), missed + max(gap, 0)
        last = now
    print(json.dumps({{"wakes": wakes, "worst": worst, "torn": torn, "missed": missed}}))
"""

# A model that writes sim time into all numbers of its interface.
PROBE = """
from libgz import GZ_REGISTER_PLUGIN, Body, Model, Position


class Probe(Model):
    def Load(self, file, node):
        self.AddBody(Body(self.world, dummy=True), True)

    def Init(self, file, node):
        self.position = Position()
        self.position.create(self.world.gz_server, self.GetId(), "Probe", self.GetIntId())

    def Update(self, step):
        now = self.world.GetSimTime()
        if self.position.lock():
            data = self.position.data
            data.time = now
            for field in (data.pos, data.rot, data.vel_pos, data.vel_rot):
                for i in range(3):
                    field[i] = now
            self.position.unlock()

    def Fini(self):
        self.position.destroy()


GZ_REGISTER_PLUGIN("Probe", Probe)
"""

WORLD = """<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>
<model:Pioneer2AT><id>robot1</id></model:Pioneer2AT>
<model:Probe><id>probe</id><plugin>Probe.so</plugin></model:Probe></gz:world>"""


@pytest.fixture
def probe_world(tmp_path):
    (tmp_path / "Probe.py").write_text(PROBE)
    path = tmp_path / "probe.world"
    path.write_text(WORLD)
    return path


def start_client(script, *words):
    command = [sys.executable, "-c", script, *map(str, words)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def test_eight_clients_miss_no_step_and_see_no_torn_sample(gazebo, probe_world):
    server = gazebo(probe_world)
    clients = [start_client(WATCHER, server.id, number, SECONDS) for number in range(CLIENTS)]
    for client in clients:
        assert client.stdout.readline() == "ready\n"
    for client in clients:
        client.stdin.write("go\n")
        client.stdin.flush()
    results = []
    for client in clients:
        out, _ = client.communicate(timeout=SECONDS + 60)
        assert client.returncode == 0
        results.append(json.loads(out))
    print(*results, sep="\n")
    expected = SECONDS / STEP
    for result in results:
        assert result["torn"] == 0
        assert result["worst"] <= 1
        assert result["wakes"] > 0.95 * expected


# A client that must never hang: it counts posts and errors, and connects again after each error.
SURVIVOR = f"""
import json, sys, time
from pathlib import Path
import libgz

server_id, client_id = int(sys.argv[1]), int(sys.argv[2])
counts = {{"posts": 0, "gone": 0, "silent": 0, "connects": 0, "stale": 0, "slowest": 0.0}}
print("ready", flush=True)
stop = False
while not stop:
    try:
        with libgz.Client(server_id, client_id, timeout={TIMEOUT}) as client:
            counts["connects"] += 1
            sim, robot = client.sim(), client.position("robot1")
            seen, same = -1.0, 0
            while True:
                begin = time.monotonic()
                try:
                    posted = client.wait(timeout={TIMEOUT})
                finally:
                    counts["slowest"] = max(counts["slowest"], time.monotonic() - begin)
                if not posted:
                    counts["silent"] += 1
                    break
                same = same + 1 if sim.sim_time == seen else 0
                seen = sim.sim_time
                counts["stale"] += same > 10  # posts without new data
                robot.command(vx=0.1)
                counts["posts"] += 1
                if Path(sys.argv[3]).exists():
                    stop = True
                    break
    except libgz.GazeboError:
        counts["gone"] += 1
print(json.dumps(counts))
"""


def wait_until_it_posts(server, server_id):
    end = time.monotonic() + 20.0
    while server.poll() is None and time.monotonic() < end:
        with contextlib.suppress(OSError):
            if SemaphoreSet.attach(server_id).last_poster() == server.pid:
                return
        time.sleep(0.02)


def test_clients_never_hang_when_servers_are_killed_and_replaced(wire, tmp_path):
    with trial("kill -9 and restart") as row:
        stop = tmp_path / "stop"
        world = installed_worlds() / "pioneer2at.world"
        generator = random.Random(row.seed)
        clients = [start_client(SURVIVOR, wire, number, stop) for number in range(3)]
        for client in clients:
            assert client.stdout.readline() == "ready\n"
        command = [sys.executable, "-m", "libgz.apps.gazebo", "-s", str(wire), "--rate", "5", "-d", "0", str(world)]
        failures = []
        for turn in range(KILLS):
            server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
            time.sleep(generator.uniform(0.02, 1.2))
            if turn % 2 and server.poll() is None:  # half of them are killed while they serve
                wait_until_it_posts(server, wire)
                time.sleep(generator.uniform(0.0, 0.3))
            if server.poll() is not None:
                failures.append((turn, server.stderr.read()))
            server.kill()
            server.wait(10)
            server.stderr.close()
            row.count += 1
        assert not failures
        last = subprocess.Popen([*command, "-t", "20"], stderr=subprocess.PIPE, text=True)
        with libgz.Client(wire, 5, timeout=20.0) as client:
            assert client.wait(timeout=5.0)
        stop.touch()
        results = []
        for client in clients:
            out, _ = client.communicate(timeout=30)
            assert client.returncode == 0, "a client failed"
            results.append(json.loads(out))
        last.send_signal(signal.SIGTERM)
        assert last.wait(20) == 0, last.stderr.read()
        last.stderr.close()
        print(*results, sep="\n")
        slowest = max(result["slowest"] for result in results)
        row.result = f"all restarted; slowest wait {slowest:.1f} s"
        for result in results:
            assert result["posts"] > 100
            assert result["stale"] == 0
            assert result["gone"] > KILLS / 10
            assert result["slowest"] < TIMEOUT + 1.0
        assert not os.listdir(os.environ["TMP"])  # noqa: PTH208
