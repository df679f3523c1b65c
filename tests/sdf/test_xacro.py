"""Robot descriptions with macros: what they expand to, what is wrong in them, and what they must not do."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st
from lxml import etree

from libgz.base.errors import Diagnostics, WorldFileError
from libgz.sdf.conversion import upgrade_document
from libgz.sdf.reader import SdfFile
from libgz.sdf.xacro import limits
from libgz.sdf.xacro.expansion import expand
from libgz.sdf.xacro.expressions import Evaluator
from libgz.sdf.xacro.functions import BUILTINS
from libgz.sdf.xacro.limits import Budget, ExpansionError, LimitError
from libgz.sdf.xml import PLACE, parse_document, place_of

HEAD = "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>"
MASS = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
MARK = "ran"  # a file that no attack may make


def document(body, head=HEAD):
    return f"{head}{body}</robot>"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder without packages around, and no search paths."""
    for name in ("GAZEBO_MODEL_PATH", "GAZEBO_RESOURCE_PATH", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    place = tmp_path / "robot"
    place.mkdir()
    return place


def expanded(body, folder=None, **options):
    """The expanded content of a robot as text, and the warnings."""
    diagnostics = Diagnostics()
    path = None if folder is None else folder / "robot.xacro"
    label = "robot.xacro"
    root = expand(parse_document(document(body).encode(), label, diagnostics), label, diagnostics, path=path, **options)
    for element in root.iter(etree.Element):
        element.attrib.pop(PLACE, "")
    etree.cleanup_namespaces(root)
    text = etree.tostring(root, encoding="unicode")
    return text.removeprefix('<robot name="r">').removesuffix("</robot>"), [str(one) for one in diagnostics.warnings]


def result(body, folder=None, **options):
    return expanded(body, folder, **options)[0]


def refused(body, folder, **options):
    with pytest.raises(WorldFileError) as caught:
        expanded(body, folder, **options)
    return str(caught.value)


def prop(name, value, more=""):
    return f'<xacro:property name="{name}" value="{value}" {more}/>'


def value(expression, *properties):
    """The text of an expression."""
    before = "".join(prop(name, given) for name, given in properties)
    return etree.fromstring(result(f'{before}<a v="${{{expression}}}"/>')).get("v")


# Expressions -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        ("1 + 2", "3"),
        ("1/2", "0.5"),
        ("7//2", "3"),
        ("7 % 4", "3"),
        ("2**10", "1024"),
        ("-2**0.5", "-1.4142135623730951"),
        ("1 &lt;&lt; 4 | 3", "19"),
        ("0.1 + 0.2", "0.30000000000000004"),
        ("1e20", "1e+20"),
        ("True", "True"),
        ("None", "None"),
        ("not 1 or 2", "2"),
        ("1 &lt; 2 &lt;= 2 != 3", "True"),
        ("1 if 0 else 2", "2"),
        ("[1, 'a', (2,)]", "[1, 'a', (2,)]"),
        ("[1, 2, 3][1:]", "[2, 3]"),
        ("'abc'[-1]", "c"),
        ("radians(180)", "3.141592653589793"),
        ("degrees(pi)", "180.0"),
        ("math.sin(pi/2) + sqrt(4)", "3.0"),
        ("[x**2 for x in range(4) if x]", "[1, 4, 9]"),
        ("python.sorted([3, 1, 2], key=lambda x: -x)", "[3, 2, 1]"),
        ("(lambda a, b=2: a + b)(1)", "3"),
        ("max([1, 3], key=lambda x: -x) + min(4, 5)", "5"),
        ("python.sum([1, 2, 3]) + len('abc')", "9"),
        ("dict(a=1, b=2).b", "2"),
        ("dict(a=1).get('z', 5)", "5"),
        ("list(map(str, [1, 2]))", "['1', '2']"),
        ("'%.2f of %s' % (1.5, 'x')", "1.50 of x"),
        ("' '.join(['a', 'b']).upper()", "A B"),
        ("'a,b'.split(',')", "['a', 'b']"),
        ("round(2.567, 2)", "2.57"),
        ("int('7') + float('0.5')", "7.5"),
        ("python.isinstance(1.0, (int, float))", "True"),
        ("python.type('') == str", "True"),
        ("xacro.tokenize('a, b;c')", "['a', 'b', 'c']"),
        ("xacro.tokenize('a b', '')", "['a b']"),
        ("xacro.tokenize('a[b', '[[')", "['a', 'b']"),
        ("'a' in 'abc' and 2 in [1, 2]", "True"),
        ("[y for x, y in python.zip([1], [2])]", "[2]"),
        ("python.list(python.set(['b', 'a']))", "['a', 'b']"),
    ],
)
def test_values(expression, text):
    assert value(expression) == text


