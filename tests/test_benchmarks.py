"""The benchmarks compare with what does the same."""

import shutil
import sys
from pathlib import Path

import pytest

import libgz

sys.path.insert(0, str(Path(__file__).parent.parent / "benchmarks"))

from laser_robots import world_text
from legged import legged_text
from reference import Reference, scene_of

pytestmark = pytest.mark.skipif(not (shutil.which("cc") or shutil.which("gcc")), reason="there is no C compiler")


@pytest.mark.parametrize("text", [world_text(2, 2), legged_text(1)], ids=["wheels and lasers", "legs"])
def test_the_reference_moves_a_world_as_libgz_does(text):
    with libgz.World.from_string(text) as world:
        for model in world.models:
            if model.GetName() == "Pioneer2AT":
                world.interface("position", model.GetId()).command(vx=0.2, vyaw=0.1)
        world.step(60)
        start = world.engine.bodies[0].GetCoMPose().pos
        scene = scene_of(world)
        assert ("cast" in scene) == ("Sick" in text)
        with Reference(scene) as reference:
            spent = reference.run(50)
            world.step(50)
        end = world.engine.bodies[0].GetCoMPose().pos
        assert reference.position == pytest.approx(tuple(end), abs=2e-4)
        assert ("Sick" in text) == (abs(end.x - start.x) > 0.1)
        assert spent.cpu > 0.0
