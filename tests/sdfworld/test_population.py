"""Populations: where each rule puts models."""

import itertools

import numpy as np
import pytest

import libgz

BALL = (
    "<model name='ball'><link name='l'><collision name='c'><geometry><sphere><radius>0.02</radius></sphere></geometry>"
)
BALL += "</collision></link></model>"
BOX = "<box><size>2 1 0.4</size></box>"
CYLINDER = "<cylinder><radius>1</radius><length>0.2</length></cylinder>"


def population(kind, region="", count=None, more="", pose="1 2 3 0 0 0", model=BALL):
    number = "" if count is None else f"<model_count>{count}</model_count>"
    rule = f"<distribution><type>{kind}</type>{more}</distribution>"
    return f"<population name='p'>{model}<pose>{pose}</pose>{region}{number}{rule}</population>"


@pytest.fixture
def places(caplog):
    """Where the models of a population stand, in its frame at (1, 2, 3)."""
    worlds = []

    def load(*parts, **options):
        text = f"<sdf version='1.5'><world name='default'>{''.join(parts)}</world></sdf>"
        worlds.append(libgz.World.from_string(text, **options))
        models = [model for model in worlds[-1].models if "_clone_" in model.GetId() and model.parent is None]
        assert [model.GetId() for model in models] == [f"ball_clone_{i}" for i in range(len(models))]
        return np.array([tuple(model.GetPose().pos) for model in models]).reshape(-1, 3) - (1.0, 2.0, 3.0)

    yield load
    for world in worlds:
        world.close()


def test_a_grid_is_centred_on_its_pose(places):
    found = places(population("grid", more="<rows>2</rows><cols>3</cols><step>0.3 0.4 0</step>"))
    wanted = [(x, y, 0.0) for y, x in itertools.product((-0.2, 0.2), (-0.3, 0.0, 0.3))]
    np.testing.assert_allclose(found, wanted, atol=1e-12)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_lines_begin_at_the_side_of_their_box(places, axis):
    found = places(population(f"linear-{'xyz'[axis]}", BOX, 4))
    size = (2.0, 1.0, 0.4)[axis]
    wanted = np.zeros((4, 3))
    wanted[:, axis] = size * np.arange(4) / 4 - size / 2
    np.testing.assert_allclose(found, wanted, atol=1e-12)


def test_random_places_fill_their_region(places):
    found = places(population("random", BOX, 300))
    assert (np.abs(found) <= (1.0, 0.5, 0.2)).all()
    np.testing.assert_allclose(found.mean(axis=0), 0.0, atol=0.15)
    np.testing.assert_allclose(np.ptp(found, axis=0), (2.0, 1.0, 0.4), rtol=0.1)
    found = places(population("random", CYLINDER, 300))
    distance = np.hypot(found[:, 0], found[:, 1])
    assert distance.max() <= 1.0
    assert distance.mean() == pytest.approx(0.5, abs=0.06)  # as many within half of the radius as beyond
    assert 0.0 <= found[:, 2].min() < found[:, 2].max() <= 0.2


@pytest.mark.parametrize(("region", "least"), [(BOX, 0.25), (CYLINDER, 0.2)])
def test_uniform_places_keep_apart(places, region, least):
    found = places(population("uniform", region, 10))
    assert len(found) == 10
    gaps = [np.linalg.norm(a[:2] - b[:2]) for a, b in itertools.combinations(found, 2)]
    assert min(gaps) > least


def test_equal_seeds_place_equal_models(places):
    one, other, third = (places(population("random", BOX, 5), seed=seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(one, other)
    assert not np.array_equal(one, third)


def test_a_turned_population_turns_about_its_first_corner(places):
    rule = "<rows>1</rows><cols>2</cols><step>1 1 0</step>"
    found = places(population("grid", more=rule, pose="1 2 3 0 0 1.5707963267948966"))
    np.testing.assert_allclose(found, [(-0.5, 0.0, 0.0), (-0.5, 1.0, 0.0)], atol=1e-9)


def test_models_of_a_population_are_models(places):
    included = "<model name='ball'><static>true</static><include><uri>model://pioneer2dx</uri></include></model>"
    places(population("grid", more="<rows>1</rows><cols>2</cols>", model=included))
    with libgz.World.from_string(
        f"<sdf version='1.5'><world name='w'>{population('random', BOX, 3)}</world></sdf>"
    ) as world:
        start = [model.GetPose() for model in world.models]
        world.step(100)
        state = world.get_state()
        world.step(100)
        later = [model.GetPose() for model in world.models]
        assert later != start
        other = world.clone()
        other.set_state(state)
        other.step(100)
        assert [model.GetPose() for model in other.models] == later
        other.close()
        world.Reset()
        assert [model.GetPose() for model in world.models] == start


def test_a_saved_world_has_the_models_and_no_population(tmp_path):
    from libgz.classic.server import attach

    with libgz.World.from_string(
        f"<sdf version='1.5'><world name='w'>{population('random', BOX, 3)}</world></sdf>"
    ) as world:
        attach(world).world.Save(str(tmp_path / "saved.world"))
        names = [model.GetId() for model in world.models]
    with libgz.World.from_file(tmp_path / "saved.world") as again:
        assert [model.GetId() for model in again.models] == names


@pytest.mark.parametrize(
    ("element", "message"),
    [
        (population("random", BOX, 0), "Trying to populate a non positive number of models [0]"),
        (population("uniform", BOX, -5), "Trying to populate a non positive number of models [-5]"),
        (population("grid", more="<rows>0</rows><cols>3</cols>"), "Incorrect number of rows"),
        (population("grid", more="<rows>2</rows><cols>-3</cols>"), "Incorrect number of columns"),
        (population("randm", BOX, 5), "Unknown distribution type [randm]; random, uniform"),
        (population("random", "", 5), "I have not found a valid region"),
        (population("random", "<box><size>0 1 1</size></box>", 5), "Incorrect box size"),
        (population("random", "<cylinder><radius>-1</radius><length>1</length></cylinder>", 5), "Incorrect radius"),
        (population("linear-x", CYLINDER, 5), "region [cylinder] and distribution [linear-x]"),
        (population("random", BOX, 5, model=""), "Unable to find <model>"),
        (population("uniform", BOX, 5000), "only 200 models fit"),
        (population("random", BOX, 10**7), "20000 at most"),
    ],
)
def test_what_cannot_be_placed_is_a_warning(places, caplog, element, message):
    assert len(places(element)) == 0
    assert message in caplog.text
    assert "<population>" in caplog.text
