"""Runs in a fresh root: installs a wheel by pip, uses it as a user does, and prints what happened as JSON.

python installed_wheel.py FOLDER_OF_WHEELS [pip's options]
"""

import ctypes
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

WHEELS, *OPTIONS = sys.argv[1:]
HOME = Path.home()
BIN = HOME / "venv" / "bin"
WORLDS = "import libgz.base.files; print(libgz.base.files.installed_worlds())"
CLIENT = """
import libgz
with libgz.Client(server_id=0) as client:
    robot = client.position("robot1")
    robot.command(vx=0.3)
    for _ in range(300):
        client.wait(timeout=5.0)
        if robot.pose[0] > 0.1:
            break
    print(robot.pose[0])
"""
results = {}


def run(name, *command):
    """Run a command and keep its result."""
    done = subprocess.run([str(BIN / command[0]), *command[1:]], capture_output=True, text=True, timeout=600)
    results[name] = {"code": done.returncode, "output": done.stdout, "messages": done.stderr}
    return done


def loads(library):
    """Whether this root has a library."""
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True


subprocess.run([sys.executable, "-m", "venv", str(HOME / "venv")], check=True, capture_output=True)
(wheel,) = Path(WHEELS).glob("libgz-*.whl")
run("pip", "pip", "install", "--no-index", "--disable-pip-version-check", *OPTIONS, str(wheel))
results["root"] = {
    "user": os.getuid(),
    "own users": Path("/proc/self/uid_map").read_text().split()[1] != "0",  # the ids of an ordinary user's namespace
    "home": sorted(path.name for path in HOME.iterdir()),
    "python": sys.version.split()[0],
    "tools": [tool for tool in ("cc", "gcc", "clang", "make", "apt-get", "sh") if shutil.which(tool)],
    "libraries": [name for name in ("libode.so.8", "libccd.so.2", "libOSMesa.so.8", "libEGL.so.1") if loads(name)],
}
worlds = Path(run("worlds", "python", "-c", WORLDS).stdout.strip())
world = str(worlds / "pioneer2at.world")
run("doctor", "libgz", "doctor")
run("check", "libgz", "check", world)
run("gazebo", "gazebo", "-n", "--steps", "100", "pioneer2at.world")
run("camera", "gazebo", "-n", "--steps", "5", str(worlds / "ptz.world"))
run("blind camera", "gazebo", "-n", "--steps", "5", "--gl", "none", str(worlds / "ptz.world"))
server = subprocess.Popen([str(BIN / "gazebo"), world], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
for _ in range(600):
    if server.poll() is not None or run("interfaces", "libgz", "interfaces").returncode == 0:
        break
    time.sleep(0.1)
run("client", "python", "-c", CLIENT)
server.terminate()
results["server"] = {"code": server.wait(30)}
print(json.dumps(results))
