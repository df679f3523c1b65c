"""Every public name of the old API that a plugin could use is declared, and called by a test."""

import re
from pathlib import Path

import pytest

from libgz.cxx import FOLDER

HERE = Path(__file__).parent
NAMES = dict(
    line.split(":", 1)
    for line in (HERE.parent / "data" / "cxx-api.txt").read_text().splitlines()
    if not line.startswith("#")
)


def called_code():
    """The C++ code of tests."""
    groups = re.findall(r'@group\("""(.*?)"""', (HERE / "test_api.py").read_text(), re.DOTALL)
    plugins = [path.read_text() for path in (HERE / "plugins").iterdir()]
    return "".join([*groups, *plugins, (HERE / "test_plugins.py").read_text()])


@pytest.mark.parametrize("header", NAMES)
def test_all_names_are_declared_and_called(header):
    text, called = (FOLDER / "include" / "gazebo" / f"{header}.hh").read_text(), called_code()
    for word in NAMES[header].split():
        name = word.strip("[]")
        assert re.search(rf"\b{name}\b", text), f"{header}.hh has no {name}"
        assert word != name or re.search(rf"\b{name}\b", called), f"no test calls {name} of {header}.hh"
