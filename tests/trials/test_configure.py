"""A configure script in the style of Player finds and links the installed library; needs autoconf and automake."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from c_programs import config, needs_compiler, run
from trials.table import trial

from libgz.base.files import installed_worlds

TOOLS = ("autoreconf", "automake", "pkg-config", "make")
pytestmark = [
    pytest.mark.trial,
    needs_compiler,
    pytest.mark.skipif(not all(map(shutil.which, TOOLS)), reason=f"{', '.join(TOOLS)} are not all installed"),
]
SOURCES = Path(__file__).parents[1] / "data" / "player_style"


@pytest.mark.parametrize("version", ["0x060", "0x050"])
def test_a_configure_script_finds_the_library(tmp_path, gazebo, version):
    with trial(f"configure in Player's style, {version}") as row:
        prefix, build = tmp_path / "gazebo", shutil.copytree(SOURCES, tmp_path / "build")
        assert config("--install", str(prefix), "--wire-version", version).returncode == 0
        environment = {**os.environ, "PKG_CONFIG_PATH": str(prefix / "lib" / "pkgconfig")}
        said = ""
        for command in (["autoreconf", "--install"], ["./configure", f"--prefix={tmp_path}/usr"], ["make", "install"]):
            done = subprocess.run(command, cwd=build, env=environment, capture_output=True, text=True)
            assert done.returncode == 0, (command, done.stdout[-3000:], done.stderr[-3000:])
            said += done.stdout
        assert "checking for gz_client_wait in -lgazebo... yes" in said
        drivers = "camera factory fiducial gps gripper laser position power ptz sonar stereo truth wifi"
        assert f"gazebo drivers: {drivers}\n" in said
        world = installed_worlds() / "pioneer2at.world"
        running = gazebo(world, "--rate", "10", "--wire-version", version)
        row.result = run(tmp_path / "usr" / "bin" / "driver", running.id).stdout.strip()
        row.count = 1
        assert row.result == "181 readings up to 8.2 m"
        other = gazebo(
            installed_worlds() / "pioneer2at.world", "--wire-version", "0.5" if version == "0x060" else "0.7"
        )
        run(tmp_path / "usr" / "bin" / "driver", other.id, code=2)
