"""Shared by the commands for SDF worlds: connecting to a running server, requests, and receiving messages."""

from __future__ import annotations

import argparse
import contextlib
import math
import time
from collections.abc import Iterator
from typing import Any

from libgz.base.errors import GazeboError, NotFoundError
from libgz.classic import msgs
from libgz.classic.msgs.declare import message_type
from libgz.classic.transport import Link, Node, TopicManager, connect
from libgz.classic.transport.functions import request

__all__ = ["PATIENCE", "add_duration", "add_world", "ask", "publish", "receive", "world_node"]

PATIENCE = 5.0  # [s] to wait for a server, a subscriber or a response
NAP = 0.002  # [s] between checks for messages


def add_world(parser: argparse.ArgumentParser) -> None:
    """Add the option for the world's name."""
    parser.add_argument(
        "-w", "--world-name", default="", metavar="WORLD", help="name of the world (default: the first one)"
    )


@contextlib.contextmanager
def world_node(options: argparse.Namespace) -> Iterator[tuple[Node, Link]]:
    """A node in the world given on the command line, and the link to its server.

    Raises:
        ServerError: there is no server.
        LibraryError: the extra for topics between processes is not installed.
    """
    with connect(timeout=PATIENCE) as link:
        node = Node()
        node.Init(options.world_name)
        yield node, link


def add_duration(parser: argparse.ArgumentParser) -> None:
    """Add the option for the duration of receiving."""
    help_ = "duration in real time [s] (default: until interrupted)"
    parser.add_argument("-d", "--duration", type=float, default=None, metavar="S", help=help_)


def receive(link: Link, duration: float | None) -> Iterator[float]:
    """Call back subscribers until a duration [s] is over, if one is given; yields the real time now and then [s].

    Raises:
        GazeboError: the server ended.
    """
    end = math.inf if duration is None else time.monotonic() + duration
    while (now := time.monotonic()) < end:
        TopicManager.Instance().ProcessNodes()
        yield now
        if not link.connected():
            raise GazeboError("the server has ended")
        time.sleep(NAP)
    TopicManager.Instance().ProcessNodes()


def publish(node: Node, topic: str, message: Any, patience: float = PATIENCE) -> None:
    """Publish one message, after waiting at most `patience` [s] for a subscriber.

    Raises:
        GazeboError: the topic has no subscribers.
    """
    publisher = node.Advertise(type(message), topic)
    if not publisher.WaitForConnection(patience):
        raise GazeboError(f"{node.DecodeTopicName(topic)} has no subscribers")
    publisher.Publish(message)


def ask(node: Node, question: str, data: str = "") -> Any:
    """The response to a request: a message, or None if the response has none.

    Raises:
        GazeboError: there was no response.
        NotFoundError: the world has no entity of this name.
    """
    answer = request(node.GetTopicNamespace(), question, data, PATIENCE)
    if answer is None:
        raise GazeboError(f"world {node.GetTopicNamespace()!r} did not respond to {question!r} within {PATIENCE:g} s")
    if answer.response == "nonexistent":
        listed = msgs.Model_V.FromString(request(node.GetTopicNamespace(), "entity_list", "", PATIENCE).serialized_data)
        raise NotFoundError(f"there is no {data!r}; there are {', '.join(model.name for model in listed.models)}")
    return message_type(answer.type).FromString(answer.serialized_data) if answer.type else None
