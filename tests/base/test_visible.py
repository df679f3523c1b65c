"""Texts from outside, as terminals and logs show them."""

import contextlib
import logging
import os

import pytest
from lxml import etree

from libgz import World
from libgz.apps.console import PREFIXES, _ConsoleFormatter
from libgz.apps.libgz import main
from libgz.base.errors import WorldFileError
from libgz.base.visible import one_line, visible
from libgz.classic import msgs
from libgz.classic.log import LogRecord


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain ä 日本", "plain ä 日本"),
        ("می\u200cرود, 👩\u200d🚀, 12\u00a0m, 日本\u3000語", "می\u200cرود, 👩\u200d🚀, 12\u00a0m, 日本\u3000語"),
        ("two\nlines\tand a tab", "two\nlines\tand a tab"),
        ("\x1b]0;title\x07\x9b2J\r\0\x7f", "\\x1b]0;title\\x07\\x9b2J\\r\\x00\\x7f"),
        ("a\x85b\u2028c", "a\\x85b\\u2028c"),
        ("turned \u202eround, broken \udcff", "turned \\u202eround, broken \\udcff"),
    ],
)
def test_control_characters_are_escaped(text, shown):
    assert visible(text) == shown
    assert one_line(text) == shown.replace("\n", "\\n")


@pytest.mark.parametrize("command", ["check", "sdf --check", "sdf --print", "xacro", "upgrade", "convert"])
def test_no_command_prints_control_characters_of_files(tmp_path, capsys, command):
    path = tmp_path / "a\x1b[2J.world"
    path.write_text("<sdf version='1.6'><world name='w'><gravity>\x9b2J</gravity><a\x85/></world></sdf>")
    main([*command.split(), str(path), *(["-o", str(tmp_path / "out")] if command == "convert" else [])])
    printed = "".join(capsys.readouterr())
    assert "a\\x1b[2J.world" in printed
    assert "\x1b" not in printed


@pytest.mark.parametrize("command", ["sdf --print", "xacro", "upgrade"])
def test_printed_documents_say_the_same_without_control_characters(tmp_path, capfd, command):
    path = tmp_path / "a.urdf"
    path.write_text("<robot name='a\x9b2J\u202e'><link name='l'/></robot>")
    assert main([*command.split(), str(path)]) == 0
    printed = capfd.readouterr().out
    assert "a&#155;2J&#8238;" in printed
    assert not any(letter in printed for letter in "\x9b\u202e")
    root = etree.fromstring(printed.encode())
    assert "a\x9b2J\u202e" in {element.get("name") for element in root.iter("*")}


def test_a_document_with_line_ends_of_windows_is_printed_as_a_document(tmp_path, capfd):
    path = tmp_path / "a.world"
    text = '<?xml version="1.0"?>\n<gz:world xmlns:gz="x">\n<model:Pioneer2AT xmlns:model="y"\nid="a"/>\n</gz:world>\n'
    path.write_text(text, newline="\r\n")
    assert main(["upgrade", str(path)]) == 0
    assert capfd.readouterr().out == text


def test_a_state_of_a_log_is_printed_without_control_characters(tmp_path, capsys):
    path = tmp_path / "state.log"
    text = "<sdf version='1.6'><model name='a\x9b2J'><link name='l'/></model></sdf>"
    with World.from_string(text) as world, LogRecord(world, path, encoding="txt"):
        world.step(2)
    assert main(["log", "-f", str(path), "-e"]) == 0
    printed = capsys.readouterr().out
    assert "a&#155;2J" in printed
    assert "\x9b" not in printed


FORGED = """<sdf version='1.6'><world name='w'>
<include><uri>model://no&#10;forged</uri></include><plugin name='p' filename='libno&#10;forged.so'/>
<model name='a&#10;forged'>
<link name='l'><sensor name='s' type='no&#10;forged'/>
<collision name='c'><geometry><mesh><uri>no&#10;forged.dae</uri></mesh></geometry></collision></link>
<joint name='j&#10;forged' type='fixed'><parent>no&#10;forged</parent><child>l</child></joint>
</model></world></sdf>"""
OLD_FORGED = """<gz:world xmlns:gz='g' xmlns:model='m'>
<model:Terrain><dataFile>no&#10;forged</dataFile></model:Terrain></gz:world>"""