def test_properties_are_numbers_texts_and_truths():
    assert value("a + 1", ("a", "2")) == "3"
    assert value("a + 1", ("a", "2.0")) == "3.0"
    assert value("a + '1'", ("a", "'x'")) == "x1"
    assert value("a + '1'", ("a", "1_0")) == "1_01"
    assert value("not a", ("a", "true")) == "False"
    assert value("b", ("a", "2"), ("b", "${a * 2}")) == "4"
    assert value("fmt.format(1, x=2.0)", ("fmt", "{}{x:.2f}")) == "12.00"


def test_texts_around_expressions():
    body = prop("x", "2") + "<a v='a${x}b${x + 1}' w='$${x} $$(arg y) $ 5$'>t${x}<b/>u${x}</a>"
    assert result(body) == '<a v="a2b3" w="${x} $(arg y) $ 5$">t2<b/>u2</a>'


# Properties ------------------------------------------------------------------------------------------------------


def test_lazy_and_eager_properties():
    assert result(prop("a", "${b}") + prop("b", "1") + "<l v='${a}'/>") == '<l v="1"/>'
    body = prop("b", "1") + prop("a", "${b}", "lazy_eval='false'") + prop("b", "2") + "<l v='${a}'/>"
    assert result(body) == '<l v="1"/>'


def test_defaults_and_removal_of_properties(folder):
    default = "<xacro:property name='a' default='{}'/>"
    assert result(default.format(1) + default.format(2) + "<l v='${a}'/>") == '<l v="1"/>'
    remove = prop("a", "1") + "<xacro:property name='a' remove='true'/><l v='${a}'/>"
    assert "name 'a' is not defined" in refused(remove, folder)


def test_blocks_as_properties():
    body = prop("x", "1") + "<xacro:property name='b'><i v='${x}'/><j/></xacro:property>" + prop("x", "2")
    assert result(body + "<l><xacro:insert_block name='b'/></l>") == '<l><i v="2"/><j/></l>'


def test_scopes():
    macro = (
        "<xacro:macro name='m'>" + prop("a", "1") + prop("b", "2", "scope='parent'") + prop("c", "3", "scope='global'")
    )
    outer = "<xacro:macro name='n'><xacro:m/><l b='${b}'/></xacro:macro>"
    text = result(prop("a", "0") + macro + "</xacro:macro>" + outer + "<xacro:n/><l a='${a}' c='${c}'/>")
    assert text == '<l b="2"/><l a="0" c="3"/>'
    assert "name 'b' is not defined" in refused(macro + "</xacro:macro>" + outer + "<xacro:n/><l b='${b}'/>", Path())


# Macros ----------------------------------------------------------------------------------------------------------


def test_parameters():
    macro = "<xacro:macro name='m' params=\"a b:=1 c='x y' d:=^|4 e:=${a} *f **g\"><l v='${a} ${b} ${c} ${d} ${e}'>"
    macro += "<xacro:insert_block name='f'/><xacro:insert_block name='g'/></l></xacro:macro>"
    call = "<xacro:m a='7'{}><p v='${{a}}'/><q><r/><s/></q></xacro:m>"
    text = result(prop("a", "5") + macro + call.format("") + prop("d", "6") + call.format(" c='z'"))
    assert text == '<l v="7 1 x y 4 5"><p v="5"/><r/><s/></l><l v="7 1 z 6 5"><p v="5"/><r/><s/></l>'


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ("<xacro:m/>", "needs the parameters a"),
        ("<xacro:m a='1' bb='2'><p/></xacro:m>", "has no parameter 'bb'"),
        ("<xacro:m a='1'/>", "needs an element for its parameter '*b'"),
        ("<xacro:m a='1'><p/><q/></xacro:m>", "has no parameter for the element <q>"),
        ("<xacro:mm a='1'><p/></xacro:mm>", "there is no macro 'mm'; did you mean 'm'?"),
        ("<xacro:call a='1'/>", "attribute 'macro' is missing"),
    ],
)
def test_wrong_calls(call, message, folder):
    if "needs the parameters" in message:
        call = call.replace("/>", "><p/></xacro:m>")
    text = refused(f"<xacro:macro name='m' params='a *b'/>\n{call}", folder)
    assert text.startswith("robot.xacro:2: <xacro:")
    assert message in text


