"""Topics: `Node` makes publishers and subscribers; messages are those of `libgz.classic.msgs`.

Within a process messages wait until the server has ended its iteration (`TopicManager.Instance().ProcessNodes()`).
"""

from __future__ import annotations

from libgz.classic.transport.functions import (
    clear_buffers,
    get_topic_namespaces,
    getAdvertisedTopics,
    getTopicMsgType,
    pause_incoming,
    request,
    requestNoReply,
)
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.node import Node
from libgz.classic.transport.publisher import Publisher
from libgz.classic.transport.subscriber import Subscriber

__all__ = [
    "Node",
    "Publisher",
    "Subscriber",
    "TopicManager",
    "clear_buffers",
    "getAdvertisedTopics",
    "getTopicMsgType",
    "get_topic_namespaces",
    "pause_incoming",
    "request",
    "requestNoReply",
]
