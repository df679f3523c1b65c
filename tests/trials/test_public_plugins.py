"""A trial: C++ plugins of Gazebo classic that the user has on disk compile unmodified.

PLUGIN_SOURCES names a directory with a folder for each project; every file that registers a plugin is compiled, with
the headers and the messages of its project. PLUGIN_RESULTS names a file to which each result is added as it comes: what
has ever compiled must compile again, and a run that was cut short goes on where it was. PLUGIN_NEEDS names the one
column to compile, such as "no ROS". As many compilers run as the trial has processors: taskset -c 0. PLUGIN_SHARE and
PLUGIN_ROS_SHARE are the least shares that must compile, such as 0.85: of the files that need no ROS, and of those that
Debian's ROS 1 suffices for; PLUGIN_ROS is the root below which that is installed, such as /. PLUGIN_WHOLE is the share
of files that are built and loaded wholly, without the precompiled header, such as 0.1. CXXFLAGS may name further
options of the compiler, such as -I/usr/include/eigen3; those of PLUGIN_OPTIONS come after the folders of a plugin's
project. The table by kind of failure is printed: pytest -s.
"""

import collections
import concurrent.futures
import ctypes
import itertools
import json
import os
import random
import re
import shlex
import subprocess
import sys
import threading
from pathlib import Path, PurePath

import pytest

from libgz.base.errors import LibraryError
from libgz.classic_cxx.build import build, check
from libgz.classic_cxx.library import EXACT, MESSAGES, SONAME, STANDARD, built
from libgz.classic_cxx.recognition import OLD_NAMES
from libgz.cxx.build import compiler
from libgz.ros.install import install

SOURCES, RESULTS = os.environ.get("PLUGIN_SOURCES"), os.environ.get("PLUGIN_RESULTS")
SHARE = float(os.environ.get("PLUGIN_SHARE", "0"))
ROS_SHARE = float(os.environ.get("PLUGIN_ROS_SHARE", "0"))
WHOLE = float(os.environ.get("PLUGIN_WHOLE", "0"))
ROS = os.environ.get("PLUGIN_ROS")
NEEDED = os.environ.get("PLUGIN_NEEDS")
JOBS = len(os.sched_getaffinity(0))
OPTIONS = shlex.split(os.environ.get("PLUGIN_OPTIONS", ""))

REGISTERS = re.compile(r"^\s*GZ_REGISTER_(WORLD|MODEL|SENSOR|SYSTEM|VISUAL|GUI)_PLUGIN\s*\(", re.MULTILINE)
PACKAGE = re.compile(r"<name>\s*(\w+)\s*</name>")
INCLUDES = re.compile(r"^\s*#\s*include\s*[<\"]([^>\"]+)[>\"]", re.MULTILINE)
HEADERS = (".h", ".hh", ".hpp", ".hxx")
CODE = (*HEADERS, ".cc", ".cpp", ".cxx")
COMPILES = "compiles"
QT, ABSENT = "windows of Qt", "a library that is not on this computer"
KINDS = {
    QT: r"Q_OBJECT|qtbase5|\bQ[A-Z]\w+|\bQt|gazebo/gui/|'gui' (has not|is not)|gui::",
    "OGRE": r"[Oo]gre|OGRE|MovableText|RenderEngine|RTShaderSystem|selection_buffer|'create_scene|VideoVisual",
    "internals of engines": r"\b(bullet|dart|simbody|ode)/|joints/contact\.h|DART|Simbody|Bullet|\bd(Body|Geom)ID",
    "a name of Gazebo": r"^gazebo/\S+: No such file|#error <gazebo/|gazebo::|has no member",
    ABSENT: r"No such file or directory",
    "the rest": "",
}
APART = (QT, ABSENT)  # the shares are of all others
# What a plugin needs beside Gazebo, by its headers and those of its project that they include; the first that fits.
NEEDS = {
    "ROS 2": r"^rclcpp/|/(msg|srv|action)/\w+\.hpp$|^gazebo_ros/\w+\.hpp$",
    "packages for Gazebo and ROS 1": (
        r"^gazebo_(ros|plugins|msgs|ros_control)/|^control(_toolbox|_msgs|ler_manager|ler_interface)/"
        r"|^(hardware|transmission)_interface/"
    ),
    "ROS 1": r"^(ros|tf|tf2_ros|nodelet|image_transport|cv_bridge|dynamic_reconfigure)/|^\w+_(msgs|srvs)/\w+\.h$",
}
GAZEBO = re.compile(r"^(?:[\w -]+ for )?(gazebo::(?:\w+::)*?|libgz::)([A-Z]\w*)(?=::|\(|$|\[)")
# Runs programs of ROS in one process, for most of their time is Python's start.
GENERATE = """
import contextlib, json, runpy, sys
for script, *arguments in json.load(sys.stdin):
    sys.argv = [script, *arguments]
    with contextlib.suppress(Exception, SystemExit):
        runpy.run_path(script, run_name="__main__")
"""
NO_ROS, ROS_1, OLD = "no ROS", "ROS 1", "a copy of Gazebo 1 to 3"
OLD_GAZEBO = re.compile(r"GAZEBO_MAJOR_VERSION\s+[1-3]\b")


