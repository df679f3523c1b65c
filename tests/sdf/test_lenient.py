"""What Gazebo classic's parser let pass is a warning with its line; what it could not read is an error."""

import pytest
from commands import run_libgz

import libgz
from libgz.base.errors import Diagnostics, WorldFileError
from libgz.reference.check import check_sdf
from libgz.sdf.reader import SdfFile
from libgz.sdf.value import repaired
from libgz.sdf.xml import parse_document

MODEL = "<sdf version='1.6'>\n<model name='m'>{}<link name='l'/></model></sdf>"


def warnings(text):
    file = SdfFile.from_string(text, "w.sdf")
    assert file.diagnostics.errors == []
    assert file.root.child("model").HasElement("link")
    return [str(warning) for warning in file.diagnostics.warnings]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("\n\n<?xml version='1.0'?>" + MODEL.format(""), "w.sdf:3: <xml>: the XML declaration stands after the start"),
        ("<?xml version='0.0'?>" + MODEL.format(""), "w.sdf:1: <xml>: Unsupported version '0.0'; it is read as 1.0"),
        (MODEL.format("<!-- a -- b -->"), "w.sdf:2: <xml>: '--' in a comment"),
        (MODEL.format("<!-- a --->"), "w.sdf:2: <xml>: '--' in a comment"),
        (MODEL.format("\n<plugin name='a&b' filename='x'/>"), "w.sdf:3: <xml>: '&' should be written &amp;"),
        (MODEL.format("\n<link name=l2>\n</link>"), "w.sdf:3: <xml>: the value of an attribute should stand in quotes"),
        (MODEL.format("<x:y/><x:z/>"), "w.sdf:2: <xml>: Namespace prefix x on y is not defined"),
        (MODEL.format("") + "<more/>", "w.sdf:2: <xml>: what follows the root element is ignored"),
        (MODEL.format("").encode() + b"<!-- \xe9 -->", "w.sdf:2: <xml>: there are bytes"),
        (MODEL.format("<pose>1 2</pose>"), "w.sdf:2: <pose>: '1 2' is read as '1 2 0 0 0 0'"),
        (MODEL.format("<pose>1 2 3 0 0 0 9</pose>"), "<pose>: '1 2 3 0 0 0 9' is read as '1 2 3 0 0 0'"),
    ],
)
def test_slips_are_warnings(text, said):
    found = warnings(text)
    assert len(found) == 1
    assert said in found[0]


def test_only_values_of_attributes_are_quoted():
    text = MODEL.format(
        "<plugin name=p filename='a=b'><t>c=d <u>e</u> f = g</t><!-- <v w=x> --><![CDATA[<y z=1>]]></plugin>"
    )
    plugin = next(SdfFile.from_string(text).root.find("plugin"))
    assert (plugin.Get(str, "name"), plugin.Get(str, "filename")) == ("p", "a=b")
    assert "c=d" in plugin.ToString()
    assert "y z=1" in plugin.ToString()
    for wrong in ("<link name=a'b'/>", "<link name=a/b/>", "<link name/>"):
        with pytest.raises(WorldFileError):
            SdfFile.from_string(MODEL.format(wrong))


@pytest.mark.parametrize("begin", ["", "\n", "x"])
@pytest.mark.parametrize(
    ("encoding", "hidden"),
    [("utf-7", "+AHA-lugin"), ("ISO-2022-JP", "pl\x1b(Bugin"), ("ISO-2022-KR", "pl\x0fugin"), ("HZ", "pl~{~}ugin")],
)
def test_a_text_is_read_as_it_stands_whatever_encoding_it_declares(begin, encoding, hidden):
    """Else who checked the text for plugins has checked another one."""
    for version in ("1.0", "1.0>"):
        text = f"{begin}<?xml version='{version}' encoding='{encoding}'?>" + MODEL.format(f"<{hidden} name='p'/>")
        try:
            file = SdfFile.from_string(text)
        except WorldFileError:
            continue
        assert list(file.root.find("plugin")) == []


