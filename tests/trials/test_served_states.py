"""Servers under random snapshots from several processes, while clients read, command, insert and delete."""

from __future__ import annotations

import hashlib
import os
import random
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import classic_wire
import pytest
import state_runs
from c_programs import compile_c, needs_compiler
from gzserver_process import SERVER, new_environment
from trials.table import trial

import libgz
from libgz.base.errors import GazeboError
from libgz.transport.control import ask

pytestmark = pytest.mark.trial

SHARE = float(os.environ.get("TRIAL_SHARE") or 1.0)
SECONDS = max(6.0, 120.0 * SHARE)
STEPS = 200  # after the last restore
SAVERS = 3

LEGACY = """<gz:world xmlns:gz="g" xmlns:model="m" xmlns:param="p"><param:Global/>
<model:GroundPlane><id>ground</id></model:GroundPlane>
<model:Pioneer2AT><id>robot1</id><model:SickLMS200><id>laser1</id><xyz>0.15 0 0.2</xyz></model:SickLMS200>
</model:Pioneer2AT><model:SimpleSolid><id>box1</id><xyz>2 0 0.5</xyz></model:SimpleSolid>
<model:Factory><id>factory1</id></model:Factory></gz:world>"""
SOLID = "<model:SimpleSolid><id>{0}</id><xyz>{1:.3f} {2:.3f} 1</xyz></model:SimpleSolid>"
CLASSIC = """<sdf version='1.6'><world name='default'><model name='ground'><static>1</static><link name='l'>
<collision name='c'><geometry><plane/></geometry></collision></link></model><model name='box'><pose>0 0 .6 0 .1 0</pose>
<link name='l'><collision name='c'><geometry><box><size>.4 .4 .4</size></box></geometry></collision>
<sensor name='imu' type='imu'><always_on>1</always_on><update_rate>100</update_rate></sensor></link>
<plugin name='pushes' filename='libpushes.so'/></model>
</world></sdf>"""
SPHERE = """<sdf version='1.6'><model name='{0}'><pose>{1:.3f} {2:.3f} 1 0 0 0</pose><link name='l'><collision name='c'>
<geometry><sphere><radius>.2</radius></sphere></geometry></collision></link></model></sdf>"""

PLUGIN = """
from libgz.classic import *
from libgz.classic.event import Events
from libgz.classic.math import Rand, Vector3d
class Pushes(ModelPlugin):
    STATE = ("count", "heard")
    def Load(self, model, sdf):
        self.model, self.count, self.heard = model, 0, 0
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.Int, "~/count")
        self.subscriber = self.node.Subscribe("~/count", self.OnCount)
    def OnUpdate(self):
        self.count += 1
        push = 5.0 if self.heard % 2 else -5.0
        self.model.GetLinks()[0].AddForce(Vector3d(Rand.DblUniform(-3, 3), push, 0))
        if self.count % 30 == 0:
            self.publisher.Publish(msgs.Int(data=self.count))
        if self.count % 500 == 0:
            self.model.GetWorld().InsertModelString(TEXT % self.count)
        if self.count % 500 == 400:
            self.model.GetWorld().RemoveModel(f"p{self.count - 400}")
    def OnCount(self, message):
        self.heard += 1
    def Reset(self):
        self.count = self.heard = 0
TEXT = "<sdf version='1.6'><model name='p%d'><pose>3 0 1 0 0 0</pose><link name='l'/></model></sdf>"
GZ_REGISTER_MODEL_PLUGIN(Pushes)
"""
CLIENT = """
#include <gazebo.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
int main(int count, char **words) {
    gz_client_t *client = gz_client_alloc();
    gz_position_t *robot = gz_position_alloc();
    time_t end = time(NULL) + atol(words[count - 1]);
    long done = 0;
    if (gz_client_connect_wait(client, atoi(words[1]), 3) != 0) return 2;
    if (gz_position_open(robot, client, "robot1") != 0) return 3;
    while (time(NULL) < end) {
        if (gz_client_wait(client) != 0) return 4;
        if (gz_position_lock(robot, 1) != 0) return 5;
        robot->data->cmd_vel_pos[0] = robot->data->pos[0] > 0.0 ? -0.2 : 0.2;
        gz_position_unlock(robot);
        done++;
    }
    gz_position_close(robot);
    gz_position_free(robot);
    gz_client_disconnect(client);
    gz_client_free(client);
    printf("%ld\\n", done);
    return 0;
}
"""

