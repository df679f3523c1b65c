"""The free functions of transport, under their old names."""

from __future__ import annotations

import time as clock
from typing import Any

from libgz.classic.msgs.convert import CreateRequest
from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.node import Node
from libgz.errors import GazeboError

__all__ = [
    "clear_buffers",
    "getAdvertisedTopics",
    "getTopicMsgType",
    "get_topic_namespaces",
    "pause_incoming",
    "request",
    "requestNoReply",
]


def getAdvertisedTopics(msgType: str = "") -> list[str]:
    """The full names of all topics that are published, or of those with one type (its full name)."""
    found = TopicManager.Instance().AdvertisedTopics()
    return [topic for topic, name in found.items() if msgType in ("", name)]


def getTopicMsgType(topic: str) -> str:
    """The full name of the type published on a topic (its full name), or an empty string."""
    return TopicManager.Instance().TopicMsgType(topic)


def get_topic_namespaces() -> list[str]:
    """The names of all worlds."""
    return TopicManager.Instance().GetTopicNamespaces()


def pause_incoming(pause: bool) -> None:
    """Hold all messages back, or deliver them again."""
    TopicManager.Instance().PauseIncoming(pause)


def clear_buffers() -> None:
    """Forget all messages that wait."""
    TopicManager.Instance().ClearBuffers()


def request(worldName: str, request: str, data: str = "", timeout: float = 10.0) -> Any:
    """Ask a world something by `~/request`, and wait for its Response.

    Delivers messages while it waits, so that it also works in the world's own process, but not in a callback.

    Args:
        worldName: The world, or an empty string for the first one.
        request: What is asked, such as `scene_info`.
        data: What belongs to it, such as a name.
        timeout: How long to wait at most [s].

    Raises:
        GazeboError: no answer came in time.
    """
    node = Node()
    node.Init(worldName)
    asked = CreateRequest(request, data)
    answers: list[Message] = []

    def OnResponse(response: Any) -> None:
        if response.id == asked.id and response.request == asked.request:
            answers.append(response)

    subscriber = node.Subscribe("~/response", OnResponse)
    publisher = node.Advertise(message_type("Request"), "~/request")
    end = clock.monotonic() + timeout
    publisher.WaitForConnection(timeout)
    publisher.Publish(asked, block=True)
    while not answers and clock.monotonic() < end:
        TopicManager.Instance().ProcessNodes()
        clock.sleep(0.001)
    subscriber.Unsubscribe()
    if not answers:
        raise GazeboError(f"world {node.GetTopicNamespace()!r} did not answer the request {request!r} in {timeout:g} s")
    return answers[0]


def requestNoReply(worldName: str | Node, request: str, data: str = "") -> None:
    """Ask something of a world, given by its name or by a node, and wait for nothing."""
    if isinstance(worldName, Node):
        node = worldName
    else:
        node = Node()
        node.Init(worldName)
    publisher = node.Advertise(message_type("Request"), "~/request")
    publisher.Publish(CreateRequest(request, data))
