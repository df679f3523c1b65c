"""A server with hostile clients: the simulation continues, and the server ends cleanly."""

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

EXTREME = [struct.pack("d", value) for value in (math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324)]
EXTREME += [struct.pack("i", value) * 2 for value in (-1, 2**31 - 1, -(2**31), 401, 4097)]


@pytest.fixture
def attacked(gazebo, tmp_path):
    path = tmp_path / "attacked.world"
    path.write_text(WORLD)
    return gazebo(path, "--rate", "20")


def files_of(server):
    """A server's files but its pid; not those that it writes at the moment, which get another name."""
    return sorted(
        path
        for path in server.directory.iterdir()
        if path.name != "gazebo.pid" and path.suffix != ".new" and path.is_file()
    )


def take_lock(descriptor):
    """Take a lock, which a server holds for microseconds; fail if it never releases it."""
    end = time.monotonic() + 10
    while True:
        try:
            return fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            assert time.monotonic() < end, "the server keeps a lock"
            time.sleep(0.0005)


def assert_it_runs(server, seconds=1.0):
    """Assert that sim time advances and that the poses of the robots are finite."""
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


def assert_it_ends_cleanly(server):
    code, _, err = server.stop()
    assert code == 0, err
    assert "Traceback" not in err
    assert " stopped, its motors off" not in err
    return err


def test_extreme_numbers_in_every_field_of_clients(attacked):
    with libgz.Client(attacked.id, 5) as client:
        for kind, name in client.interfaces():
            interface = client.open(new_interface(kind), name)
            for field_name, field in fields_of(interface.layout).items():
                if field.writer == "S" or field_name in ("save", "string"):
                    continue
                place = getattr(interface.layout, field_name)
                for pattern in EXTREME:
                    raw = (pattern * (place.size // 8 + 1))[: place.size]
                    memory = memoryview(interface.data).cast("B")
                    memory[place.offset : place.offset + place.size] = raw
                    for _ in range(6):  # models read commands in every fifth step
                        assert client.wait(timeout=5.0)
    assert_it_runs(attacked)
    err = assert_it_ends_cleanly(attacked)
    assert "a client wrote position.robot1: cmd_vel_pos[0] is" in err


def test_random_bytes_in_all_files(attacked):
    generator = random.Random(2)
    end = time.monotonic() + 1.5
    while time.monotonic() < end:
        path = generator.choice(files_of(attacked))
        size = path.stat().st_size
        if not size:  # a file of the observers that is being written
            continue
        with path.open("r+b") as file:
            file.seek(generator.randrange(size))
            file.write(generator.randbytes(min(64, size - file.tell())))
        if path.name == "sim.default":  # not the commands reset and save
            with path.open("r+b") as file:
                file.seek(176)
                file.write(bytes(16))
    for path in files_of(attacked):  # clients check the head
        if path.name.startswith(("sim", "position")):
            with path.open("r+b") as file:
                file.write(struct.pack("iiQ", 0x060, 0, path.stat().st_size))
    assert_it_runs(attacked)
    assert_it_ends_cleanly(attacked)


def test_all_files_truncated_repeatedly(attacked):
    # Under the lock, which is survived without the native part, too.
    for turn in range(20):
        for path in files_of(attacked):
            descriptor = os.open(path, os.O_RDWR)
            take_lock(descriptor)
            os.ftruncate(descriptor, turn % 3)
            fcntl.flock(descriptor, fcntl.LOCK_UN)
            os.close(descriptor)
        time.sleep(0.02)
    time.sleep(0.2)
    assert_it_runs(attacked)
    assert "its length was restored" in assert_it_ends_cleanly(attacked)


def test_all_locks_held(attacked):
    held = [os.open(path, os.O_RDWR) for path in files_of(attacked) if path.name != "sim.default"]
    for descriptor in held:
        take_lock(descriptor)
    with libgz.Client(attacked.id, 5) as client:
        sim = client.sim()
        time.sleep(0.3)
        before = sim.sim_time
        for _ in range(100):
            assert client.wait(timeout=2.0)
        assert sim.sim_time > before
    for descriptor in held:
        os.close(descriptor)
    assert_it_runs(attacked)
    err = assert_it_ends_cleanly(attacked)
    assert err.count("holds the lock of position.robot1") == 1


def test_all_files_removed(attacked):
    with libgz.Client(attacked.id, 5) as client:
        sim = client.sim()
        for path in files_of(attacked):
            path.unlink()
        before = sim.sim_time
        for _ in range(50):
            assert client.wait(timeout=2.0)
        assert sim.sim_time > before
    assert_it_ends_cleanly(attacked)


def test_files_replaced_by_links(attacked, tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("precious")
    for path in files_of(attacked):
        path.unlink()
        path.symlink_to(precious)
    time.sleep(0.2)
    assert_it_ends_cleanly(attacked)
    assert precious.read_text() == "precious"


def test_a_factory_with_many_invalid_requests(attacked):
    generator = random.Random(3)
    requests = [
        b"<model:SimpleSolid><id>s</id><xyz>9 9 1</xyz></model:SimpleSolid>",
        b"<delete>s</delete>",
        b"<delete>nobody</delete>",
        b"<model:SimpleSolid><size>nan nan nan</size></model:SimpleSolid>",
        b"<" * 4096,
        generator.randbytes(4096),
        b"<!DOCTYPE x [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;'>]><model:SimpleSolid><id>&b;</id></model:SimpleSolid>",
        b"<model:SimpleSolid>" * 200,
    ]
    path = Path(attacked.directory) / "factory.f"
    end = time.monotonic() + 1.5
    while time.monotonic() < end:
        request = generator.choice(requests)[: generator.choice((4096, 4096, 10))]
        with path.open("r+b", buffering=0) as file:  # without the lock
            file.seek(160)
            file.write(request.ljust(4096, b"\0"))
        time.sleep(generator.choice((0, 0.005)))
    assert_it_runs(attacked)
    assert "request failed" in assert_it_ends_cleanly(attacked)


def test_a_model_that_fails_releases_its_locks(caplog):
    class Failing(libgz.Model):
        def Load(self, file, node):
            self.AddBody(libgz.Body(self.world, dummy=True), True)

        def Init(self, file, node):
            self.position = libgz.Position()
            self.position.create(self.world.gz_server, self.GetId(), "Failing", self.GetIntId())

        def Update(self, step):
            self.position.lock()
            raise ValueError("in the middle")

    unlocked = []
    with libgz.World() as world:
        world.factory.RegisterModel("test", "Failing", Failing)
        world.Initialize()
        world.InsertModel("<model:Failing/>")
        world.interface("position", "Failing").unlock = lambda: unlocked.append(1)
        world.step(2)
    assert unlocked == [1]
