"""Runs of the worlds: in this process, and by a `gzserver`, that of libgz or the real one, with a plugin in C++."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from topics import send

import libgz
from beside.worlds import STEPS
from libgz.classic import msgs
from libgz.classic.math import Pose3d
from libgz.classic.sensors import SensorManager
from libgz.classic.server import attach

MEDIA = Path(libgz.__file__).parent / "sdf" / "media" / "models"
RECORDED = Path(__file__).parents[1] / "data" / "beside.tsv"
PLUGIN = Path(__file__).parents[1] / "data" / "beside" / "follow.cc"
OURS = "<plugin name='follow' filename='libfollow.so'/></world>"


def write_files(beside, folder):
    """Write the model folders that a world names, into GAZEBO_MODEL_PATH."""
    for name, content in beside.files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)


def followed(beside):
    """{link: position and rotation} after all iterations, in this process.

    Files of the world are in GAZEBO_MODEL_PATH.
    """
    with libgz.World.from_string(beside.text) as world:
        kept, done = [], 0
        for iteration, topic, *said in beside.commands:
            world.step(iteration - done)  # what is published now is delivered at the end of the next iteration
            done = iteration
            kept.append(send(topic, _message(*said)))
        world.step(STEPS - done)
        view = attach(world).world
        poses = {
            link.GetScopedName(): [*link.WorldPose().Pos(), *link.WorldPose().Rot()]
            for model in _models(view.Models())
            for link in model.GetLinks()
        }
        if beside.links:
            return {name: poses[name] for name in beside.links}
        return poses | dict(filter(None, map(_measured, SensorManager.Instance().GetSensors())))


def _message(value, turn=None):
    """A Pose of speed and turn, or a GzString."""
    if turn is None:
        return msgs.GzString(data=str(value))
    message = msgs.Pose()
    msgs.Set(message, Pose3d(value, 0.0, 0.0, 0.0, 0.0, turn))
    return message


def _models(models):
    """Models, each before those in it."""
    for model in models:
        yield model
        yield from _models(model.NestedModels())


def _measured(sensor):
    """(name, seven numbers) of a sensor, as the plugin in C++ writes them."""
    kind = sensor.Type()
    if kind == "imu":
        found = [*sensor.LinearAcceleration(), *sensor.AngularVelocity()]
    elif kind == "force_torque":
        found = [*sensor.Force(), *sensor.Torque()]
    elif kind == "ray":
        found = [*(sensor.Range(ray) for ray in range(3)), sensor.RangeCount()]
    elif kind == "sonar":
        found = [sensor.Range()]
    elif kind == "contact":
        found = [float(len(sensor.Contacts().contact) > 0)]
    else:
        return None
    return f"sensor {sensor.Name()}", found + [0.0] * (7 - len(found))


def environment(beside, file, **more):
    """What the plugin in C++ reads."""
    commands = "\n".join(" ".join(map(str, command)) for command in beside.commands)
    return {"FOLLOW_STEPS": str(STEPS), "FOLLOW_FILE": str(file), "FOLLOW_COMMANDS": commands, **more}


def read(beside, file):
    """What the plugin in C++ has written of the links that are compared."""
    lines = [line.split("\t") for line in file.read_text().splitlines()]
    found = {link: [float(number) for number in numbers] for link, *numbers in lines}
    return {link: found[link] for link in beside.links or found}


class RealGazebo:
    """The real gzserver in a root of its own, which has g++ and Gazebo's headers.

    Args:
        root: the root directory.
        plugins: folders in it, before those of its own plugins.
    """

    def __init__(self, root, plugins=""):
        self.folder = Path(root) / "beside"
        self.folder.mkdir(exist_ok=True)
        self._root, self._plugins = root, plugins
        for path in (PLUGIN, *MEDIA.glob("*.dae")):
            shutil.copy(path, self.folder)
        build = "g++ -O1 -std=c++17 -shared -fPIC follow.cc -o libfollow.so $(pkg-config --cflags gazebo)"
        self._run(f"cd /beside && {build}", {})

    def _run(self, command, variables):
        path = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/tmp"}
        subprocess.run(
            ["chroot", self._root, "sh", "-c", command], env={**path, **variables}, check=True, capture_output=True
        )

    def poses(self, beside):
        """{link: position and rotation} after all iterations."""
        (self.folder / "own.world").write_text(beside.text.replace("</world>", OURS))
        write_files(beside, self.folder / "models")
        file = self.folder / "poses.tsv"
        file.unlink(missing_ok=True)
        # Sensors are measured in other threads there, with images; in lockstep at the right iterations. In it MudPlugin
        # stops the server.
        lockstep = "<sensor" in beside.text and "MudPlugin" not in beside.text
        command = "xvfb-run -a gzserver --lockstep" if lockstep else "gzserver"
        variables = {
            "GAZEBO_PLUGIN_PATH": f"/beside:{self._plugins}:/usr/lib/x86_64-linux-gnu/gazebo-11/plugins",
            "GAZEBO_RESOURCE_PATH": "/usr/share/gazebo-11",
            "GAZEBO_MODEL_PATH": "/beside/models",
            "GAZEBO_MODEL_DATABASE_URI": "",
            "GAZEBO_MASTER_URI": "http://127.0.0.1:11397",
        }
        self._run(
            f"cd /beside && timeout 40 {command} own.world", environment(beside, "/beside/poses.tsv", **variables)
        )
        return read(beside, file)


def run_server(beside, folder, plugins):
    """{link: position and rotation} after all iterations of libgz's gzserver with plugins in C++, from some folders."""
    (folder / "own.world").write_text(beside.text.replace("</world>", OURS))
    file = folder / "poses.tsv"
    variables = environment(beside, file, GAZEBO_PLUGIN_PATH=str(plugins), GAZEBO_MASTER_URI="http://localhost:0")
    command = [sys.executable, "-P", "-m", "libgz.apps.gzserver", str(folder / "own.world")]
    subprocess.run(command, env={**os.environ, **variables}, check=True, capture_output=True, timeout=100)
    return read(beside, file)
