"""What has changed in memory, found natively or in Python, gives the writing process the same bytes."""

import random

import numpy as np
import pytest

import libgz
from libgz.base.records import LinkRecord
from libgz.recording import changes
from libgz.recording.changes import Changes, Piece, apply_patches
from libgz.recording.frames import Frames, Kind, tick_times
from libgz.transport.layout import Part

SIZES = (40, 96, 511, 512, 513, 5056, 20000)


@pytest.fixture(params=[True, False], ids=["native", "python"])
def native(request):
    if request.param and changes._library() is None:
        pytest.skip("the native part was not built")
    return request.param


def frames_of(taken):
    return list(Frames().feed(bytes(taken)))


def apply(copies, found):
    """Write the patches of frames into the copies; the channels that have changed."""
    patched = [one for one in found if one.kind == Kind.PATCH]
    for one in patched:
        apply_patches(copies[one.channel], one.content)
    return [one.channel for one in patched]


def test_copies_equal_the_memory_after_each_step(native):
    dice = random.Random(7)
    memories = [bytearray(size) for size in SIZES]
    looking = Changes([Piece(memory, i) for i, memory in enumerate(memories)], native=native)
    copies = [bytearray(size) for size in SIZES]
    looking.record(0, 0)
    assert apply(copies, frames_of(looking.send())) == list(range(len(SIZES)))  # all are new
    for step in range(150):
        touched = sorted(dice.sample(range(len(SIZES)), dice.randrange(3)))
        for i in touched:
            for _ in range(dice.randrange(1, 5)):
                start = dice.randrange(SIZES[i])
                end = min(SIZES[i], start + dice.choice((1, 8, 31, 32, 700)))
                memories[i][start:end] = bytes(b ^ dice.randrange(1, 256) for b in memories[i][start:end])
        looking.record(step, 2 * step)
        found = frames_of(looking.send())
        assert apply(copies, found) == touched
        assert copies == memories
        assert tick_times(found[0].content) == (step, 2 * step)
        assert [found[0].kind, found[-1].kind] == [Kind.TICK, Kind.END]


def test_frames_wait_in_order(native):
    memory = bytearray(64)
    looking = Changes([Piece(memory, 1), Piece(bytearray(64), 2)], native=native)
    looking.record(1, 1, before=b"")
    waiting = looking.record(2, 2)
    for i in range(300):  # more than there is space for at the beginning
        memory[3] = i % 256
        more = looking.record(3, 3, 0, before=b"b" * 500, after=b"a")
        assert more > waiting + 500
        waiting = more
    taken = bytes(looking.send())
    assert len(taken) == waiting
    assert taken.count(b"b" * 500) == 300
    assert looking.record(4, 4) < 100
    assert [one.kind for one in frames_of(looking.send())] == [Kind.TICK, Kind.END]


def test_the_first_piece_can_be_left_out(native):
    memories = bytearray(64), bytearray(64)
    looking = Changes([Piece(memory, i) for i, memory in enumerate(memories)], native=native)
    looking.record(0, 0)
    looking.send()
    memories[0][0] = memories[1][0] = 1
    copies = [bytearray(64), bytearray(64)]
    looking.record(0, 0, first=1)
    assert apply(copies, frames_of(looking.send())) == [1]
    looking.record(0, 0)
    assert apply(copies, frames_of(looking.send())) == [0]


def test_writes_of_the_server_and_of_clients_are_recorded_in_the_same_step(native):
    memory, link = bytearray(5000), LinkRecord()
    copies = {5: bytearray(5000)}
    looking = Changes([Piece(memory, 5, ((0, 64), (4000, 8)), link)], native=native)
    looking.record(0, 0)
    looking.send()
    for step in range(40):
        memory[2000] += 1  # by the server, under the lock
        link.exchanges += 1
        looking.record(step, step)
        assert apply(copies, frames_of(looking.send())) == [5]
        memory[4003] += 1  # a command
        looking.record(step, step)
        assert apply(copies, frames_of(looking.send())) == [5]
        looking.record(step, step)
        assert apply(copies, frames_of(looking.send())) == []
        assert copies[5] == memory
    memory[3000] += 1  # by somebody who should not
    for step in range(128):
        looking.record(step, step)
        apply(copies, frames_of(looking.send()))
    assert copies[5] == memory


