"""Addresses for tests that start a server of classic messages."""

import socket


def free_master_uri():
    """A GAZEBO_MASTER_URI with a port that no server uses."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"http://localhost:{probe.getsockname()[1]}"
