"""The grammar of worldfiles, against the installed worlds and the models' examples."""

from pathlib import Path

import pytest
from lxml import etree

from libgz.base.files import installed_worlds
from libgz.models import MODELS
from libgz.reference.catalogue import entry
from libgz.reference.grammar import grammar

ROOT = Path(__file__).parents[2]
READY_WORLDS = sorted([*installed_worlds().glob("*.world"), *ROOT.glob("examples/*/*.world")])
READY_WORLDS = [path for path in READY_WORLDS if "<sdf" not in path.read_text()]
BUILT_IN = sorted(MODELS)


@pytest.fixture(scope="module")
def schema():
    return etree.RelaxNG(etree.fromstring(grammar()))


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
def test_errors_are_not_valid(schema, old, new):
    text = (installed_worlds() / "simplesolids.world").read_text()
    assert old in text
    assert not schema.validate(etree.fromstring(text.replace(old, new).encode()))


def test_models_of_plugins_may_contain_anything(schema):
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
