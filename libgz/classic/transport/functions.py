"""The free functions of transport, with their original names."""

from __future__ import annotations

import atexit
import time as clock
from typing import Any

from libgz.base.errors import GazeboError, ServerError
from libgz.classic.msgs.convert import CreateRequest
from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message
from libgz.classic.names import takes_names
from libgz.classic.transport.address import DEFAULT_PORT
from libgz.classic.transport.link import Link, connect
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.node import Node
from libgz.classic.transport.topic import log

__all__ = [
    "clear_buffers",
    "fini",
    "getAdvertisedTopics",
    "getTopicMsgType",
    "get_topic_namespaces",
    "init",
    "is_stopped",
    "pause_incoming",
    "request",
    "requestNoReply",
    "run",
    "stop",
]


def init(masterHost: str = "", masterPort: int = 0, timeoutIterations: int = 30) -> bool:
    """Connect to a server, unless this process has a link.

    Args:
        masterHost: The machine; empty, with `masterPort` 0, for GAZEBO_MASTER_URI.
        masterPort: The port.
        timeoutIterations: How long to try [s].

    Returns:
        Whether there is a link; if not, the reason has been logged.
    """
    if Link.current is not None:
        return True
    uri = f"http://{masterHost or 'localhost'}:{masterPort or DEFAULT_PORT}" if masterHost or masterPort else None
    try:
        connect(uri, float(timeoutIterations))
    except ServerError as error:
        log.error("%s", error)
        return False
    return True


def run() -> None:
    """Deliver messages in a thread until `stop`: for clients, which have no server loop that does it."""
    TopicManager.Instance().thread.start()
    atexit.register(stop)


def stop() -> None:
    """Stop the thread of `run`; also allowed in a callback."""
    atexit.unregister(stop)
    TopicManager.Instance().thread.stop()


def is_stopped() -> bool:
    """Whether the thread of `run` is stopped."""
    return not TopicManager.Instance().thread.running


def fini() -> None:
    """Stop the thread of `run`, end all publications and subscriptions, and close the link."""
    stop()
    TopicManager.Instance().clear("")
    if Link.current is not None:
        Link.current.close()


@takes_names
def getAdvertisedTopics(msgType: str = "") -> list[str]:
    """Return the full names of all published topics, or of those with one type (its full name)."""
    found = TopicManager.Instance().AdvertisedTopics()
    return [topic for topic, name in found.items() if msgType in ("", name)]


@takes_names
def getTopicMsgType(topic: str) -> str:
    """Return the full name of the type published on a topic (its full name), or an empty string."""
    return TopicManager.Instance().TopicMsgType(topic)


def get_topic_namespaces() -> list[str]:
    """Return the names of all worlds."""
    return TopicManager.Instance().GetTopicNamespaces()


def pause_incoming(pause: bool) -> None:
    """Stop delivering messages, or deliver them again."""
    TopicManager.Instance().PauseIncoming(pause)


def clear_buffers() -> None:
    """Drop all waiting messages."""
    TopicManager.Instance().ClearBuffers()


@takes_names
def request(worldName: str, request: str, data: str = "", timeout: float = 10.0) -> Any:
    """Send a request to a world on `~/request`, and wait for its Response.

    Delivers messages while it waits, so that it also works in the world's own process, but not in a callback.

    Args:
        worldName: The world, or an empty string for the first one.
        request: The kind of request, such as `scene_info`.
        data: Its argument, such as a name.
        timeout: Longest time to wait [s].

    Raises:
        GazeboError: there was no response in time.
    """
    node = Node()
    node.Init(worldName)
    asked = CreateRequest(request, data)
    answers: list[Message] = []

    def OnResponse(response: Any) -> None:
        if response.id == asked.id and response.request == asked.request:
            answers.append(response)

    manager = TopicManager.Instance()
    end = clock.monotonic() + timeout
    subscriber = node.Subscribe("~/response", OnResponse)
    publisher = node.Advertise(message_type("Request"), "~/request")
    _wait_attached(manager, subscriber.GetTopic(), end)
    if publisher.WaitForConnection(end - clock.monotonic()):
        publisher.Publish(asked, block=True)
    while not answers and clock.monotonic() < end:
        manager.ProcessNodes()
        clock.sleep(0.001)
    subscriber.Unsubscribe()
    if not answers:
        raise GazeboError(f"world {node.GetTopicNamespace()!r} did not answer the request {request!r} in {timeout:g} s")
    return answers[0]


def _wait_attached(manager: TopicManager, topic: str, end: float) -> None:
    """Wait until the server knows of the subscription to its responses, at most to a time."""
    if manager.remote is not None and manager.remote.client:
        while not manager.remote.attached(topic) and clock.monotonic() < end:
            clock.sleep(0.001)


@takes_names
def requestNoReply(worldName: str | Node, request: str, data: str = "") -> None:
    """Send a request to a world, given by its name or by a node, and do not wait for a response."""
    if isinstance(worldName, Node):
        node = worldName
    else:
        node = Node()
        node.Init(worldName)
    publisher = node.Advertise(message_type("Request"), "~/request")
    publisher.Publish(CreateRequest(request, data))
