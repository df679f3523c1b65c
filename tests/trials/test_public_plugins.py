"""A trial: C++ plugins of Gazebo classic that the user has on disk compile unmodified.

PLUGIN_SOURCES names a directory with a folder for each project; every file that registers a plugin is compiled, with
the headers and the messages of its project. PLUGIN_RESULTS names a file that keeps the results: what compiled before
must compile again. PLUGIN_SHARE is the least share of files that must compile, such as 0.85. CXXFLAGS may name further
options of the compiler, such as -I/usr/include/eigen3. The table by kind of failure is printed: pytest -s.
"""

import collections
import concurrent.futures
import os
import re
import subprocess
from pathlib import Path

import pytest

from libgz.base.errors import LibraryError
from libgz.classic_cxx.build import check
from libgz.classic_cxx.library import built

SOURCES, RESULTS = os.environ.get("PLUGIN_SOURCES"), os.environ.get("PLUGIN_RESULTS")
SHARE = float(os.environ.get("PLUGIN_SHARE", "0"))

REGISTERS = re.compile(r"^\s*GZ_REGISTER_(WORLD|MODEL|SENSOR|SYSTEM|VISUAL|GUI)_PLUGIN\s*\(", re.MULTILINE)
HEADERS = (".h", ".hh", ".hpp", ".hxx")
CODE = (*HEADERS, ".cc", ".cpp", ".cxx")
COMPILES = "compiles"
KINDS = {
    "windows of Qt": r"Q_OBJECT|\bQ[A-Z]\w+|\bQt|gazebo/gui/|'gui' (has not|is not)|gui::",
    "OGRE": r"[Oo]gre|OGRE|MovableText|RenderEngine|RTShaderSystem|SelectionBuffer",
    "other engines": r"(bullet|dart|simbody)/|DART|Simbody|Bullet",
    "ROS 2": r"rclcpp|/msg/\w+\.hpp|gazebo_ros/node\.hpp",
    "a header that is not on this computer": r"No such file or directory",
    "a name of Gazebo": r"gazebo::|has no member",
    "the rest": "",
}


def kind_of(errors):
    """The kind of failure that the first error tells of."""
    return next(kind for kind, words in KINDS.items() if re.search(words, errors[0])) if errors else COMPILES


def options_of(project, library, place):
    """The compiler's options for the headers of a project, behind those of all others, and for its messages."""
    proto = library.include / "gazebo" / "msgs" / "proto"
    own = sorted(path for path in project.rglob("*.proto") if not (proto / path.name).exists())
    place.mkdir()
    for path in own:
        folders = [f"-I{folder}" for folder in dict.fromkeys((path.parent, proto, *(one.parent for one in own)))]
        subprocess.run(["protoc", f"--cpp_out={place}", *folders, path], capture_output=True, check=False)
        if not (place / path.parent.name).exists():
            (place / path.parent.name).symlink_to(".")  # included as msgs/own.pb.h
    headers = {path.parent for path in project.rglob("*") if path.suffix in HEADERS}
    folders = sorted(headers | {folder.parent for folder in headers})
    return [f"-idirafter{folder}" for folder in (place, *folders)]


@pytest.mark.trial
@pytest.mark.skipif(not SOURCES, reason="PLUGIN_SOURCES names no directory with plugins' sources")
def test_plugins_compile_unmodified(tmp_path):
    try:
        library = built()
    except LibraryError as error:
        pytest.skip(str(error))
    found = {}
    for project in sorted(path for path in Path(SOURCES).iterdir() if path.is_dir()):
        files = [path for path in sorted(project.rglob("*")) if path.suffix in CODE and path.is_file()]
        files = [path for path in files if REGISTERS.search(path.read_text(errors="replace"))]
        options = options_of(project, library, tmp_path / project.name) if files else []
        for path in files:
            found[path.relative_to(SOURCES)] = [f"-I{path.parent}", *options]
    assert found, f"no file in {SOURCES} registers a plugin"

    def compiled(item):
        path, options = item
        try:
            return [error.message for error in check([Path(SOURCES, path)], options=options)]
        except LibraryError as error:
            return [str(error)]

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        errors = dict(zip(map(str, found), pool.map(compiled, found.items()), strict=True))
    counts = collections.Counter(map(kind_of, errors.values()))
    for path, messages in errors.items():
        print(f"{kind_of(messages)}\t{path}\t{messages[0] if messages else ''}")
    for kind, count in counts.most_common():
        print(f"{count:5} {kind}")
    lost = []
    if RESULTS:
        before = Path(RESULTS).read_text().splitlines() if Path(RESULTS).exists() else []
        known = {path for path, _, kind in (line.partition("\t") for line in before) if kind == COMPILES}
        lost = [path for path in sorted(known & errors.keys()) if errors[path]]
        lines = [f"{path}\t{COMPILES if path in lost else kind_of(messages)}\n" for path, messages in errors.items()]
        Path(RESULTS).write_text("".join(lines))  # what is lost stays so until it compiles again
    assert not lost, {path: errors[path][0] for path in lost}
    assert counts[COMPILES] >= SHARE * len(errors)
