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
from libgz.classic.server import attach

RECORDED = Path(__file__).parents[1] / "data" / "beside.tsv"
PLUGIN = Path(__file__).parents[1] / "data" / "beside" / "follow.cc"
OURS = "<plugin name='follow' filename='libfollow.so'/></world>"


def followed(beside):
    """{link: position and rotation} after all iterations, in this process."""
    with libgz.World.from_string(beside.text) as world:
        kept, done = [], 0
        for iteration, topic, speed, turn in beside.commands:
            world.step(iteration - done)  # what is published now is delivered at the end of the next iteration
            done = iteration
            message = msgs.Pose()
            msgs.Set(message, Pose3d(speed, 0.0, 0.0, 0.0, 0.0, turn))
            kept.append(send(topic, message))
        world.step(STEPS - done)
        return {
            link.GetScopedName(): [*link.WorldPose().Pos(), *link.WorldPose().Rot()]
            for model in attach(world).world.Models()
            for link in model.GetLinks()
        }


def environment(beside, file, **more):
    """What the plugin in C++ reads."""
    commands = "\n".join(" ".join(map(str, command)) for command in beside.commands)
    return {"FOLLOW_STEPS": str(STEPS), "FOLLOW_FILE": str(file), "FOLLOW_COMMANDS": commands, **more}


def read(file):
    """What the plugin in C++ has written."""
    lines = [line.split("\t") for line in file.read_text().splitlines()]
    return {link: [float(number) for number in numbers] for link, *numbers in lines}


class RealGazebo:
    """The real gzserver in a root of its own, which has g++ and Gazebo's headers.

    Args:
        root: the root directory.
    """

    def __init__(self, root):
        self.folder = Path(root) / "beside"
        self.folder.mkdir(exist_ok=True)
        self._root = root
        shutil.copy(PLUGIN, self.folder)
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
        file = self.folder / "poses.tsv"
        file.unlink(missing_ok=True)
        plugins = "/beside:/usr/lib/x86_64-linux-gnu/gazebo-11/plugins"
        variables = {
            "GAZEBO_PLUGIN_PATH": plugins,
            "GAZEBO_MODEL_DATABASE_URI": "",
            "GAZEBO_MASTER_URI": "http://127.0.0.1:11397",
        }
        self._run("timeout 120 gzserver /beside/own.world", environment(beside, "/beside/poses.tsv", **variables))
        return read(file)


def run_server(beside, folder, plugins):
    """{link: position and rotation} after all iterations of libgz's gzserver with the plugin in C++."""
    (folder / "own.world").write_text(beside.text.replace("</world>", OURS))
    file = folder / "poses.tsv"
    variables = environment(beside, file, GAZEBO_PLUGIN_PATH=str(plugins), GAZEBO_MASTER_URI="http://127.0.0.1:11398")
    command = [sys.executable, "-P", "-m", "libgz.apps.gzserver", str(folder / "own.world")]
    subprocess.run(command, env={**os.environ, **variables}, check=True, capture_output=True, timeout=300)
    return read(file)