def test_a_text_without_a_declaration_is_not_guessed_to_be_of_two_bytes_a_character():
    text = "".join(f"\0{letter}" for letter in "<?xml version='1.0'?>" + MODEL.format(""))
    with pytest.raises(WorldFileError):
        SdfFile.from_string(text)


def test_what_follows_the_end_of_a_text_of_c_is_ignored():
    file = SdfFile.from_string(MODEL.format("") + "\0\0rest")
    assert [one.message for one in file.diagnostics.found] == ["what follows the root element is ignored"]


def test_an_encoding_that_is_declared_late_is_used():
    text = "\n<?xml version='1.0' encoding='latin-1'?>" + MODEL.format("").replace("'m'", "'\xe9'")
    file = SdfFile.from_string(text.encode("latin-1"))
    assert file.root.child("model").Get(str, "name") == "\xe9"


@pytest.mark.parametrize(
    "text", ["<sdf version='1.6'><model name='m'></sdf>", "<sdf version='1.6/>", "<sdf version='1.6'><a>", "", "plain"]
)
def test_what_is_not_well_formed_is_an_error_with_its_line(text):
    with pytest.raises(WorldFileError, match=r"^w\.sdf:1: "):
        SdfFile.from_string(text, "w.sdf")


@pytest.mark.parametrize(
    ("kind", "text", "read"),
    [
        ("double", "1.5kg", "1.5"),
        ("int", "3.7", "3"),
        ("int", "1e400", ""),
        ("vector3", "1,2,3", "1 2 3"),
        ("vector3", "1 x 3", "1 0 0"),
        ("vector3", "1 1", "1 1 0"),
        ("vector3", "nan nan nan", "9 9 9"),
        ("vector3", "x", "9 9 9"),
        ("vector2d", "1 2 3", "1 2"),
        ("pose", "0 0 inf 0 0 0", "0 0 0 0 0 0"),
        ("double", "nan", "9 9 9"),
        ("double", "-NaN", "9 9 9"),
        ("double", "x", ""),
        ("int", "nan", ""),
        ("color", "1", "1 0 0"),
        ("color", "1 1 1 1 1", "1 1 1 1"),
        ("bool", "yes", "false"),
        ("double", "", ""),
    ],
)
def test_numbers_are_read_as_far_as_they_go(kind, text, read):
    default = "9" if kind == "double" else "9 9 9"
    assert repaired(kind, text, default) == (default if read == "9 9 9" else read)


def test_lists_that_are_too_short_are_warnings_with_their_line():
    (found,) = warnings(
        MODEL.format("<link name='k'>\n<pose>1 2 3 0 0 0</pose><inertial><pose>1 1</pose></inertial></link>")
    )
    assert found.endswith(
        "<pose>: '1 1' is read as '1 1 0 0 0 0'; it should be 6 finite numbers: x y z [m] roll pitch yaw [rad]"
    )


@pytest.mark.parametrize(
    ("inside", "key", "used"),
    [
        ("<pose>1e300 0 0 0 0 0</pose>", "pose", "1000000000.0 0.0 0.0 0.0 0.0 0.0"),
        ("<velocity_decay><linear>-1</linear></velocity_decay>", "velocity_decay/linear", "0.0"),
    ],
)
def test_numbers_that_no_world_can_use_are_replaced_with_a_warning(inside, key, used):
    file = SdfFile.from_string(MODEL.format(f"<link name='k'>{inside}</link>"))
    assert not file.diagnostics.errors
    assert "is out of range" in str(file.diagnostics.warnings[0])
    element = next(one for one in file.root.child("model").named("link") if one.Get(str, "name") == "k")
    for tag in key.split("/"):
        element = element.child(tag)
    assert element.Get(str) == used


def test_bounds_of_numbers_leave_the_texts_of_plugins_alone():
    inside = (
        "<plugin name='p' filename='p'><solver><iters>many</iters></solver><mimic><offset>1 2</offset></mimic></plugin>"
    )
    file = SdfFile.from_string(MODEL.format(inside))
    plugin = file.root.child("model").child("plugin")
    assert plugin.child("solver").Get(str, "iters") == "many"
    assert plugin.child("mimic").Get(str, "offset") == "1 2"


