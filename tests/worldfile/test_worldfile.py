"""Worldfiles: the old getters, errors, older spellings, and saving."""

import math
import os
from dataclasses import dataclass

import pytest
from hypothesis import given, strategies as st
from lxml import etree

import libgz
from libgz.base.entities import DEEPEST, Entities
from libgz.base.errors import ParameterError, WorldFileError
from libgz.base.files import xml_parser
from libgz.base.geometry import GzColor, GzQuaternFromEuler, GzQuaternToEuler, GzVector
from libgz.worldfile.attributes import angle, choice, color, length, number, numbers, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.number import atof, atoi, malformed

HEAD = """<?xml version="1.0"?>
<gz:world xmlns:gz='urn:gz' xmlns:model='urn:model' xmlns:param='urn:param' xmlns:params='urn:params'>
"""


def load(body, head=HEAD):
    file = WorldFile()
    file.LoadString(f"{head}{body}\n</gz:world>")
    return file


def node_of(body):
    return load(f"<model:Thing>{body}</model:Thing>").GetRootNode().GetChild()


def messages(file):
    return [str(error) for error in file.diagnostics.found]


# Numbers ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        (" -0", 0),
        (".10", 0.1),
        ("+10.0", 10),
        ("5.", 5),
        ("1e3x", 1000),
        ("abc", 0),
        ("", 0),
        ('"0.0', 0),
        ("inf", math.inf),
    ],
)
def test_atof(text, value):
    assert atof(text) == value


def test_atoi_stops_at_the_point():
    assert (atoi("12.9"), atoi(" -3 "), atoi("x")) == (12, -3, 0)


def test_malformed_numbers():
    assert [malformed(t) for t in ("1", " 1 ", "1x", "", "1 2", "-.5e-3")] == [False, False, True, True, True, False]


# Getters ---------------------------------------------------------------------------------------------------------


def test_getters_convert():
    node = node_of(
        "<d>1.5</d><i>7</i><b>true</b><off>0</off><a>180</a><p>1 2</p><r>0 0 90</r><c>1 0.5 0</c><t>1.0 90 x</t><e/>"
    )
    assert node.GetDouble("d") == 1.5
    assert node.GetInt("i") == 7
    assert node.GetBool("b") is True
    assert node.GetBool("off", True) is False
    assert node.GetAngle("a") == pytest.approx(math.pi)
    assert node.GetPosition("p") == GzVector(1, 2, 0)
    assert tuple(node.GetRotation("r")) == pytest.approx(tuple(GzQuaternFromEuler(0, 0, math.pi / 2)))
    assert node.GetColor("c") == GzColor(1, 0.5, 0, 1)
    assert node.GetTupleAngle("t", 1) == pytest.approx(math.pi / 2)
    assert node.GetTupleDouble("t", 5, 9.0) == 9.0
    assert node.GetTupleString("t", 2) == "x"
    assert node.GetTupleString("t", 3, "d") is None
    assert node.GetPosition("e", (7, 8, 9)) == GzVector(7, 8, 9)  # blank: the default
    assert node.GetColor("e", GzColor(1, 1, 1)) == GzColor(0, 0, 0)  # blank: black


def test_defaults_of_absent_keys():
    node = node_of("")
    assert node.GetString("x", "d") == "d"
    assert node.GetAngle("x", 1.0) == 1.0  # radians
    assert node.GetTupleAngle("x", 0, 0.5) == 0.5
    assert node.GetTupleString("x", 0, "d") == "d"
    assert node.GetColor("x", GzColor(0.1, 0.2, 0.3)) == GzColor(0.1, 0.2, 0.3)


def test_lookup_order_is_own_attribute_own_name_first_child():
    node = node_of('<color size="3">1 0 0</color><k>first</k><k>second</k>')
    assert node.GetString("k") == "first"
    child = node.GetChild("color")
    assert child.GetInt("size") == 3
    assert child.GetColor("color") == GzColor(1, 0, 0)


def test_content_is_untrimmed_and_skips_comments():
    assert node_of("<s> a <!-- no --> b </s>").GetString("s") == " a  b "


