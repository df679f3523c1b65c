"""World: time, entities by name, and settings of a world."""

import math

import pytest
from plugin_worlds import body, collision

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic import physics
from libgz.classic.common import Time
from libgz.classic.math import Vector3d

BOX = collision("<box><size>1 1 1</size></box>")
LAMP = "<light name='lamp' type='point'><pose>0 0 9 0 0 0</pose></light>"
PLACE = (
    "<spherical_coordinates><surface_model>EARTH_WGS84</surface_model><latitude_deg>45</latitude_deg>"
    "<longitude_deg>9</longitude_deg><elevation>120</elevation><heading_deg>0</heading_deg></spherical_coordinates>"
)


@pytest.fixture
def world(run):
    """A world with two boxes and a light."""
    _, view = run(PLACE, body("a", "0 0 1 0 0 0", link=BOX), body("b", "3 0 1 0 0 0", link=BOX), LAMP)
    return view


def test_times_advance_with_steps_and_pauses(world):
    world.Step(3)
    assert (world.SimTime(), world.Iterations()) == (Time(0, 3000000), 3)
    world.SetPaused(True)
    world.core.step(2)
    assert (world.SimTime(), world.PauseTime(), world.IsPaused()) == (Time(0, 3000000), Time(0, 2000000), True)
    world.Step(1)
    assert (world.SimTime(), world.IsPaused()) == (Time(0, 4000000), True)
    world.SetSimTime(Time(5, 0))
    assert world.SimTime() == Time(5, 0)
    world.ResetTime()
    assert (world.SimTime(), world.Iterations()) == (Time(0, 0), 0)
    now = float(world.StartTime() + world.RealTime())
    assert now == pytest.approx(float(Time.GetWallTime()), abs=1.0)


def test_run_ends_after_its_iterations_or_with_stop(world):
    world.Run(5)
    assert (world.Iterations(), world.Running()) == (5, True)
    kept = world.core.events["WorldUpdateEnd"].Connect(lambda: world.Stop() if world.Iterations() == 8 else None)
    world.Run()
    assert (world.Iterations(), world.Running()) == (8, False)
    del kept


def test_entities_are_found_by_name(world):
    assert [model.GetName() for model in world.Models()] == ["a", "b"]
    assert (world.ModelCount(), world.LightCount()) == (2, 1)
    link = world.EntityByName("default::b::link")
    assert link is world.ModelByName("b").GetLink() is world.BaseByName("b::link")
    assert world.GetModel(1) is world.ModelByName("b") is world.GetEntity("b")
    assert world.Light("lamp") is world.Light(0) is world.LightByName("lamp") is world.Lights()[0]
    assert world.Light(1) is world.Light("sun") is world.ModelByIndex(2) is world.EntityByName("d") is None
    assert world.PrintEntityTree().splitlines()[:3] == ["default", "  a", "    link"]


def test_the_entity_below_a_point(world):
    assert world.EntityBelowPoint((3, 0, 9)) is world.ModelByName("b").GetLink().GetCollision(0)
    assert world.EntityBelowPoint((9, 9, 9)) is None
    with pytest.raises(ParameterError):
        world.EntityBelowPoint((float("nan"), 0, 0))


def test_settings_are_those_of_the_engine(world):
    world.SetGravity((0, 0, -1))
    assert world.Gravity() == Vector3d(0, 0, -1) == world.Physics().GetGravity()
    assert world.core.engine.gravity == (0, 0, -1)
    world.SetPhysicsEnabled(False)
    world.Step(10)
    assert world.ModelByName("a").WorldPose().Pos().Z() == 1.0
    assert (world.PhysicsEnabled(), world.SimTime()) == (False, Time(0, 10000000))
    contacts = world.Physics().GetContactManager()
    contacts.SetNeverDropContacts(True)
    world.ModelByName("a").SetWorldPose(world.ModelByName("b").WorldPose())
    world.Step(1)
    assert contacts.GetContactCount() == 1
    world.Step(1)
    assert contacts.GetContactCount() == 1
    world.SetMagneticField((1, 2, 3))
    assert world.MagneticField() == Vector3d(1, 2, 3)
    with pytest.raises(ParameterError, match="magnetic field"):
        world.SetMagneticField((1, 2))


def test_the_place_on_earth_is_read_from_the_file(world):
    place = world.SphericalCoords()
    assert (place.LatitudeReference().Degree(), place.LongitudeReference().Degree()) == pytest.approx((45, 9))
    assert place.GetElevationReference() == 120.0


def test_a_state_is_restored(world):
    box = world.ModelByName("a")
    state = physics.WorldState(world)
    box.SetWorldPose(world.ModelByName("b").WorldPose())
    box.SetLinearVel((1, 2, 3))
    world.SetState(state)
    assert tuple(box.WorldPose().Pos()) == (0, 0, 1)
    assert box.WorldLinearVel() == Vector3d()
    assert (
        state.GetModelStateCount(),
        state.SimTime(),
        tuple(state.GetModelState("b").GetLinkState("link").Pose().pos),
    ) == (2, Time(), (3, 0, 1))


def test_models_and_lights_are_removed(world):
    world.RemoveModel("a")
    world.RemoveModel("lamp")
    assert (world.ModelByName("a"), world.LightCount()) == (None, 0)
    with pytest.raises(NotFoundError, match="has no model 'a'"):
        world.RemoveModel("a")
    world.Clear()
    assert world.children() == []


def test_the_views_of_a_world_hold_no_state_of_it(world):
    assert set(vars(world)) == {"core", "server", "played", "_world", "_name", "_parent", "_sdf"}
    assert world.core.facade is world
    assert physics.worlds() == [world]
    assert physics.has_world("default")
    assert not physics.has_world("other")


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("real_time_update_rate", math.nan),
        ("real_time_update_rate", "fast"),
        ("max_step_size", math.nan),
        ("max_step_size", None),
        ("real_time_factor", math.nan),
        ("real_time_factor", -1.0),
        ("iters", math.inf),
        ("precon_iters", -1),
    ],
)
def test_a_parameter_of_physics_takes_no_other_value(run, key, value):
    _, view = run(body("box"))
    before = view.Physics().GetParam(key)
    with pytest.raises(ParameterError, match=key if key != "max_step_size" else "stepTime|max_step_size"):
        view.Physics().SetParam(key, value)
    assert view.Physics().GetParam(key) == before
    for setter in (view.Physics().SetRealTimeUpdateRate, view.Physics().SetMaxStepSize):
        with pytest.raises(ParameterError):
            setter(math.nan)
