"""libgz's expansion of robot descriptions beside that of the package xacro, on checkouts of public robots.

The folder ROBOTS holds the checkouts; XACRO_PYTHON is a Python that has xacro 2.1, or a venv with it is made by pip.
Compared is each file that the package expands with default arguments: elements, attributes and texts.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from lxml import etree
from trials.table import trial

from libgz.base.errors import Diagnostics, GazeboError
from libgz.base.files import read_limited, xml_parser
from libgz.sdf.xacro.expansion import expand
from libgz.sdf.xml import PLACE, parse_document, tag_name

pytestmark = pytest.mark.trial

VERSION = "xacro==2.1.1"
# Prints a set of texts, whose order differs from process to process in xacro.
UNORDERED = {"test_process_fingers_parameter.xacro"}
# Expands a file by the package xacro, with packages of a table; prints the time it took.
ORACLE = """
import json, sys, time
import xacro, xacro.substitution_args as substitution
packages = json.loads(open(sys.argv[1]).read())
substitution._eval_find = lambda name: packages[name]
for line in sys.stdin:
    name, target = json.loads(line)
    begin = time.perf_counter()
    try:
        document = xacro.process_file(name)
        text, took = document.toxml(), time.perf_counter() - begin
        open(target, "w", encoding="utf-8").write(text)
        print(json.dumps([took, ""]), flush=True)
    except BaseException as error:
        print(json.dumps([0, f"{type(error).__name__}: {error}"]), flush=True)
"""


def oracle_python(folder: Path) -> str:
    """A Python with the package xacro."""
    if "XACRO_PYTHON" in os.environ:
        return os.environ["XACRO_PYTHON"]
    python = folder / "venv" / "bin" / "python"
    subprocess.run([sys.executable, "-m", "venv", folder / "venv"], check=True)
    done = subprocess.run([python, "-m", "pip", "install", "-q", VERSION], capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"pip cannot install {VERSION}; set XACRO_PYTHON to a Python that has it")
    return str(python)


def packages(robots: Path) -> dict[str, str]:
    """Packages of ROS below a folder, by the names in their manifests or of their folders."""
    found: dict[str, str] = {}
    for manifest in sorted([*robots.rglob("package.xml"), *robots.rglob("manifest.xml")]):
        try:
            name = (etree.parse(manifest, xml_parser()).getroot().findtext("name") or "").strip()
        except etree.XMLSyntaxError:
            name = ""
        found.setdefault(name or manifest.parent.name, str(manifest.parent))
        found.setdefault(manifest.parent.name, str(manifest.parent))
    return found


def canonical(element: etree._Element) -> object:
    """An element as names, attributes and texts, without what a reader ignores."""
    attributes = {
        (f"xml:{key.rpartition('}')[2]}" if key.startswith("{http://www.w3.org/XML") else key.rpartition("}")[2]): value
        for key, value in element.attrib.items()
        if key != PLACE
    }
    inside: list[object] = []
    text = element.text or ""
    for child in element:
        if isinstance(child.tag, str):
            inside += [" ".join(text.split()), canonical(child)]
            text = child.tail or ""
        else:
            text += child.tail or ""
    inside.append(" ".join(text.split()))
    return [tag_name(element), attributes, [one for one in inside if one]]


def difference(a: object, b: object, way: str = "") -> str:
    """The first difference of two canonical elements."""
    if a == b:
        return ""
    if not (isinstance(a, list) and isinstance(b, list)) or a[0] != b[0]:
        return f"{way}: {str(a)[:100]} | {str(b)[:100]}"
    way = f"{way}/{a[0]}[{a[1].get('name', '')}]"
    if a[1] != b[1]:
        return f"{way}: {a[1]} | {b[1]}"
    for one, other in zip(a[2], b[2], strict=False):
        if found := difference(one, other, way):
            return found
    return f"{way}: {len(a[2])} | {len(b[2])} parts"


def test_public_robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if "ROBOTS" not in os.environ:
        pytest.skip("ROBOTS names no folder with checkouts of robots")
    robots = Path(os.environ["ROBOTS"]).resolve()
    known = packages(robots)
    (tmp_path / "packages.json").write_text(json.dumps(known))
    links = tmp_path / "packages"  # named as their manifests say
    links.mkdir()
    for name, folder in known.items():
        (links / name).symlink_to(folder)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(links))
    # The package prints the paths that it finds: the same in both.
    (tmp_path / "packages.json").write_text(json.dumps({name: str(links / name) for name in known}))
    oracle = subprocess.Popen(
        [oracle_python(tmp_path), "-c", ORACLE, str(tmp_path / "packages.json")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert oracle.stdin is not None
    assert oracle.stdout is not None
    different, equal, refused, times = [], 0, 0, [0.0, 0.0]
    slowest: list[tuple[float, float, str]] = []
    errors: Counter[str] = Counter()
    with trial("robot descriptions beside xacro") as row:
        for path in sorted(path for path in robots.rglob("*.xacro") if path.name not in UNORDERED):
            target = tmp_path / "expanded.xml"
            oracle.stdin.write(json.dumps([str(path), str(target)]) + "\n")
            oracle.stdin.flush()
            theirs, error = json.loads(oracle.stdout.readline())
            begin = time.perf_counter()
            problem = ""
            try:
                root = parse_document(read_limited(path), str(path), Diagnostics())
                ours = expand(root, str(path), Diagnostics(), path=path)
            except GazeboError as failure:
                ours, problem = None, str(failure)
            took = time.perf_counter() - begin
            if error:
                refused += 1
                errors[error.splitlines()[0][:60]] += 1
                if ours is not None and os.environ.get("SHOW_LENIENT"):
                    print(f"only libgz expands {path.relative_to(robots)}: {error[:200]}")
                continue
            if ours is not None:
                expected = etree.fromstring(target.read_bytes(), xml_parser())
                problem = difference(canonical(expected), canonical(ours))
            if problem:
                different.append(f"{path.relative_to(robots)}: {problem[:400]}")
            else:
                equal += 1
                times[0] += theirs
                times[1] += took
                slowest.append((theirs, took, str(path.relative_to(robots))))
        oracle.stdin.close()
        oracle.stdout.close()
        oracle.wait()
        row.count = equal + len(different)
        row.result = f"{equal} equal, {len(different)} different; xacro refuses {refused}"
    print(f"seconds of xacro and of libgz: {times[0]:.1f}, {times[1]:.1f}")
    for theirs, took, name in sorted(slowest, reverse=True)[:8]:
        print(f"  {theirs:.2f} {took:.2f} {name}")
    print("xacro refuses:", *errors.most_common(12), sep="\n  ")
    assert not different, "\n".join(different)
