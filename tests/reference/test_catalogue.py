"""The catalogue of models, made from their declarations."""

import pytest

import libgz
from libgz.base.errors import NotFoundError
from libgz.interfaces.catalog import INTERFACES
from libgz.legacy.model import CommonAttributes
from libgz.models import MODELS
from libgz.models.simplesolid import SimpleSolidAttributes
from libgz.reference.catalogue import entries, entry
from libgz.worldfile.attributes import attributes_of, written
from libgz.worldfile.file import WorldFile

BUILT_IN = sorted(MODELS)


def example_of(name):
    file = WorldFile()
    file.LoadString(entry(name).example)
    return file


@pytest.mark.parametrize("name", BUILT_IN)
def test_examples_load_without_warnings_and_read_what_is_declared(name):
    file = example_of(name)
    with libgz.World() as world:
        world.Load(file)
        node = next(model for model in world.models if model.GetName() == name).node
        declared = {*attributes_of(entry(name).kind.attributes), *attributes_of(CommonAttributes), "enabled"}
        assert not file.diagnostics.found
        assert set(node.asked) <= declared
        assert set(attributes_of(entry(name).kind.attributes)) <= set(node.asked)


@pytest.mark.parametrize("name", BUILT_IN)
def test_declared_interfaces_are_those_served(name):
    with libgz.World.from_string(entry(name).example) as world:
        model = next(model for model in world.models if model.GetName() == name)
        served = {kind for kind, name_ in world.gz_server.interfaces if name_ == model.GetId()}
        assert served == set(model.interfaces)


def test_every_declared_interface_exists():
    assert {name for found in entries() for name in found.kind.interfaces} <= set(INTERFACES)


def test_summaries_are_short_sentences():
    for found in entries():
        assert found.summary.endswith("."), found.name
        assert len(found.summary) <= 116, found.name


def test_an_unknown_model_raises_an_error_with_a_suggestion():
    with pytest.raises(NotFoundError, match="did you mean 'SickLMS200'"):
        entry("SickLMS20")
    assert entry("sicklms200").name == "SickLMS200"


def test_rows_are_in_the_units_of_files():
    rows = {row.name: row for row in entry("SickLMS200").rows}
    assert (rows["minAngle"].default, rows["minAngle"].unit) == ("-90", "deg")
    assert rows["rangeCount"].allowed == "at least 1 and at most 400"
    rows = {row.name: row for row in entry("SimpleSolid").rows}
    assert rows["size"].default == "0.5 0.5 0.5 (box), 0.1 0.5 (cylinder), 0.5 (sphere)"
    assert rows["skinRpy"].default == "0 0 0"
    assert written(attributes_of(SimpleSolidAttributes)["transparent"], True) == "true"


def test_parts_are_those_of_the_engine():
    bodies, joints = entry("Pioneer2DX").parts()
    assert [part.name for part in bodies] == ["canonical", "left", "right", "caster"]
    assert bodies[3].text == "5 kg, sphere of radius 0.04 m"
    assert [part.text for part in joints][2] == "BallJoint between caster and canonical"
