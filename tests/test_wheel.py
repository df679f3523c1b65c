"""The wheel of `make wheel`: its content, and its use by pip alone where nothing else is installed."""

import importlib.metadata
import sys
import zipfile
from pathlib import Path

import pytest
from c_programs import needs_compiler
from fresh_root import FreshRoot, needs_namespaces
from wheels import build_wheel, check_use, use_wheel

pytestmark = needs_compiler
DEPENDENCIES = ("numpy", "lxml", "pillow", "PyOpenGL")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return build_wheel(tmp_path_factory.mktemp("wheel") / "dist")


def test_one_wheel_serves_every_python_and_contains_ode(wheel):
    assert wheel.name.startswith("libgz-")
    assert "-py3-none-manylinux_2_" in wheel.name
    names = zipfile.ZipFile(wheel).namelist()
    bundled = sorted(name for name in names if name.startswith("libgz.libs/") and not name.endswith("/"))
    assert [name.partition("/")[2][:7] for name in bundled] == ["libccd-", "libccd2", "libode.", "libode8"]
    assert [name for name in bundled if name.endswith(".copyright")] == [
        "libgz.libs/libccd2.copyright",
        "libgz.libs/libode8.copyright",
    ]
    assert {"libgz/ode/_step.so", "libgz/clib/gazebo.h", "libgz/worlds/pioneer2at.world"} <= set(names)
    assert wheel.stat().st_size < 3e6


@needs_namespaces
def test_the_wheel_suffices_in_a_fresh_root(wheel, tmp_path):
    # This environment's dependencies stand in for an index: the test needs no network.
    root = FreshRoot(tmp_path / "root", sys.executable)
    for name in DEPENDENCIES:
        distribution = importlib.metadata.distribution(name)
        for top in sorted({file.parts[0] for file in distribution.files if file.parts[0] != ".."}):
            if (source := Path(distribution.locate_file(top))).is_dir():
                root.bind(source, f"/packages/{top}")
    check_use(use_wheel(root, wheel.parent, PYTHONPATH="/packages"))
