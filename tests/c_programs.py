"""C programs for tests: compiled and linked with the options that `libgz config` prints."""

import ctypes
import os
import shutil
import subprocess
import sys

import pytest

from libgz.transport.layout import fields_of

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


def run(program, *arguments, code=0, text=None):
    """Run a program, with a text to read, and assert its exit code."""
    words = [str(program), *map(str, arguments)]
    done = subprocess.run(words, input=text, capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == code, (done.returncode, done.stdout, done.stderr)
    return done


def scalars_of(struct, wanted):
    """(C and Python path of a number, its kind) of a struct, the first and the last of each array."""
    for name, field in fields_of(struct).items():
        if not any(writer in field.writer for writer in wanted):
            continue
        indices = [""]
        for extent in field.shape:
            indices = [f"{i}[{k}]" for i in indices for k in sorted({0, extent - 1})]
        for index in indices:
            if issubclass(field.ctype, ctypes.Structure):
                for inner, kind in scalars_of(field.ctype, "SC"):
                    yield f"{name}{index}.{inner}", kind
            elif field.ctype is not ctypes.c_char:
                yield f"{name}{index}", field.ctype


def number_for(position, kind):
    """A number that a field of this kind holds, another one for each field."""
    return (position % 200) + (0.25 if kind in (ctypes.c_double, ctypes.c_float) else 0) + 1
