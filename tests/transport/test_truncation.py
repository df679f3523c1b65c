"""Clients that truncate interface files: the process survives, in the middle of an access, too."""

import faulthandler
import mmap
import os
import random
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import libgz
from libgz.transport import truncation
from libgz.transport.client import Client
from libgz.transport.layout import LIBGAZEBO_VERSION
from libgz.transport.server import Server
from libgz.transport.truncation import watch

pytestmark = pytest.mark.skipif(
    not Path(truncation.__file__).with_name("_truncation.so").exists(),
    reason="without a C compiler truncations are not survived",
)

SIZE = 5 * mmap.PAGESIZE + 100


@pytest.fixture
def mapped(tmp_path):
    descriptor = os.open(tmp_path / "file", os.O_RDWR | os.O_CREAT)
    os.ftruncate(descriptor, SIZE)
    memory = mmap.mmap(descriptor, SIZE)
    yield memory, descriptor
    os.close(descriptor)


def run(script, *words):
    command = [sys.executable, "-c", script, *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_access_to_a_truncated_file_extends_it(mapped):
    memory, descriptor = mapped
    found = watch(memory, descriptor)
    for length in (0, 1, mmap.PAGESIZE, SIZE - 200):
        os.ftruncate(descriptor, length)
        memory[SIZE - 1] = 7
        assert os.fstat(descriptor).st_size == SIZE
        assert os.pread(descriptor, 1, SIZE - 1) == b"\7"
    assert (found.counts.recovered, found.counts.lost) == (4, 0)


def test_memory_survives_its_descriptor(mapped, tmp_path):
    memory, descriptor = mapped
    found = watch(memory, descriptor)
    os.ftruncate(descriptor, 0)
    found.release()
    memory[0] = 7
    assert memory[0] == 7
    assert found.counts.lost == 1
    assert os.fstat(descriptor).st_size == 0


def test_a_descriptor_that_now_belongs_to_another_file_is_not_touched(mapped, tmp_path):
    memory, descriptor = mapped
    found = watch(memory, descriptor)
    other = os.open(tmp_path / "other", os.O_RDWR | os.O_CREAT)
    os.ftruncate(descriptor, 0)
    os.dup2(other, descriptor)
    memory[0] = 7
    assert memory[0] == 7
    assert found.counts.lost == 1
    assert os.fstat(other).st_size == 0
    os.close(other)


def test_many_mappings_come_and_go(tmp_path):
    descriptor = os.open(tmp_path / "file", os.O_RDWR | os.O_CREAT)
    os.ftruncate(descriptor, SIZE)
    for _ in range(3):
        memories = [mmap.mmap(descriptor, SIZE) for _ in range(600)]
        watches = [watch(memory, descriptor) for memory in memories]
        os.ftruncate(descriptor, 0)
        memories[599][0] = 7
        assert watches[599].counts.recovered == 1
        del memories, watches
    os.close(descriptor)


FULL = """
import mmap, os, resource, sys
from libgz.transport.truncation import watch
descriptor = os.open(sys.argv[1], os.O_RDWR | os.O_CREAT)
os.ftruncate(descriptor, 20000)
memory = mmap.mmap(descriptor, 20000)
found = watch(memory, descriptor)
os.ftruncate(descriptor, 0)
resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
memory[9000] = 7
assert memory[9000] == 7 and memory[0] == 0
print(found.counts.recovered, found.counts.lost)
"""


def test_a_file_that_cannot_be_extended_becomes_private_memory(tmp_path):
    done = run(FULL, tmp_path / "file")
    assert (done.returncode, done.stdout) == (0, "0 2\n"), done.stderr


FOREIGN = """
import faulthandler, mmap, os, sys
from libgz.transport.truncation import watch
if "before" in sys.argv:
    faulthandler.enable()
descriptor = os.open(sys.argv[1], os.O_RDWR | os.O_CREAT)
os.ftruncate(descriptor, 20000)
mine, other = mmap.mmap(descriptor, 20000), mmap.mmap(descriptor, 20000)
watch(mine, descriptor)
if "after" in sys.argv:
    faulthandler.enable()
if "cycle" in sys.argv:
    faulthandler.enable()
    third = mmap.mmap(descriptor, 20000)
    watch(third, descriptor)
if "sent" in sys.argv:
    os.kill(os.getpid(), 7)
os.ftruncate(descriptor, 0)
if "forked" in sys.argv and os.fork() == 0:
    os.closerange(3, 100)
    mine[0] = 7
    print("survived", flush=True)
    os._exit(0)
other[0] = 7
"""


@pytest.mark.parametrize("case", ["alone", "before", "after", "cycle", "sent"])
def test_other_bus_errors_end_the_process_as_ever(tmp_path, case):
    done = run(FOREIGN, tmp_path / "file", case)
    assert done.returncode == -7
    assert ("Fatal Python error: Bus error" in done.stderr) == (case in ("before", "after", "cycle"))


def test_a_forked_child_without_descriptors_survives(tmp_path):
    assert "survived" in run(FOREIGN, tmp_path / "file", "forked").stdout


def test_pytest_itself_watches_bus_errors():
    assert faulthandler.is_enabled()  # so all tests here run before its handler


ATTACK = """
import os, random, sys, time
paths, end, generator = sys.argv[2:], time.monotonic() + float(sys.argv[1]), random.Random(5)
files = [(os.open(path, os.O_RDWR), os.stat(path).st_size) for path in paths]
count = 0
while time.monotonic() < end:
    descriptor, size = generator.choice(files)
    os.ftruncate(descriptor, generator.choice((0, 1, 100, 200, size // 2, size - 1)))
    count += 1
print(count)
"""


def test_a_server_and_a_client_survive_truncation_at_full_speed(wire, caplog):
    server, client = Server(wire), Client()
    server.start()
    camera, seen = libgz.Camera(), libgz.Camera()
    camera.create(server, "c", "MonoCam", 3, 2)
    client.connect_wait(wire, -1)
    seen.open(client, "c")
    attack = [sys.executable, "-c", ATTACK, "2", f"{server.path}/camera.c"]
    process = subprocess.Popen(attack, stdout=subprocess.PIPE, text=True)
    pixels = np.full(camera.all_pixels.size, 7, dtype=np.uint8)
    while process.poll() is None:
        if camera.lock():
            camera.all_pixels[:] = pixels
            camera.unlock()
        seen.all_pixels.sum()
    assert int(process.communicate()[0]) > 1000
    time.sleep(0.06)
    assert camera.lock()
    camera.all_pixels[:] = pixels
    camera.unlock()
    head = seen.data.head
    assert (head.version, head.size, head.model_id) == (LIBGAZEBO_VERSION, camera.size, 3)
    assert (seen.all_pixels == 7).all()
    messages = [record.message for record in caplog.records if "truncated camera.c" in record.message]
    assert "its length was restored" in messages[0]
    assert len(messages) < 10
    client.disconnect()
    server.stop()


@pytest.mark.parametrize("native", [True, False])
def test_the_length_is_restored_with_the_lock(wire, monkeypatch, native):
    if not native:
        monkeypatch.setattr(truncation, "_library", lambda: None)
    server = Server(wire)
    server.start()
    robot = libgz.Position()
    robot.create(server, "robot1", "Pioneer2AT", 3, 2)
    for length in (0, 10, robot.size - 1):
        os.truncate(f"{server.path}/position.robot1", length)
        time.sleep(0.06)
        assert robot.lock()
        robot.unlock()
        with open(f"{server.path}/position.robot1", "rb") as file:  # noqa: PTH123
            content = file.read()
        assert len(content) == robot.size
        assert content[:152] == bytes(robot.data.head)
        assert b"Pioneer2AT" in content
    server.stop()


def test_a_head_that_a_client_overwrote_is_restored(wire, caplog):
    server, client = Server(wire), Client()
    server.start()
    robot, seen = libgz.Position(), libgz.Position()
    robot.create(server, "robot1", "Pioneer2AT", 3, 2)
    client.connect_wait(wire, -1)
    seen.open(client, "robot1")
    before = bytes(seen.data.head)
    generator = random.Random(1)
    for _ in range(1000):
        memoryview(seen.data.head).cast("B")[:] = generator.randbytes(len(before))
        assert robot.lock()
        robot.unlock()
        assert bytes(seen.data.head) == before
    assert [record.message for record in caplog.records] == [
        "a client overwrote the head of position.robot1; it was restored" + count
        for count in ("", " (100 times so far)", " (1000 times so far)")
    ]
    client.disconnect()
    server.stop()
