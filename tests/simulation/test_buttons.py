"""The buttons of the sim interface: numbers other than 0 and 1 are overwritten memory, not commands."""

import random

import pytest

import libgz


@pytest.mark.parametrize("paused", [False, True])
def test_random_numbers_do_not_pause_reset_or_save(wire, paused, caplog):
    with libgz.World(wire) as world:
        world.Initialize()
        world.paused = paused
        world.Step()
        resets = []
        world.era.press_reset = lambda _: resets.append(1)
        with libgz.Client(wire, 0) as client:
            data = client.sim().data
            for number in (2, -1, 1 << 30, 0x5A):
                data.pause = data.reset = data.save = number
                assert world.paused == paused
                world.Step()
                assert (data.pause, data.reset, data.save) == (int(paused), 0, 0)
                data.reset = number
                world.Step()
                assert data.reset == 0
            assert not resets
            data.reset = 1
            data.pause = int(not paused)
            world.Step()
            assert resets == [1]
            assert world.paused != paused
    assert sum("sim.default: pause" in message for message in caplog.messages) == 1


def test_random_numbers_cost_python_only_what_is_logged(wire, monkeypatch, caplog):
    with libgz.World(wire) as world:
        world.Initialize()
        world.step(2)
        data, read, own = world.sim.data, [], world.buttons.read
        monkeypatch.setattr(world.buttons, "read", lambda: read.append(1) or own())
        for name in ("pause", "reset", "save"):
            for number in range(2, 152):
                setattr(data, name, number)
                world.step()
                assert (data.pause, data.reset, data.save) == (0, 0, 0)
        assert len(read) == 3 * 2
        data.pause, data.reset, data.save = 7, 1, 1  # beside an invalid pause, the others mean nothing
        world.step()
        assert (data.pause, data.reset, data.save) == (0, 0, 0)
        assert world.iterations == 2 + 3 * 150 + 1
    assert [message.partition(" is ")[0] for message in caplog.messages] == [
        f"a client wrote sim.default: {name}" for name in ("pause", "reset", "save") for _ in range(2)
    ]
    assert caplog.messages[1].endswith("(100 times so far)")


def test_native_code_reads_buttons_as_python_does(caplog):
    rng, done = random.Random(3), {True: [], False: []}
    with libgz.World() as native, libgz.World() as twin:
        twin.rows.enabled = False
        for world in (native, twin):
            world.Initialize()
            acts = done[world is native]
            world.Save = lambda acts=acts: acts.append("save")
            world.era.press_reset = lambda _, acts=acts: acts.append("reset")
        for step in range(2000):
            numbers = [rng.choice((0, 0, 0, 0, 1, 2, -1, 1 << 30)) for _ in range(3)]
            for world in (native, twin):
                data = world.sim.data
                data.pause, data.reset, data.save = numbers
                world.step()
                done[world is native].append((data.pause, data.reset, data.save, world.paused, world.iterations))
            assert done[True] == done[False], step
    assert {"save", "reset"} < set(done[True])
    assert caplog.messages == [message for message in caplog.messages[::2] for _ in range(2)], "both log the same"


def test_to_look_at_buttons_that_nobody_presses_takes_no_lock(wire):
    with libgz.World(wire) as world:
        world.Initialize()
        world.step(2)
        assert world.rows.run(0, 1) == 1
        with libgz.Client(wire, 0) as client:
            sim = client.sim()
            assert sim.lock()
            before = world.sim.link.attempts, world.sim.link.exchanges
            assert world.rows.run(0, 1) == 1
            assert (world.sim.link.attempts, world.sim.link.exchanges) == before
            sim.data.pause = 1
            assert world.rows.run(0, 1) == 0, "what is pressed is read under the lock"
            sim.unlock()
            world.Step()
            assert world.paused
