"""The buttons of the sim interface: numbers other than 0 and 1 are overwritten memory, not commands."""

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
