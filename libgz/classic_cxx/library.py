"""The library behind classic's C++ API, built once on the user's machine, and its installation for build systems.

It cannot come with the package: a plugin shares sdformat, protobuf and boost with it, whose versions are those of the
distribution. It is kept in the user's cache by a key of its sources, interpreter, compiler and distribution.
"""

from __future__ import annotations

import concurrent.futures
import fcntl
import functools
import hashlib
import itertools
import os
import platform
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

import libgz.cxx
from libgz.base.errors import LibraryError
from libgz.base.files import own_cache, write_whole
from libgz.base.manifest import Manifest
from libgz.classic.api import TABLE as CLASSIC
from libgz.classic.msgs.declare import declarations
from libgz.classic_cxx import FOLDER
from libgz.classic_cxx.generate import bodies, headers
from libgz.classic_cxx.layouts import shared
from libgz.classic_cxx.messages import proto_files
from libgz.classic_cxx.names import BASE_PLUGINS
from libgz.cxx.build import compiler

__all__ = [
    "QT",
    "Library",
    "built",
    "default_prefix",
    "ignition_part",
    "install",
    "package_flags",
    "source_key",
    "sources",
    "uninstall",
]

Progress = Callable[[str], None]

NATIVE = FOLDER / "native"
FRAME = libgz.cxx.FOLDER / "include" / "gazebo" / "LibgzFrame.h"
VERSION = (11, 15, 1)  # of Gazebo, whose names these are
FORMER = ("2.2", *range(3, VERSION[0]))  # whose folders of headers, /usr/include/gazebo-7, sources name, too
STANDARD = "c++17"
EXACT = "-ffp-contract=off"  # products and sums are rounded one by one, as in Python, whatever the processor can do
SONAME, MESSAGES = "libgazebo.so.11", "libgazebo_msgs.so.11"
IGNITION = "libgazebo_ignition.so"  # is built where ignition-transport is installed
WIDGETS = "libgazebo_widgets.so"  # is built where Qt is installed
# Names under which Makefiles link classic's parts.
PARTS = ("client", "common", "gui", "ode", "physics", "rendering", "sensors", "transport", "util")
BOOST = ("thread", "system", "filesystem", "program_options", "regex", "iostreams", "date_time")
# By which plugins of Gazebo 11 speak with ignition's tools, if it is installed; whatever does not use it is not linked.
TRANSPORT = ("ignition-transport11", "ignition-msgs8")
QT = ("Qt5Widgets",)
# Parts that are built apart, as what they need may be installed later: the packages, the source, further options.
APART = {
    IGNITION: (TRANSPORT, "ignition", ()),
    WIDGETS: (QT, "qt", ("-DQT_NO_KEYWORDS",)),  # slots is a word of Python's headers, too
}
# A header or program that is needed, and its package in Debian.
HEADERS = {
    "Python.h": "python3-dev",
    "sdf/sdf.hh": "libsdformat-dev",
    "ignition/math.hh": "libignition-math-dev",
    "google/protobuf/message.h": "libprotobuf-dev",
    "boost/shared_ptr.hpp": "libboost-dev",
    **{f"boost/{name}.hpp": f"libboost-{name.replace('_', '-')}-dev" for name in ("thread", "filesystem", "regex")},
    "boost/program_options.hpp": "libboost-program-options-dev",
    "boost/iostreams/stream.hpp": "libboost-iostreams-dev",
    "boost/date_time.hpp": "libboost-date-time-dev",
    "boost/system/error_code.hpp": "libboost-system-dev",
}
MANIFEST = Path("share", "libgz", "classic_cxx.txt")
# Files by their parts, which are compiled as one, and how. Forwards spend their time in Python, and compile faster so.
PARTS_OF = {"native": ("bridge", "library", "hot", "roscpp", "uri", "gui")}
QUALITY = {"native": "-O1"}


class Library:
    """A built library.

    Args:
        folder: with `include` and `lib`.
        key: its key.
    """

    def __init__(self, folder: Path, key: str) -> None:
        self.folder, self.key = folder, key

    @property
    def include(self) -> Path:
        """The folder of its headers."""
        return self.folder / "include" / "gazebo-11"

    @property
    def lib(self) -> Path:
        """The folder of its shared objects."""
        return self.folder / "lib"

    def compiler_flags(self) -> list[str]:
        """The compiler's options for plugins."""
        # The last one for sources that say <gazebo-11/gazebo/gazebo.hh>, which the compiler found in /usr/include.
        own = [f"-I{one}" for one in (self.include, self.include / "gazebo" / "msgs", self.include.parent)]
        return [f"-std={STANDARD}", "-fPIC", *own, *_include()]

    def linker_flags(self) -> list[str]:
        """The linker's options for plugins."""
        return [f"-L{self.lib}", "-lgazebo", "-lgazebo_msgs", *_libraries()]


# Keys ----------------------------------------------------------------------------------------------------------------


def sources() -> list[Path]:
    """The files of which the library is made; declarations of messages and records come from objects, which are there.

    All that are in this package, so that none is forgotten.
    """
    return [*sorted([*FOLDER.glob("*.py"), *FOLDER.glob("*.tsv"), *NATIVE.rglob("*.*")]), CLASSIC, FRAME]


@functools.cache
def source_key() -> str:
    """A key of the library's sources, and of the interpreter: a plugin needs a library with the same one."""
    digest = hashlib.sha256(f"{sys.implementation.cache_tag} {platform.machine()}".encode())
    for path in sources():
        digest.update(path.read_bytes())
    digest.update(repr(declarations()).encode())
    digest.update(shared().encode())
    return digest.hexdigest()[:16]


def _toolchain_key() -> str:
    """A key of what else decides whether a library and a plugin fit together."""
    release = platform.freedesktop_os_release()
    version = _output([*compiler(), "--version"]).partition("\n")[0]
    packages = package_flags("--modversion")
    text = f"{release.get('ID')} {release.get('VERSION_ID')} {version} {packages} {sysconfig.get_paths()['include']}"
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def cache_folder(*, create: bool = False) -> Path:
    """Where libraries are kept.

    Raises:
        LibraryError: it belongs to another user, or all users may write there.
        OSError: it cannot be made.
    """
    return own_cache("libgz", "classic-cxx", create=create)


def default_prefix() -> Path:
    """Where the library is installed if no directory is named: below the user's home."""
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "libgz" / "gazebo-11"


# What is needed ------------------------------------------------------------------------------------------------------