# A process that saves and restores at random moments, as `libgz snapshot` does.
SAVER = """
import random, sys, time
from pathlib import Path
from libgz.apps.libgz import main
server, folder, seed, end = sys.argv[1], Path(sys.argv[2]), sys.argv[3], time.time() + float(sys.argv[4])
dice, done, own = random.Random(seed), 0, f"{seed}.state"
while time.time() < end:
    time.sleep(dice.expovariate(8.0))
    known = sorted(folder.glob("*.state"))
    what = dice.choice(("save", "restore", "restore", "rewind"))
    if what == "restore" and known:
        words = ["restore", str(dice.choice(known))]
    elif what == "rewind":
        words = ["rewind", f"{dice.uniform(0.0, 1.0):.2f}"]
    else:
        words = ["save", str(folder / own)]
    code = main(["snapshot", *words, "-s", server])
    if code not in ((0, 1) if words[0] == "rewind" else (0,)):  # a rewind may be beyond the oldest state
        sys.exit(f"{words}: exit code {code}")
    done += 1
print(done)
"""


class Activities:
    """Clients in threads, each of which does one thing again and again until the end; the first error is kept."""

    def __init__(self, seconds: float) -> None:
        self._end = time.monotonic() + seconds
        self._threads: list[threading.Thread] = []
        self.failures: list[str] = []
        self.counts: dict[str, int] = {}

    def add(self, name: str, function: Callable[[], object], pause: float = 0.01) -> None:
        """Call a function until the end, with a pause [s]."""

        def repeat() -> None:
            try:
                while time.monotonic() < self._end and not self.failures:
                    function()
                    self.counts[name] = self.counts.get(name, 0) + 1
                    time.sleep(pause)
            except BaseException as error:  # noqa: BLE001 - it is the result
                self.failures.append(f"{name}: {type(error).__name__}: {error}")

        self._threads.append(threading.Thread(target=repeat, daemon=True))
        self._threads[-1].start()

    def finish(self) -> None:
        """Wait for their ends."""
        for thread in self._threads:
            thread.join(60)
        assert not any(thread.is_alive() for thread in self._threads)
        assert self.failures == []
        assert all(self.counts.values())