def test_memory_that_is_known_is_not_sent_again(native):
    memory, other = bytearray(b"x" * 100), bytearray(b"y" * 200)
    first = Changes([Piece(memory, 1)], native=native)
    first.record(0, 0)
    first.send()
    second = Changes([Piece(memory, 1), Piece(other, 2, seen=True)], first, native=native)
    second.record(0, 0)
    assert apply({}, frames_of(second.send())) == []
    other[150] += 1
    second.record(0, 0)
    copies = {2: bytearray(b"y" * 200)}
    assert apply(copies, frames_of(second.send())) == [2]
    assert copies[2] == other


def test_each_release_of_a_lock_is_counted():
    text = (
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>"
        "<model:Pioneer2AT><id>robot1</id></model:Pioneer2AT></gz:world>"
    )
    with libgz.World.from_string(text) as world:
        link = world.interface("position", "robot1").link
        before = link.exchanges
        world.step(50)  # natively, 10 times a second of sim time
        assert link.exchanges >= before + 10
        before = link.exchanges
        with world.interface("position", "robot1").locked():
            pass
        assert link.exchanges == before + 1


def test_steps_of_a_world_are_recorded_at_its_times(native):
    memories, numbers = [bytearray(64), bytearray(64)], np.zeros(2)
    revision = np.zeros(1, np.int64)
    quick, plain = (Changes([Piece(memory, i) for i, memory in enumerate(memories)], native=native) for _ in range(2))
    moments = changes.Moments(0.0, 0.0, 0.03, 0.0, 1e12, 2000)
    moments.step, moments.sim_time = numbers.ctypes.data, numbers.ctypes.data + 8
    moments.revision = revision.ctypes.data
    time, found = 0.0, []
    for step in range(9):
        numbers[:] = 0.01, -1.0 if step < 3 else 7.0 + 0.0123456789 * step
        for memory in memories:
            memory[step] = step + 1
        time += 0.01
        first = 0 if step % 3 == 0 else 1  # bodies and joints are recorded in every third step
        plain.record(round(time * 1e9), max(round(float(numbers[1]) * 1e9), 0), first)
        found.append(quick.record_step(moments))
    revision[0] = 1
    before = moments.time
    assert quick.record_step(moments) == -1  # there is another scene
    if not native:
        assert found == [-1] * 9  # Python has to call `record`
        return
    assert moments.time == before == time
    assert found == [0] * 9
    frames = bytes(quick.send())
    assert frames == bytes(plain.send())
    moments.revision_seen, moments.send_size = 1, len(frames) // 9
    memories[0][:] = memories[1][:] = bytes(range(64))
    assert quick.record_step(moments) == 1  # there is enough to send
    quick.send()
    moments.send_size, moments.send_period = 2000, 0.0
    assert quick.record_step(moments) == 1  # it is time to
    numbers[1] = 1e12
    assert quick.record_step(moments) == -1  # for Python limits it


def test_after_a_write_what_is_in_use_of_an_array_is_compared(native):
    memory, link = bytearray(5000), LinkRecord()
    parts = Part(0, 200), Part(200, 4000, element=40, used=196), Part(4200, 800)
    copies = {5: bytearray(5000)}
    looking = Changes([Piece(memory, 5, ((0, 40),), link, parts=parts)], native=native)
    looking.record(0, 0)
    looking.send()
    for count in (1, 3, 99, 100, 101, 2, -1, 2**31 - 1, 0, 7):
        memory[196:200] = count.to_bytes(4, "little", signed=True)
        used = count if 0 <= count <= 100 else 100
        for place in (150, *((200, 199 + 40 * used) if used else ()), 4200, 4999):
            memory[place] ^= 0xFF
        link.exchanges += 1
        looking.record(0, 0)
        assert apply(copies, frames_of(looking.send())) == [5]
        assert copies[5] == memory
    memory[3000] ^= 0xFF  # behind those in use
    link.exchanges += 1
    for _ in range(128):
        looking.record(0, 0)
        apply(copies, frames_of(looking.send()))
    assert copies[5] == memory