@given(st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=3))
def test_numbers_round_trip(values):
    node = node_of(f"<v>{' '.join(map(repr, values))}</v>")
    assert [node.GetTupleDouble("v", i) for i in range(3)] == values


def test_odd_values_of_real_files_are_read_with_a_warning():
    node = node_of('<c>"0.0 1.0 0.0"</c><b>yes</b><n>12abc</n>')
    assert node.GetColor("c") == GzColor(0, 1, 0)
    assert node.GetBool("b") is False
    assert node.GetDouble("n") == 12
    text = "\n".join(messages(node.file))
    assert "'\"0.0' is not a number, and is read as 0" in text
    assert "'yes' is neither true, false nor a number" in text
    assert "'12abc' is not a number, and is read as 12" in text


def test_lists_that_are_too_short_are_warnings():
    node = node_of("<xyz>1 2</xyz><rpy>90</rpy><color>1 1</color><size>1 2 3</size>")
    assert node.GetPosition("xyz") == GzVector(1, 2, 0)
    node.GetRotation("rpy")
    assert node.GetColor("color") == GzColor(1, 1, 0)
    node.GetPosition("size")
    missing = [text for text in messages(node.file) if "those that are missing are read as 0" in text]
    assert [text.partition(">: ")[2][:10] for text in missing] == ["has 2 of 3", "has 1 of 3", "has 2 of 3"]


def test_required_attribute():
    node = node_of("<otherName>1</otherName>")
    node.GetString("othername", None, 1)
    assert "must be given; did you mean 'otherName'?" in messages(node.file)[0]


def test_structure():
    root = load("<a/><model:X/><b/>").GetRootNode()
    assert (root.GetName(), root.GetNSPrefix()) == ("world", "gz")
    assert root.GetChild().GetName() == "a"
    assert root.GetChildByNSPrefix("model").GetName() == "X"
    assert root.GetChild("a").GetNext().GetNext().GetName() == "b"
    assert root.GetChild("b").GetNext() is None


def test_files_are_searched(tmp_path, monkeypatch):
    (tmp_path / "here.ppm").write_text("x")
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "far.ppm").write_text("x")
    world = tmp_path / "w.world"
    world.write_text(f"{HEAD}<model:X><f>here.ppm</f><g>far.ppm</g><h>gone.ppm</h></model:X></gz:world>")
    node = WorldFile.from_file(world).GetRootNode().GetChild()
    assert node.SearchFilename("f") == str(tmp_path / "here.ppm")
    assert node.SearchFilename("g", str(tmp_path / "lib")) == str(tmp_path / "lib" / "far.ppm")
    assert node.SearchFilename("h", None, "default") == "default"
    assert node.GetFilename("h") == str(tmp_path / "gone.ppm")
    error = messages(node.file)[0]
    assert error.startswith(f"{world}:3: <h>: file 'gone.ppm' was not found; looked for ")
    assert str(tmp_path / "gone.ppm") in error


# Errors ----------------------------------------------------------------------------------------------------------


def test_unused_attributes_are_reported_with_line_and_suggestion():
    file = load("<model:Thing>\n  <updaterate>5</updaterate>\n  <used>1</used>\n</model:Thing>")
    node = file.GetRootNode().GetChildByNSPrefix("model")
    file.GetRootNode().GetNSPrefix()
    node.GetNSPrefix()
    node.GetDouble("updateRate", 1)
    node.GetInt("used")
    assert file.WarnUnused()
    assert messages(file) == ["<string>:4: <updaterate>: is not used by <model:Thing>; did you mean 'updateRate'?"]


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("<a><b></a>", "mismatch"),
        ("", "ocument is empty"),
        ("not xml", "Start tag expected"),
        ("<gazebo:world xmlns:gazebo='x'/>", "0.8 - 0.10"),
        ("<sdf version='1.4'/>", "SDF world"),
    ],
)
def test_invalid_files_are_errors_with_file_and_line(text, what):
    with pytest.raises(WorldFileError, match=what) as caught:
        WorldFile().LoadString(text, "my.world")
    assert str(caught.value).startswith("my.world:")


def test_a_missing_file():
    with pytest.raises(WorldFileError, match="No such file"):
        WorldFile().Load("/nowhere.world")


