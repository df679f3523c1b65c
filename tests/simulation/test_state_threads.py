"""Clones in threads: each does what it does alone, whatever the others do, and after the original was closed."""

import sys
import threading

import pytest
import state_runs
from classic_runs import Run

from libgz import World
from libgz.base.files import installed_worlds

PLUGIN = """
import threading
from libgz.classic import *
from libgz.classic.event import Events
from libgz.classic.physics import get_world
barrier = None
class Pushes(ModelPlugin):
    STATE = ("count",)
    def Load(self, model, sdf):
        self.model, self.count = model, 0
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        if barrier is not None:
            barrier.wait(20)
        assert get_world("default").GetName() == "default"
        assert get_world() is model.GetWorld()
        self.node = transport.Node()
        self.node.Init("default")
    def OnUpdate(self):
        self.count += 1
        self.model.GetLinks()[0].AddForce((0.3 * (self.count % 5), 0, 0))
GZ_REGISTER_MODEL_PLUGIN(Pushes)
"""
TEXT = """<sdf version='1.6'><world name='default'><model name='ground'><static>1</static><link name='l'>
<collision name='c'><geometry><plane/></geometry></collision></link></model><model name='box'><pose>0 0 .6 0 .1 0</pose>
<link name='l'><collision name='c'><geometry><box><size>.4 .4 .4</size></box></geometry></collision>
<sensor name='bump' type='contact'><always_on>1</always_on><contact><collision>c</collision></contact></sensor></link>
<plugin name='p' filename='libpushes.so'/></model></world></sdf>"""


@pytest.fixture
def pushes(tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    (tmp_path / "pushes.py").write_text(PLUGIN)


def run_legacy(world, steps=40):
    return state_runs.digest(state_runs.run(world, steps, 1)), world.get_state()


def run_classic(world, steps=40):
    return Run(world).steps(steps), world.get_state()


def legacy():
    return World.from_file(installed_worlds() / "pioneer2at.world")


def classic():
    return World.from_string(TEXT)


def in_threads(functions):
    """What functions return that run at once; each in a thread of its own."""
    results = {}

    def call(number, function):
        results[number] = function()

    threads = [threading.Thread(target=call, args=pair, daemon=True) for pair in enumerate(functions)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert not any(thread.is_alive() for thread in threads)
    return [results.get(number) for number in range(len(functions))]


@pytest.mark.parametrize(
    ("make", "run"), [pytest.param(legacy, run_legacy, marks=pytest.mark.trial), (classic, run_classic)]
)
def test_clones_in_threads_do_what_each_does_alone(make, run, pushes):
    with make() as world:
        world.step(30)
        state = world.get_state()
        alone = run(world)
        world.set_state(state)
        clones = [world.clone(), world.clone()]
        clones.append(clones[0].clone())
        everything = [world, *clones]
        assert in_threads([lambda one=one: run(one) for one in everything]) == [alone] * 4

        def again(one):
            for _ in range(3):
                one.set_state(state)
                one.step(3)
                with one.clone() as another:
                    another.step(2)
            one.set_state(state)
            return run(one)

        assert in_threads([lambda one=one: again(one) for one in everything]) == [alone] * 4
    for clone in clones:  # of a world that is closed
        clone.set_state(state)
        with clone, clone.clone() as another:
            assert run(another) == run(clone) == alone


def test_a_plugin_of_a_clone_may_wait_for_a_thread_that_uses_the_original(pushes):
    with classic() as world:
        plugin = world.facade.server.plugins.of_model(world.facade.ModelByName("box"))[0].plugin
        module, begun = sys.modules[type(plugin).__module__], threading.Event()

        class Barrier:
            def wait(self, seconds):
                begun.set()
                user.join(seconds)
                assert not user.is_alive()

        user = threading.Thread(target=lambda: begun.wait(20) and world.step(3), daemon=True)
        module.barrier = Barrier()
        try:
            user.start()
            state = world.get_state()
            with world.clone() as clone:
                assert (clone.errors, clone.get_state()) == ([], state)
                assert world.iterations == 3
        finally:
            module.barrier = None


def test_worlds_that_load_at_once_do_not_wait_for_each_other(pushes):
    with classic() as world:
        module = sys.modules[
            type(world.facade.server.plugins.of_model(world.facade.ModelByName("box"))[0].plugin).__module__
        ]
        state = world.get_state()
        module.barrier = threading.Barrier(2)  # both hold their locks when they look for a world
        try:
            for other in in_threads([classic, classic]):
                with other:
                    assert other.errors == []
                    assert other.get_state() == state
        finally:
            module.barrier = None
