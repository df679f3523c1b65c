"""The `<state>` element: read from XML, written as text, and applied to a world."""

import pytest
from lxml import etree

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzPose, GzVector
from libgz.sdf.state import SdfState

BODY = (
    "<link name='{}'><collision name='c'><geometry><sphere><radius>.1</radius></sphere></geometry></collision></link>"
)


def parse(inside):
    return SdfState.parse(etree.fromstring(f"<state world_name='w'>{inside}</state>"))


def test_a_state_is_read_as_it_was_written():
    state = SdfState(
        1.5,
        0.25,
        1.4e9,
        1500,
        poses={"lamp": GzPose(GzVector(0, 0, 9)), "a::b::link": GzPose(GzVector(1, 2, 3.25))},
        velocities={"a::b::link": (GzVector(1, 0, 0), GzVector(0, 0, -2))},
        insertions=["<model name='new'/>"],
        deletions=["old & gone"],
        world="hall & yard",
    )
    document = etree.fromstring(state.text("1.6"))
    found = SdfState.parse(document.find("state"))
    found.insertions = [text.strip().replace('"', "'") for text in found.insertions]
    assert found == state


def test_times_are_seconds_and_nanoseconds_or_seconds_alone():
    state = parse("<sim_time>3 1</sim_time><real_time>2.5</real_time><wall_time/>")
    assert (state.sim_time, state.real_time, state.wall_time) == (3.000000001, 2.5, 0.0)


@pytest.mark.parametrize(
    ("inside", "said"),
    [
        ("<sim_time>soon</sim_time>", r"<sim_time>: 'soon' is not allowed; it must be seconds and nanoseconds"),
        ("<sim_time>nan</sim_time>", r"<sim_time>: 'nan'"),
        ("<iterations>1.5</iterations>", r"<iterations>: '1.5' is not allowed; it must be an integer"),
        ("<model name='m'><pose>1 2</pose></model>", r"<pose>: '1 2' .* 6 numbers: x y z \[m\]"),
        ("<model name='m'><link name='l'><velocity>1 2 3 x 5 6</velocity></link></model>", r"<velocity>: .* 6 numbers"),
    ],
)
def test_an_invalid_number_is_an_error(inside, said):
    with pytest.raises(ParameterError, match=said):
        parse(inside)


def test_a_state_moves_nested_models_and_reports_each_unknown_name_once(load, caplog):
    nested = f"<model name='inner'>{BODY.format('tip')}</model>"
    state = (
        "<state world_name='w'><model name='outer'><pose>1 0 0 0 0 0</pose>"
        "<model name='inner'><pose>2 0 0 0 0 0</pose><link name='tip'><velocity>0 1 0 0 0 0</velocity></link></model>"
        "<link name='base'><pose>0 0 4 0 0 0</pose></link></model>"
        "<model name='nobody'><pose>0 0 0 0 0 0</pose><link name='l'><pose>0 0 0 0 0 0</pose></link></model></state>"
    )
    made = load(
        "<world name='w'><gravity>0 0 0</gravity>"
        f"<model name='outer'>{BODY.format('base')}{nested}</model>{state}</world>"
    )
    assert tuple(made.model("outer").GetBody("base").GetPosition()) == (0, 0, 4)
    tip = made.model("outer::inner").GetBody("tip")
    assert tuple(tip.GetPosition()) == (2, 0, 0)
    assert tuple(tip.GetLinearVel()) == (0, 1, 0)
    assert caplog.text.count("there is no model 'nobody'") == 1