def test_macros_by_name_and_recursive_ones():
    loop = "<xacro:macro name='m' params='n'><xacro:if value='${n}'><l v='${n}'/><xacro:m n='${n - 1}'/></xacro:if>"
    text = result(loop + "</xacro:macro><xacro:call macro='m' n='${1 + 2}'/>")
    assert text == '<l v="3"/><l v="2"/><l v="1"/>'
    assert result(loop + "</xacro:macro><xacro:m n='300'/>").count("<l") == 300


def test_conditions_and_made_elements():
    body = "<xacro:unless value='0'><a/></xacro:unless><xacro:if value='${1 == 2}'><b/></xacro:if>"
    assert result(body) == "<a/>"
    body = "<xacro:element xacro:name='${&quot;x&quot;}' k='1'><xacro:attribute name='w' value='${2}'/></xacro:element>"
    assert result(body) == '<x k="1" w="2"/>'


# Files -----------------------------------------------------------------------------------------------------------


def test_includes(folder):
    (folder / "parts").mkdir()
    (folder / "parts" / "a.xacro").write_text(document("<xacro:include filename='b.xacro'/>" + prop("x", "1")))
    (folder / "parts" / "b.xacro").write_text(document("<xacro:macro name='m'>\n<l v='${x}'/></xacro:macro>"))
    body = "<xacro:include filename='parts/a.xacro'/><xacro:m/>"
    assert result(body, folder).strip() == '<l v="1"/>'
    assert result("<xacro:include filename='parts/*.xacro'/><xacro:m/>", folder).strip() == '<l v="1"/>'
    spaced = "<xacro:include filename='parts/a.xacro' ns='p'/><xacro:p.m/><k v='${p.x}'/>"
    assert result(spaced, folder).strip() == '<l v="1"/><k v="1"/>'
    assert result("<xacro:include filename='no.xacro' optional='true'/><l/>", folder) == "<l/>"
    assert "no.xacro does not exist" in refused("<xacro:include filename='no.xacro'/>", folder)
    assert "no file is named 'no*'" in expanded("<xacro:include filename='no*'/>", folder)[1][0]


def test_elements_have_the_places_of_their_sources(folder):
    (folder / "b.xacro").write_text(document("\n<xacro:macro name='m'>\n<l v='${y}'/>\n</xacro:macro>"))
    body = "\n<xacro:include filename='b.xacro'/>" + prop("y", "1") + "<k>\n<xacro:m/></k>"
    text = document(body)
    root = expand(parse_document(text.encode(), "r", Diagnostics()), "r", Diagnostics(), path=folder / "r.xacro")
    places = [(place_of(one, "r").file, place_of(one, "r").line, one.tag) for one in root.iter("k", "l")]
    assert places == [("r", 2, "k"), (str(folder / "b.xacro"), 3, "l")]
    error = refused("\n<xacro:include filename='b.xacro'/>\n<xacro:m/>", folder)
    assert error.startswith(f"{folder / 'b.xacro'}:3: <l>: name 'y' is not defined, in the expression 'y'")
    assert error.endswith("; in <xacro:m> at robot.xacro:3")


def test_lines_beyond_65535_are_read():
    file = SdfFile.from_string("<robot name='r'>" + "\n" * 70000 + f"<link name='a'>{MASS}<visual/></link></robot>")
    assert [one.line for one in file.diagnostics.warnings] == [65535]  # libxml2 knows no later one of an empty element
    assert file.root.child("model").child("link").line >= 65535


def test_arguments_and_substitutions(folder, monkeypatch):
    monkeypatch.setenv("SIDE", "left")
    arg = "<xacro:arg name='n' default='${1 + 1}'/>"
    assert result(arg + "<l v='$(arg n)' w='${xacro.arg(&quot;n&quot;)}'/>") == '<l v="2" w="2"/>'
    assert result(arg + "<l v='$(arg n)'/>", arguments={"n": "5"}) == '<l v="5"/>'
    assert result(arg + "<l v='$(eval n + 1)'/>") == '<l v="3"/>'
    assert result("<l v='$(env SIDE) $(optenv NONE a b)'/>") == '<l v="left a b"/>'
    assert result("<l v='$(optenv SIDE none)'/>", environment={}) == '<l v="none"/>'
    assert "'SIDE' is not set" in refused("<l v='$(env SIDE)'/>", folder, environment={})
    assert result("<l v='$(dirname)'/>", folder) == f'<l v="{folder}"/>'
    assert "there is no argument 'm'" in refused("<l v='$(arg m)'/>", folder)
    assert "unknown substitution $(rm -r)" in refused("<l v='$(rm -r)'/>", folder)


