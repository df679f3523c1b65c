"""A server among clients that do all they can to end it: it goes on, keeps time, and ends when it is told to."""

import fcntl
import math
import os
import random
import struct
import time
from pathlib import Path

import pytest

import libgz
from libgz.interfaces.catalog import new_interface
from libgz.transport.layout import fields_of

WORLD = """<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>
<model:Pioneer2AT><id>robot1</id>
  <model:SickLMS200><id>laser1</id><xyz>0.1 0 0.3</xyz></model:SickLMS200>
  <model:SonyVID30><id>ptz1</id><xyz>-0.1 0 0.3</xyz></model:SonyVID30>
</model:Pioneer2AT>
<model:Pioneer2DX><id>robot2</id><xyz>0 3 0</xyz></model:Pioneer2DX>
<model:Factory><id>f</id></model:Factory></gz:world>"""

SPITEFUL = [struct.pack("d", value) for value in (math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324)]
SPITEFUL += [struct.pack("i", value) * 2 for value in (-1, 2**31 - 1, -(2**31), 401, 4097)]


@pytest.fixture
def victim(gazebo, tmp_path):
    path = tmp_path / "victim.world"
    path.write_text(WORLD)
    return gazebo(path, "--rate", "20")


def files_of(server):
    return sorted(path for path in server.directory.iterdir() if path.name != "gazebo.pid")


def lock_soon(descriptor):
    """A server holds its locks for microseconds; one that never gives a lock back fails here instead of hanging."""
    end = time.monotonic() + 10
    while True:
        try:
            return fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            assert time.monotonic() < end, "the server keeps a lock"
            time.sleep(0.0005)


def assert_it_lives(server, seconds=1.0):
    """Its clock goes on, and its robots are somewhere."""
    with libgz.Client(server.id, 6) as client:
        sim = client.sim()
        sim.paused = False
        before, end = sim.sim_time, time.monotonic() + 20
        while sim.sim_time < before + seconds:
            assert server.process.poll() is None
            assert time.monotonic() < end, "the simulation stands still"
            client.wait(timeout=1.0)
        for name in ("robot1", "robot2"):
            assert all(map(math.isfinite, client.position(name).pose))


def assert_it_ends_well(server):
    code, _, err = server.stop()
    assert code == 0, err
    assert "Traceback" not in err
    assert " stopped, its motors off" not in err
    return err


def test_every_client_field_full_of_every_spiteful_number(victim):
    with libgz.Client(victim.id, 5) as client:
        for kind, name in client.interfaces():
            interface = client.open(new_interface(kind), name)
            for field_name, field in fields_of(interface.layout).items():
                if field.writer == "S" or field_name in ("save", "string"):
                    continue
                place = getattr(interface.layout, field_name)
                for pattern in SPITEFUL:
                    raw = (pattern * (place.size // 8 + 1))[: place.size]
                    memory = memoryview(interface.data).cast("B")
                    memory[place.offset : place.offset + place.size] = raw
                    for _ in range(6):  # models look every fifth step
                        assert client.wait(timeout=5.0)
    assert_it_lives(victim)
    err = assert_it_ends_well(victim)
    assert "a client wrote position.robot1: cmd_vel_pos[0] is" in err


def test_noise_in_whole_files_heads_included(victim):
    chance = random.Random(2)
    end = time.monotonic() + 1.5
    while time.monotonic() < end:
        path = chance.choice(files_of(victim))
        size = path.stat().st_size
        with path.open("r+b") as file:
            file.seek(chance.randrange(size))
            file.write(chance.randbytes(min(64, size - file.tell())))
        if path.name == "sim.default":  # saving is not what this is about
            with path.open("r+b") as file:
                file.seek(176)
                file.write(bytes(16))
    for path in files_of(victim):  # clients look at the head
        if path.name.startswith(("sim", "position")):
            with path.open("r+b") as file:
                file.write(struct.pack("iiQ", 0x060, 0, path.stat().st_size))
    assert_it_lives(victim)
    assert_it_ends_well(victim)


def test_all_files_cut_short_again_and_again(victim):
    # Under the lock, as a client's clumsy open() would; a file cut while the server is writing to it is beyond help.
    for turn in range(20):
        for path in files_of(victim):
            descriptor = os.open(path, os.O_RDWR)
            lock_soon(descriptor)
            os.ftruncate(descriptor, turn % 3)
            fcntl.flock(descriptor, fcntl.LOCK_UN)
            os.close(descriptor)
        time.sleep(0.02)
    time.sleep(0.2)
    assert_it_lives(victim)
    assert "it has its length again" in assert_it_ends_well(victim)


def test_all_locks_held_for_ever(victim):
    held = [os.open(path, os.O_RDWR) for path in files_of(victim) if path.name != "sim.default"]
    for descriptor in held:
        lock_soon(descriptor)
    with libgz.Client(victim.id, 5) as client:
        sim = client.sim()
        time.sleep(0.3)
        before = sim.sim_time
        for _ in range(100):
            assert client.wait(timeout=2.0)
        assert sim.sim_time > before
    for descriptor in held:
        os.close(descriptor)
    assert_it_lives(victim)
    err = assert_it_ends_well(victim)
    assert err.count("holds the lock of position.robot1") == 1


def test_all_files_removed(victim):
    with libgz.Client(victim.id, 5) as client:
        sim = client.sim()
        for path in files_of(victim):
            path.unlink()
        before = sim.sim_time
        for _ in range(50):
            assert client.wait(timeout=2.0)
        assert sim.sim_time > before
    assert_it_ends_well(victim)


def test_files_replaced_by_others(victim, tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("precious")
    for path in files_of(victim):
        path.unlink()
        path.symlink_to(precious)
    time.sleep(0.2)
    assert_it_ends_well(victim)
    assert precious.read_text() == "precious"


def test_a_factory_flooded(victim):
    chance = random.Random(3)
    letters = [
        b"<model:SimpleSolid><id>s</id><xyz>9 9 1</xyz></model:SimpleSolid>",
        b"<delete>s</delete>",
        b"<delete>nobody</delete>",
        b"<model:SimpleSolid><size>nan nan nan</size></model:SimpleSolid>",
        b"<" * 4096,
        chance.randbytes(4096),
        b"<!DOCTYPE x [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;'>]><model:SimpleSolid><id>&b;</id></model:SimpleSolid>",
        b"<model:SimpleSolid>" * 200,
    ]
    path = Path(victim.directory) / "factory.f"
    end = time.monotonic() + 1.5
    while time.monotonic() < end:
        letter = chance.choice(letters)[: chance.choice((4096, 4096, 10))]
        with path.open("r+b", buffering=0) as file:  # without the lock
            file.seek(160)
            file.write(letter.ljust(4096, b"\0"))
        time.sleep(chance.choice((0, 0.005)))
    assert_it_lives(victim)
    assert "request failed" in assert_it_ends_well(victim)


def test_a_model_that_fails_gives_its_locks_back(caplog):
    class Clumsy(libgz.Model):
        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world, dummy=True), True)

        def Init(self, file, node):
            self.position = libgz.Position()
            self.position.create(self.world.gz_server, self.GetId(), "Clumsy", self.GetIntId())

        def Update(self, step):
            self.position.lock()
            raise ValueError("in the middle")

    unlocked = []
    with libgz.World() as world:
        world.factory.RegisterModel("test", "Clumsy", Clumsy)
        world.Initialize()
        world.InsertModel("<model:Clumsy/>")
        world.interface("position", "Clumsy").unlock = lambda: unlocked.append(1)
        world.step(2)
    assert unlocked == [1]