def savers(wire: int, folder: Path, seed: int, seconds: float) -> list[subprocess.Popen[str]]:
    """Processes that save and restore."""
    return [
        subprocess.Popen(
            [sys.executable, "-c", SAVER, str(wire), str(folder), f"{seed + number}", str(seconds)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for number in range(SAVERS)
    ]


def finished(processes: list[subprocess.Popen[str]]) -> int:
    """How much they did."""
    done = 0
    try:
        for process in processes:
            out, err = process.communicate(timeout=SECONDS + 60.0)
            assert process.returncode == 0, err[-2000:]
            done += int(out.split()[-1])
    finally:
        for process in processes:
            process.kill()
            process.wait(10)
    return done


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Starts a server, and waits until it takes requests."""
    running: list[subprocess.Popen[str]] = []

    def begin(wire: int, words: list[str], log: Path, environment: dict[str, str] | None = None) -> Any:
        with log.open("w") as file:
            process = subprocess.Popen(words, stdout=file, stderr=file, text=True, env=environment)
        running.append(process)
        end = time.monotonic() + 60
        while time.monotonic() < end:
            try:
                ask(wire, "abilities")
                return process
            except GazeboError:
                assert process.poll() is None, log.read_text()
                time.sleep(0.05)
        raise AssertionError("it did not start")

    yield begin
    for process in running:
        process.terminate()
        process.wait(20)


def digests(world: Any, commands: bool) -> list[str]:
    """What a world is like after each of some steps."""
    rng, found = random.Random(1), []
    for number in range(STEPS):
        if commands and number % 20 == 0:
            state_runs.command(world, rng)
        world.Step()
        found.append(hashlib.blake2b(repr(state_runs.look(world)).encode(), digest_size=8).hexdigest())
    return found


def seen(world: Any) -> dict[str, bytes]:
    """What can be seen of a world; paused steps, which a server counts, are left out."""
    found = state_runs.look(world)
    del found["clock"], found["sim.default"]
    return {**found, "sim time": repr((world.GetSimTime(), world.iterations)).encode()}


def check_states(wire: int, world: Path, folder: Path, options: dict[str, Any]) -> int:
    """From each kept state, two worlds and the server continue equally to the bit."""
    ask(wire, "pause", "on")
    kept = sorted(folder.glob("*.state"))
    for path in kept:
        state = path.read_bytes()
        with libgz.World.from_file(world, **options) as one, libgz.World.from_file(world, **options) as other:
            one.set_state(state)
            assert one.get_state() == state
            first = digests(one, one.sdf is None)
            other.set_state(one.get_state())  # a later one, with what it needs
            other.set_state(state)
            assert digests(other, one.sdf is None) == first
            one.set_state(state)
            one.paused = True
            one.step(3)  # what a factory was told is done in pauses, too, of which a server has some before it steps
            before = one.get_state()
            ask(wire, "restore", content=before)
            ask(wire, "step", str(STEPS))
            one.paused = False
            one.step(STEPS)
            end = time.monotonic() + 60.0
            while True:
                other.set_state(ask(wire, "save"))
                if other.paused and other.iterations == one.iterations:
                    break
                assert time.monotonic() < end
                time.sleep(0.05)
            assert seen(other) == seen(one)
    return len(kept)


@needs_compiler
def test_a_gazebo_server_under_snapshots(wire, start, tmp_path, flags):
    world = tmp_path / "run.world"
    world.write_text(LEGACY)
    states = tmp_path / "states"
    states.mkdir()
    with trial("gazebo: snapshots, rewinds, clients, factory") as row:
        command = [
            sys.executable,
            "-m",
            "libgz.apps.gazebo",
            "-s",
            str(wire),
            "--rewind",
            "5",
            "--rate",
            "4",
            str(world),
        ]
        program = compile_c(tmp_path, CLIENT, *flags)
        server = start(wire, command, tmp_path / "log")
        dice = random.Random(row.seed)
        activities = Activities(SECONDS)
        with libgz.Client(wire, 0) as reader, libgz.Client(wire, 1) as driver, libgz.Observer(wire) as observer:
            robot, laser, sim = driver.position("robot1"), reader.laser("laser1"), reader.sim()
            factory = driver.factory("factory1")

            def read() -> None:
                with laser.locked():
                    assert 0 <= laser.data.range_count <= 1024
                    assert laser.data.time <= 1e6
                assert 0.0 <= sim.data.sim_time < 1e6

            def insert() -> None:
                name = f"n{dice.randrange(4)}"
                if dice.random() < 0.5:
                    factory.create_model(SOLID.format(name, dice.uniform(-5, 5), dice.uniform(-5, 5)))
                else:
                    factory.delete_model(name)

            activities.add("read", read)
            activities.add("drive", lambda: robot.command(vx=dice.uniform(-0.3, 0.5), vyaw=dice.uniform(-1, 1)), 0.05)
            activities.add("insert", insert, 0.1)
            activities.add("observe", lambda: observer.state())
            activities.add("wait", lambda: reader.wait(10.0) or pytest.fail("no post"))
            words = [str(program), str(wire), str(round(SECONDS))]
            native = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            row.count = finished([native, *savers(wire, states, row.seed, SECONDS)])
            activities.finish()
            assert server.poll() is None, (tmp_path / "log").read_text()[-2000:]
            count = check_states(wire, world, states, {})
            before = sim.data.sim_time
            ask(wire, "pause", "off")
            time.sleep(1.0)
            assert sim.data.sim_time > before
        server.terminate()
        assert server.wait(20) == 0
        assert not [line for line in (tmp_path / "log").read_text().splitlines() if "Traceback" in line]
        assert sorted(states.iterdir()) == sorted(states.glob("*.state"))
        row.result = f"{count} states continue to the bit"


def test_a_gzserver_under_snapshots(wire, start, tmp_path, monkeypatch):
    world = tmp_path / "run.world"
    (tmp_path / "pushes.py").write_text(PLUGIN)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    world.write_text(CLASSIC)
    states = tmp_path / "states"
    states.mkdir()
    environment = {**new_environment(tmp_path), "TMP": os.environ["TMP"]}
    port = int(environment["GAZEBO_MASTER_URI"].rpartition(":")[2])
    with trial("gzserver: snapshots, rewinds, topics, factory") as row:
        command = [*SERVER, "--seed", "7", "--server-id", str(wire), "--rewind", "5", str(world)]
        server = start(wire, command, tmp_path / "log", environment)
        dice = random.Random(row.seed)
        activities = Activities(SECONDS)
        masters = [classic_wire.Connection(port) for _ in range(5)]
        poses = classic_wire.Subscription(masters[0], "/gazebo/default/pose/info", "PosesStamped")
        imu = classic_wire.Subscription(masters[1], "/gazebo/default/box/l/imu/imu", "IMU")
        factory = classic_wire.Publication(masters[2], "/gazebo/default/factory", "Factory")
        control = classic_wire.Publication(masters[3], "/gazebo/default/world_control", "WorldControl")
        requests = classic_wire.Publication(masters[4], "/gazebo/default/request", "Request")

        def insert() -> None:
            name = f"n{dice.randrange(4)}"
            if dice.random() < 0.5:
                text = SPHERE.format(name, dice.uniform(-5, 5), dice.uniform(-5, 5))
                factory.publish(classic_wire.new("Factory", sdf=text))
            else:
                requests.publish(
                    classic_wire.new("Request", id=dice.randrange(1, 9**9), request="entity_delete", data=name)
                )

        def switch() -> None:
            kind = dice.choice(("pause", "run", "steps", "reset"))
            message = classic_wire.new("WorldControl")
            if kind == "steps":
                message.multi_step = dice.randrange(1, 200)
            elif kind == "reset":
                message.reset.all = True
            else:
                message.pause = kind == "pause"
            control.publish(message)

        try:
            with libgz.Observer(wire) as observer:
                activities.add("poses", poses.next)
                activities.add("imu", imu.next)
                activities.add("insert", insert, 0.1)
                activities.add("control", switch, 0.3)
                activities.add("observe", lambda: observer.state())
                row.count = finished(savers(wire, states, row.seed, SECONDS))
                # Both go on while the world runs.
                control.publish(classic_wire.new("WorldControl", pause=False))
                activities.finish()
                assert server.poll() is None, (tmp_path / "log").read_text()[-2000:]
            count = check_states(wire, world, states, {"seed": 7})
        finally:
            classic_wire.close_all()
        server.terminate()
        assert server.wait(20) == 0
        assert not [line for line in (tmp_path / "log").read_text().splitlines() if "Traceback" in line]
        row.result = f"{count} states continue to the bit"


def test_killed_saves_leave_whole_files(wire, start, tmp_path):
    """The server and the saving process are killed at random moments of the save of a big world."""
    states = tmp_path / "states"
    states.mkdir()
    world = tmp_path / "big.world"
    solids = "".join(SOLID.format(f"s{i}", i % 40, i // 40) for i in range(800))
    head, tail = LEGACY.rsplit("</gz:world>", 1)
    world.write_text(f"{head}{solids}</gz:world>{tail}")
    with trial("kill -9 of a server, and of a save") as row:
        dice = random.Random(row.seed)
        path = states / "kept.state"
        command = [sys.executable, "-m", "libgz.apps.gazebo", "-s", str(wire), "--rate", "0.1", str(world)]
        saving = [sys.executable, "-m", "libgz.apps.libgz", "snapshot", "save", str(path), "-s", str(wire)]
        server = start(wire, command, tmp_path / "log")
        began = time.monotonic()
        assert subprocess.run(saving, capture_output=True, check=False).returncode == 0
        takes = time.monotonic() - began
        for number in range(max(6, round(60 * SHARE))):
            whole = path.read_bytes()
            process = subprocess.Popen(saving, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            time.sleep(dice.uniform(0.3, 1.1) * takes)
            if number % 6 == 5:
                server.kill()
                server.wait(10)
                _, messages = process.communicate(timeout=30)
                assert (process.returncode, messages.count("\n")) in ((0, 0), (1, 1)), messages
                server = start(wire, command, tmp_path / "log")
            else:
                process.kill()
                process.communicate(timeout=30)
            assert [one.name for one in states.iterdir()] == [path.name]
            now = path.read_bytes()
            if now != whole or number % 6 == 5:
                ask(wire, "restore", content=now)
            row.count += 1
        with libgz.World.from_file(world) as found:
            found.set_state(path.read_bytes())
        server.terminate()
        assert server.wait(20) == 0
