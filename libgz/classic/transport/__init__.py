"""Topics: `Node` makes publishers and subscribers; messages are those of `libgz.classic.msgs`.

Within a process messages wait until the end of the server's iteration (`TopicManager.Instance().ProcessNodes()`).
Between processes, a server is the master of Gazebo classic's protocol (`serve`), and clients connect (`connect`, or
`init`, its original name).
"""

from __future__ import annotations

from libgz.base.exports import Exports
from libgz.classic.api import without

_exports = Exports(__name__, without(__name__))
__getattr__, __dir__ = _exports.get, _exports.names
