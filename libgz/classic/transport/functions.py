"""The free functions of transport, under their old names."""

from __future__ import annotations

import atexit
import threading
import time as clock
from typing import Any

from libgz.classic.msgs.convert import CreateRequest
from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message
from libgz.classic.transport.link import Link, connect
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.master import DEFAULT_PORT
from libgz.classic.transport.node import Node
from libgz.classic.transport.topic import log
from libgz.errors import GazeboError, ServerError

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

ANSWER_PERIOD = 0.25  # [s] between looks for an answer that was given early
PUMP_PERIOD = 0.001  # [s] between looks for messages in a client

_stopping = threading.Event()
_thread: threading.Thread | None = None


def init(masterHost: str = "", masterPort: int = 0, timeoutIterations: int = 30) -> bool:
    """Connect to a server, where this process has no link yet.

    Args:
        masterHost: The machine; empty, with `masterPort` 0, for GAZEBO_MASTER_URI.
        masterPort: The port.
        timeoutIterations: How long to try [s].

    Returns:
        Whether there is a link; if not, it has been logged why.

    Raises:
        LibraryError: the extra `libgz[net]` is not installed.
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
    """Deliver messages in a thread of its own until `stop`: for clients, where no server does it."""
    global _thread
    if _thread is None or not _thread.is_alive():
        _stopping.clear()
        _thread = threading.Thread(target=_pump, name="transport", daemon=True)
        _thread.start()
        atexit.register(stop)


def _pump() -> None:
    manager = TopicManager.Instance()
    while not _stopping.wait(PUMP_PERIOD):
        manager.ProcessNodes()


def stop() -> None:
    """End the thread of `run`; also allowed in a callback."""
    atexit.unregister(stop)
    _stopping.set()
    if _thread is not None and _thread is not threading.current_thread():
        _thread.join()


def is_stopped() -> bool:
    """Whether no thread of `run` delivers messages."""
    return _thread is None or not _thread.is_alive()


def fini() -> None:
    """End the thread, all publications and subscriptions, and the link."""
    stop()
    TopicManager.Instance().clear("")
    if Link.current is not None:
        Link.current.close()


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
    manager, topic = TopicManager.Instance(), TopicManager.Instance().topic(subscriber.GetTopic())
    end = clock.monotonic() + timeout
    if publisher.WaitForConnection(timeout):
        publisher.Publish(asked, block=True)
    again = clock.monotonic() + ANSWER_PERIOD
    while not answers and (now := clock.monotonic()) < end:
        if now >= again:  # the server may have answered before it knew that we listen
            again = now + ANSWER_PERIOD
            manager.latch(topic, subscriber)
        manager.ProcessNodes()
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
