"""Compiles C++ plugins, and explains what a compiler misses."""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from libgz.base.errors import LibraryError, ParameterError, nearest
from libgz.cxx import FOLDER
from libgz.cxx.headers import INCLUDE

__all__ = [
    "STANDARD",
    "CompileError",
    "build",
    "check",
    "compiler",
    "cxxflags",
    "for_installation",
    "run_compiler",
    "source_words",
]

STANDARD = "gnu++98"  # as which old sources are compiled
# Casts of pointers to int, and other things that compilers of 2006 accepted. Python does not fuse multiply and add.
OLD = ("-fPIC", "-fpermissive", "-ffp-contract=off")
MOST_ERRORS = 20
SUFFIXES = (".cc", ".cpp", ".cxx", ".c++", ".C", ".c", ".o", ".a")  # of what a plugin is built of
FALLBACK = FOLDER / "fallback"

# Lines of sources, which a compiler shows, have any length: what is searched in them begins at a line, and ends.
LONGEST_MESSAGE = 2000  # characters
_ERROR = re.compile(
    rf"^(?P<file>[^:\n]+):(?P<line>\d+):(?:\d+:)? (?:fatal )?error: (?P<message>.{{0,{LONGEST_MESSAGE}}})", re.MULTILINE
)
_EXPANSION = re.compile(r"^(?P<file>[^:\n]+):(?P<line>\d+):(?:\d+:)? note: in expansion of macro", re.MULTILINE)
_MISSING = re.compile(r"([\w./+-]+): No such file or directory|'([\w./+-]+)' file not found")
_MEMBER = re.compile(r"'?(?:class |struct )?(\w+)'? has no member named '(\w+)'|no member named '(\w+)' in '(\w+)'")
_NAME = re.compile(
    r"'(\w+)' (?:was not declared|has not been declared|does not name a type)|undeclared identifier '(\w+)'"
)
_METHOD = re.compile(r"\b([A-Za-z_]\w+)\s*\(")
_CLASS = re.compile(r"class (\w+) : public (\w+)\n\{(.*?)\n\};", re.DOTALL)
# Packages of Debian with headers, by the beginning of their names.
PACKAGES = {
    "GL/glut": "freeglut3-dev",
    "GL/": "libgl-dev",
    "X11/": "libx11-dev",
    "boost/": "libboost-dev",
    "gsl/": "libgsl-dev",
    "lib3ds/": "lib3ds-dev",
    "libplayer": "libplayerc-dev",
    "libxml/": "libxml2-dev",
    "ode/": "libode-dev",
    "opencv": "libopencv-dev",
}
STD_NAMES = frozenset({"cerr", "cout", "endl", "list", "map", "ofstream", "ifstream", "string", "vector"})


@dataclass(frozen=True)
class CompileError:
    """One error of the compiler, with what helps."""

    file: str
    line: int
    message: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.message}"


def compiler() -> list[str]:
    """The C++ compiler's command: CXX if it is set, else c++ or g++.

    Raises:
        LibraryError: there is none.
    """
    wanted = shlex.split(os.environ.get("CXX", ""))
    for command in [wanted] if wanted else [["c++"], ["g++"]]:
        if shutil.which(command[0]):
            return command
    problem = (
        f"the compiler {wanted[0]!r}, named by CXX, is not installed" if wanted else "no C++ compiler is installed"
    )
    raise LibraryError(f"{problem}; C++ plugins need one: apt-get install g++")


def _include_flags(include: str, fallback: str) -> list[str]:
    """The options for directories of headers; those in `fallback` include ODE's and OpenGL's own where they are."""
    return [f"-I{include}", f"-I{include}/gazebo", f"-I{fallback}"]


def cxxflags() -> list[str]:
    """The compiler's options for plugins."""
    return [*OLD, *_include_flags(str(INCLUDE), str(FALLBACK))]


