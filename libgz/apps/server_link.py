"""What the commands for SDF worlds share: a link to a running server, and questions to its world."""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Iterator
from typing import Any

from libgz.classic import msgs
from libgz.classic.msgs.declare import message_type
from libgz.classic.transport import Link, Node, connect
from libgz.classic.transport.functions import request
from libgz.errors import GazeboError, NotFoundError

__all__ = ["add_world", "ask", "publish", "world_node"]

PATIENCE = 5.0  # [s] for a server, a subscriber or an answer


def add_world(parser: argparse.ArgumentParser) -> None:
    """Add the option for the world's name."""
    parser.add_argument("-w", "--world-name", default="", metavar="WORLD", help="the world (default: the first one)")


@contextlib.contextmanager
def world_node(options: argparse.Namespace) -> Iterator[tuple[Node, Link]]:
    """A node in the world that the command line names, and the link to its server.

    Raises:
        ServerError: there is no server.
        LibraryError: the extra for topics between processes is not installed.
    """
    with connect(timeout=PATIENCE) as link:
        node = Node()
        node.Init(options.world_name)
        yield node, link


def publish(node: Node, topic: str, message: Any) -> None:
    """Send one message to the server.

    Raises:
        GazeboError: nobody listens.
    """
    publisher = node.Advertise(type(message), topic)
    if not publisher.WaitForConnection(PATIENCE):
        raise GazeboError(f"nobody listens on {node.DecodeTopicName(topic)}")
    publisher.Publish(message)


def ask(node: Node, question: str, data: str = "") -> Any:
    """The answer to a request: a message, or None where it has none.

    Raises:
        GazeboError: there was no answer.
        NotFoundError: the world has no such thing.
    """
    answer = request(node.GetTopicNamespace(), question, data, PATIENCE)
    if answer is None:
        raise GazeboError(f"world {node.GetTopicNamespace()!r} did not answer {question!r} within {PATIENCE:g} s")
    if answer.response == "nonexistent":
        listed = msgs.GzString_V.FromString(
            request(node.GetTopicNamespace(), "entity_list", "", PATIENCE).serialized_data
        )
        raise NotFoundError(f"there is no {data!r}; there are {', '.join(listed.data)}")
    return message_type(answer.type).FromString(answer.serialized_data) if answer.type else None