def test_elements_with_a_prefix_are_kept_without_a_warning():
    text = MODEL.format("<x:speed>3</x:speed>").replace("<sdf", "<sdf xmlns:x='u'")
    assert warnings(text) == []
    assert SdfFile.from_string(text).root.child("model").Get(float, "x:speed") == 3.0


def test_a_joint_is_left_out_whose_link_is_in_what_is_missing(caplog):
    text = (
        "<sdf version='1.6'><world name='w'><model name='m'><link name='l'/>\n<include><uri>model://lost</uri></include>"
        "<joint name='j' type='fixed'><parent>l</parent><child>lost::wing</child></joint></model></world></sdf>"
    )
    with libgz.World.from_string(text) as world:
        world.step(10)
        assert not world.model("m").sdf_joints
    assert "'lost::wing'; it may be in what was not found: the <include> at <string>:2 (model://lost)" in caplog.text


# The check finds what a run finds ------------------------------------------------------------------------------------

SENSOR = "<link name='k'><sensor name='s' type='{}'>{}</sensor></link>"


@pytest.mark.parametrize(
    ("inside", "said"),
    [
        (SENSOR.format("camera", "<camera><image><width>99999</width></image></camera>"), "<width>: is 99999"),
    ],
)
def test_the_check_reports_errors_of_building(tmp_path, inside, said):
    path = tmp_path / "w.sdf"
    path.write_text(MODEL.format(inside))
    assert any(
        said in str(error) and (error.file, error.line) == (str(path), 2)
        for error in check_sdf(path)
        if error.severity == "error"
    )


def test_the_check_runs_no_plugin_and_reports_those_that_are_missing(tmp_path):
    path, trace = tmp_path / "w.sdf", tmp_path / "trace"
    (tmp_path / "here.py").write_text(f"open({str(trace)!r}, 'w').close()\n")
    plugins = "<plugin name='a' filename='libhere.so'/><plugin name='b' filename='liblost.so'/>"
    camera = "<link name='k'><sensor name='c' type='camera'/></link>"
    path.write_text(MODEL.format(plugins + camera))
    done = run_libgz("sdf", "--check", path)
    assert (done.returncode, done.stdout) == (0, "Check complete\n")
    assert "warning : " in done.stderr
    assert "there is no plugin 'liblost.so' here" in done.stderr
    assert "libhere" not in done.stderr
    assert not trace.exists()


@pytest.mark.parametrize("slip", ["", "<!-- a -- b -->"])
def test_entities_of_the_document_are_text(slip):
    declared = "<!DOCTYPE sdf [<!ENTITY y '2'><!ENTITY at '1 &y;'>]>"
    text = declared + MODEL.format(f"<pose>0 <!-- x --> &at; &y; 0 0</pose><name>&lt;&y;</name>{slip}")
    file = SdfFile.from_string(text, "w.sdf")
    assert file.diagnostics.errors == []
    assert file.root.child("model").Get(str, "pose").split() == ["0", "1", "2", "2", "0", "0"]
    assert file.root.child("model").Get(str, "name") == "m"


@pytest.mark.parametrize(
    ("entity", "message"),
    [
        ("<!ENTITY e SYSTEM 'other.sdf'>", "w.sdf:2: <pose>: entity &e; is not text of this file"),
        ("<!ENTITY e '<b/>'>", "w.sdf:2: <pose>: entity &e; holds elements"),
        (f"<!ENTITY e '{'x' * 100_000}'>", "w.sdf:2: <pose>: entity &e; contains itself, or is longer than 100000"),
    ],
)
def test_other_entities_are_errors(entity, message):
    text = f"<!DOCTYPE sdf [{entity}]>" + MODEL.format("<pose>&e;</pose>")
    with pytest.raises(WorldFileError, match="entity") as found:
        libgz.World.from_string(text)
    assert message.removeprefix("w.sdf:") in str(found.value)


# What has no effect is a warning -------------------------------------------------------------------------------------


def test_misspelt_children_of_an_include_are_warnings():
    known = "<pose>0 0 1 0 0 0</pose><plugin name='p' filename='q'/>"
    inside = f"<include>\n<uri>model://sun</uri>\n<nam>x</nam>{known}</include>"
    file = SdfFile.from_string(f"<sdf version='1.6'><world name='w'>{inside}</world></sdf>", "w.sdf")
    (found,) = map(str, file.diagnostics.found)
    assert ":3: <nam>: is not part of SDF in <include> and has no effect; did you mean 'name'?" in found


def test_misspelt_children_of_an_include_without_a_model_are_reported_once():
    text = "<sdf version='1.6'><world name='w'><include><uri>model://nothing</uri><nam>x</nam></include></world></sdf>"
    found = list(map(str, SdfFile.from_string(text, "w.sdf").diagnostics.found))
    assert ["<nam>" in message for message in found] == [False, True], found


@pytest.mark.parametrize(("version", "in_model"), [("1.6", True), ("1.7", False), ("1.9", False)])
def test_axes_of_later_versions_are_in_the_frames_that_they_name(version, in_model):
    axis = "<axis><xyz>1 0 0</xyz>\n<use_parent_model_frame>1</use_parent_model_frame></axis>"
    text = MODEL.format(
        f"<link name='k'/><joint name='j' type='prismatic'><parent>l</parent><child>k</child>{axis}</joint>"
    ).replace("version='1.6'", f"version='{version}'")
    file = SdfFile.from_string(text, "w.sdf")
    found = [str(one) for one in file.diagnostics.warnings]
    axis = file.root.child("model").child("joint").child("axis")
    assert axis.Get(bool, "use_parent_model_frame") == in_model
    said = f"w.sdf:3: <use_parent_model_frame>: is not part of SDF {version} and has no effect; the attribute"
    assert any(one.startswith(said) for one in found) == (not in_model)


ENDLESS = {
    "comments": b"<sdf>" + b"<!--" * 1_000_000,
    "sections": b"<sdf>" + b"<![CDATA[" * 1_000_000,
    "declarations": b"<?xml " * 1_000_000 + b"<sdf>",
    "ampersands": b"<sdf version='1.6'>" + b"&a " * 1_000_000 + b"</sdf>",
    "entities": b"<!DOCTYPE sdf [<!ENTITY a ''>]><sdf version='1.6'>" + (b"&a;" + b"x" * 100) * 90_000 + b"</sdf>",
}


@pytest.mark.parametrize("name", ENDLESS)
def test_documents_of_repeated_beginnings_are_read_in_linear_time(name):
    """Each of these would take hours in quadratic time."""
    diagnostics = Diagnostics()
    try:
        parse_document(ENDLESS[name], "w.sdf", diagnostics)
    except WorldFileError as error:
        assert str(error).startswith("w.sdf:1: ")
        assert len(str(error).splitlines()) == 1
    else:
        assert name in ("ampersands", "entities")


def test_texts_around_entities_keep_their_order():
    data = b"<!DOCTYPE a [<!ENTITY e '1'><!ENTITY f '2'>]><a>x&e;y&f;z<b>p&e;&f;</b>q&f;r<!-- c -->s&e;<c/>&e;t</a>"
    root = parse_document(data, "w.sdf", Diagnostics())
    assert (root.text, root[0].text, root[0].tail) == ("x1y2z", "p12", "q2r")
    assert (root[1].tail, root[2].tail) == ("s1", "1t")


@pytest.mark.parametrize(
    "document", ["<sdf version='1.6'>\n<world name='w' {}/></sdf>", "<gz:world xmlns:gz='g'>\n<a b='' {}/></gz:world>"]
)
def test_an_element_has_a_bounded_number_of_attributes(document):
    words = [f"a{i}='1'" for i in range(1000)]
    libgz.World.from_string(document.format(" ".join(words[:-1]))).close()
    with pytest.raises(WorldFileError, match=r":2: <\w+>: it has 1001 attributes; at most 1000"):
        libgz.World.from_string(document.format(" ".join(words)))