def test_packages(folder, monkeypatch):
    package = folder.parent / "elsewhere" / "parts"
    package.mkdir(parents=True)
    (package / "p.xacro").write_text(document("<l/>"))
    include = "<xacro:include filename='$(find parts)/p.xacro'/>"
    assert "Unable to find uri[package://parts]" in refused(include, folder)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(package.parent))
    assert result(include, folder) == result(include) == "<l/>"
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    (folder.parent / "package.xml").write_text("<package><name>own</name></package>")
    (folder.parent / "q.xacro").write_text(document("<q/>"))
    assert result("<xacro:include filename='$(find own)/q.xacro'/>", folder) == "<q/>"
    assert result("<xacro:include filename='../q.xacro'/>", folder) == "<q/>"


def test_yaml(folder):
    text = "a: {b: [1, 2.5, x], c: !degrees 90 + 90}\nd: &d {e: true}\nf: {<<: *d, g: ~}\n"
    (folder / "c.yaml").write_text(text)
    load = "${xacro.load_yaml('c.yaml')}"
    body = prop("c", load) + "<l v='${c.a.b}' w='${c[\"a\"].c}' x='${c.f.e}' y='${c.f}'/>"
    assert (
        result(body, folder) == '<l v="[1, 2.5, \'x\']" w="3.141592653589793" x="True" y="{\'e\': True, \'g\': None}"/>'
    )
    (folder / "bad.yaml").write_text("a: 1\nb: [")
    message = refused("<l v=\"${xacro.load_yaml('bad.yaml')}\"/>", folder)
    assert message.startswith(f"robot.xacro:1: <l>: {folder / 'bad.yaml'}: line 2: ")


def test_messages_of_a_description(folder):
    _, warnings = expanded("<l v=\"${xacro.warning('old', 2)}\"/>", folder)
    assert warnings == ["robot.xacro:1: <l>: old 2"]
    assert "robot.xacro:1: <l>: broken" in refused("<l v=\"${xacro.fatal('broken')}\"/>", folder)


# Documents -------------------------------------------------------------------------------------------------------


def test_texts_and_files_that_are_not_named_so_are_never_refused_for_a_tag():
    text = document("<link name='a'/><xacro:unknown/><gazebo reference='a'><mu1>${no}</mu1></gazebo>")
    file = SdfFile.from_string(text.replace("<mu1>${no}</mu1>", ""))
    assert not file.diagnostics.errors
    assert any("there is no macro 'unknown'; the element is left out" in str(one) for one in file.diagnostics.warnings)
    loaded = SdfFile.from_string(document("<xacro:include filename='no.xacro'/><link name='a'/>"))
    assert not loaded.diagnostics.errors


def test_sdf_with_macros(folder):
    (folder / "m.sdf.xacro").write_text(
        "<sdf version='1.6' xmlns:xacro='x'><xacro:arg name='n' default='a'/><model name='$(arg n)'>"
        "<link name='${1 + 1}'/></model></sdf>"
    )
    file = SdfFile.load(folder / "m.sdf.xacro", arguments={"n": "b"})
    assert not file.diagnostics.errors
    model = file.root.child("model")
    assert (model.Get(str, "name"), model.child("link").Get(str, "name")) == ("b", "2")


def test_upgraded_robots_have_no_traces_of_places(folder):
    (folder / "r.xacro").write_text(document(f"<link name='${{1}}'>{MASS}</link>"))
    text, _ = upgrade_document((folder / "r.xacro").read_bytes(), "r", folder / "r.xacro")
    assert b"libgz" not in text
    assert b'<link name="1"' in text


def test_an_included_robot_has_the_environment_of_its_world(folder, monkeypatch):
    monkeypatch.setenv("SIDE", "left")
    (folder / "r.xacro").write_text(document(f"<link name='$(optenv SIDE none)'>{MASS}</link>"))
    (folder / "w.world").write_text(
        "<sdf version='1.6'><world name='w'><include><uri>r.xacro</uri></include></world></sdf>"
    )
    for environment, name in ((None, "left"), ({}, "none")):
        file = SdfFile.load(folder / "w.world", environment=environment)
        assert file.root.child("world").child("model").child("link").Get(str, "name") == name


