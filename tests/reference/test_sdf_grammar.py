"""The grammar of SDF, against files of all versions that it describes."""

from pathlib import Path

import pytest
from lxml import etree

from libgz.reference.sdf_grammar import sdf_grammar
from libgz.sdf.description import VERSIONS

ROOT = Path(__file__).parents[2]
FILES = sorted([*ROOT.glob("libgz/sdf/worlds/*.world"), *ROOT.glob("libgz/sdf/models/*/model.sdf")])
FILES += sorted(path for path in ROOT.glob("examples/**/*.world") if "<sdf" in path.read_text())
WORLD = """<sdf version="1.6"><world name="w"><model name="m"><static>false</static><link name="l">
<pose>0 0 1 0 0 0</pose><inertial><mass>2.5</mass></inertial>
<sensor name="s" type="ray"><ray><range><min>0.1</min><max>8</max></range></ray></sensor></link>
<link name="k"/><joint name="j" type="revolute"><parent>l</parent><child>k</child><axis><xyz>0 0 1</xyz></axis></joint>
<model name="inner"><link name="l"/></model><plugin name="p" filename="p.so"><any x="1">thing</any></plugin>
</model></world></sdf>"""


@pytest.fixture(scope="module")
def schemas():
    return {version: etree.RelaxNG(etree.fromstring(sdf_grammar(version))) for version in VERSIONS}


@pytest.mark.parametrize("path", FILES, ids=lambda path: "/".join(path.parts[-2:]))
def test_files_are_valid(schemas, path):
    document = etree.parse(path)
    schema = schemas[document.getroot().get("version")]
    assert schema.validate(document), schema.error_log


@pytest.mark.parametrize("version", VERSIONS)
def test_a_world_is_valid_in_each_version(schemas, version):
    text = WORLD if version >= "1.5" else WORLD.replace('<model name="inner"><link name="l"/></model>', "")
    assert schemas[version].validate(etree.fromstring(text.encode())), schemas[version].error_log


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("<mass>", "<mas>"),
        ("2.5", "heavy"),
        ("0 0 1 0 0 0", "0 0 1"),
        ("<static>false</static>", "<static>perhaps</static>"),
        ("<parent>l</parent>", ""),
        ('name="k"', 'nam="k"'),
        ("0.1", "0.1 0.2"),
    ],
)
def test_errors_are_not_valid(schemas, old, new):
    text = WORLD.replace(old, new).replace("</mass>", "</mas>" if "mas>" in new else "</mass>")
    assert old in WORLD
    assert not schemas["1.6"].validate(etree.fromstring(text.encode()))
