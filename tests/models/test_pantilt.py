"""Pan-tilt cameras: when they act, natively and while the world is paused."""

import pytest

import libgz

WORLD = """<gz:world xmlns:gz="g" xmlns:model="m"><model:GroundPlane/>
<model:SonyVID30><id>cam</id><xyz>0 0 1</xyz></model:SonyVID30></gz:world>"""


def test_what_is_due_in_a_paused_world_stays_due(wire):
    with libgz.World.from_string(WORLD, server_id=wire) as world, libgz.Client(wire, 0) as client:
        model, ptz = world.model("cam"), client.ptz("cam")
        moved = set()
        for number in range(12):
            ptz.data.cmd_pan = 0.1 + 0.01 * number  # each is taken by the first step that is due
            world.paused = True
            for _ in range(2):
                world.Step()
                assert model.rate.last == model._moved
                assert model.ptz.command[0] != ptz.data.cmd_pan
            world.paused = False
            world.Step()
            if model.ptz.command[0] == ptz.data.cmd_pan:
                moved.add(number)
        assert len(moved) in (2, 3)
        assert max(moved) - min(moved) in (5, 10)


@pytest.mark.parametrize("native", [True, False])
def test_it_moves_and_looks_once_a_period(monkeypatch, native):
    with libgz.World.from_string(WORLD) as world:
        world.rows.enabled = native
        world.step(6)
        model, calls = world.model("cam"), []
        for name in ("_move", "_look"):
            own = getattr(model, name)
            monkeypatch.setattr(model, name, lambda *given, name=name, own=own: (calls.append(name), own(*given)))
        world.step(25)
        assert calls.count("_move") == 5
        assert calls.count("_look") == 5
