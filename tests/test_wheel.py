"""The wheel of `make wheel`: its content, and its use by pip alone where nothing else is installed."""

import platform
import sys
import zipfile

import pytest
from c_programs import needs_compiler
from fresh_root import FreshRoot, needs_namespaces
from wheels import build_wheel, check_use, use_wheel_offline

pytestmark = needs_compiler


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    return build_wheel(tmp_path_factory.mktemp("wheel") / "dist")


def test_one_wheel_serves_every_python_and_contains_ode(wheel):
    assert wheel.name.startswith("libgz-")
    assert f"-py3-none-manylinux_2_24_{platform.machine()}" in wheel.name
    names = zipfile.ZipFile(wheel).namelist()
    bundled = sorted(name for name in names if name.startswith("libgz.libs/") and not name.endswith("/"))
    assert [name.partition("/")[2][:7] for name in bundled] == ["libccd-", "libccd2", "libode.", "libode8"]
    assert [name for name in bundled if name.endswith(".copyright")] == [
        "libgz.libs/libccd2.copyright",
        "libgz.libs/libode8.copyright",
    ]
    assert {"libgz/ode/_step.so", "libgz/clib/gazebo.h", "libgz/worlds/pioneer2at.world"} <= set(names)
    pages = {"gazebo", "gz", "gzclient", "gzserver", "libgz"}
    assert {name.rpartition("/")[2] for name in names if "/man1/" in name} == {"", *(f"{page}.1" for page in pages)}
    assert wheel.stat().st_size < 4e6  # of which the page takes 0.5e6


@needs_namespaces
def test_the_wheel_suffices_in_a_fresh_root(wheel, tmp_path):
    check_use(use_wheel_offline(FreshRoot(tmp_path / "root", sys.executable), wheel.parent))
