"""Running the gzserver command, and an environment for it."""

import os

from commands import command_line, run_command
from master_uri import free_master_uri

__all__ = ["SERVER", "new_environment", "run"]

SERVER = command_line("gzserver")


def new_environment(folder):
    """Return environment variables with a home in `folder`, an unused port, and `folder` as the plugin path."""
    kept = {k: v for k, v in os.environ.items() if not k.startswith("GAZEBO")}
    home = folder / "home"
    home.mkdir()
    paths = {"HOME": str(home), "TMP": str(folder), "GAZEBO_PLUGIN_PATH": str(folder)}
    return {**kept, **paths, "GAZEBO_MASTER_URI": free_master_uri(), "GAZEBO_IP": "127.0.0.1"}


def run(environment, *words):
    """Run gzserver with these arguments until it ends, in this process."""
    return run_command("gzserver", *words, env=environment)
