"""Compiles C++ plugins of Gazebo classic."""

from __future__ import annotations

import os
import re
import shlex
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from libgz.base.errors import LibraryError, ParameterError
from libgz.classic_cxx.library import EXACT, STANDARD, built
from libgz.classic_cxx.qt import QtSources
from libgz.classic_cxx.recognition import OLD_NAMES, asks_for_old_names, version_flags
from libgz.cxx.build import CompileError, compiler, run_compiler, source_words

__all__ = ["build", "check", "default_output"]

Progress = Callable[[str], None]

_MISSING = re.compile(r"([\w./+-]+): No such file or directory|'([\w./+-]+)' file not found")
# Packages of Debian with headers, by the beginning of their names, and the directory that is named by -I.
PACKAGES = {
    "Eigen/": ("libeigen3-dev", "/usr/include/eigen3"),
    "GL/": ("libgl-dev", ""),
    "Q": ("qtbase5-dev", ""),
    "boost/": ("libboost-dev", ""),
    "gst/": ("libgstreamer1.0-dev", "/usr/include/gstreamer-1.0"),
    "ignition/": ("libignition-transport-dev", ""),
    "opencv2/": ("libopencv-dev", "/usr/include/opencv4"),
    "pcl/": ("libpcl-dev", "/usr/include/pcl-1.13"),
    "ros/": ("libroscpp-dev", ""),
    "tinyxml": ("libtinyxml-dev", ""),
    "yaml-cpp/": ("libyaml-cpp-dev", ""),
}


def default_output(source: Path) -> Path:
    """Where the plugin of a source is built: libpush.so beside push.cc, as worlds name it."""
    stem = source.stem
    return source.with_name(f"{stem if stem.startswith('lib') else f'lib{stem}'}.so")


def build(
    sources: Sequence[Path],
    output: Path,
    *,
    debug: bool = False,
    standard: str | None = None,
    options: Sequence[str] = (),
    libraries: Sequence[str] = (),
    progress: Progress = lambda _line: None,
) -> list[CompileError]:
    """Compile and link a plugin; the errors, which are none if there is now a new file.

    The library that it needs is built first, which takes about a minute once.

    Args:
        sources: C++ files.
        output: the shared object; it is replaced as a whole, so that servers that use it run on.
        debug: without optimization, and with all that gdb needs.
        standard: of the language; None: that of the headers.
        options: further ones of the compiler, such as ``-Ifolder``.
        libraries: further ones of the linker, such as ``-lm``.
        progress: is given a line now and then.

    Raises:
        LibraryError: there is no compiler, or a package is missing.
        ParameterError: a source cannot be read, or the output cannot be written.
    """
    own_words = source_words(sources)
    qt = QtSources(sources, options)
    library = built(progress)
    quality = ["-g3", "-O0"] if debug else ["-O2"]
    try:
        with tempfile.TemporaryDirectory(dir=output.parent) as folder:
            new = Path(folder) / output.name
            words = [*own_words, *qt.make(Path(folder)), *libraries, *library.linker_flags(), *qt.libraries()]

            def compiled(version: Sequence[str]) -> list[CompileError]:
                own = _command(library.compiler_flags(), standard, [*quality, *version, *options, *qt.flags(folder)])
                return run_compiler([*own, "-shared", "-o", str(new), *words], _hint)

            errors = _either(compiled, sources)
            if not errors:
                new.replace(output)
            return errors
    except LibraryError:  # which is an OSError, too
        raise
    except OSError as error:
        raise ParameterError(f"cannot write {output}: {error.strerror}") from None


def check(
    sources: Sequence[Path],
    *,
    standard: str | None = None,
    options: Sequence[str] = (),
    progress: Progress = lambda _line: None,
) -> list[CompileError]:
    """Compile only; the errors.

    Raises:
        LibraryError: there is no compiler, or a package is missing.
        ParameterError: a source cannot be read.
    """
    named = zip(sources, source_words(sources), strict=True)
    flags = built(progress).compiler_flags()
    found: list[CompileError] = []
    for source, word in named:
        qt = QtSources([source], options)
        with tempfile.TemporaryDirectory() as folder:
            qt.make(Path(folder))

            given = [*options, *qt.flags(folder)], word

            def compiled(version: Sequence[str], given: tuple[Sequence[str], str] = given) -> list[CompileError]:
                words = [*_command(flags, standard, [*version, *given[0]]), "-fsyntax-only", given[1]]
                return run_compiler(words, _hint)

            found += _either(compiled, [source])
    return found


def _hint(message: str) -> str:
    """What helps against a message of compiler or linker."""
    match = _MISSING.search(message)
    if "libgz_new_plugin" in message and "definition" in message:
        return "; a plugin has one GZ_REGISTER_..._PLUGIN"
    if match is None:
        return ""
    name = match[1] or match[2]
    if name.startswith("gazebo/"):
        return "; libgz has no such header"
    for begin, (package, folder) in PACKAGES.items():
        if name.startswith(begin):
            return f"; apt-get install {package}" + (f", and -I{folder}" if folder else "")
    return "; is its directory missing? Name it by -I"


def _either(compiled: Callable[[Sequence[str]], list[CompileError]], sources: Sequence[Path]) -> list[CompileError]:
    """The errors of sources by the present names, or none if those of Gazebo 7 are what they need."""
    version = version_flags(sources)
    errors = compiled(version)
    if errors and not version and asks_for_old_names(sources, [error.message for error in errors]):
        return compiled(OLD_NAMES) and errors
    return errors


def _command(flags: Sequence[str], standard: str | None, options: Sequence[str]) -> list[str]:
    own = [flag for flag in flags if not flag.startswith("-std=")]
    chosen = [f"-std={standard or STANDARD}", "-w", EXACT, *own]
    return [*compiler(), *chosen, *shlex.split(os.environ.get("CXXFLAGS", "")), *options]