def _output(command: Sequence[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
    return done.stdout if done.returncode == 0 else ""


@functools.cache
def _packages() -> tuple[str, ...]:
    """The names by which pkg-config knows sdformat, ignition-math and protobuf."""
    known = _output(["pkg-config", "--list-all"]) if shutil.which("pkg-config") else ""
    found = re.findall(r"^(sdformat(?:9|1[0-2])) ", known, re.MULTILINE)
    newest = max(found, key=lambda name: int(name.removeprefix("sdformat")), default="sdformat12")
    return newest, "ignition-math6", "protobuf"


@functools.cache
def package_flags(option: str, packages: tuple[str, ...] = ()) -> list[str]:
    """What pkg-config says of packages, by default of those that the library needs; nothing if one is missing."""
    words = shlex.split(_output(["pkg-config", option, *(packages or _packages())]))
    # The standard is ours; folders with .. in them make messages unreadable.
    return [re.sub(r"/usr/\S*\.\./include", "/usr/include", word) for word in words if not word.startswith("-std=")]


def _boost() -> list[str]:
    return [f"-lboost_{name}" for name in BOOST]


def _include() -> list[str]:
    """The compiler's options for what plugins use beside the library."""
    return [*package_flags("--cflags"), *package_flags("--cflags", TRANSPORT)]


def _libraries() -> list[str]:
    """The linker's options for what plugins use beside the library."""
    transport = package_flags("--libs", TRANSPORT)
    if transport:
        transport = ["-Wl,--push-state,--as-needed", *transport, "-Wl,--pop-state"]
    return [*package_flags("--libs"), *_boost(), *transport]


def check_needs() -> None:
    """Check that all is installed that building needs.

    Raises:
        LibraryError: something is missing; the message names the packages of Debian.
    """
    missing: list[str] = []
    try:
        command = compiler()
    except LibraryError:
        missing.append("g++")
        command = []
    for program, package in (("pkg-config", "pkg-config"), ("protoc", "protobuf-compiler")):
        if shutil.which(program) is None:
            missing.append(package)
    text = "".join(f"#if !__has_include(<{name}>)\nlibgz_missing {name}\n#endif\n" for name in HEADERS)
    if command:
        include = [f"-I{sysconfig.get_paths()['include']}", *package_flags("--cflags")]
        done = subprocess.run(
            [*command, "-E", "-P", "-x", "c++", *include, "-"], input=text, capture_output=True, text=True, check=False
        )
        missing += [HEADERS[name] for name in re.findall(r"libgz_missing (\S+)", done.stdout)]
    else:
        missing += HEADERS.values()
    if not missing:
        return
    words = " ".join(dict.fromkeys(missing))
    rare = ("libsdformat-dev", "libignition-math-dev")
    absent = " and ".join(name for name in rare if name in missing and not _in_archive(name))
    if absent:
        raise LibraryError(
            f"C++ plugins of Gazebo classic need {absent}, which this distribution's archive does not have; "
            "use Debian 12, or build sdformat 12 and ignition-math 6 yourself and name the directory with their "
            ".pc files in PKG_CONFIG_PATH"
        )
    raise LibraryError(f"C++ plugins of Gazebo classic need packages that are missing: apt-get install {words}")


def _in_archive(package: str) -> bool:
    """Whether apt may know a package; True if there is no apt to ask."""
    if shutil.which("apt-cache") is None:
        return True
    return bool(_output(["apt-cache", "show", "--no-all-versions", package])) or not _output(
        ["apt-cache", "show", "g++"]
    )


# Building ------------------------------------------------------------------------------------------------------------


def built(progress: Progress = lambda _line: None) -> Library:
    """The library of this libgz, interpreter, compiler and distribution; it is built if it is not in the cache.

    Args:
        progress: is given a line now and then.

    Raises:
        LibraryError: a package is missing, or building fails.
    """
    check_needs()
    key = f"{source_key()}-{_toolchain_key()}"
    cache = cache_folder()
    folder = cache / key
    try:
        cache_folder(create=True)
        with (cache / f"{key}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # one process builds, the others wait for it
            if not (folder / "lib" / SONAME).exists():
                with tempfile.TemporaryDirectory(dir=cache, prefix=".build-") as place:
                    made = Path(place) / key
                    _build(made, key, folder / "lib", progress)
                    made.rename(folder)
            for name, (packages, _, _) in APART.items():
                if package_flags("--libs", packages) and not (folder / "lib" / name).exists():
                    _build_apart(name, Library(folder, key), progress)
    except LibraryError:  # which is an OSError, too
        raise
    except OSError as error:
        raise LibraryError(f"cannot build in {cache}: {error.strerror}") from None
    return Library(folder, key)


def ignition_part() -> Path:
    """The shared object that speaks with ignition-transport; the library is built first, if it is not in the cache.

    Raises:
        LibraryError: a package is missing, or building fails.
    """
    part = built().lib / IGNITION
    if not part.is_file():
        raise LibraryError("ignition-transport is not installed: apt-get install libignition-transport-dev")
    return part


def config_header(key: str, folder: Path) -> str:
    """What plugins are marked with: the key of their library, and where it is."""
    major, minor, patch = VERSION
    return f"""\
/* Written by libgz. License: Apache License 2.0. */
#ifndef LIBGZ_CONFIG_HH
#define LIBGZ_CONFIG_HH
#define LIBGZ_KEY "{key}"
#define LIBGZ_FOLDER "{folder}"
#ifndef GAZEBO_MAJOR_VERSION
#define GAZEBO_MAJOR_VERSION {major}
#endif
#define GAZEBO_MINOR_VERSION {minor}
#define GAZEBO_PATCH_VERSION {patch}
#define GAZEBO_VERSION "{major}.{minor}"
#define GAZEBO_VERSION_FULL "{major}.{minor}.{patch}"
#define GAZEBO_VERSION_HEADER "Gazebo {major}'s API, by libgz\\n"
#endif
"""


def _build(folder: Path, key: str, lib: Path, progress: Progress) -> None:
    include, sources, out = folder / "include" / "gazebo-11", folder / "src", folder / "lib"
    messages = include / "gazebo" / "msgs"
    proto = messages / "proto"
    for directory in (sources, out, proto):
        directory.mkdir(parents=True)
    progress("generating headers and messages")
    for name, text in headers().items():
        path = include / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    for former in FORMER:
        include.with_name(f"gazebo-{former}").symlink_to(include.name)
    own = include / "gazebo" / "libgz"
    for path in (NATIVE / "libgz").iterdir():
        shutil.copyfile(path, own / path.name)
    shutil.copyfile(FRAME, own / "frame.h")
    (own / "config.hh").write_text(config_header(key, lib))
    for name, text in proto_files().items():
        # Half the code; messages of plugins go through Python, which decides the speed.
        text = text.replace("package gazebo.msgs;", "package gazebo.msgs;\noption optimize_for = CODE_SIZE;")
        (proto / name).write_text(text)
    _run(["protoc", f"--cpp_out={messages}", f"-I{proto}", *sorted(proto_files())], cwd=proto)
    (sources / "messages.cc").write_text(_unity(messages))
    (sources / "api.cc").write_text(bodies())
    (sources / "shared.hh").write_text(shared())
    for path in NATIVE.glob("*.*"):
        shutil.copyfile(path, sources / path.name)
    for name, parts in PARTS_OF.items():
        (sources / f"{name}.cc").write_text("".join(f'#include "{part}.cc"\n' for part in parts))
    flags = [f"-std={STANDARD}", "-fPIC", "-g0", "-w", EXACT, f"-I{include}", f"-I{messages}"]
    flags += [f"-I{sysconfig.get_paths()['include']}", *package_flags("--cflags")]
    # The longest first.
    objects = _compile(sources, ("api", "native", "messages"), flags, progress)
    progress("linking")
    link = [*compiler(), "-shared", "-Wl,-z,now"]
    _run([*link, f"-Wl,-soname,{MESSAGES}", "-o", str(out / MESSAGES), objects.pop("messages"), "-lprotobuf"])
    (out / "libgazebo_msgs.so").symlink_to(MESSAGES)
    libraries = [f"-L{out}", "-lgazebo_msgs", *package_flags("--libs"), *_boost()]
    _run([*link, f"-Wl,-soname,{SONAME}", "-o", str(out / SONAME), *objects.values(), *libraries])
    (out / "libgazebo.so").symlink_to(SONAME)
    for name in (*(f"gazebo_{part}" for part in PARTS), *itertools.chain(*BASE_PLUGINS.values())):
        (out / f"lib{name}.so").write_text("INPUT(-lgazebo)\n")
    shutil.rmtree(sources)
    for path in messages.glob("*.pb.cc"):
        path.unlink()


def _build_apart(name: str, library: Library, progress: Progress) -> None:
    """Build a part for packages that may have been installed after the library was built."""
    packages, stem, options = APART[name]
    progress(f"compiling for {packages[0]}")
    with tempfile.TemporaryDirectory(dir=library.lib) as folder:
        made = Path(folder) / name
        flags = [*library.compiler_flags(), f"-I{sysconfig.get_paths()['include']}", *options]
        flags += [*package_flags("--cflags", packages), "-g0", "-O1", "-w", "-shared", "-Wl,-z,now"]
        libraries = [*library.linker_flags(), *package_flags("--libs", packages)]
        source = str(NATIVE / f"{stem}.cc")
        _run([*compiler(), *flags, "-Wl,-rpath,$ORIGIN", "-o", str(made), source, *libraries])
        made.rename(library.lib / name)


def _unity(messages: Path) -> str:
    """All messages as one source: their headers are read once."""
    lines: list[str] = []
    for path in sorted(messages.glob("*.pb.cc")):
        stem = path.name.partition(".")[0]
        names = ("schemas", "file_default_instances")  # which each file has
        lines += [f"#define {name} {name}_{stem}" for name in names]
        lines += [f'#include "{path.name}"', *(f"#undef {name}" for name in names)]
    return "\n".join(lines) + "\n"


def _compile(sources: Path, names: Sequence[str], flags: list[str], progress: Progress) -> dict[str, str]:
    """Compile files beside each other; their objects."""

    def one(name: str) -> str:
        output = str(sources / f"{name}.o")
        command = [*compiler(), *flags, QUALITY.get(name, "-O0"), "-c", "-o", output, str(sources / f"{name}.cc")]
        _run(command)
        progress(f"compiled {name}.cc")
        return output

    progress(f"compiling {len(names)} files: about a minute on two cores")
    with concurrent.futures.ThreadPoolExecutor(max(1, os.cpu_count() or 1)) as pool:
        return dict(zip(names, pool.map(one, names), strict=True))


def _run(command: list[str], cwd: Path | None = None) -> None:
    environment = {**os.environ, "LC_ALL": "C"}
    done = subprocess.run(
        command, capture_output=True, text=True, errors="replace", check=False, cwd=cwd, env=environment
    )
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if "error" in line.lower()] or done.stderr.splitlines()
        reason = "\n".join(lines[:5])
        raise LibraryError(f"the library of Gazebo's C++ API cannot be built: {command[0]} failed:\n{reason}")


# Installation --------------------------------------------------------------------------------------------------------

CMAKE = """\
# find_package(gazebo): Gazebo's C++ API, of libgz.
get_filename_component(_libgz_prefix "${{CMAKE_CURRENT_LIST_DIR}}/../../.." ABSOLUTE)
set(GAZEBO_FOUND TRUE)
set(gazebo_FOUND TRUE)
set(GAZEBO_VERSION {version})
set(GAZEBO_MAJOR_VERSION {major})
set(_libgz_include "${{_libgz_prefix}}/include/gazebo-11")
set(GAZEBO_INCLUDE_DIRS "${{_libgz_include}};${{_libgz_include}}/gazebo/msgs;${{_libgz_prefix}}/include;{include}")
set(GAZEBO_LIBRARY_DIRS "${{_libgz_prefix}}/lib{folders}")
set(GAZEBO_LIBRARIES "${{_libgz_prefix}}/lib/libgazebo.so;${{_libgz_prefix}}/lib/libgazebo_msgs.so;{libraries}")
set(GAZEBO_CXX_FLAGS "-std={standard} {exact}")
set(GAZEBO_LDFLAGS "-L${{_libgz_prefix}}/lib")
set(GAZEBO_PROTO_PATH "${{_libgz_prefix}}/include/gazebo-11/gazebo/msgs/proto")
set(GAZEBO_PROTO_INCLUDE_DIRS "${{_libgz_prefix}}/include/gazebo-11/gazebo/msgs")
set(GAZEBO_PROTO_LIBRARIES "${{_libgz_prefix}}/lib/libgazebo_msgs.so")
set(GAZEBO_PLUGIN_PATH "${{_libgz_prefix}}/lib/gazebo-11/plugins")
set(GAZEBO_MODEL_PATH "${{_libgz_prefix}}/share/gazebo-11/models")
set(GAZEBO_MEDIA_PATH "${{_libgz_prefix}}/share/gazebo-11/media")
find_package(Boost QUIET COMPONENTS {boost})
find_package(Protobuf QUIET)
"""
CMAKE_VERSION = """\
set(PACKAGE_VERSION {version})
if(NOT PACKAGE_FIND_VERSION VERSION_GREATER PACKAGE_VERSION)
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
  if(PACKAGE_FIND_VERSION VERSION_EQUAL PACKAGE_VERSION)
    set(PACKAGE_VERSION_EXACT TRUE)
  endif()
endif()
"""
PKG_CONFIG = """\
prefix={prefix}
libdir=${{prefix}}/lib
includedir=${{prefix}}/include
folders=-I${{includedir}}/gazebo-11 -I${{includedir}}/gazebo-11/gazebo/msgs -I${{includedir}}

Name: gazebo
Description: Gazebo's C++ API, of libgz
Version: {version}
Libs: -L${{libdir}} -lgazebo -lgazebo_msgs {libraries}
Cflags: -std={standard} {exact} ${{folders}} {include}
"""


def _registry() -> list[Path]:
    """Where cmake looks for packages of the user, in whatever directory they are: by the name that a project writes."""
    return [Path.home() / ".cmake" / "packages" / name / "libgz" for name in ("gazebo", "GAZEBO", "Gazebo")]


def install(prefix: Path | None = None, progress: Progress = lambda _line: None) -> tuple[Path, list[Path]]:
    """Build the library if needed, and copy it with what cmake and pkg-config read below a directory.

    Args:
        prefix: the directory; None: one below the user's home.
        progress: is given a line now and then.

    Returns:
        The directory, and the files that were written.

    Raises:
        LibraryError: the library cannot be built, or the directory cannot be written.
    """
    place = (prefix or default_prefix()).expanduser().absolute()
    if (place / "lib" / "libgazebo.so.0").exists():
        raise LibraryError(
            f"{place} has libgz's C library of Gazebo 0.x, whose files have the same names; name another directory"
        )
    library = built(progress)
    version = ".".join(map(str, VERSION))
    include, libraries = _include(), _libraries()
    folders = "".join(f";{word[2:]}" for word in libraries if word.startswith("-L"))
    plain = [word for word in libraries if not word.startswith("-L")]
    values = {
        "version": version,
        "major": VERSION[0],
        "standard": STANDARD,
        "exact": EXACT,
        "prefix": str(place).replace(" ", "\\ "),
        "folders": folders,
    }
    texts = {
        "lib/cmake/gazebo/gazebo-config.cmake": CMAKE.format(
            **values,
            include=";".join(word[2:] for word in include if word.startswith("-I")),
            libraries=";".join(word.removeprefix("-l") for word in plain),
            boost=" ".join(BOOST),
        ),
        "lib/cmake/gazebo/gazebo-config-version.cmake": CMAKE_VERSION.format(**values),
        "lib/pkgconfig/gazebo.pc": PKG_CONFIG.format(
            **values, include=shlex.join(include), libraries=shlex.join(libraries)
        ),
        "include/gazebo-11/gazebo/libgz/config.hh": config_header(library.key, place / "lib"),
    }
    progress(f"installing in {place}")
    uninstall(place)
    written: list[Path] = []
    try:
        for path in sorted(library.folder.rglob("*")):
            relative = path.relative_to(library.folder)
            if str(relative) in texts or (path.is_dir() and not path.is_symlink()):
                continue
            target = place / relative
            target.parent.mkdir(parents=True, exist_ok=True)
            target.unlink(missing_ok=True)
            shutil.copy(path, target, follow_symlinks=False)
            written.append(target)
        for name, text in texts.items():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            write_whole(place / name, text.encode())
            written.append(place / name)
        for entry in _registry():
            entry.parent.mkdir(parents=True, exist_ok=True)
            entry.write_text(f"{place / 'lib' / 'cmake' / 'gazebo'}\n")
        Manifest(place, MANIFEST).write(str(path.relative_to(place)) for path in written)
    except OSError as error:
        raise LibraryError(f"Gazebo's C++ API cannot be installed in {place}: {error.strerror}") from None
    return place, written


def uninstall(prefix: Path | None = None) -> list[Path]:
    """Remove what `install` has written below a directory, and nobody has changed; the files that are gone now.

    Raises:
        LibraryError: a file cannot be removed.
    """
    place = (prefix or default_prefix()).expanduser().absolute()
    manifest = Manifest(place, MANIFEST)
    if not manifest.file.is_file():
        return []
    try:
        removed = manifest.remove_all()
    except OSError as error:
        raise LibraryError(f"Gazebo's C++ API cannot be removed from {place}: {error.strerror}") from None
    for entry in _registry():
        if entry.is_file() and entry.read_text().strip() == str(place / "lib" / "cmake" / "gazebo"):
            entry.unlink()
    return removed
