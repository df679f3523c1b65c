"""scripts/setup.sh installs once: for a demonstration what it needs, for tests the rest."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parent.parent / "scripts" / "setup.sh"
# What an installation leaves in the tree, or nothing where the file `broken` is.
PIP = """#!/bin/sh
echo "$@" | grep -o "[.].[a-z]*." >>calls
mkdir -p build libgz/__pycache__
test ! -e broken || exit 1
touch libgz/ode/_step.so libgz/__pycache__/a.pyc
"""


class Tree:
    """A tree with a package, in which every program that setup.sh calls succeeds and pip counts its calls."""

    def __init__(self, path):
        self.path = path
        for name in ("libgz/ode", "interfaces", "models", "worlds", "scripts", ".venv/bin", "programs"):
            (path / name).mkdir(parents=True)
        for name in ("setup.py", "setup.cfg", "pyproject.toml", "libgz/a.py", "libgz/ode/step.c", "libgz/ode/step.h"):
            (path / name).write_text(name)
        shutil.copy(SCRIPT, path / "scripts")
        for name, text in (
            (".venv/bin/pip", PIP),
            (".venv/bin/python", "#!/bin/sh"),
            ("programs/python3", "#!/bin/sh"),
        ):
            (path / name).write_text(text)
            (path / name).chmod(0o755)

    def setup(self, extra):
        """Run it; the extras of all installations until now."""
        environment = {"PATH": f"{self.path / 'programs'}:{os.environ['PATH']}", "CC": "true"}
        command = [str(self.path / "scripts/setup.sh"), extra]
        ended = subprocess.run(command, env=environment, capture_output=True, text=True)
        calls = self.path / "calls"
        return ended.returncode, calls.read_text().split() if calls.exists() else []


@pytest.fixture
def tree(tmp_path):
    return Tree(tmp_path)


def test_a_second_setup_installs_nothing_and_tests_add_the_rest(tree):
    assert tree.setup("view") == (0, [".[view]"])
    assert tree.setup("view") == (0, [".[view]"])
    assert tree.setup("dev") == (0, [".[view]", ".[dev]"])
    for extra in ("dev", "view"):
        assert tree.setup(extra) == (0, [".[view]", ".[dev]"])


@pytest.mark.parametrize("name", ["libgz/new.py", "models/new.py", "libgz/ode/step.c", "libgz/ode/step.h", "setup.cfg"])
def test_what_the_installation_depends_on_is_installed_again(tree, name):
    tree.setup("dev")
    (tree.path / name).write_text("changed")
    assert tree.setup("view") == (0, [".[dev]", ".[dev]"])  # what was set up for tests stays so
    assert tree.setup("dev") == (0, [".[dev]", ".[dev]"])


def test_a_changed_module_needs_no_installation_a_removed_build_does(tree):
    tree.setup("view")
    (tree.path / "libgz/a.py").write_text("changed")
    assert tree.setup("view") == (0, [".[view]"])
    shutil.rmtree(tree.path / "build")
    assert tree.setup("view") == (0, [".[view]"] * 2)


def test_an_installation_that_failed_is_repeated(tree):
    tree.setup("view")
    (tree.path / "libgz/new.py").write_text("")
    (tree.path / "broken").write_text("")
    assert tree.setup("view") == (1, [".[view]"] * 2)
    (tree.path / "libgz/new.py").unlink()
    (tree.path / "broken").unlink()
    assert tree.setup("view") == (0, [".[view]"] * 3)


@pytest.mark.parametrize("compiler", ["/no/compiler", "false"])
def test_a_build_without_a_compiler_ends_with_what_to_install(compiler, tmp_path):
    places = ["--build-lib", str(tmp_path / "lib"), "--build-temp", str(tmp_path / "temp")]
    done = subprocess.run(
        [sys.executable, "setup.py", "-q", "build_ext", *places],
        cwd=SCRIPT.parent.parent,
        env={**os.environ, "CC": compiler},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("libgz needs a C compiler: apt-get install gcc libc6-dev")
    assert "Traceback" not in done.stderr
