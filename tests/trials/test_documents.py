"""In a root of its own: what the first tutorial shows, as it is typed, and the example of tests for pytest."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from c_programs import needs_compiler
from fresh_root import ROOT, FreshRoot, needs_namespaces
from trials.table import trial
from wheels import DEPENDENCIES, bind_packages, build_wheel

pytestmark = [pytest.mark.trial, needs_compiler, needs_namespaces]
SESSION = (ROOT / "tests" / "docs" / "session.py").read_text()
WORK = "/home/user/work"
ENVIRONMENT = {"PYTHONPATH": "/packages", "PIP_NO_INDEX": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
PYTEST = """
import json, subprocess, sys
run = lambda *command: subprocess.run(command, cwd="/home/user/work", capture_output=True, text=True)
run(sys.executable, "-m", "venv", "env")
(wheel,) = __import__("glob").glob("/home/user/work/libgz-*.whl")
run("env/bin/pip", "install", wheel)
done = run("env/bin/python", "-m", "pytest", "-q", "--import-mode=importlib", "--libgz-record", "ci")
print(json.dumps([done.returncode, done.stdout + done.stderr]))
"""


WITHOUT_HYPOTHESIS = """
import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == "hypothesis":
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
sys.meta_path.insert(0, Absent())
import pytest
sys.exit(pytest.main(sys.argv[1:]))
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return build_wheel(tmp_path_factory.mktemp("wheel") / "dist")


@pytest.fixture
def root(tmp_path, wheel):
    """A root with a shell, sed and the wheel in a folder of the user, and nothing of libgz installed."""
    found = FreshRoot(tmp_path / "root", sys.executable)
    tools = [Path(shutil.which(name)).resolve() for name in ("sh", "sed")]
    for name, tool in zip(("sh", "sed"), tools, strict=True):
        found.place("/bin").mkdir(parents=True, exist_ok=True)
        shutil.copy(tool, found.place(f"/bin/{name}"))
    found.copy_libraries(*tools)
    found.place("/usr/bin").mkdir(parents=True, exist_ok=True)
    if not found.place("/usr/bin/python3").exists():
        found.place("/usr/bin/python3").symlink_to(found.python)
    bind_packages(found, DEPENDENCIES)
    work = found.place(WORK)
    work.mkdir(parents=True)
    work.chmod(0o1777)
    shutil.copy(wheel, work)
    return found


def test_the_first_tutorial_ends_with_a_driving_robot(root):
    with trial("the first tutorial in a fresh root") as row:
        page = root.place("/old_world.md")
        shutil.copy(ROOT / "docs" / "tutorials" / "old_world.md", page)
        words = ["/old_world.md", WORK, "--installs", "--until", "See it"]
        row.count = root.run(SESSION, *words, **ENVIRONMENT)
        row.result = f"{row.count} commands"
        assert row.count > 12
        assert "driven 1.0 m" in page.read_text()  # what the session has compared with


def test_the_example_for_pytest_passes(root):
    with trial("the example for pytest in a fresh root") as row:
        bind_packages(root, ["pytest", "pluggy", "iniconfig", "packaging", "pygments"])
        shutil.copytree(ROOT / "examples" / "ci", root.place(f"{WORK}/ci"))
        code, text = root.run(PYTEST, LIBGZ_GL="none", **ENVIRONMENT)
        row.count, row.result = 1, json.dumps(text.splitlines()[-1:])
        assert code == 0, text
        assert "passed" in text


def test_the_example_for_pytest_needs_pytest_only_in_a_checkout():
    command = [
        sys.executable,
        "-c",
        WITHOUT_HYPOTHESIS,
        "-q",
        "-p",
        "no:cacheprovider",
        "-p",
        "no:hypothesispytest",
        "examples/ci",
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