# Attacks ---------------------------------------------------------------------------------------------------------

REACHING = [
    "__import__('os').system('touch ran')",
    "open('ran', 'w')",
    "eval('1')",
    "exec('1')",
    "getattr(1, 'real')",
    "globals()",
    "python.vars()",
    "().__class__.__base__.__subclasses__()",
    "(lambda: 0).__globals__",
    "(lambda: open('ran', 'w'))()",
    "[open('ran', 'w') for x in [1]]",
    "sin.__self__",
    "math.__loader__.load_module('os')",
    "python.__builtins__",
    "python.type(1).mro()",
    "str.format('{0.__class__}', 1)",
    "'%s'.format.__self__",
    "xacro.load_yaml.__globals__",
    "(x for x in [1]).gi_frame",
    "[].__reduce__()",
    "f'{1}'",
    "(x := 1)",
    "'a'.encode()",
    "b'a'",
    "[x.y for x.y in [1]]",
]
GROWING = [
    "10**10**10",
    "10**9999999",
    "1 &lt;&lt; 10**9",
    "'a' * 10**9",
    "[0] * 10**9",
    "'%999999999d' % 1",
    "'%.999999999f' % 1",
    "'%((x))999999999d' % dict(x=1)",
    "'a'.ljust(10**9)",
    "'a'.zfill(10**9)",
    "'\\t'.expandtabs(10**9)",
    "('a' * 10000).replace('a', 'b' * 10000)",
    "('a' * 1000).join(['b' * 1000] * 1000)",
    "range(10**12)",
    "[0 for a in range(99999) for b in range(99999) for c in range(99999)]",
    "factorial(10**7)",
    "math.comb(10**7, 10**6)",
    "math.prod([10**300] * 9)",
    "round(5, -10**9)",
    "int('f' * 9999, 16)",
    "(lambda f: f(f))(lambda f: f(f))",
    "(lambda f: f(f))(lambda f: [f(f), f(f)])",
    "(" * 300 + "1" + ")" * 300,
    "-" * 50000 + "1",
    "1+" * 40000 + "1",
    "1 if 1 else " * 8000 + "1",
    "not " * 20000 + "1",
    "('a' * 100000).rfind('ab' + 'a' * 50000)",  # each of these takes minutes if its bound is lost, or seconds
    "('a' * 100000).strip('b' * 50000 + 'a')",
    "('a' * 100000).replace('a' * 50000 + 'b', '')",
    "'a' * 50000 + 'b' in 'a' * 100000",
    "('%' + '0' * 300000) % 1",
    "[float(text) for text in ['1' * 300000] * 100]",
    "[text.format() for text in ['1' * 300000] * 100]",
    "{i * (2**61 - 1): 0 for i in range(1000)}",
    "{(a, b, c, d, e, f, g) for a in x for b in x for c in x for d in x for e in x for f in x for g in x}".replace(
        "x", "[-1, -2]"
    ),
    "python.set().union([i * (2**61 - 1) for i in range(1000)])",
    "{i - i / 1000003 * 1j for i in range(0, 1000003 * 1000, 1000003)}",
]


@pytest.mark.parametrize("expression", REACHING)
def test_expressions_reach_nothing(expression, folder, monkeypatch):
    monkeypatch.chdir(folder)
    message = refused(f'\n<l v="${{{expression}}}"/>'.replace("{1}'", "(1)'"), folder)
    assert message.startswith("robot.xacro:2: <l>: ")
    assert not (folder / MARK).exists()
    evaluator = Evaluator(Budget())
    with pytest.raises(ExpansionError):
        evaluator.evaluate(expression, BUILTINS)
    assert not (folder / MARK).exists()


@pytest.mark.parametrize("expression", GROWING, ids=lambda text: text[:30])
def test_expressions_do_not_grow(expression, folder, monkeypatch):
    monkeypatch.setattr(limits, "MOST_WORK", 50_000)
    message = refused(f'\n<l v="${{{expression}}}"/>', folder)
    assert message.startswith("robot.xacro:2: <l>: ")
    with pytest.raises((LimitError, ExpansionError)):
        Evaluator(Budget()).evaluate(expression.replace("&lt;", "<"), BUILTINS)


