"""Several steps of one call are the same as single ones."""

import pytest

import libgz

TEXT = (
    "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>"
    "<model:Pioneer2AT><id>r</id></model:Pioneer2AT><model:SimpleSolid><id>s</id><xyz>2 0 1</xyz></model:SimpleSolid>"
    "</gz:world>"
)


@pytest.fixture
def world(monkeypatch):
    monkeypatch.setattr("libgz.ode.step.LONGEST", 60.0)
    with libgz.World.from_string(TEXT) as made:
        made.interface("position", "r").command(vx=0.3, vyaw=0.2)
        yield made


def test_steps_on_are_equal_to_single_steps(world):
    if not world.rows.native:
        pytest.skip("the native step was not built")
    with libgz.World.from_string(TEXT) as other:
        other.interface("position", "r").command(vx=0.3, vyaw=0.2)
        made, calls = 0, 0
        while made < 600:
            made += world.step_on(600 - made)
            calls += 1
        for _ in range(600):
            other.Step()
        assert made == world.iterations == 600
        assert calls < 60  # most of them without Python
        assert world.get_state() == other.get_state()


def test_steps_of_a_paused_world_count(world):
    world.paused = True
    assert [world.step_on(5), world.step_on(5)] == [1, 1]
    world.step(3)
    assert world.iterations == 0
    assert world.GetPauseTime() == pytest.approx(5 * 0.02)


def test_a_listener_is_called_in_each_step(world):
    seen = []
    connection = world.events["WorldUpdateEnd"].Connect(lambda: seen.append(world.iterations))
    assert world.step_on(5) == 1
    world.step(3)
    assert seen == [1, 2, 3, 4]
    del connection
    assert world.step_on(5) == 5


def test_states_are_kept_for_rewinding_in_several_steps(world):
    world.keep_rewind(1.0, interval=0.1)
    world.step(40)
    assert world.rewind(0.4) == pytest.approx(0.4)
