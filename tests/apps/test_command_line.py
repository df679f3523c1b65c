"""What is made from the commands' parsers: shell completion, man pages, the table of exit codes; and `libgz worlds`."""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from commands import run_command, run_libgz
from master_uri import free_master_uri

from libgz.apps.command_line import EXIT_CODES, command_parsers
from libgz.apps.completion import SHELLS, script
from libgz.apps.libgz import main as libgz_main
from libgz.base.files import installed_worlds

ROOT = Path(__file__).parents[2]
BASH = """
source "$1"; shift
command=$1
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=()
function=$(complete -p "$command" | sed 's/.*-F \\([^ ]*\\).*/\\1/')
"$function" "$command" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
echo "${COMPREPLY[@]}"
"""
CASES = [
    (("gazebo", "pio"), {"pioneer2at", "pioneer2dx", "pioneer2sonars"}),
    (("gazebo", "--so"), {"--solver"}),
    (("gazebo", "--solver", ""), {"world", "quick", "tree"}),
    (("gzserver", "emp"), {"empty"}),
    (("gzclient", "--pic"), {"--picture"}),
    (("libgz", "wor"), {"world", "worlds"}),
    (("libgz", "check", "roo"), {"roomba", "room.world"}),
    (("libgz", "models", "Sick"), {"SickLMS200"}),
    (("libgz", "completion", "f"), {"fish"}),
]


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scripts")
    for shell in SHELLS:
        (folder / shell).write_text(script(shell))
    return folder


@pytest.mark.parametrize(("words", "expected"), CASES, ids=lambda case: "-".join(case) if type(case) is tuple else "")
def test_bash_completes(scripts, tmp_path, words, expected):
    (tmp_path / "room.world").touch()
    done = subprocess.run(
        ["bash", "-c", BASH, "bash", scripts / "bash", *words], cwd=tmp_path, capture_output=True, text=True, timeout=30
    )
    assert set(done.stdout.split()) == expected, done.stderr


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_other_shells_take_their_scripts(scripts, shell):
    text = (scripts / shell).read_text()
    for words in ("gazebo", "gzserver", "gzclient", "libgz", "pioneer2sonars", "--solver"):
        assert words.lstrip("-") in text
    if shutil.which(shell) is not None:
        subprocess.run([shell, "-n", scripts / shell], check=True, timeout=30)


def test_the_command_prints_a_script():
    done = run_libgz("completion", "bash")
    assert done.returncode == 0
    assert "complete -o bashdefault -F" in done.stdout
    assert run_libgz("completion", "dos").returncode == 2


def test_the_man_pages_are_built(tmp_path):
    words = [sys.executable, ROOT / "scripts" / "make_docs.py", "--man", tmp_path]
    subprocess.run(words, check=True, timeout=60)
    assert {path.name for path in tmp_path.iterdir()} == {f"{name}.1" for name in command_parsers()}
    for path in tmp_path.iterdir():
        assert '.SH "EXIT STATUS"' in path.read_text() or ".SH EXIT STATUS" in path.read_text()
        if shutil.which("man") is not None:
            words = ["man", "-l", "--warnings", path]
            done = subprocess.run(
                words, capture_output=True, text=True, env={**os.environ, "MANWIDTH": "90"}, timeout=60
            )
            assert "EXIT STATUS" in done.stdout or "No such" in done.stderr


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("SickLMS200", "| `rayCount` |"),
        ("position", "`gz_position_data_t`, 312 bytes"),
        ("HingeJoint", "`GetAngleRate"),
        ("physics.Link", "| `AddForce` |"),
        ("World", "# physics.World"),
        ("msgs", "## Enumerations"),
        ("SetLinearVel", "| Link, Model"),
    ],
)
def test_help_prints_the_reference_of_a_name(name, shown):
    done = run_libgz("help", name)
    assert (done.returncode, done.stderr) == (0, "")
    assert shown in done.stdout
    assert "](" not in done.stdout


