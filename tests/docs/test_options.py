"""Commands and options that documents, examples and starters name are those of the parsers."""

import argparse
import re
from pathlib import Path

import pytest

from libgz.apps import gazebo, gzclient, gzserver, libgz

ROOT = Path(__file__).parents[2]
PLACES = ("docs", "examples", "libgz")
ENDINGS = {".md", ".sh", ".yml", ".toml", ".world"}
# Of a shell: the command and its words, up to the end of the code, line, or a comment, pipe or second command.
CALL = re.compile(r"(?<![\w/.~-])(gazebo|gzserver|gzclient|libgz|gz) ((?:(?!\s#)[^`\n|;&>)\"])+)")
IN_CODE = re.compile(r"(?:`|^    |^\$ )(libgz|gz) ([a-z][\w-]*)")
OF_OTHERS = {"--ros-args", "--propshop-save", "--propshop-model", "--frames-to"}  # of ROS, and of a plugin in the call
OPTION = re.compile(r"(?<!\S)--?[a-zA-Z][\w-]*(?=[\s=,\]]|$)")


@pytest.fixture(scope="module")
def known():
    """(command, subcommand) -> its options."""
    found = {}
    for prog, module in (("gzserver", gzserver), ("gzclient", gzclient)):
        found[prog, ""] = set(module.make_parser()._option_string_actions)
    found["gazebo", ""] = set(gazebo.make_parser()._option_string_actions).union(*found.values())  # the era decides
    for prog in ("libgz", "gz"):
        parser = libgz.make_parser(everything=True, prog=prog)
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                for name, sub in action.choices.items():
                    found[prog, name] = set(sub._option_string_actions) | inner(sub)
    return found


def inner(parser):
    """The options of subcommands of a subcommand."""
    actions = [action for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    return {word for action in actions for sub in action.choices.values() for word in sub._option_string_actions}


def texts():
    yield from ROOT.glob("*.md")
    for place in PLACES:
        yield from (path for path in (ROOT / place).rglob("*") if path.suffix in ENDINGS and path.is_file())


@pytest.fixture(scope="module")
def calls():
    """(file, line, command, words) of each call in a text."""
    found = []
    for path in texts():
        for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1):
            found += [(path, number, match[1], match[2].split()) for match in CALL.finditer(line)]
    return found


def test_options_in_texts_exist(known, calls):
    wrong, count = [], 0
    for path, number, command, words in calls:
        sub = words[0] if command in ("libgz", "gz") else ""
        if (command, sub) not in known:
            continue
        for option in OPTION.findall(" ".join(words)):
            count += 1
            if option not in known[command, sub] | OF_OTHERS and not (
                len(option) > 2 and option[:2] in known[command, sub]
            ):
                wrong.append(f"{path.relative_to(ROOT)}:{number}: {command} {sub} has no {option}")
    assert wrong == [], wrong
    assert count > 200


def test_commands_in_texts_exist(known):
    wrong, count = [], 0
    for path in texts():
        if path.suffix != ".md":
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            for command, sub in IN_CODE.findall(line):
                count += 1
                if (command, sub) not in known and sub not in libgz.WITHOUT:
                    wrong.append(f"{path.relative_to(ROOT)}:{number}: there is no {command} {sub}")
    assert wrong == [], wrong
    assert count > 200