@pytest.mark.parametrize(
    ("text", "command"),
    [(FORGED, "check"), (FORGED, "sdf --check"), (FORGED, "gazebo"), (OLD_FORGED, "check"), (OLD_FORGED, "gazebo")],
)
def test_no_name_in_a_file_looks_like_a_message(tmp_path, capsys, caplog, text, command):
    path = tmp_path / "a.world"
    path.write_text(text)
    if command == "gazebo":
        with contextlib.suppress(WorldFileError), World.from_file(path):
            pass
    else:
        main([*command.split(), str(path)])
    printed = "".join(capsys.readouterr()) + caplog.text
    assert "\\nforged" in printed
    assert "\nforged" not in printed


def test_no_command_prints_control_characters_of_logs(tmp_path, capsys):
    path = tmp_path / "state.log"
    header = "<log_version>1.0\x9b2J</log_version><gazebo_version>\x9b2J</gazebo_version><rand_seed>1</rand_seed>"
    path.write_text(f"<gazebo_log><header>{header}</header></gazebo_log>")
    assert main(["log", "-f", str(path)]) == 0
    assert "Gazebo Version: \\x9b2J" in (printed := capsys.readouterr().out)
    assert "\x9b" not in printed


def test_commands_print_no_control_characters():
    record = logging.LogRecord("libgz", logging.ERROR, "x.py", 1, "%s: wrong", ("a\x1b[2J.world",), None)
    assert _ConsoleFormatter("%(message)s").format(record) == f"{PREFIXES[logging.ERROR]}a\\x1b[2J.world: wrong"


@pytest.mark.parametrize("name", ["a\x1b[2J", os.fsdecode(b"a\xff"), "a\x9b2J"])
def test_no_command_prints_control_characters_of_names(tmp_path, capsys, name):
    world, source = tmp_path / f"{name}.world", tmp_path / f"{name}.cc"
    world.write_text(
        "<sdf version='1.6'><world name='w'><model name='m\x9b2J'><link name='l'><sensor name='c' type='camera'/>"
        "</link></model></world></sdf>"
    )
    source.write_text("#error a\x1b[2J\x9b2J\n")
    for words in (
        ("picture", "--time", "0.1", world, "-o", tmp_path / f"{name}.png"),
        ("cxx", "check", source),
        ("new", "model", "Name", "--in", tmp_path / name),
        ("config", "--uninstall", "--install-classic", tmp_path / name),
    ):
        main([*map(str, words)])
        printed = "".join(capsys.readouterr())
        assert visible(printed) == printed
        assert printed, words


def test_no_refusal_of_arguments_prints_control_characters(capsys):
    """A shell makes arguments of the names of files."""
    with pytest.raises(SystemExit):
        main(["debug", "a\x1b[2J\x9b2J\u202e"])
    assert "a\\x1b[2J\\x9b2J\\u202e" in capsys.readouterr().err


def test_no_part_of_a_name_looks_like_a_message_of_its_own(tmp_path, capsys):
    path = tmp_path / "a.urdf"
    path.write_text("<robot name='r'><link name='l&#10;forged.world:1: &lt;a&gt;: wrong'/><link name='b'/></robot>")
    main(["check", str(path)])
    printed = "".join(capsys.readouterr())
    assert "links l\\nforged.world:1: <a>: wrong, b have no parent" in printed
    assert "\nforged" not in printed


def test_no_message_is_printed_with_control_characters():
    message = msgs.Model(name="a\x1b[2J\x9b2J\u202e é\n")
    assert message.DebugString() == 'name: "a\\033[2J\\302\\2332J\\342\\200\\256 é\\n"\n'
    again = msgs.Model()
    msgs.Parse(again, message.DebugString())
    assert again == message
