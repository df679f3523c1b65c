"""Topics: `Node` makes publishers and subscribers; messages are those of `libgz.classic.msgs`.

Within a process messages wait until the end of the server's iteration (`TopicManager.Instance().ProcessNodes()`).
Between processes, a server is the master of Gazebo classic's protocol (`serve`), and clients connect (`connect`, or
`init`, its original name).
"""

from __future__ import annotations

from libgz.classic.api import without
from libgz.classic.transport.address import get_master_uri, publicized_address
from libgz.classic.transport.functions import (
    clear_buffers,
    fini,
    get_topic_namespaces,
    getAdvertisedTopics,
    getTopicMsgType,
    init,
    is_stopped,
    pause_incoming,
    request,
    requestNoReply,
    run,
    stop,
)
from libgz.classic.transport.link import Link, connect, serve
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.node import Node
from libgz.classic.transport.publisher import Publisher
from libgz.classic.transport.subscriber import Subscriber

__all__ = [
    "Link",
    "Node",
    "Publisher",
    "Subscriber",
    "TopicManager",
    "clear_buffers",
    "connect",
    "fini",
    "getAdvertisedTopics",
    "getTopicMsgType",
    "get_master_uri",
    "get_topic_namespaces",
    "init",
    "is_stopped",
    "pause_incoming",
    "publicized_address",
    "request",
    "requestNoReply",
    "run",
    "serve",
    "stop",
]

__getattr__ = without(__name__)
