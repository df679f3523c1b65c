"""The wheel, built once, and what must hold when it was installed and used in a fresh root."""

import importlib.metadata
import re
import shutil
import subprocess
import sys
from pathlib import Path

from fresh_root import ROOT

PROGRAM = (Path(__file__).parent / "installed_wheel.py").read_text()


DEPENDENCIES = [
    re.match(r"[\w.-]+", line)[0] for line in importlib.metadata.requires("libgz") if "extra ==" not in line
]


def build_wheel(folder):
    """Run what `make wheel` runs."""
    command = [sys.executable, str(ROOT / "scripts" / "make_wheel.py"), str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=1500, check=False)
    assert done.returncode == 0, done.stderr
    return Path(done.stdout.strip())


def use_wheel(root, wheels, *options, **environment):
    """Install the wheel from a folder of wheels in a root, and use it; returns what happened."""
    root.bind(wheels, "/wheels")
    return root.run(PROGRAM, "/wheels", *options, **environment)


def use_wheel_offline(root, wheels):
    """The same without an index: this environment's dependencies stand in for it."""
    bind_packages(root, DEPENDENCIES)
    return use_wheel(root, wheels, "--no-compile", PYTHONPATH="/packages")


def bind_packages(root, names):
    """Show distributions of this environment in the root, in /packages."""
    for name in names:
        distribution = importlib.metadata.distribution(name)
        for top in sorted({file.parts[0] for file in distribution.files if file.parts[0] != ".."}):
            if (source := Path(distribution.locate_file(top))).is_dir():
                root.bind(source, f"/packages/{top}")
            elif source.suffix == ".py":
                shutil.copy(source, root.place("/packages") / top)


def check_use(found):
    """Assert what a user expects of a machine that has Python alone."""
    for name, result in found.items():
        assert result.get("code", 0) == int(name == "camera"), (name, result)
    root = found["root"]
    assert root["user"] != 0 or root["own users"]
    assert (root["home"], root["tools"], root["libraries"]) == (["venv"], [], [])
    lines = {line[8:22].strip(): line for line in found["doctor"]["output"].splitlines()}
    assert "libgz.libs/libode" in lines["ode"]
    assert ", bundled: ODE" in lines["ode"]
    assert "libgz/ode/_step.so" in lines["step"]
    assert "missing: libOSMesa.so.8; install with apt-get install libosmesa6 (Debian, Ubuntu); " in lines["osmesa"]
    assert "missing: libEGL.so.1, libEGL_mesa.so.0, swrast_dri.so; " in lines["egl"]
    for command in (
        "apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri (Debian, Ubuntu)",
        "dnf install libglvnd-egl mesa-libEGL mesa-dri-drivers (Fedora)",
        "pacman -S libglvnd mesa (Arch)",
    ):
        assert command in lines["egl"]
        assert command in found["camera"]["messages"]
    assert float(found["client"]["output"]) > 0.1
