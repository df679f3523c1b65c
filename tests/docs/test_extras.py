"""Extras that code, starters and documents name exist, and no text installs libgz from an index without it."""

import re
import tomllib
from pathlib import Path

import pytest

from libgz.base.extras import install

ROOT = Path(__file__).parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
PLACES = ("libgz", "interfaces", "models", "docs", "examples")
ENDINGS = {".py", ".md", ".in", ".yml", ".ipynb", ".toml"}


def texts():
    yield from ROOT.glob("*.md")
    yield from (path for place in PLACES for path in (ROOT / place).rglob("*") if path.suffix in ENDINGS)


NAMED = re.compile(r"libgz[^\s'\"`]*\[(\w+)\]'|\bextra `(\w+)`|\binstall\(['\"](\w+)['\"]\)")


def test_extras_that_texts_name_exist():
    named = [(path, "".join(found)) for path in texts() for found in NAMED.findall(path.read_text())]
    assert not [(str(path), extra) for path, extra in named if extra not in EXTRAS]
    assert len(named) > 15


def test_libgz_is_not_installed_from_an_index():
    """Besides xacro's extra, no text says `pip install libgz` or `pip install 'libgz[...]'`."""
    wrong = re.compile(r"pip install (?:[\w.<>=-]+ )*'?libgz(?:\[(?!urdf)|[ `]|$)", re.M)
    assert not [str(path.relative_to(ROOT)) for path in texts() if wrong.search(path.read_text())]
    assert wrong.search("`pip install libgz pytest`")
    assert wrong.search("pip install 'libgz[view]'")


@pytest.mark.parametrize("extra", ["view", "gym", "plot", "log", "video", "mesh", "cluster"])
def test_the_command_installs_what_the_extra_needs(extra):
    words = install(extra)
    assert words.startswith("pip install ")
    assert not [line for line in EXTRAS[extra] if re.match(r"[\w-]+", line)[0] not in words]


def test_packages_that_texts_install_are_those_of_extras():
    known = {line.replace(" ", "") for lines in EXTRAS.values() for line in lines}
    quoted = re.compile(r'"((?:aiohttp|gymnasium)[^"]*)"')
    named = [word for path in texts() if path.suffix != ".py" for word in quoted.findall(path.read_text())]
    assert len(named) > 5
    assert set(named) <= known
