"""A root of its own: one Python, the C and C++ run-time libraries, and nothing else; no ODE, OpenGL, compiler or shell.

Mount and IPC namespaces and chroot (unshare) make it. As root, commands run as user 1000; an ordinary user's own user
namespace does the same where the kernel allows it.
"""

import functools
import json
import os
import re
import shlex
import shutil
import subprocess
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
RUNTIME = ("libstdc++.so.6", "libgcc_s.so.1", "libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1")
LIBRARIES = Path("/usr/lib") / (sysconfig.get_config_var("MULTIARCH") or "")
PATHS = "import json, sys, sysconfig; print(json.dumps([sysconfig.get_paths()['stdlib'], sys.executable]))"
ENVIRONMENT = {"HOME": "/home/user", "USER": "user", "PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "LC_ALL": "C.UTF-8"}


@functools.cache
def namespace():
    """The command that makes namespaces, or None where that is not allowed."""
    own_user = [] if os.getuid() == 0 else ["--user", "--map-root-user"]
    command = ["unshare", *own_user, "--mount", "--ipc"]
    try:
        subprocess.run([*command, "true"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return command


needs_namespaces = pytest.mark.skipif(namespace() is None, reason="this user cannot make mount namespaces")


class FreshRoot:
    """A root in a folder, for one interpreter."""

    def __init__(self, folder, interpreter):
        self.folder = folder
        self.stdlib, self.python = map(Path, json.loads(output(interpreter, "-I", "-c", PATHS)))
        self.python = self.python.resolve()
        self.mounts = []
        for path in (self.stdlib, "/dev", "/proc"):
            self.bind(path, path)
        if (wheels := Path("/usr/share/python-wheels")).exists():
            self.bind(wheels, wheels)  # Debian's Python takes pip from there
        if (packages := self.stdlib / "site-packages").exists():  # others' packages are no part of the root
            self.mounts.append(f"mount -t tmpfs none {self.place(packages)}")
        self.fill()

    def bind(self, source, path):
        """Show a directory of this machine at a path of the root."""
        self.place(path).mkdir(parents=True)
        self.mounts.append(f"mount --rbind {source} {self.place(path)}")

    def fill(self):
        """Copy the interpreter and the libraries that it needs."""
        for name in ("tmp", "home/user"):
            (self.folder / name).mkdir(parents=True)
            (self.folder / name).chmod(0o1777)
        self.copy(self.python)
        self.copy_libraries(self.python, *self.stdlib.glob("lib-dynload/*.so"))
        for name in RUNTIME:
            self.copy(LIBRARIES / name)

    def copy_libraries(self, *users):
        """Copy what programs or libraries need."""
        for library in map(Path, sorted(set(re.findall(r"(/\S+) \(0x", output("ldd", *map(str, users)))))):
            if not library.is_relative_to(self.stdlib):
                self.copy(library)

    def place(self, path):
        """Where a path of the root is in the folder."""
        return self.folder / Path(path).relative_to("/")

    def copy(self, path):
        """Copy a file of this machine to the same place in the root."""
        target = self.place(path)
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists():
            shutil.copy(path, target)

    def run(self, program, *arguments, **environment):
        """Run a Python program in the root as an ordinary user with a fresh HOME; returns what it prints, as JSON."""
        (self.folder / "program.py").write_text(program)
        user = ["--userspec=1000:1000"] if os.getuid() == 0 else []
        inside = ["chroot", *user, str(self.folder), str(self.python), "-I", "/program.py", *arguments]
        command = [*namespace(), "sh", "-c", " && ".join([*self.mounts, f"exec {shlex.join(inside)}"])]
        done = subprocess.run(command, env=ENVIRONMENT | environment, capture_output=True, text=True, timeout=1500)
        assert done.returncode == 0, (done.stdout, done.stderr)
        return json.loads(done.stdout)


def output(*command):
    """What a command prints."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout
