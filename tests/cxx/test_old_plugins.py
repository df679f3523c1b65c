"""Plugins in the style of 2005 that use odd corners of the API, in `plugins/`: each checks what it sees."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from cxx_plugins import compiled, needs_cxx, world_text

import libgz
from libgz.cxx.build import build, cxxflags
from libgz.cxx.objects import OBJECTS

pytestmark = needs_cxx

FOLDER = Path(__file__).parent / "plugins"
NAMES = sorted(path.stem for path in FOLDER.glob("*.cc"))
STANDARDS = ("c++98", "c++11", "c++14", "c++17", "c++20")


@pytest.fixture(scope="module")
def together(tmp_path_factory):
    """One file with all plugins, which takes a quarter of the time of one file for each."""
    register = "".join(f"Register{name}();" for name in [*NAMES, "Child"])
    parts = [f"#include <gazebo/{name}.hh>\n" for name in ("World", "WorldFile", "ModelFactory")] + [
        "#undef GZ_REGISTER_PLUGIN\n#define GZ_REGISTER_PLUGIN GZ_REGISTER_STATIC\n"
    ]
    for name in NAMES:
        parts.append(
            f'#define gazebo_plugin_init init{name}\n#include "{FOLDER / name}.cc"\n#undef gazebo_plugin_init\n'
        )
    parts.append(f'extern "C" int gazebo_plugin_init() {{ {register} return 0; }}\n')
    return compiled(tmp_path_factory.mktemp("together"), "All", "".join(parts))


def run(folder, name, plugin, steps=160):
    """Simulate a world of a plugin."""
    path = folder / f"{name}.world"
    more = f"<xyz>1 2 1</xyz><out>{folder / 'out.world'}</out>"
    path.write_text(world_text((name, more)).replace(f"{name}.so", plugin))
    with libgz.World.from_file(path) as world:
        state = None
        for part in range(2):
            world.step(steps // 2)
            if part == 0 and name not in ("Nursery", "OdeUser"):  # which make models, and joints of ODE's
                state = world.get_state()
        assert [world.models[0].GetName(), world.models[0].error] == [name, None]
        motion = world.engine.states.tobytes()
        served = {key: interface.get_bytes() for key, interface in world.gz_server.interfaces.items()}
        if state is not None and name not in ("Linkage", "Ground"):  # whose variables count the steps
            world.set_state(state)
            world.step(steps - steps // 2)
            assert world.engine.states.tobytes() == motion
    return served


@pytest.mark.parametrize("name", NAMES)
def test_they_see_what_they_expect(tmp_path, together, name, capfd, caplog):
    caplog.set_level("DEBUG")
    shutil.copy(together, tmp_path)
    served = run(tmp_path, name, "All.so")
    kinds = {kind for kind, _ in served} - {"sim"}
    assert {"Scanner": 2, "Servant": 11, "Watcher": 1}.get(name, 0) == len(kinds)
    assert not any("is not so" in record.getMessage() for record in caplog.records)
    if name == "Archivist":
        messages = [(r.levelname, r.getMessage(), Path(r.pathname).name) for r in caplog.records]
        for level, text in (
            ("ERROR", "error, 3, 0.5"),
            ("WARNING", "50% of it"),
            ("INFO", "important"),
            ("INFO", "informative 1"),
            ("DEBUG", "1 2 3 4 5 6 7"),
        ):
            assert (level, text, "Archivist.cc") in messages
        assert "plugin: 'All.so'" in capfd.readouterr().out


@pytest.mark.trial
@pytest.mark.parametrize("standard", STANDARDS)
def test_they_compile_without_warnings_as_any_standard(standard):
    sources = [str(FOLDER / f"{name}.cc") for name in NAMES]
    command = ["c++", f"-std={standard}", "-Wall", "-fsyntax-only", *cxxflags(), *sources]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "LC_ALL": "C"})
    warnings = [line for line in done.stderr.splitlines() if "warning:" in line]
    # Plugins of the time pass (int) this.
    assert (done.returncode, [line for line in warnings if "loses precision" not in line]) == (0, [])


@pytest.mark.trial
@pytest.mark.parametrize("name", NAMES)
def test_they_run_alone_with_optimization(tmp_path, name):
    assert not build([FOLDER / f"{name}.cc"], tmp_path / f"{name}.so")
    before = len(OBJECTS)
    run(tmp_path, name, f"{name}.so")
    assert len(OBJECTS) <= before + 1  # that of Archivist at file scope
