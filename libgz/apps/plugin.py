"""libgz plugin: load an edited plugin file again while its world runs: libgz plugin reload drive."""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any, NamedTuple

from libgz.apps.console import say
from libgz.base.errors import ServerError
from libgz.transport.control import ask
from libgz.transport.paths import CONTROL_SOCKET, server_directory

__all__ = ["configure", "run"]

LOADING = 60.0  # [s] that a plugin may take to load
TOPIC = "~/plugin/reload"


class _Answer(NamedTuple):
    """What a process answers: success, error or nonexistent; and what it replaced, a line each, or why it did not."""

    result: str
    text: str


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the subcommands and options."""
    commands = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    reload = commands.add_parser(
        "reload",
        help="load a plugin's edited file; if that fails, the former plugin runs on",
        epilog="Without -s, the server with id 0 is asked, and gzserver and gzclients at GAZEBO_MASTER_URI.",
    )
    reload.add_argument(
        "name",
        metavar="NAME",
        help="of the plugin (drive, robot1::drive) or its file (drive.py); or id or class of a model of a worldfile",
    )
    reload.add_argument("-s", dest="server_id", metavar="ID", type=int, default=None, help="server id")


def run(options: argparse.Namespace) -> int:
    """Ask all processes that are meant, and print what was replaced.

    Raises:
        ServerError: there is no server, or none could do it.
    """
    if options.server_id is not None:
        answers = [_ask_server(options.server_id, options.name)]
    else:
        served = Path(server_directory(0), CONTROL_SOCKET).exists()
        answers = [_ask_server(0, options.name)] if served else []
        answers += _ask_topics(options.name)
    if not answers:
        raise ServerError("there is no server with id 0 and none at GAZEBO_MASTER_URI; -s ID names another one")
    done = [answer.text for answer in answers if answer.result == "success"]
    if done:
        say("reloaded " + "\nreloaded ".join("\n".join(done).splitlines()), flush=True)
    failed = [answer.text for answer in answers if answer.result == "error"]
    failed = failed or ([answer.text for answer in answers] if not done else [])
    if failed:
        raise ServerError("\n".join(failed))
    return 0


def _ask_server(server_id: int, name: str) -> _Answer:
    """Ask a server by its id.

    Raises:
        ServerError: there is no such server.
    """
    content = json.dumps({"name": name}).encode()
    answer = json.loads(ask(server_id, "reload", content=content))
    return _Answer(answer["result"], answer["text"])


def _ask_topics(name: str) -> list[_Answer]:
    """Ask the gzserver and the gzclients of GAZEBO_MASTER_URI; their answers, none if there is no server.

    Raises:
        ServerError: one of them does not answer.
    """
    from libgz.classic import msgs
    from libgz.classic.msgs.convert import CreateRequest
    from libgz.classic.transport import Node, TopicManager, connect

    try:
        link = connect(timeout=0.0)
    except ServerError:
        return []
    with link:
        node, manager = Node(), TopicManager.Instance()
        node.Init()
        topic = node.DecodeTopicName(TOPIC)
        request = CreateRequest("plugin_reload", name)
        answers: list[_Answer] = []

        def on_response(response: Any) -> None:
            if response.id == request.id and response.request == request.request:
                answers.append(_Answer(response.response, msgs.GzString.FromString(response.serialized_data).data))

        subscriber = node.Subscribe("~/response", on_response)
        publisher = node.Advertise(type(request), TOPIC)
        asked = len(manager.TopicInfo(topic).subscriber)
        end = time.monotonic() + LOADING
        while asked and manager.remote is not None and time.monotonic() < end:
            attached = manager.remote.attached(subscriber.GetTopic())
            if attached and manager.remote.receivers(topic) >= asked:
                break
            time.sleep(0.01)
        publisher.Publish(request)
        while len(answers) < asked:
            if time.monotonic() > end or not link.connected():
                raise ServerError(f"{asked - len(answers)} of {asked} processes did not answer in {LOADING:g} s")
            manager.ProcessNodes()
            time.sleep(0.005)
    return answers
