"""Gazebo classic's `physics` names: views on the objects of the engine.

There is one view for each World, Model, Link, Joint, Collision and Light of the engine, so that `is` works; the
engine's object holds it as `view`. Poses, velocities and settings are the engine's. A view keeps its name, id, parent
and SDF element, a Link whether it is kinematic, and a Collision its bitmask while it has no contacts. All other state,
such as joint controllers, batteries and animations, is kept by its `libgz.classic.server.WorldServer`.
"""

from __future__ import annotations

from libgz.base.exports import Exports
from libgz.classic.api import without

_exports = Exports(__name__, without(__name__))
__getattr__, __dir__ = _exports.get, _exports.names
