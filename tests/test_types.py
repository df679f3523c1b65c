"""What type checkers and editors know: the programs in the documents, and what look-ups return."""

import inspect
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from libgz.classic.sensors.kinds import CLASSES
from libgz.interfaces.catalog import INTERFACES
from libgz.interfaces.client import Client

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md")), *sorted(ROOT.glob("examples/**/*.md"))]

# A line for each look-up, with the type that it has without a cast.
LOOKUPS = """
import libgz
from libgz import HingeJoint, Model
from libgz.classic import physics, sensors
from libgz.classic.sdf import Element

def look(world: libgz.World, client: libgz.Client, sdf: Element) -> None:
    reveal_type(world.model("robot1"))  # Entity
    reveal_type(world.model("robot1", Model))  # Model
    reveal_type(world.joint("robot1", "wheel", HingeJoint))  # HingeJoint
    reveal_type(world.body("robot1"))  # Body
    reveal_type(sdf.Get(float, "height"))  # float
    reveal_type(sdf.Get(float, "height", 1.0))  # tuple[float, bool]
    reveal_type(physics.get_world().ModelByName("a"))  # Model | Any
    reveal_type(sensors.get_sensor("a", sensors.RaySensor))  # RaySensor | Any
    with libgz.World.from_file("pioneer2at", strict=True) as mine:
        reveal_type(mine)  # World
"""


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """All Python programs of the documents as files, each named after its page and line, and that of the look-ups."""
    folder = tmp_path_factory.mktemp("programs")
    for page in PAGES:
        text = page.read_text()
        for block in re.finditer(r"^```python\n(.*?)^```", text, re.S | re.M):
            line = text.count("\n", 0, block.start()) + 2
            name = "_".join(page.relative_to(ROOT).with_suffix("").parts)
            (folder / f"{re.sub(r'[^0-9A-Za-z]', '_', name)}_line_{line}.py").write_text(block[1])
            saved = re.search(r"[Ss]ave\sthis\sas\s`(\w+)\.py`[^`]*$", text[: block.start()])
            if saved is not None and f"from {saved[1]} import" in text:  # another program of the page imports it
                (folder / f"{saved[1]}.py").write_text(block[1])
    looks = [LOOKUPS]
    for type_, kind in INTERFACES.items():
        looks.append(f'    reveal_type(world.interface("{type_}", "robot1"))  # {kind.__name__}\n')
        argument = "" if type_ == "sim" else '"robot1"'
        looks.append(f"    reveal_type(client.{type_}({argument}))  # {kind.__name__}\n")
    (folder / "lookups.py").write_text("".join(looks))
    return folder


def expected_types(programs):
    found = re.findall(r"reveal_type\(.*\)  # (.*)", (programs / "lookups.py").read_text())
    assert len(found) > 40
    return found


def test_the_documents_and_lookups_pass_mypy(programs):
    files = sorted(map(str, programs.glob("*.py")))
    assert len(files) > 15
    # What `make types` found out about the library serves here, too.
    shared = ["--config-file", str(ROOT / "pyproject.toml"), "--cache-dir", str(ROOT / "build" / ".mypy_cache")]
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *shared, *files],
        cwd=programs,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    types = [re.sub(r"[a-z_]\w*\.", "", text) for text in re.findall(r'Revealed type is "(.*)"', done.stdout)]
    assert types == expected_types(programs)


def test_the_documents_and_lookups_pass_pyright(programs):
    pytest.importorskip("pyright")
    command = [sys.executable, "-m", "pyright", "--pythonpath", sys.executable, "--outputjson", str(programs)]
    done = subprocess.run(
        command,
        env={**os.environ, "PYRIGHT_PYTHON_IGNORE_WARNINGS": "1"},
        cwd=programs,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    if not done.stdout.lstrip().startswith("{"):
        pytest.skip(f"pyright needs Node.js, and found none: {done.stderr[-200:]}")
    report = json.loads(done.stdout)["generalDiagnostics"]
    assert [f"{d['file']}: {d['message']}" for d in report if d["severity"] == "error"] == []
    types = [re.search(r'is "(.*)"', d["message"])[1] for d in report if d["message"].startswith("Type of")]
    assert types == expected_types(programs)


def test_the_overloads_are_current():
    scope = {"__name__": "make_overloads", "__file__": str(ROOT / "scripts" / "make_overloads.py")}
    exec((ROOT / "scripts" / "make_overloads.py").read_text(), scope)
    source = scope["WORLD"].read_text()
    assert scope["with_overloads"](source) == source, "run: python scripts/make_overloads.py"


def test_clients_open_every_interface_by_its_type():
    for type_, kind in INTERFACES.items():
        assert inspect.signature(getattr(Client, type_)).return_annotation == kind.__name__


def test_every_sensor_class_is_known_to_type_checkers():
    source = (ROOT / "libgz" / "classic" / "sensors" / "__init__.py").read_text()
    for name in CLASSES:
        assert re.search(rf"\b{name} as {name}\b", source), name


def test_constructors_give_units():
    import libgz

    for name in dir(libgz):
        kind = getattr(libgz, name)
        if not inspect.isclass(kind) or not kind.__module__.startswith("libgz") or "__init__" not in vars(kind):
            continue
        text = inspect.getdoc(kind) or ""
        floats = [p for p in inspect.signature(kind).parameters.values() if str(p.annotation) == "float"]
        if floats and name not in ("GzQuatern", "GzColor"):  # which have none
            assert re.search(r"\[[\w /^]+\]", text), f"{name} gives no unit: {text}"


def test_the_package_says_that_it_is_typed():
    import libgz

    assert (Path(libgz.__file__).parent / "py.typed").is_file()
