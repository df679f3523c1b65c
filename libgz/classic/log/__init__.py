"""Logs of runs: recording, reading and playback."""

from __future__ import annotations

from libgz.base.exports import Exports
from libgz.classic.api import without

_exports = Exports(__name__, without(__name__))
__getattr__, __dir__ = _exports.get, _exports.names