def test_arguments_may_have_any_name():
    assert Evaluator(Budget()).evaluate("'{on} {text}'.format(on=1, text=2)", BUILTINS) == "1 2"
    assert Evaluator(Budget()).evaluate("dict(on=1, function=2)", BUILTINS) == {"on": 1, "function": 2}


def test_keys_of_a_grid_are_few_of_one_hash():
    grid = "len({(x, y, z, -x) for x in range(-5, 5) for y in range(-5, 5) for z in range(-5, 5)})"
    assert Evaluator(Budget()).evaluate(grid, BUILTINS) == 1000


def doubling(pattern, first="x", count=60):
    steps = [prop(f"a{i}", pattern.format(i - 1) if i else first) for i in range(count)]
    return "".join(steps)


TREES = {
    "lists": doubling("${{[a{0}, a{0}]}}") + "<l v='${a59}'/>",
    "texts": doubling("${{a{0}}}${{a{0}}}") + "<l v='${a59}'/>",
    "equal lists": doubling("${{[a{0}, a{0}]}}") + "<l v='${a59 == [a58, a58]}'/>",
    "dictionaries": doubling("${{dict(a=a{0}, b=a{0})}}") + "<l v='${a59}'/>",
    "list in itself": prop("t", "${[]}") + "<l v='${t.append(t)}'/><l v='${t}'/>",
    "tuples": prop("t", "${()}") + prop("t", "${(t,)}", "lazy_eval='false'") * 9999 + "<l v='${python.set([t])}'/>",
    "macro in itself": "<xacro:macro name='m'><xacro:m/><xacro:m/></xacro:macro><xacro:m/>",
    "nested elements": "<xacro:macro name='m'><a><xacro:m/></a></xacro:macro><xacro:m/>",
    "macros": "".join(
        f"<xacro:macro name='m{i}'>{f'<xacro:m{i - 1}/>' * 10 if i else '<a/>'}</xacro:macro>" for i in range(12)
    )
    + "<xacro:m11/>",
    "block in itself": "<xacro:property name='b'><xacro:insert_block name='b'/></xacro:property>"
    "<xacro:insert_block name='b'/>",
    "blocks": "<xacro:macro name='m' params='*b'><xacro:m><a><xacro:insert_block name='b'/>"
    "<xacro:insert_block name='b'/></a></xacro:m></xacro:macro><xacro:m><q/></xacro:m>",
    "circular properties": prop("a", "${b}") + prop("b", "${a}") + "<l v='${a}'/>",
    "long chain": "".join(prop(f"a{i}", f"${{a{i + 1}}}") for i in range(3000)) + "<l v='${a0}'/>",
    "texts of macros": f"<xacro:macro name='m'>{'x' * 100000}</xacro:macro>" + "<xacro:m/>" * 500,
    "attributes": f"<xacro:macro name='m'><a {' '.join(f'a{i}=1' for i in range(2000))}/></xacro:macro><xacro:m/>",
    "parameters": "<xacro:macro name='m' params='" + "a=$( " * 20_000 + "'/>",
    "element of xacro": "<xacro:element xacro:name='xacro:element'/>",
}


@pytest.mark.parametrize("name", TREES)
def test_documents_do_not_grow(name, folder, monkeypatch):
    monkeypatch.setattr(limits, "MOST_ELEMENTS", 5000)
    monkeypatch.setattr(limits, "MOST_WORK", 200_000)
    message = refused(TREES[name].replace("=1", "='1'") if name == "attributes" else TREES[name], folder)
    assert message.startswith("robot.xacro:1: <")
    assert len(message) < 1000


def test_files_that_are_not_read(folder, monkeypatch):
    secret = folder.parent / "secret.yaml"
    secret.write_text("password: 1")
    (folder / "link.yaml").symlink_to(secret)
    (folder / "up").symlink_to(folder.parent)
    os.mkfifo(folder / "pipe.yaml")
    names = ["../secret.yaml", str(secret), "link.yaml", "up/secret.yaml", "/etc/hostname", "/dev/zero", "pipe.yaml"]
    names += [
        "/proc/self/environ",
        "/*",
        "/**/*",
        "up/*",
        "~/x",
        f"$(find {folder.parent.name})/secret.yaml",
        "x" * 5000,
    ]
    for name in names:
        for body in (f"<xacro:include filename='{name}'/>", f"<l v='${{xacro.load_yaml(\"{name}\")}}'/>"):
            message = refused(body, folder)
            assert message.startswith("robot.xacro:1: <"), name
            assert "password" not in message
    assert "is outside of" in refused("<xacro:include filename='../secret.yaml'/>", folder)
    assert "is no plain file" in refused("<xacro:include filename='pipe.yaml'/>", folder)
    assert "is relative" in refused_text("<xacro:include filename='x.xacro'/>")


