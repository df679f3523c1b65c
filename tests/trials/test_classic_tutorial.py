"""Gazebo classic's first tutorial in a root of Debian 12 that has nothing else, by the commands of docs/classic_cxx.md.

LIBGZ_FRESH_DEBIAN names the root, as `debootstrap bookworm` makes it; as root, for chroot, with /proc and /dev in it.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from classic_cxx.test_library import CMAKE, HELLO, WORLD
from fresh_root import ROOT
from trials.table import trial
from wheels import build_wheel

FRESH = os.environ.get("LIBGZ_FRESH_DEBIAN", "")
pytestmark = [pytest.mark.trial, pytest.mark.skipif(not FRESH, reason="LIBGZ_FRESH_DEBIAN names no root")]
SERVE = "timeout --preserve-status -s INT 20 "
ENVIRONMENT = ("PATH=/usr/sbin:/usr/bin:/sbin:/bin", "HOME=/home/tutorial")


def commands(page, heading):
    """The first block of commands below a heading of a page."""
    (block,) = re.findall(rf"^## {heading}\n(?:.*\n)*?\n((?:    .+\n)+)", (ROOT / "docs" / page).read_text(), re.M)
    return [line.strip() for line in block.splitlines()]


def run(command, *user):
    """What a command says in the root."""
    words = ["chroot", *user, FRESH, "/usr/bin/env", "-i", *ENVIRONMENT, "bash", "-ec", command]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=1800)
    assert done.returncode == 0, done.stdout
    return done.stdout


def test_the_tutorial_in_a_fresh_root(tmp_path):
    with trial("classic's tutorial in a fresh root") as row:
        packages, *typed = commands("classic_cxx.md", "Five commands")
        environment, *installation = commands("install.md", "From the wheel")
        shutil.copy(build_wheel(tmp_path / "dist"), Path(FRESH, "tmp"))
        for command in (environment, packages):
            run(f"DEBIAN_FRONTEND=noninteractive {command} -y -qq")
        run("rm -rf /home/tutorial; mkdir -p /home/tutorial; chown 1234:1234 /home/tutorial")
        folder = Path(FRESH, "home/tutorial/gazebo_plugin_tutorial")
        make = "g++ -shared -fPIC $(pkg-config --cflags gazebo) $< -o $@ $(pkg-config --libs gazebo)"
        folder.mkdir()
        for name, text in {
            "hello_world.cc": HELLO,
            "CMakeLists.txt": CMAKE,
            "hello.world": WORLD,
            "Makefile": f"libhello_world.so: hello_world.cc\n\t{make.replace('$(', '$$(')}\n",
        }.items():
            (folder / name).write_text(text)
        os.chown(folder, 1234, 1234)
        *built, serve = typed
        (exported,) = [one for one in built if one.startswith("export")]
        user = "--userspec=1234:1234"
        said = run(
            "\n".join(["cd", "cp /tmp/libgz-*.whl .", *installation, f"cd {folder.name}", *built, SERVE + serve]), user
        )
        row.count, row.result = len(typed), " | ".join(said.splitlines()[-5:])
        variable = re.search(r"export PKG_CONFIG_PATH=\S+", said)[0]
        begin, end = "cd ~/gazebo_plugin_tutorial; . ~/libgz/bin/activate", SERVE + serve.replace("../", "")
        by_make = run(f"{begin}; {variable}; make -s; {exported}; {end}", user)
        by_libgz = run(f"{begin}; rm *.so; libgz cxx build hello_world.cc; {exported}; {end}", user)
        for lines in (said, by_make, by_libgz):
            assert lines.rstrip().endswith("Publicized address: 127.0.0.1\nHello World!"), lines
        run("~/libgz/bin/libgz config --install-classic --uninstall", user)
        assert not Path(FRESH, "home/tutorial/.local/share/libgz/gazebo-11").exists()