def kind_of(errors):
    """The kind of failure that the first error tells of."""
    return next(kind for kind, words in KINDS.items() if re.search(words, errors[0])) if errors else COMPILES


class Project:
    """The files of a public project, and what compiling them needs.

    Args:
        folder: of the project.
        place: for what is generated of its messages.
        library: Gazebo's C++ API.
        ros: where `libgz ros install` has installed.
    """

    def __init__(self, folder, place, library, ros):
        self.folder, self.place = folder, place
        self.files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
        code = [path for path in self.files if path.suffix in CODE]
        self.text = {path: path.read_text(errors="replace") for path in code}
        self.plugins = [path for path in code if REGISTERS.search(self.text[path])]
        self.named = collections.defaultdict(list)
        for path in code:
            self.named[path.name].append(path)
        if self.plugins:
            place.mkdir()
            self._generate_protobuf(library.include / "gazebo" / "msgs" / "proto")
            if ROS is not None:
                self._generate_ros(Path(ROS), ros)
        headers = {path.parent for path in code if path.suffix in HEADERS}
        folders = sorted(headers | {above for folder in headers for above in (folder.parent, folder.parent.parent)})
        self.sources = {path: self._source_of(path) for path in self.plugins}
        self.options = [f"-idirafter{folder}" for folder in (place, *folders, ros / "include")] + OPTIONS

    def _source_of(self, plugin):
        """The source of a plugin: of one that a header registers, a source that includes that."""
        if plugin.suffix not in HEADERS:
            return plugin
        for path, text in self.text.items():
            if path.suffix not in HEADERS and any(self._own(name, path) == plugin for name in INCLUDES.findall(text)):
                return path
        made = self.place / f"{plugin.stem}.cc"
        made.write_text(f'#include "{plugin}"\n')
        return made

    def _generate_protobuf(self, known):
        """The messages of the project's own, as headers."""
        own = [path for path in self.files if path.suffix == ".proto" and not (known / path.name).exists()]
        for path in own:
            folders = [f"-I{folder}" for folder in dict.fromkeys((path.parent, known, *(one.parent for one in own)))]
            subprocess.run(["protoc", f"--cpp_out={self.place}", *folders, path], capture_output=True, check=False)
            if not (self.place / path.parent.name).exists():
                (self.place / path.parent.name).symlink_to(".")  # included as msgs/own.pb.h

    def _generate_ros(self, root, gazebo):
        """The messages, services, actions and reconfigurations of the project's packages, as catkin makes them."""
        share, programs = root / "usr" / "share", root / "usr" / "lib"
        environment = {**os.environ, "PYTHONPATH": str(programs / "python3" / "dist-packages")}

        def run(programs):
            subprocess.run(
                [sys.executable, "-c", GENERATE],
                input=json.dumps([[str(word) for word in words] for words in programs]),
                text=True,
                capture_output=True,
                check=False,
                env=environment,
                cwd=self.place,
            )

        packages = {}
        for path in self.files:
            if path.name == "package.xml" and (name := PACKAGE.search(path.read_text(errors="replace"))):
                packages[name[1]] = path.parent.absolute()
        known = [path for folder in (share, gazebo / "share") for path in folder.glob("*/msg")]
        folders = [word for path in known for word in ("-I", f"{path.parent.name}:{path}")]
        for name, folder in packages.items():
            folders += ["-I", f"{name}:{folder / 'msg'}", "-I", f"{name}:{self.place / name / 'msg'}"]
        begin, then = [], []
        for name, folder in packages.items():
            into = self.place / name
            into.mkdir(exist_ok=True)
            begin += [(path, share / "dynamic_reconfigure", into, into, into) for path in folder.glob("cfg/*.cfg")]
            program = programs / "actionlib_msgs" / "genaction.py"
            begin += [(program, path, "-o", into / "msg") for path in folder.glob("action/*.action")]
        run(begin)
        for name, folder in packages.items():
            into = self.place / name
            options = (*folders, "-p", name, "-o", into, "-e", share / "gencpp")
            files = (*folder.glob("msg/*.msg"), *folder.glob("srv/*.srv"), *into.glob("msg/*.msg"))
            then += [(programs / "gencpp" / "gen_cpp.py", path, *options) for path in files]
        run(then)

    def _own(self, name, place):
        """The file of the project that an include means, if it is one of its own."""
        if (place.parent / name).is_file():
            return (place.parent / name).resolve()
        return next((path for path in self.named[PurePath(name).name] if str(path).endswith(f"/{name}")), None)

    def defines(self, name):
        """Whether the project, or what is generated of its messages, has a class or function of a name."""
        word = re.compile(rf"\b{re.escape(name)}\b\s*(final)?\s*[{{:(]")
        made = (path.read_text(errors="replace") for path in self.place.glob("*.pb.h"))
        return any(map(word.search, itertools.chain(self.text.values(), made)))

    def needs_of(self, plugin):
        """What a plugin needs beside Gazebo."""
        build_file = self.folder / "CMakeLists.txt"
        if build_file.is_file() and OLD_GAZEBO.search(build_file.read_text(errors="replace")):
            return OLD
        foreign, seen, todo = set(), {plugin}, [plugin]
        while todo:
            path = todo.pop()
            for name in INCLUDES.findall(self.text.get(path, "")):
                own = self._own(name, path)
                if own is None:
                    foreign.add(name)
                elif own not in seen:
                    seen.add(own)
                    todo.append(own)
        return next((need for need, words in NEEDS.items() if any(re.search(words, one) for one in foreign)), NO_ROS)