def for_installation() -> tuple[dict[str, bytes], str]:
    """The headers by their paths below a prefix, and the compiler's options in terms of pkg-config."""
    files = {f"include/gazebo/{path.name}": path.read_bytes() for path in sorted((INCLUDE / "gazebo").iterdir())}
    for path in sorted(FALLBACK.rglob("*.h")):
        files[f"share/libgz/{path.relative_to(FALLBACK)}"] = path.read_bytes()
    return files, " ".join([*OLD, *_include_flags("${includedir}", "${prefix}/share/libgz")])


def _command(standard: str, options: Sequence[str]) -> list[str]:
    return [*compiler(), f"-std={standard}", "-w", *cxxflags(), *shlex.split(os.environ.get("CXXFLAGS", "")), *options]


def build(
    sources: Sequence[Path],
    output: Path,
    *,
    debug: bool = False,
    standard: str = STANDARD,
    options: Sequence[str] = (),
    libraries: Sequence[str] = (),
) -> list[CompileError]:
    """Compile and link a plugin; the errors, which are none if there is now a new file.

    Args:
        sources: C++ files.
        output: the shared object; it is replaced as a whole, so that servers that use it run on.
        debug: without optimization, and with all that gdb needs.
        standard: of the language.
        options: further ones of the compiler, such as ``-Ifolder``.
        libraries: further ones of the linker, such as ``-lm``.

    Raises:
        LibraryError: there is no compiler.
        ParameterError: a source cannot be read, or the output cannot be written.
    """
    words = source_words(sources)
    quality = ["-g3", "-O0"] if debug else ["-O2"]
    try:
        with tempfile.TemporaryDirectory(dir=output.parent) as folder:
            new = Path(folder) / output.name
            command = [
                *_command(standard, [*quality, *options]),
                "-shared",
                "-o",
                str(new),
                *words,
                *libraries,
            ]
            errors = run_compiler(command)
            if not errors:
                new.replace(output)
            return errors
    except OSError as error:
        raise ParameterError(f"cannot write {output}: {error.strerror}") from None


def check(sources: Sequence[Path], *, standard: str = STANDARD, options: Sequence[str] = ()) -> list[CompileError]:
    """Compile only; the errors.

    Raises:
        LibraryError: there is no compiler.
        ParameterError: a source cannot be read.
    """
    return [
        error
        for source in source_words(sources)
        for error in run_compiler([*_command(standard, options), "-fsyntax-only", source])
    ]


def source_words(sources: Sequence[Path]) -> list[str]:
    """What names sources to a compiler, which takes ``-x.cc`` for options, and ``@x.cc`` for a file with options.

    Raises:
        ParameterError: one is not.
    """
    for source in sources:
        if not source.is_file():
            raise ParameterError(f"there is no file {str(source)!r}")
        if source.suffix not in SUFFIXES:  # which a compiler would give to the linker as a script
            raise ParameterError(f"{str(source)!r} is no C++ source: it ends with none of {', '.join(SUFFIXES)}")
        if source.name[0] == "@":  # wherever it lies: GCC hands the name on
            raise ParameterError(f"{str(source)!r} is a name that compilers take for a file with options; rename it")
    return [f"./{source}" if str(source)[0] in "-@" else str(source) for source in sources]


def run_compiler(command: list[str], hint: Callable[[str], str] | None = None) -> list[CompileError]:
    """Run the compiler; its errors, explained.

    Args:
        command: of the compiler.
        hint: what helps against a message; None: what helps models of the old API.
    """
    environment = {**os.environ, "LC_ALL": "C"}
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False, env=environment)
    if done.returncode == 0:
        return []
    found = dict.fromkeys(_explained(match, done.stderr, hint or _hint) for match in _ERROR.finditer(done.stderr))
    if not found:
        text = done.stderr.strip().splitlines()
        undefined = [line for line in text if "undefined" in line or "hidden symbol" in line or "error" in line.lower()]
        return [CompileError(command[0], 0, (undefined or text or [f"exit code {done.returncode}"])[0])]
    return list(found)[:MOST_ERRORS]


