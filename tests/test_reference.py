"""What is made from the models' declarations: the catalogue, the reference pages, the grammar."""

import re
from pathlib import Path

import pytest
from lxml import etree

import libgz
from libgz.errors import NotFoundError
from libgz.interfaces.catalog import INTERFACES
from libgz.legacy.model import CommonAttributes
from libgz.models import MODELS
from libgz.models.simplesolid import SimpleSolidAttributes
from libgz.reference.catalogue import entries, entry
from libgz.reference.grammar import grammar
from libgz.reference.pages import pages, write_pages
from libgz.worldfile.attributes import attributes_of, installed_worlds, written
from libgz.worldfile.file import WorldFile

ROOT = Path(__file__).parent.parent
READY_WORLDS = sorted([*installed_worlds().glob("*.world"), *ROOT.glob("examples/*/*.world")])
BUILT_IN = sorted(MODELS)


def example_of(name):
    file = WorldFile()
    file.LoadString(entry(name).example)
    return file


@pytest.mark.parametrize("name", BUILT_IN)
def test_examples_load_without_a_word_and_declarations_are_what_is_read(name):
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


def test_summaries_are_sentences():
    for found in entries():
        assert found.summary.endswith("."), found.name
        assert len(found.summary) <= 116, found.name


def test_an_unknown_model_is_answered_with_the_nearest():
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


def test_pages_are_current(tmp_path):
    expected = pages()
    found = {path.name: path.read_text() for path in (ROOT / "docs" / "models").glob("*.md")}
    assert found == expected, "run libgz models --pages docs/models"
    assert len(write_pages(tmp_path)) == len(MODELS) + 1
    assert write_pages(tmp_path) == []


def test_pages_link_to_pages_that_exist():
    folder = ROOT / "docs" / "models"
    for path in folder.glob("*.md"):
        for target in re.findall(r"\]\(([^)#]+)", path.read_text()):
            assert (folder / target).exists(), (path, target)


@pytest.fixture(scope="module")
def schema():
    return etree.RelaxNG(etree.fromstring(grammar()))


def test_every_ready_world_has_its_picture():
    page = (ROOT / "docs/worlds.md").read_text()
    worlds = sorted(path.stem for path in (ROOT / "worlds").glob("*.world"))
    assert re.findall(r"^!\[\w+\]\(worlds/(\w+)\.png\)$", page, re.MULTILINE) == worlds
    assert sorted(path.stem for path in (ROOT / "docs/worlds").glob("*.png")) == worlds, "run scripts/make_gallery.py"


def test_every_model_is_in_a_ready_world():
    text = "".join(path.read_text() for path in (ROOT / "worlds").glob("*.world"))
    assert set(re.findall(r"<model:(\w+)", text)) >= set(MODELS)


@pytest.mark.parametrize("path", READY_WORLDS, ids=lambda path: path.stem)
def test_ready_worlds_are_valid(schema, path):
    assert schema.validate(etree.parse(path)), schema.error_log


@pytest.mark.parametrize("name", BUILT_IN)
def test_examples_are_valid(schema, name):
    assert schema.validate(etree.fromstring(entry(name).example.encode())), schema.error_log


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<mass>20</mass>", "<mas>20</mas>"),  # a misspelt attribute
        ("<mass>20</mass>", "<mass>-20</mass>"),
        ("<mass>20</mass>", "<mass>heavy</mass>"),
        ("<shape>sphere</shape>", "<shape>ball</shape>"),
        ("<size>0.2</size>", "<size>1 2 3 4</size>"),
        ("<transparent>true</transparent>", "<transparent>perhaps</transparent>"),
        ("model:GroundPlane>", "model:GroundPlan>"),  # a misspelt model
    ],
)
def test_faults_are_not_valid(schema, old, new):
    text = (installed_worlds() / "simplesolids.world").read_text()
    assert old in text
    assert not schema.validate(etree.fromstring(text.replace(old, new).encode()))


def test_a_models_plugin_may_bring_anything(schema):
    example = entry("GroundPlane").example
    with_plugin = (
        "<model:Ball><plugin>Ball.py</plugin><radius unit='cm'>3<x/></radius><model:SimpleSolid/></model:Ball>"
    )
    assert schema.validate(etree.fromstring(example.replace("</gz:world>", with_plugin + "</gz:world>").encode()))
    without = with_plugin.replace("<plugin>Ball.py</plugin>", "")
    assert not schema.validate(etree.fromstring(example.replace("</gz:world>", without + "</gz:world>").encode()))
    misspelt_inside = with_plugin.replace(
        "<model:SimpleSolid/>", "<model:SimpleSolid><sice>1</sice></model:SimpleSolid>"
    )
    assert not schema.validate(
        etree.fromstring(example.replace("</gz:world>", misspelt_inside + "</gz:world>").encode())
    )


def test_the_tools_page_names_all_commands():
    from libgz.apps.libgz import COMMANDS

    text = (ROOT / "docs" / "tools.md").read_text()
    for command in ("check", "models", "schema", "upgrade", "convert"):
        assert command in COMMANDS
        assert f"`libgz {command} " in text or f"`libgz {command}`" in text