def test_help_of_an_unknown_name_suggests_one():
    done = run_libgz("help", "SickLMS20")
    assert (done.returncode, done.stdout) == (2, "")
    assert "no command, model, interface or class is called 'SickLMS20'; did you mean 'SickLMS200'?" in done.stderr


def test_the_table_of_exit_codes_is_current():
    text = (ROOT / "docs" / "tools.md").read_text()
    for code, row in EXIT_CODES.items():
        assert f"| {code} | {' | '.join(row)} |\n" in text


def test_worlds_are_listed():
    done = run_libgz("worlds")
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert re.search(r"^pioneer2at +A Pioneer 2 AT on open ground", done.stdout, re.M)
    rows = json.loads(run_libgz("worlds", "--json").stdout)
    assert [row["name"] for row in rows] == [line.split()[0] for line in lines]
    assert all(Path(row["file"]).is_file() and row["summary"] for row in rows)


def test_a_world_leads_to_its_file(tmp_path):
    done = run_libgz("worlds", "ptz", cwd=tmp_path)
    assert done.stdout == f"{installed_worlds() / 'ptz.world'}\n"
    done = run_libgz("worlds", "pzt", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert "did you mean 'ptz'" in done.stderr


def test_gazebo_and_gzserver_run_a_world_by_its_name(wire, tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBO_MASTER_URI", free_master_uri())
    for command in (["gazebo", "-n", "-s", str(wire)], ["gzserver"]):
        done = run_command(*command, "--steps", 3, "pioneer2at", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    missing = run_command("gazebo", "pionere2at")
    assert missing.returncode == 2
    assert "does not exist here, in GAZEBOPATH or among" in missing.stderr
    assert "did you mean 'pioneer2at'" in missing.stderr


@pytest.mark.parametrize(
    ("arguments", "keys"),
    [
        (["models", "--json"], {"name", "summary", "interfaces"}),
        (["models", "SickLMS200", "--json"], {"name", "summary", "interfaces", "attributes", "example"}),
        (["doctor", "--json"], {"name", "text", "good", "needed"}),
        (["worlds", "--json"], {"name", "file", "summary"}),
        (["check", "--json", "map"], None),
        (["clean", "--json", "-s", "987654321"], None),
    ],
    ids=lambda value: "-".join(value[:2]) if type(value) is list else "",
)
def test_programs_read_json(arguments, keys):
    done = run_libgz(*arguments)
    assert done.returncode == 0, done.stderr
    value = json.loads(done.stdout)
    rows = value if isinstance(value, list) else [value]
    assert all(keys is None or set(row) == keys for row in rows)


def test_errors_of_sdf_are_json(tmp_path):
    file = tmp_path / "a.sdf"
    file.write_text("<sdf version='1.6'><world name='w'><model/></world></sdf>")
    done = run_libgz("sdf", "--check", file, "--json")
    assert done.returncode == 1
    assert {"file", "line", "element", "message", "severity"} <= set(json.loads(done.stdout)[0])


def every_parser(parser):
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from every_parser(below)


def test_an_empty_name_is_one_sentence_everywhere():
    checked = 0
    for main in command_parsers().values():
        for parser in every_parser(main):
            for action in parser._actions:
                if action.nargs != 0 and action.type in (None, Path) and not action.choices and action.default != "":
                    for empty in ("", " "):
                        with pytest.raises(argparse.ArgumentError, match=r"the name is empty$"):
                            parser._get_values(action, [empty])
                    checked += 1
    assert checked > 60


def test_texts_may_be_empty_and_the_default_too():
    topic = next(p for p in every_parser(command_parsers()["libgz"]) if p.prog == "libgz topic")
    options = topic.parse_args(["-p", "~/x", "-m", "", "-w", ""])
    assert (options.msg, options.world_name) == ("", "")


def test_empty_words_that_nobody_wants_are_shown(capsys):
    with pytest.raises(SystemExit):
        libgz_main(["stats", ""])
    assert "unrecognized arguments: ''; " in capsys.readouterr().err
