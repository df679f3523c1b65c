"""C programs for tests: compiled and linked with the options that `libgz config` prints."""

import os
import shutil
import subprocess
import sys

import pytest

COMPILER = shutil.which("cc") or shutil.which("gcc")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler is installed")
WARNINGS = ["-Wall", "-Wextra", "-Werror", "-Wshadow"]


def compile_c(folder, source, *flags, name="program", compiler=COMPILER):
    """Compile and link a program; returns its path."""
    path = folder / f"{name}.c"
    path.write_text(source)
    command = [compiler, *WARNINGS, str(path), *flags, "-o", str(folder / name)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return folder / name


def config(*options, **env):
    """Run `libgz config`."""
    command = [sys.executable, "-m", "libgz.apps.libgz", "config", *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False, env={**os.environ, **env})


def run(program, *arguments, code=0):
    """Run a program and assert its exit code."""
    done = subprocess.run([str(program), *map(str, arguments)], capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == code, (done.returncode, done.stdout, done.stderr)
    return done