def precompiled(place, library):
    """The compiler's options for a precompiled header of the whole API, by present names and those of Gazebo 7."""
    header = place / "all.hh"
    header.write_text('#include "gazebo/libgz/gazebo.hh"\n')
    (place / "all.hh.gch").mkdir()
    flags = [f"-std={STANDARD}", "-w", EXACT, *(one for one in library.compiler_flags() if not one.startswith("-std="))]

    def compiled(version):
        output = place / "all.hh.gch" / ("old" if version else "new")
        subprocess.run([*compiler(), *flags, *version, "-x", "c++-header", header, "-o", output], check=True)

    with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
        list(pool.map(compiled, ((), OLD_NAMES)))
    return ["-include", str(header)]


def symbols(path, *which):
    """The names of a shared object that are defined, or that it wants of others."""
    command = ["nm", "-DCj", *which, str(path)]
    lines = subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()
    return {line.partition("@")[0] for line in lines}


def linked(path, options, place, project, given):
    """The errors of building a plugin wholly: names of Gazebo among them that neither libgz nor its project has.

    It is loaded, if nothing that it wants is in a library or a file that is not linked.
    """
    output = place / f"lib{path.stem}.so"
    errors = [error.message for error in build([path], output, options=options)]
    if errors:
        return errors
    missing = symbols(output, "--undefined-only") - given
    missing = [name for name in missing if (found := GAZEBO.search(name)) and not project.defines(found[2])]
    if not missing:
        try:
            ctypes.CDLL(str(output), mode=os.RTLD_LAZY)
        except OSError as error:
            if not re.search("undefined symbol|cannot open shared", str(error)):
                return [str(error)]
    return missing


def compiled(path, options):
    """The errors of compiling a file."""
    try:
        return [error.message for error in check([path], options=options)]
    except LibraryError as error:
        return [str(error)]


