"""Fixtures of C++ plugins of Gazebo classic: one source is compiled once, and linked as a plugin of each kind."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from libgz.base.errors import LibraryError
from libgz.classic_cxx.library import Library, built, check_needs
from libgz.cxx.build import compiler

HERE = Path(__file__).parent
KINDS = {kind: kind for kind in ("Model", "World", "Sensor", "System", "Visual")}
KINDS |= dict.fromkeys(("Battery", "Elevator", "Wheels", "Winch"), "Model")  # derived from plugins of Gazebo
KIND = """\
namespace libgz {{ class PluginRoot; }}
libgz::PluginRoot *New{name}();
extern "C" libgz::PluginRoot *libgz_new_plugin() {{ return New{name}(); }}
extern "C" const char *libgz_classic_plugin() {{ return "libgz classic plugin: {kind}; {key}; {folder};"; }}
"""


@pytest.fixture(scope="session")
def library() -> Library:
    """The library, from the user's cache if it is there."""
    try:
        check_needs()
    except LibraryError as error:
        pytest.skip(str(error))
    return built()


@pytest.fixture(scope="session")
def plugins(library: Library, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with libmodel.so, libworld.so and so on, of checks.cc; workers of one run share it."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "classic_cxx"
    folder.mkdir(exist_ok=True)
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / f"lib{list(KINDS)[-1].lower()}.so").exists():
            _build(library, folder)
    return folder


def _build(library: Library, folder: Path) -> None:
    common = folder / "checks.o"
    flags = library.compiler_flags()
    _run([*compiler(), *flags, "-O0", "-w", "-c", "-o", str(common), str(HERE / "checks.cc")])
    for name, kind in KINDS.items():
        source = folder / f"{name.lower()}.cc"
        source.write_text(KIND.format(name=name, kind=kind, key=library.key, folder=library.lib))
        output = folder / f"lib{name.lower()}.so"
        _run([*compiler(), "-shared", "-fPIC", "-o", str(output), str(source), str(common), *library.linker_flags()])


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False, env={**os.environ, "LC_ALL": "C"})
    assert done.returncode == 0, done.stderr[-4000:]


@pytest.fixture
def place(plugins: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with copies of the plugins, where worlds find them."""
    for path in plugins.glob("*.so"):
        shutil.copy(path, tmp_path / path.name)
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    return tmp_path
