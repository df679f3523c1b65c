"""Running the gzserver command, and an environment for it."""

import os
import socket
import subprocess
import sys

__all__ = ["SERVER", "new_environment", "run"]

SERVER = [sys.executable, "-m", "libgz.apps.gzserver"]


def new_environment(folder):
    """Return environment variables with a home in `folder`, an unused port, and `folder` as the plugin path."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    kept = {k: v for k, v in os.environ.items() if not k.startswith("GAZEBO")}
    home = folder / "home"
    home.mkdir()
    paths = {"HOME": str(home), "TMP": str(folder), "GAZEBO_PLUGIN_PATH": str(folder)}
    return {**kept, **paths, "GAZEBO_MASTER_URI": f"http://localhost:{port}", "GAZEBO_IP": "127.0.0.1"}


def run(environment, *words, timeout=60):
    """Run gzserver with these arguments until it ends."""
    command = [*SERVER, *map(str, words)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=timeout)