def _explained(match: re.Match[str], output: str, hint_for: Callable[[str], str]) -> CompileError:
    """An error with what helps, at its place in the plugin's own files."""
    file, line, message = match["file"], int(match["line"]), match["message"]
    if Path(file).is_relative_to(INCLUDE):
        rest = output[match.end() :]
        end = _ERROR.search(rest)
        used = _EXPANSION.search(rest, 0, end.start() if end is not None else len(rest))
        file, line = (used["file"], int(used["line"])) if used is not None else (file, line)
    hint = hint_for(message)
    return CompileError(file, line, (message.partition("; did you mean ")[0] if hint else message) + hint)


@cache
def _api() -> dict[str, tuple[str, set[str]]]:
    """The old API: class -> its base, and the names in it; under an empty name, the functions."""
    found: dict[str, tuple[str, set[str]]] = {}
    functions: set[str] = set()
    for path in sorted((INCLUDE / "gazebo").glob("*.hh")):
        text = path.read_text()
        for match in _CLASS.finditer(text):
            names = {name for name in _METHOD.findall(match[3]) if "_" not in name and name != match[1]}
            names |= set(re.findall(r"public: [\w *]+?\b(\w+);", match[3]))
            found[match[1]] = match[2], names
        functions |= set(re.findall(r"^inline [\w ]+?[ *](Gz\w+)\(", text, re.MULTILINE))
        functions |= set(re.findall(r"^#define (\w+)\(", text, re.MULTILINE))
    found[""] = "", functions
    return found


def _members(name: str) -> set[str]:
    members: set[str] = set()
    while name in _api():
        base, own = _api()[name]
        members |= own
        name = base
    return members


def _hint(message: str) -> str:
    """What helps against an error; begins with a semicolon, or is empty."""
    missing = _MISSING.search(message)
    if missing is not None:
        return _header_hint(missing[1] or missing[2])
    member = _MEMBER.search(message)
    if member is not None:
        owner, name = (member[1], member[2]) if member[1] else (member[4], member[3])
        members = _members(owner)
        return (nearest(name, members) or f"; {owner} has {', '.join(sorted(members))}") if members else ""
    name_ = _NAME.search(message)
    if name_ is not None:
        return _name_hint(name_[1] or name_[2])
    if "cast from pointer to smaller type" in message:
        return "; g++ accepts this: CXX=g++. Or pass GetIntId() and GetParentIntId()"
    if "abstract class" in message or "abstract type" in message:
        return (
            "; a model must define int Load(WorldFile *, WorldFileNode *), int Init(WorldFile *, WorldFileNode *), "
            "void Update(double) and int Fini()"
        )
    return ""


def _header_hint(name: str) -> str:
    if name.startswith("gazebo/") or name.endswith(".hh"):
        known = sorted(path.name for path in (INCLUDE / "gazebo").glob("*.hh") if not path.name.startswith("Libgz"))
        near = nearest(Path(name).name, known)
        return near or f"; the headers of the old API are {', '.join(known)}"
    package = next((package for begin, package in PACKAGES.items() if name.startswith(begin)), None)
    return f"; apt-get install {package}" if package else "; is its directory missing? Name it by -I"


def _name_hint(name: str) -> str:
    if name in STD_NAMES:
        return f"; add `using namespace std;`, or write std::{name}"
    if re.match(r"gl[A-Z]|glu[A-Z]|GL_", name):
        return (
            "; OpenGL's header is missing: apt-get install libgl-dev. Models are rendered without calls of their Render"
        )
    if re.match(r"d[A-Z]", name):
        return "; ODE's own header is missing: apt-get install libode-dev"
    if name.startswith("xml"):
        return "; apt-get install libxml2-dev; WorldFileNode has all that worldfiles contain"
    if name.startswith(("gz_", "GAZEBO_", "LIBGAZEBO_")):
        return "; add #include <gazebo.h>"
    if name in _api():
        return f"; add #include <gazebo/{name}.hh>"
    return nearest(name, {*_api()[""][1], *filter(None, _api())})
