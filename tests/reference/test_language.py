"""Completion and meanings in texts that are being typed."""

import random

import pytest

from libgz.base.files import installed_worlds
from libgz.reference.language import completions, meaning

LEGACY = """<?xml version="1.0"?>
<gz:world xmlns:gz="x#gz" xmlns:model="x#model">
  <!-- <model:Nothing> -->
  <param:Global><stepTime>0.02</stepTime></param:Global>
  <model:SimpleSolid><shape>box</shape><siz|
</gz:world>"""
MANY = 300_000
SDF = """<sdf version="1.6"><world name="w"><model name="m"><link name="l">
<inertial><ma|</inertial></link></model></world></sdf>"""


def at(text):
    """The text without its mark, and the mark's offset."""
    return text.replace("|", ""), text.index("|")


def labels(text):
    return {one.label: one for one in completions(*at(text))}


def test_attributes_of_a_model_are_offered_in_its_element():
    found = labels(LEGACY)
    assert {"size", "mass", "xyz", "model:SickLMS200"} <= found.keys()
    assert "[m]" in found["size"].detail
    assert "Nothing" not in found


@pytest.mark.parametrize(
    ("text", "wanted", "unwanted"),
    [
        ("<gz:world><|</gz:world>", {"model:Pioneer2AT", "param:Global"}, {"size"}),
        ("<gz:world><param:Global><|", {"gravity", "stepTime"}, {"model:Pioneer2AT"}),
        ("<gz:world><model:SimpleSolid><shape>|", {"box", "sphere"}, {"xyz"}),
        ("<gz:world><model:Pioneer2AT><model:SickLMS200><range|", {"rangeMax"}, {"shape"}),
        ("<gz:world><model:SimpleSolid><transparent>t|", {"true", "false"}, {"xyz"}),
        ("<gz:world><!-- <model:SimpleSolid><|", set(), {"shape"}),
        ('<sdf version="1.6"><world name="w"><|', {"model", "light", "physics"}, {"mass"}),
        ('<sdf version="1.6"><world name="w"><joint |', {"name", "type"}, {"axis"}),
        ('<sdf version="1.6"><world name="w"><joint name="j" type="|', {"revolute", "prismatic"}, {"name"}),
        ('<sdf version="1.6"><world name="w"><model name="m"><static>|', {"true", "false"}, {"mass"}),
        ('<sdf version="1.6"><world name="w"><model name="m"><link name="l"/><|', {"link", "joint"}, {"mass"}),
        ('<sdf version="1.6"><world name="w"><plugin name="p" filename="f"><|', set(), {"model"}),
        ("", set(), {"mass"}),
    ],
)
def test_what_is_offered_depends_on_the_place(text, wanted, unwanted):
    found = labels(text if "|" in text else text + "|").keys()
    assert wanted <= found
    assert not unwanted & found


def test_meanings_name_type_unit_and_default():
    assert "kg" in meaning(*at(SDF.replace("<ma|", "<ma|ss>")))
    text = meaning(*at(LEGACY.replace("<siz|", "<si|ze>1</size>")))
    assert text.startswith("**size**: ")
    assert "[m]" in text
    assert "Pioneer2AT" in meaning(*at("<gz:world><model:Pione|er2AT>"))
    assert "required" in meaning(*at('<sdf version="1.6"><world na|me="w">'))
    assert meaning(*at("<gz:world><model:SimpleSolid><id>si|ze</id>")) == ""


def test_no_text_is_too_wild():
    text = (installed_worlds() / "simplesolids.world").read_text()
    numbers = random.Random(3)
    for _ in range(150):
        cut = numbers.randrange(len(text))
        wild = text[: numbers.randrange(len(text))] + "<!--"[: numbers.randrange(5)] + text[cut:]
        offset = numbers.randrange(len(wild) + 1)
        completions(wild, offset)
        meaning(wild, offset)
    completions("<" * 200_000, 200_000)
    completions("<a " * 50_000 + '"', 150_001)


@pytest.mark.parametrize(
    "text",
    [
        "<sdf>" + "<sdf " * MANY,
        "<sdf version='1.6'><world name='w'><!-- -->" + "a" * MANY + " ",
        "<sdf version='1.6'><world " + "a" * MANY + " '",
        "<sdf version='1.6'>" + "<a>" * MANY + "<b></b>" * MANY,
        "<!-- -->" + "<!-- " * MANY,
    ],
)
def test_the_time_grows_with_the_length_of_a_text(text):
    meaning(text, len(text))
    completions(text, len(text))
    completions(text, 8)
