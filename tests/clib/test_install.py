"""libgz config --install: what pkg-config and configure scripts of old programs find, and what they build with it."""

import os
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
from c_programs import COMPILER, compile_c, config, needs_compiler, run

pytestmark = needs_compiler

# Relies on the <stdlib.h> of gazebo.h, as old programs do.
DRIVE = r"""
#include <stdio.h>
#include <gazebo.h>

int main(int count, char **words)
{
    gz_client_t *client = gz_client_alloc();
    gz_truth_t *truth = gz_truth_alloc();

    if (count != 3 || gz_client_connect_wait(client, atoi(words[1]), GZ_CLIENT_ID_PLAYER) != 0)
        return 1;
    if (gz_truth_open(truth, client, "truth1") != 0 || gz_client_wait(client) != 0)
        return 2;
    gz_truth_lock(truth, 1);
    printf("%.4f %lu %x %.2f\n", truth->data->rot[2], sizeof truth->data->rot / sizeof(double),
           truth->data->head.version, atof(words[2]));
    gz_truth_unlock(truth);
    gz_truth_close(truth);
    gz_client_disconnect(client);
    return 0;
}
"""
WORLD = """<gz:world xmlns:gz="g" xmlns:model="m">
<model:SimpleSolid><id>box</id><xyz>0 0 1</xyz><rpy>0 0 30</rpy><shape>box</shape>
<model:TruthWidget><id>truth1</id></model:TruthWidget></model:SimpleSolid></gz:world>"""


@pytest.fixture(scope="module")
def prefix(tmp_path_factory):
    """A prefix with a space in its path, with the default version installed."""
    folder = tmp_path_factory.mktemp("old programs") / "usr local"
    done = config("--install", str(folder), XDG_CACHE_HOME=str(tmp_path_factory.mktemp("cache")))
    assert done.returncode == 0, done.stderr
    assert sorted(done.stdout.splitlines()) == sorted(map(str, files(folder)))
    assert f"export PKG_CONFIG_PATH='{folder}/lib/pkgconfig'" in done.stderr
    return folder


def files(folder):
    return [path for path in folder.rglob("*") if not path.is_dir() or path.is_symlink()]


def pkg_config(prefix, *options):
    """What pkg-config prints; without pkg-config, what gazebo.pc says."""
    if shutil.which("pkg-config"):
        environment = {**os.environ, "PKG_CONFIG_PATH": str(prefix / "lib" / "pkgconfig")}
        command = ["pkg-config", *options, "gazebo"]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
        return done.stdout.strip()
    text = (prefix / "lib" / "pkgconfig" / "gazebo.pc").read_text()
    values = dict(line.split(": ", 1) for line in text.splitlines() if ": " in line)
    folders = {"${libdir}": f"{prefix}/lib", "${includedir}": f"{prefix}/include"}
    wanted = " ".join(values[{"--cflags": "Cflags", "--libs": "Libs", "--modversion": "Version"}[o]] for o in options)
    for name, folder in folders.items():
        wanted = wanted.replace(name, folder.replace(" ", "\\ "))
    return wanted


def test_pkg_config_finds_gazebo(prefix):
    assert pkg_config(prefix, "--modversion") == "0.7.0"
    names = sorted(str(path.relative_to(prefix)) for path in files(prefix))
    assert {"include/gazebo/Body.hh", "include/gazebo/ModelFactory.hh", "share/libgz/ode/ode.h"} <= set(names)
    assert [name for name in names if not name.startswith(("include/gazebo/", "share/libgz/"))] == [
        "include/gazebo.h",
        "lib/libgazebo.a",
        "lib/libgazebo.so",
        "lib/libgazebo.so.0",
        "lib/pkgconfig/gazebo.pc",
    ]
    assert Path(prefix / "lib" / "libgazebo.so").readlink() == Path("libgazebo.so.0")


@pytest.mark.parametrize("static", [False, True], ids=["shared", "static"])
@pytest.mark.parametrize("function", ["gz_client_wait", "gz_truth_alloc", "gz_position_alloc", "gz_laser_alloc"])
def test_the_link_test_of_configure_succeeds(prefix, tmp_path, function, static):
    # What AC_CHECK_LIB compiles: it declares the function as it likes.
    source = tmp_path / "conftest.c"
    source.write_text(f"char {function} (void);\nint main (void) {{ return {function} (); }}\n")
    libraries = [str(prefix / "lib" / "libgazebo.a"), "-lm"]
    if not static:
        libraries = ["-lgazebo", *shlex.split(pkg_config(prefix, "--libs"))]
    command = [COMPILER, "-o", str(tmp_path / "conftest"), "-g", "-O2", "-fno-builtin", str(source), *libraries]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("version", "numbers"), [("0x060", 4), ("0x050", 3)])
def test_programs_run_without_search_paths_and_see_their_version(prefix, tmp_path, gazebo, version, numbers):
    if version == "0x050":
        prefix = tmp_path / "player"
        assert config("--install", str(prefix), "--wire-version", version).returncode == 0
        assert pkg_config(prefix, "--modversion") == "0.5.0"
    flags = shlex.split(pkg_config(prefix, "--cflags", "--libs"))
    assert "-fpermissive" in flags  # for C++ plugins; C compilers warn of it
    program = compile_c(tmp_path, DRIVE, *flags, "-Wno-error")
    world = tmp_path / "truth.world"
    world.write_text(WORLD)
    running = gazebo(world, "--rate", "10", "--wire-version", version)
    seen = run(program, running.id, 0.25).stdout.split()
    assert seen[1:] == [str(numbers), version[3:], "0.25"]
    assert float(seen[0]) == pytest.approx(0.5236 if version == "0x050" else 0.0, abs=1e-3)


def test_what_cannot_be_installed_is_reported(tmp_path):
    (tmp_path / "file").write_text("")
    done = config("--install", str(tmp_path / "file"))
    assert done.returncode == 1
    assert f"the C library cannot be installed in {tmp_path}/file: " in done.stderr
    assert "Traceback" not in done.stderr
    done = config("--install", str(tmp_path), "--libs")
    assert (done.returncode, done.stdout) == (1, "")
    assert "--install excludes --cflags, --cxxflags and --libs" in done.stderr
    assert "--wire-version needs --install PREFIX" in config("--wire-version", "0x050").stderr
    assert "allowed are 0x050, 0.5" in config("--install", str(tmp_path), "--wire-version", "7").stderr


def test_the_installed_library_is_replaced_while_programs_use_it(prefix):
    used = (prefix / "lib" / "libgazebo.so.0").stat().st_ino
    assert config("--install", str(prefix)).returncode == 0
    assert (prefix / "lib" / "libgazebo.so.0").stat().st_ino != used
    assert "#define LIBGAZEBO_VERSION 0x060" in (prefix / "include" / "gazebo.h").read_text()
