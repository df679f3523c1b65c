"""Interfaces served for tests."""

from libgz.interfaces.position import Position


def serve(server, kind=Position, name="robot1"):
    """A new interface on a server, with a model in its head."""
    interface = kind()
    interface.create(server, name, "Tester", 7, 3)
    return interface
