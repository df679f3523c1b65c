"""Clocks, seeds and settings that change after a state: set again in the same world, and in one with another seed."""

import numpy as np
import pytest
import state_runs
from classic_runs import Run
from state_settings import KEPT_BY_RESET, OF_CLASSIC, OF_WORLDS

from libgz import World
from libgz.base.errors import ParameterError
from libgz.classic.math import Rand

LEGACY = (
    "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane><id>ground</id></model:GroundPlane><model:Pioneer2AT>"
    "<id>one</id><model:SickLMS200><id>laser</id><xyz>.1 0 .311</xyz></model:SickLMS200></model:Pioneer2AT>"
    "<model:SimpleSolid><id>box</id><xyz>1 0.2 1</xyz></model:SimpleSolid></gz:world>"
)
NOISE = """<noise type='gaussian'><mean>0.1</mean><stddev>0.2</stddev><bias_mean>1</bias_mean>
<bias_stddev>1</bias_stddev></noise>"""
CLASSIC = f"""<sdf version='1.6'><world name='default'><model name='ground'><static>1</static><link name='l'>
<collision name='c'><geometry><plane/></geometry></collision></link></model><model name='box'><pose>0 0 .6 0 .1 0</pose>
<link name='l'><collision name='c'><geometry><box><size>.4 .4 .4</size></box></geometry></collision>
<sensor name='imu' type='imu'><always_on>1</always_on><update_rate>130</update_rate><imu><angular_velocity>
<x>{NOISE}</x></angular_velocity></imu></sensor><sensor name='bump' type='contact'><always_on>1</always_on>
<update_rate>30</update_rate><contact><collision>c</collision></contact></sensor></link></model></world></sdf>"""
NEW = """<sdf version='1.6'><model name='new{1}'><pose>0 0 3 0 0 0</pose><link name='l'>
<sensor name='s' type='altimeter'><always_on>1</always_on><altimeter><vertical_position>{0}</vertical_position>
</altimeter></sensor></link></model></sdf>"""


class Legacy:
    """A legacy world, and what follows in it."""

    def __init__(self, **options):
        self.world = World.from_string(LEGACY, **options)

    def run(self, steps=12):
        seen = state_runs.digest(state_runs.run(self.world, steps, 1))
        return seen, self.world.random.spawn(1)[0].generate_state(4).tolist()


class Classic:
    """An SDF world, and what follows in it: with the noise of a new sensor, and that of one that starts again."""

    def __init__(self, **options):
        self.world = World.from_string(CLASSIC, **options)
        self.world.attach_era()

    def run(self, steps=12):
        run = Run(self.world)
        view, seen = run.view, run.steps(steps)
        view.InsertModelString(NEW.format(NOISE, len(self.world.models)))
        seen += run.steps(steps)
        view.ResetTime()
        seen += run.steps(steps)
        return seen, Rand.DblUniform(0.0, 1.0), self.world.random.spawn(1)[0].generate_state(4).tolist()


def check(kind, name, change):
    """The state from before a change, and that from after it, set again, have the same consequences."""
    made = kind()
    with made.world as world:
        start = world.get_state()
        made.run()
        state = world.get_state()
        seen = made.run()
        change(world)
        changed = world.get_state()
        after = made.run()
        world.set_state(state)
        assert world.get_state() == state
        assert made.run() == seen
        other = kind(seed=5)
        with other.world as second:
            second.set_state(changed)
            assert second.get_state() == changed
            assert other.run() == after
        if kind is Legacy or name not in KEPT_BY_RESET:
            world.Reset()
            assert world.get_state() == start


SHORT = {"seed", "update rates"}
CASES = [(Legacy, OF_WORLDS), (Classic, OF_WORLDS | OF_CLASSIC)]


@pytest.mark.parametrize(
    ("kind", "name", "change"),
    [
        pytest.param(kind, name, change, id=f"{kind.__name__}-{name}", marks=[] if name in SHORT else pytest.mark.trial)
        for kind, changes in CASES
        for name, change in changes.items()
    ],
)
def test_what_is_set_after_a_state_is_undone_by_it(kind, name, change):
    check(kind, name, change)


def test_a_seed_is_a_natural_number():
    with World.from_string(LEGACY) as world:
        for seed in (-1, 1.5, "1", None):
            with pytest.raises(ParameterError, match="seed is"):
                world.reseed(seed)
        world.reseed(2**70)
        state = world.get_state()
        draw = np.random.default_rng(world.random.spawn(1)[0]).random()
        world.reseed(3)
        world.set_state(state)
        assert (world.seed, np.random.default_rng(world.random.spawn(1)[0]).random()) == (2**70, draw)