def refused_text(body):
    _, warnings = expanded(body)
    return warnings[0]


def test_links_of_search_paths_lead_into_packages_only(folder, monkeypatch):
    source, share = folder.parent / "src" / "parts", folder.parent / "share" / "parts"
    source.mkdir(parents=True)
    share.mkdir(parents=True)
    (source / "p.xacro").write_text(document("<l/>"))
    (share / "p.xacro").symlink_to(source / "p.xacro")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(share.parent))
    include = "<xacro:include filename='$(find parts)/p.xacro'/>"
    assert "is outside of" in refused(include, folder)
    (source / "package.xml").write_text("<package><name>parts</name></package>")
    assert result(include, folder) == "<l/>"


def test_includes_in_themselves_end(folder):
    (folder / "a.xacro").write_text(document("<xacro:include filename='a.xacro'/>"))
    assert "include each other more than 100 deep" in refused("<xacro:include filename='a.xacro'/>", folder)


YAML = {
    "aliases": "a0: &a0 x\n" + "".join(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 60)),
    "merges": "a0: &a0 {x: 1}\n"
    + "".join(f"a{i}: &a{i} {{<<: [{', '.join([f'*a{i - 1}'] * 10)}], k{i}: 1}}\n" for i in range(1, 40)),
    "deep": "[" * 5000,
    "in itself": "&a [*a]",
    "integer": "a: 0x" + "f" * 100000,
    "base 60": "a: " + ":".join(["59"] * 5000),
    "code": "!!python/object/apply:os.system ['touch ran']",
    "unit": "a: !degrees __import__('os').system('touch ran')",
    "tag": "a: !foo 1",
    "key": "? [1]\n: 2",
    "size": "[" + "1, " * 400000 + "]",
}


@pytest.mark.parametrize("name", YAML)
def test_yaml_that_is_refused(name, folder, monkeypatch):
    monkeypatch.chdir(folder)
    (folder / "d.yaml").write_text(YAML[name])
    body = prop("d", "${xacro.load_yaml('d.yaml')}") + "<l v='${d}'/>"
    if name == "merges":  # each key once, however often it is merged
        assert result(body, folder).count("x") > 1
    else:
        assert refused(body, folder).startswith("robot.xacro:1: <l>: ")
    assert not (folder / MARK).exists()


ATOMS = st.sampled_from(
    [
        "1",
        "2.5",
        "'a'",
        "x",
        "[]",
        "()",
        "None",
        "math",
        "python",
        "xacro",
        "sin",
        "str",
        "len",
        "lambda: x",
        "''",
        "{}",
    ]
)
NAMES = st.sampled_from(
    ["__class__", "__globals__", "__self__", "mro", "format", "join", "items", "append", "real", "pi", "type", "map"]
)


def combined(inner):
    return st.one_of(
        st.builds("({}).{}".format, inner, NAMES),
        st.builds("({})({})".format, inner, inner),
        st.builds("({})[{}]".format, inner, inner),
        st.builds("({}) {} ({})".format, inner, st.sampled_from(["+", "*", "**", "%", "<<", "==", "in", "and"]), inner),
        st.builds("[{} for x in ({})]".format, inner, inner),
        st.builds("(lambda x: {})({})".format, inner, inner),
        st.builds("{} if {} else {}".format, inner, inner, inner),
    )


@settings(max_examples=300, deadline=None)
@given(st.recursive(ATOMS, combined, max_leaves=12))
def test_random_expressions_end_with_a_value_or_an_error(expression):
    evaluator = Evaluator(Budget())
    try:
        made = evaluator.evaluate(expression, {**BUILTINS, "x": 3})
    except ExpansionError as error:
        assert str(error)
    else:
        kinds = (bool, int, float, complex, str, list, tuple, dict, set, frozenset, range, type(None))
        assert isinstance(made, kinds) or type(made).__module__.startswith("libgz.sdf.xacro.")
