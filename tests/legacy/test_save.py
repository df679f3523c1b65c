"""Saving a world: what was deleted goes, what was inserted stays, in the file that is loaded next."""

import shutil
from pathlib import Path

import pytest

import libgz
from libgz.base.files import installed_worlds

ROBOT = """<model:Pioneer2DX><id>new</id><xyz>3 3 0.24</xyz><model:SickLMS200><id>scanner</id></model:SickLMS200>
<model:MonoCam><id>eye</id><xyz>0 0 0.5</xyz></model:MonoCam></model:Pioneer2DX>"""


@pytest.fixture
def path(tmp_path):
    return Path(shutil.copy(installed_worlds() / "pioneer2at.world", tmp_path))


def ids(world):
    return [model.GetId() for model in world.GetModels()]


def test_inserted_and_deleted_models_are_saved(path):
    with libgz.World.from_file(path) as world:
        world.InsertModel(ROBOT)
        for name in ("eye", "barrel", "laser1"):
            world.DeleteModel(name)
        world.interface("position", "new").command(vx=0.3)
        world.run(1.0)
        kept, place = ids(world), tuple(world.model("new").GetPose().pos)
        assert world.Save(whole=True) == 0
        assert world.Save(whole=True) == 0
    with libgz.World.from_file(path) as world:
        assert ids(world) == kept
        assert world.model("scanner").parent is world.model("new")
        assert tuple(world.model("new").GetPose().pos) == pytest.approx(place, abs=6e-4)
    assert "passes between these" in path.read_text()


def test_states_and_resets_are_independent_of_saves(path):
    with libgz.World.from_file(path) as world:
        state, before = world.get_state(), ids(world)
        world.InsertModel(ROBOT)
        world.DeleteModel("crate")
        world.model("barrel").SetPose(libgz.GzPose((1, 2, 0)))
        assert world.Save(whole=True) == 0
        world.set_state(state)
        assert ids(world) == before
        assert world.get_state() == state
        world.DeleteModel("crate")
        world.reset()
        assert sorted(ids(world)) == sorted(before)
        assert world.Save(whole=True) == 0
    with libgz.World.from_file(path) as world:
        assert sorted(ids(world)) == sorted(before)