class Results:
    """The results of runs in a file: a line for each plugin and library, added as it comes.

    Args:
        file: the file, or None.
        key: of the library.

    Attributes:
        done: {path: its errors} with this library.
        good: the paths that have ever compiled.
    """

    def __init__(self, file, key):
        self._file, self._key = file, key
        self._lock = threading.Lock()
        lines = Path(file).read_text().splitlines() if file and Path(file).exists() else []
        rows = [line.split("\t") for line in lines]
        self.good = {path for path, kind, *_ in rows if kind == COMPILES}
        self.done = {row[0]: row[3:] for row in rows if row[2:3] == [key]}

    def add(self, path, errors):
        """Keep what came out for a plugin."""
        with self._lock:
            self.done[path] = errors
            if self._file:
                with Path(self._file).open("a") as file:
                    print(
                        path,
                        kind_of(errors),
                        self._key,
                        *(" ".join(one.split()) for one in errors[:1]),
                        sep="\t",
                        file=file,
                    )


def table_of(needs, errors):
    """Files by what they need and the kind of failure, as lines; and the share that compiles of each need."""
    lines, shares = [], {}
    for need in dict.fromkeys(needs.values()):
        counts = collections.Counter(kind_of(errors[path]) for path in errors if needs[path] == need)
        rest = counts.total() - sum(counts[kind] for kind in APART)
        shares[need] = counts[COMPILES] / max(1, rest)
        lines.append(f"{need}: {counts.total()} files, of which {shares[need]:.1%} of {rest} compile")
        lines += [f"{count:7} {kind}" for kind, count in counts.most_common()]
    return lines, shares


@pytest.mark.trial
@pytest.mark.skipif(not SOURCES, reason="PLUGIN_SOURCES names no directory with plugins' sources")
def test_plugins_compile_unmodified(tmp_path):
    try:
        library = built()
    except LibraryError as error:
        pytest.skip(str(error))
    ros = tmp_path / "ros"
    install(ros)
    needs, commands, projects = {}, {}, {}
    for folder in sorted(path for path in Path(SOURCES).iterdir() if path.is_dir()):
        project = Project(folder, tmp_path / folder.name, library, ros)
        for path, source in project.sources.items():
            name = str(path.relative_to(SOURCES))
            if NEEDED in (None, need := project.needs_of(path)):
                projects[name], needs[name] = project, need
                commands[name] = source, [f"-I{path.parent}", *project.options]
    assert commands, f"no file in {SOURCES} registers a plugin"
    results = Results(RESULTS, library.key)
    fast, ever = precompiled(tmp_path, library), set(results.good)

    def attempt(name):
        source, options = commands[name]
        results.add(name, compiled(source, [*fast, *options]))

    with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
        list(pool.map(attempt, (name for name in commands if name not in results.done)))
    errors = {name: results.done[name] for name in commands}
    for path, messages in errors.items():
        print(f"{needs[path]}\t{kind_of(messages)}\t{path}\t{messages[0] if messages else ''}")
    lines, shares = table_of(needs, errors)
    print(*lines, sep="\n")
    lost = [path for path in sorted(ever & errors.keys()) if errors[path]]
    assert not lost, {path: errors[path][0] for path in lost}
    assert shares.get(NO_ROS, 1.0) >= SHARE
    assert shares.get(ROS_1, 1.0) >= ROS_SHARE
    good = [path for path in errors if not errors[path]]
    chosen = random.Random(0).sample(good, round(WHOLE * len(good)))
    libraries = [ctypes.CDLL(str(library.lib / name), mode=os.RTLD_GLOBAL) for name in (MESSAGES, SONAME)]
    given = set().union(*(symbols(one._name, "--defined-only") for one in libraries))
    with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
        jobs = [(*commands[path], tmp_path, projects[path], given) for path in chosen]
        whole = dict(zip(chosen, pool.map(linked, *zip(*jobs, strict=True)), strict=True)) if jobs else {}
    print(f"built wholly: {len(whole)}", *(f"{path}\t{found[0]}" for path, found in whole.items() if found), sep="\n")
    assert not any(whole.values()), whole
