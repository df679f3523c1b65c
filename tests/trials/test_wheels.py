"""The wheel on every version of Python that libgz supports and that is on this machine, in a fresh root for each."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from fresh_root import LIBRARIES, FreshRoot, needs_namespaces, output
from trials.table import trial
from wheels import build_wheel, check_use, use_wheel, use_wheel_offline

pytestmark = [pytest.mark.trial, needs_namespaces]
VERSIONS = ("3.11", "3.12", "3.13")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return build_wheel(tmp_path_factory.mktemp("wheel") / "dist")


def interpreter(version):
    """An interpreter of a version: of PATH, pyenv or uv; skips without one."""
    candidates = [[f"python{version}"]]
    if shutil.which("uv"):
        found = subprocess.run(["uv", "python", "find", version], capture_output=True, text=True)
        candidates.append([found.stdout.strip() or "absent"])
    for command in candidates:
        environment = {**os.environ, "PYENV_VERSION": pyenv_version(version)}
        code = "import ensurepip, sys; print(sys.executable)"
        try:
            found = subprocess.run([*command, "-c", code], capture_output=True, text=True, env=environment)
        except OSError:
            continue
        if found.returncode == 0:
            return found.stdout.strip()
    pytest.skip(f"Python {version} is not on this machine")


def pyenv_version(version):
    """The full name of a version that pyenv has, or the version itself."""
    if shutil.which("pyenv") is None:
        return version
    names = output("pyenv", "versions", "--bare").split()
    return next((name for name in names if name.startswith(f"{version}.")), version)


@pytest.mark.parametrize("version", VERSIONS)
def test_the_wheel_suffices(wheel, tmp_path, version):
    with trial(f"the wheel on Python {version}") as row:
        python = interpreter(version)
        wheels = tmp_path / "wheels"
        output(python, "-m", "pip", "download", "--quiet", "--only-binary=:all:", "--dest", str(wheels), str(wheel))
        found = use_wheel(FreshRoot(tmp_path / "root", python), wheels, "--find-links", "/wheels")
        row.count, row.result = 1, f"{found['root']['python']}: {json.dumps(sorted(found))}"
        check_use(found)
        assert found["root"]["python"].startswith(version)


VENDOR = Path("/usr/share/glvnd/egl_vendor.d/50_mesa.json")
BACKENDS = {
    "osmesa": [LIBRARIES / "libOSMesa.so.8"],
    "egl": [
        LIBRARIES / "libEGL.so.1",
        LIBRARIES / "libEGL_mesa.so.0",
        VENDOR,
        LIBRARIES / "dri" / "swrast_dri.so",
    ],
}


@pytest.mark.parametrize(("backend", "without"), [("osmesa", None), ("egl", None), ("egl", 1), ("egl", 2), ("egl", 3)])
def test_cameras_use_what_the_system_has(wheel, tmp_path, backend, without):
    files = [path for i, path in enumerate(BACKENDS[backend]) if i != without]
    if not all(path.exists() for path in BACKENDS[backend]):
        pytest.skip(f"{backend} is not on this machine in Debian's places")
    with trial(f"cameras by {backend} in a fresh root, without {without}") as row:
        root = FreshRoot(tmp_path / "root", sys.executable)
        root.copy_libraries(*(path for path in files if path != VENDOR))
        for path in files:
            root.copy(path)
        found = use_wheel_offline(root, wheel.parent)
        (line,) = (line for line in found["doctor"]["output"].splitlines() if line[8:22].strip() == backend)
        row.count, row.result = 1, line
        assert found["gazebo"]["code"] == 0
        if without is None:
            assert line.startswith("ok")
            assert " renders: llvmpipe" in line
            assert found["camera"]["code"] == 0, found["camera"]
        else:
            absent = BACKENDS[backend][without]
            name = f"egl_vendor.d/{absent.name}" if absent == VENDOR else absent.name
            assert f"missing: {name}; install with apt-get install lib" in line
            assert found["camera"]["code"] == 1
