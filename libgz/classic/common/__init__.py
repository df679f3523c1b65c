"""Common types of Gazebo classic: time, PID, animations, console, search paths, spherical coordinates."""

from __future__ import annotations

from libgz.base.errors import GazeboError
from libgz.base.exports import Exports
from libgz.classic.api import without

_exports = Exports(__name__, without(__name__))
__getattr__, __dir__ = _exports.get, _exports.names

# As `InternalError`. It is no part of a star import, where it would hide Python's own.
Exception = GazeboError  # noqa: A001 - Gazebo's name
