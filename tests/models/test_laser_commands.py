"""Requests for another scan, and memory that clients overwrite."""

import os
import random

from camera_worlds import HEAD

import libgz
from libgz.interfaces.laser import LaserData

LASER = "<model:SickLMS200><id>l</id><xyz>0 0 0.3</xyz><scanRate>50</scanRate></model:SickLMS200>"
BOX = "<model:SimpleSolid><xyz>2 0 0</xyz><size>1 2 2</size></model:SimpleSolid>"
TEXT = f"{HEAD.format('')}{LASER}{BOX}</gz:world>"
HEAD_SIZE = LaserData.time.offset


def read_switches(laser, monkeypatch):
    """The names of switches that Python looks at from now on."""
    read, own = [], laser.guard.switch
    monkeypatch.setattr(laser.guard, "switch", lambda name, *values: read.append(name) or own(name, *values))
    return read


def test_random_requests_cost_python_only_what_is_logged(wire, monkeypatch, caplog):
    with libgz.World.from_string(TEXT, server_id=wire) as world:
        world.step(2)
        laser = world.model("l")
        data, read = laser.laser.data, read_switches(laser, monkeypatch)
        for name in ("cmd_new_angle", "cmd_new_length"):
            for number in range(2, 152):
                setattr(data, name, number)
                world.step()
                assert (data.cmd_new_angle, data.cmd_new_length) == (0, 0)
        assert len(read) == 2 * 2 * 2  # both switches, the 1st and the 100th time, each of them
        data.cmd_new_angle, data.cmd_new_length, data.cmd_max_range = 7, 1, 4.0
        world.step()
        assert (data.cmd_new_angle, data.cmd_new_length, data.max_range) == (0, 0, 4.0)
    assert [message.partition(" is ")[0] for message in caplog.messages] == [
        f"a client wrote laser.l: {name}" for name in ("cmd_new_angle", "cmd_new_length") for _ in range(2)
    ]
    assert caplog.messages[1].endswith("(100 times so far)")


def overwrite(laser, rng):
    """Random bytes somewhere in the file, or a request, valid or not; always the same for one state of `rng`."""
    if rng.random() < 0.5:
        begin = rng.choice((0, LaserData.cmd_new_angle.offset, rng.randrange(laser.size)))
        os.pwrite(laser.descriptor, rng.randbytes(min(rng.choice((64, laser.size)), laser.size - begin)), begin)
        return
    data = laser.data
    data.cmd_new_angle, data.cmd_new_length = rng.choices((0, 1, 2, -1, 1 << 30), (4, 1, 1, 1, 1), k=2)
    data.cmd_min_angle, data.cmd_max_angle = rng.uniform(-2.0, 0.5), rng.uniform(-0.5, 2.0)
    data.cmd_max_range, data.cmd_range_count = rng.choice((0.0, rng.uniform(0.0, 9.0))), rng.randrange(500)


def test_native_code_treats_overwritten_memory_as_python_does(wire, monkeypatch, caplog):
    found, scans = ([], []), set()
    with (
        libgz.World.from_string(TEXT, server_id=wire) as native,
        libgz.World.from_string(TEXT, server_id=wire + 1) as twin,
    ):
        twin.rows.enabled = False
        read = read_switches(native.model("l"), monkeypatch)
        for world, results in ((native, found[0]), (twin, found[1])):
            world.step(2)
            rng, laser = random.Random(5), world.model("l").laser
            head = os.pread(laser.descriptor, HEAD_SIZE, 0)
            for _ in range(1000):
                overwrite(laser, rng)
                laser.link.next_check = 0.0  # commands are kept in each exchange, not by real time
                caplog.clear()
                world.step()
                content = os.pread(laser.descriptor, laser.size, 0)
                assert content[:HEAD_SIZE] == head
                scans.add(world.model("l")._wanted_scan)
                results.append((content[HEAD_SIZE:], world.model("l")._wanted_scan, caplog.messages.copy()))
    for number, (one, two) in enumerate(zip(*found, strict=True)):
        assert one == two, number
    assert len(scans) > 50, "some requests are valid"
    assert len(read) < 800, "and most of the others are for native code"


def test_a_request_does_not_come_again_when_its_memory_is_restored(wire):
    with libgz.World.from_string(TEXT, server_id=wire) as world:
        world.step(2)
        laser = world.model("l").laser
        for far in (4.0, 5.0):
            laser.link.next_check = 0.0 if far == 4.0 else 1e300  # commands are kept after the first request only
            laser.data.cmd_max_range, laser.data.cmd_new_length = far, 1
            world.step()
            assert laser.data.max_range == far
        os.pwrite(laser.descriptor, b"\xff" * HEAD_SIZE, 0)
        world.step()
        assert laser.data.max_range == 5.0