def test_a_second_load_is_refused():
    file = load("")
    with pytest.raises(WorldFileError, match="use a new one"):
        file.LoadString("<a/>")


def test_undeclared_prefix_is_a_warning():
    file = WorldFile()
    file.LoadString("<gz:world xmlns:gz='x'><model:X/></gz:world>", "w")
    assert "prefix 'model' is not declared" in messages(file)[0]
    file.root.note_unused()
    assert len(messages(file)) == 1


def test_invalid_namespaces_are_accepted():
    file = WorldFile()
    file.LoadString("<gz:world xmlns:gz='&quot;http://x/#gz&quot;' xmlns:model='&quot;x y&quot;'><model:X/></gz:world>")
    assert file.GetRootNode().GetChildByNSPrefix("model").GetName() == "X"
    assert messages(file) == []


def test_entities_and_files_outside_are_not_followed(tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("SECRET")
    file = WorldFile()
    file.LoadString(f"<!DOCTYPE w [<!ENTITY e SYSTEM 'file://{secret}'>]><gz:world xmlns:gz='x'><a>&e;</a></gz:world>")
    assert "SECRET" not in file.GetRootNode().content


def test_entities_of_the_file_are_text():
    file = WorldFile()
    file.LoadString(
        "<!DOCTYPE w [<!ENTITY y '2'><!ENTITY at '1 &y;'><!ENTITY c 'a &amp;&y;'>]>"
        "<w><a>0 <!-- x --> &at; 3</a><b>&y;</b><c>&c; &lt;</c></w>"
    )
    assert file.GetRootNode().GetPosition("a") == GzVector(0, 1, 2)
    assert file.GetRootNode().GetString("a").split() == ["0", "1", "2", "3"]
    assert file.GetRootNode().GetInt("b") == 2
    assert file.GetRootNode().GetString("c") == "a &2 <"


@pytest.mark.parametrize(
    ("entity", "message"),
    [
        ("<!ENTITY e SYSTEM 'other.world'>", "2: <a>: entity &e; is not text of this file; other files are not read"),
        ("<!ENTITY e '<b/>'>", "2: <a>: entity &e; holds elements; only text is replaced"),
        (f"<!ENTITY e '{'x' * 100_000}'>", "2: <a>: entity &e; contains itself, or is longer than 100000 characters"),
    ],
)
def test_other_entities_are_errors(entity, message):
    file = WorldFile()
    file.LoadString(f"<!DOCTYPE w [{entity}]><w>\n<a>&e;</a></w>", "w")
    assert message in str(file.diagnostics.errors[0])


@pytest.mark.parametrize("depth", [DEEPEST, DEEPEST + 1, 10 * DEEPEST])
def test_entities_may_be_nested_as_deeply_as_that(depth):
    inside = "".join(f"<!ENTITY e{i} '&e{i + 1};'>" for i in range(depth))
    root = etree.fromstring(f"<!DOCTYPE w [{inside}<!ENTITY e{depth} 'x'>]><w/>", xml_parser())
    if depth <= DEEPEST:
        assert Entities(root).text("e0") == "x"
    else:
        with pytest.raises(ParameterError, match="entity &e41; contains itself, or is longer than 100000 characters"):
            Entities(root).text("e0")


def test_entity_bombs_are_not_expanded():
    bomb = "<!DOCTYPE b [<!ENTITY a 'aaaaaaaaaa'>" + "".join(
        f"<!ENTITY {chr(98 + i)} '{('&' + chr(97 + i) + ';') * 10}'>" for i in range(9)
    )
    file = WorldFile()
    try:
        file.LoadString(f"{bomb}]><gz:world xmlns:gz='x'>&j;</gz:world>")
    except WorldFileError as error:
        assert "entity" in str(error)  # newer parsers refuse it
    else:
        assert len(file.GetRootNode().content) < 100  # older ones leave it alone


@given(st.binary(max_size=200))
def test_no_bytes_crash_the_reader(data):
    try:
        WorldFile().LoadString(data)
    except WorldFileError as error:
        assert str(error)


# Attributes ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Declared:
    rate: float = number(10.0, unit="Hz", above=0.0, help="rate")
    view: float = angle(60.0, above=0.0, most=179.0, help="view")
    shape: str = choice("box", ("box", "sphere"), help="shape")
    size: tuple[float, ...] = numbers(1.0, 2.0, above=0.0, help="size")
    wide: float = length(3.0, least=0.0, help="width")
    color: GzColor = color(0.1, 0.2, 0.3, help="colour")


def test_declared_attributes_are_read():
    values = read(Declared, node_of("<view>90</view><size>5</size><shape> sphere </shape>"))
    assert values == Declared(view=math.pi / 2, size=(5.0, 2.0), shape="sphere")


def test_declared_attributes_name_what_is_allowed():
    node = node_of("<rate>-1</rate><view>200</view><shape>spere</shape>")
    values = read(Declared, node)
    assert values == Declared()
    text = messages(node.file)
    assert text[0] == "<string>:3: <rate>: '-1' is not allowed; rate [Hz] must be above 0"
    assert "view [deg] must be above 0 and at most 179 deg" in text[1]
    assert "shape must be one of box, sphere; did you mean 'sphere'?" in text[2]
    with pytest.raises(WorldFileError) as caught:
        node.file.diagnostics.raise_errors()
    assert len(str(caught.value).splitlines()) == 3


# Older spellings -------------------------------------------------------------------------------------------------


def old(model, body):
    return load(f"<model:{model}>{body}</model:{model}>").GetRootNode().GetChild()


def test_older_spellings():
    camera = old("SonyVID30", "<updatePeriod>.25</updatePeriod><imgSize>160 120</imgSize><lens><hfov>45</hfov></lens>")
    assert camera.GetDouble("updateRate") == 4.0
    assert camera.GetTupleInt("imageSize", 1) == 120
    assert camera.GetAngle("hfov") == pytest.approx(math.radians(45))
    observer = old(
        "ObserverCam",
        "<window><size>640 480</size></window><shadeModel>flat</shadeModel><displayLaser>1</displayLaser>",
    )
    assert observer.GetTupleInt("imageSize", 0) == 640
    assert observer.GetBool("shadeSmooth", True) is False
    assert observer.GetBool("displayRays") is True
    assert old("GroundPlane", "<texture2D>a.ppm</texture2D>").GetString("textureFile") == "a.ppm"
    assert old("SimpleSolid", "<cfm>.01</cfm>").GetTupleDouble("surfaceHardness", 0) == pytest.approx(1 / (0.02 * 0.01))


def test_the_newer_spelling_wins():
    node = old("MonoCam", "<updatePeriod>1</updatePeriod><updateRate>7</updateRate>")
    assert node.GetDouble("updateRate") == 7
    assert not node.WarnUnused()


def test_ignored_tags_are_no_warning():
    node = old("SonyVID30", "<window><title>x</title><pos>1 2</pos></window><displayLaser>true</displayLaser>")
    node.GetTupleInt("imageSize", 0)
    assert not node.WarnUnused()


def test_origins_of_old_files():
    file = load("<model:SimpleSolid><cfm>1</cfm><size>1 1 0.8</size></model:SimpleSolid><model:Pioneer2AT/>")
    solid, robot = file.GetRootNode().children
    assert file.is_old
    assert file.origin_height(solid) == pytest.approx(0.4)
    assert file.origin_height(robot) == pytest.approx(0.195)
    assert load("<model:Pioneer2AT/>").is_old is False


# Saving ----------------------------------------------------------------------------------------------------------

SAVED = """<?xml version="1.0"?>
<!-- first -->
<gz:world
   xmlns:gz='urn:gz'
   xmlns:model='urn > model'>

  <model:Box >   <!-- a box -->
    <id>a</id>
    <xyz>0 0 0</xyz><!-- its place -->
    <rpy/>
    <unknown a="1 > 0">&lt;kept&gt;</unknown>
  </model:Box>
  <model:Ball><id>b</id></model:Ball>
</gz:world>
"""


def test_save_keeps_comments_and_layout(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(SAVED)
    path.chmod(0o640)
    file = WorldFile.from_file(path)
    box, ball = file.GetRootNode().children
    box.SetPosition("xyz", (1, -0.00001, 2.34567))
    box.SetRotation("rpy", GzQuaternFromEuler(0, math.radians(1.5), math.pi / 2))
    ball.SetPosition("xyz", (0, 0, 1), add=True)
    file.Save()
    expected = SAVED.replace("<xyz>0 0 0</xyz>", "<xyz>1.000 0.000 2.346</xyz>").replace(
        "<rpy/>", "<rpy>0 1.500 90</rpy>"
    )
    expected = expected.replace("<model:Ball><id>", "<model:Ball><xyz>0.000 0.000 1.000</xyz><id>")
    assert path.read_text() == expected
    assert path.stat().st_mode & 0o777 == 0o640
    assert sorted(tmp_path.iterdir()) == [path]
    file.Save()
    assert path.read_text() == expected
    ball.SetPosition("xyz", (0, 0, 2), add=True)
    file.Save()
    assert path.read_text() == expected.replace("0.000 0.000 1.000", "0.000 0.000 2.000")


def test_added_tags_are_indented_like_their_neighbours(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(SAVED.replace("    <xyz>0 0 0</xyz><!-- its place -->\n", "").replace(">   <!-- a box -->", ">"))
    file = WorldFile.from_file(path)
    file.GetRootNode().GetChild().SetPosition("xyz", (1, 2, 3), add=True)
    file.Save()
    assert "<model:Box >\n    <xyz>1.000 2.000 3.000</xyz>\n    <id>a</id>\n" in path.read_text()


MODELS = """<gz:world xmlns:gz='g' xmlns:model='m'>
  <!-- the first -->
  <model:A><id>a</id><model:B><id>b</id></model:B></model:A>
  <model:C/> <!-- the last -->
</gz:world>
"""


def parsed(text):
    file = WorldFile()
    file.LoadString(text)
    return file


def test_elements_are_left_out_and_added(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(MODELS)
    file = WorldFile.from_file(path)
    a, c = file.GetRootNode().children
    other = parsed("<w:w xmlns:w='w' xmlns:model='m'> <model:D><w:x>\u00e9</w:x><id/></model:D></w:w>")
    [d] = other.GetRootNode().children
    d.SetPosition("xyz", (1, 0, 0), add=True)
    file.Save(removed=[a.children[1]], added=[d])
    expected = MODELS.replace("<model:B><id>b</id></model:B>", "").replace(
        "<!-- the last -->",
        "<!-- the last -->\n  <model:D xmlns:w='w'><xyz>1.000 0.000 0.000</xyz><w:x>\u00e9</w:x><id/></model:D>",
    )
    assert path.read_text() == expected
    a.SetPosition("xyz", (0, 1, 0), add=True)  # what is in an element that is left out has no effect
    file.Save(removed=[a, a.children[2], c])
    assert (
        path.read_text()
        == "<gz:world xmlns:gz='g' xmlns:model='m'>\n  <!-- the first --> <!-- the last -->\n</gz:world>\n"
    )
    file.Save(removed=[a, c], added=[d])
    again = WorldFile.from_file(path).GetRootNode()
    assert [node.tag for node in again.children] == ["model:D"]
    empty = parsed("<gz:world xmlns:gz='g'/>")
    empty.Save(tmp_path / "e.world", added=[c])
    assert (tmp_path / "e.world").read_text() == "<gz:world xmlns:gz='g'>\n<model:C xmlns:model='model'/>\n</gz:world>"


def test_other_encodings_survive(tmp_path):
    path = tmp_path / "w.world"
    text = (
        "<?xml version='1.0' encoding='iso-8859-1'?>\n<gz:world xmlns:gz='x'><!-- gr\u00fc\u00df --><a>1</a></gz:world>"
    )
    path.write_bytes(text.encode("iso-8859-1"))
    file = WorldFile.from_file(path)
    file.GetRootNode().SetString("a", "2\u00b0")
    file.Save()
    assert path.read_bytes().decode("iso-8859-1") == text.replace("<a>1", "<a>2\u00b0")


def test_a_protected_file_is_left_alone(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(SAVED)
    path.chmod(0o444)
    file = WorldFile.from_file(path)
    file.GetRootNode().children[0].SetPosition("xyz", (1, 2, 3))
    with pytest.raises(WorldFileError, match=r"unable to save .*: it is write-protected"):
        file.Save()
    assert path.read_text() == SAVED
    file.Save(tmp_path / "copy.world")
    assert "1.000 2.000 3.000" in (tmp_path / "copy.world").read_text()


def test_saving_fails_with_a_reason(tmp_path):
    file = load("<a>1</a>")
    with pytest.raises(WorldFileError, match="name a file"):
        file.Save()
    with pytest.raises(WorldFileError, match="unable to save"):
        file.Save(tmp_path / "no" / "such" / "folder.world")


POSED = {
    "attributes": "<model:A t='x>y' xyz = \"1 2 3\"  rpy='0 0 90'/>",
    "the tags of 0.3": "<model:A><pos>1 2 3</pos><rot>0 0 90</rot></model:A>",
    "a model of that name": "<model:A><model:xyz>5 5 5</model:xyz></model:A>",
}


@pytest.mark.parametrize("element", POSED.values(), ids=POSED)
@pytest.mark.parametrize("place", [(4.0, 5.0, 6.0), (0.0, 0.0, 0.0)])
def test_what_was_saved_is_what_is_read_again(tmp_path, element, place):
    path = tmp_path / "w.world"
    path.write_text(f"<gz:world xmlns:gz='g' xmlns:model='m'>{element}</gz:world>")
    file = WorldFile.from_file(path)
    (node,) = file.GetRootNode().children
    node.SetPosition("xyz", (9, 9, 9), add=True)
    node.SetPosition("xyz", place, add=True)
    node.SetRotation("rpy", GzQuaternFromEuler(0, 0, math.pi), add=True)
    file.Save()
    (again,) = WorldFile.from_file(path).GetRootNode().children
    for some in (node, again):
        assert tuple(some.GetPosition("xyz")) == place
        assert GzQuaternToEuler(some.GetRotation("rpy")).z == pytest.approx(math.pi)
    assert "5 5 5" in path.read_text() or "model:xyz" not in element


def test_attributes_are_quoted_where_they_are_saved(tmp_path):
    path = tmp_path / "w.world"
    path.write_text("<gz:world xmlns:gz='g'><a b='1' c=\"b='2'\"/></gz:world>")
    file = WorldFile.from_file(path)
    file.GetRootNode().children[0].SetString("b", "it's <\"&>")
    file.Save()
    (again,) = WorldFile.from_file(path).GetRootNode().children
    assert again.attributes == {"b": "it's <\"&>", "c": "b='2'"}


def test_files_of_wide_characters_are_read_and_left_alone(tmp_path):
    path = tmp_path / "w.world"
    path.write_bytes("<gz:world xmlns:gz='g'><a>1</a></gz:world>".encode("utf-16"))
    before, file = path.read_bytes(), WorldFile.from_file(path)
    assert file.GetRootNode().GetInt("a") == 1
    file.GetRootNode().SetString("a", "2")
    with pytest.raises(WorldFileError, match=r"unable to save .*UTF-8"):
        file.Save()
    assert path.read_bytes() == before


def test_a_second_value_is_a_warning():
    for body, message in (
        ("<m><a>1</a>\n<a>2</a></m>", "is not used: the first one counts, line 3"),
        ("<m a='1'><a>2</a></m>", "is not used: the attribute a= counts"),
    ):
        file = load(body)
        (node,) = file.GetRootNode().children
        assert node.GetInt("a") == 1
        node.used = True
        node.note_unused()
        assert [error.message for error in file.diagnostics.warnings] == [message]


@pytest.mark.parametrize("text", ["<gz:world xmlns:gz='g'/>", "<sdf version='1.6'><world name='default'/></sdf>"])
def test_names_and_texts_that_are_no_unicode(tmp_path, text):
    path = tmp_path / os.fsdecode(b"caf\xe9.world")
    path.write_text(text)
    with libgz.World.from_file(path) as world:
        world.step()
    with pytest.raises(libgz.GazeboError, match=r"<string>:2: '\\udce9' is no character of XML"):
        libgz.World.from_string(text + "\n\udce9")
