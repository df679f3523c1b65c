"""Names of ROS: how a node resolves them, and what its command line and environment say about them."""

from __future__ import annotations

import logging
import os
import re
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from libgz.base.errors import ParameterError
from libgz.ros.parameters import Parameters

__all__ = ["NodeNames", "frame_with_prefix", "read_names", "read_names_of_ros2"]

log = logging.getLogger("libgz.ros")

INVALID = re.compile(r"[^\w/]", re.ASCII)
DEFAULT_MASTER = "http://localhost:11311"
ROS_ARGS = "--ros-args"  # before words for nodes of ROS 2; "--" ends them


class NodeNames(NamedTuple):
    """The name and namespace of a node, its remappings and its private parameters.

    Attributes:
        name: full, such as ``/gazebo``.
        namespace: that of relative names, such as ``/``.
        remappings: full names, as they would be -> as they are to be.
        parameters: values for private parameters; texts in ROS 1.
        master: the address of the master.
        host: what other nodes call this computer.
        address: where it listens: loopback unless ROS_IP or ROS_HOSTNAME ask for more.
        rules: in ROS 2, (node, or nothing for all; name; its new name) of what is remapped in all nodes of the process.
        values: in ROS 2, parameters of all nodes of the process.
    """

    name: str
    namespace: str
    remappings: Mapping[str, str]
    parameters: Mapping[str, Any]
    master: str
    host: str
    address: str
    rules: Sequence[tuple[str, str, str]] = ()
    values: Parameters | None = None

    def resolve(self, name: str, within: str = "") -> str:
        """The full name of a topic, service or parameter.

        Args:
            name: absolute, relative, or private with ``~``.
            within: the namespace of relative names, itself relative to that of the node.
        """
        full = self._full(name, within)
        return self.remappings.get(full, full)

    def _full(self, name: str, within: str = "") -> str:
        if name.startswith("/"):
            parts = name
        elif name.startswith("~"):
            parts = f"{self.name}/{name[1:].lstrip('/')}"
        else:
            base = within if within.startswith("/") else f"{self.namespace}/{within}"
            parts = f"{base}/{name}"
        full = "/" + "/".join(filter(None, parts.split("/")))
        valid = INVALID.sub("_", full)
        if valid != full:
            log.warning("ROS: %r is no name of ROS; %r is used instead", full, valid)
        return valid


def read_names(words: Sequence[str], address: str | None = None, name: str = "gazebo") -> NodeNames:
    """What the environment and the words of a command line say: ``a:=b``, ``__name:=x``, ``__ns:=y``, ``_p:=1``.

    Args:
        words: of the command line; those without ``:=`` are left out.
        address: where to listen, and what others call this computer; None: as ROS_HOSTNAME and ROS_IP say.
        name: of the node, if no word says otherwise.

    Raises:
        ParameterError: the address of the master is none.
    """
    pairs = [(before, after) for before, found, after in (word.partition(":=") for word in words) if found]
    special = dict(pairs)
    space = special.get("__ns") or os.environ.get("ROS_NAMESPACE", "")
    space = "/" + space.strip("/")
    own = NodeNames(
        f"{space.rstrip('/')}/{special.get('__name', name).strip('/')}",
        space,
        {},
        {},
        _master(special),
        *_host(special, address),
    )
    remappings = {own._full(a): own._full(b) for a, b in pairs if not a.startswith("_")}
    parameters = {a[1:]: b for a, b in pairs if a.startswith("_") and not a.startswith("__")}
    return own._replace(remappings=remappings, parameters=parameters)


class _Arguments:
    """The words for nodes of ROS 2 on a command line.

    Attributes:
        rules: (node, or nothing for all; name; its new name) of topics and services, ``__ns`` and ``__node``.
        values: parameters.
    """

    def __init__(self, words: Sequence[str]) -> None:
        self.rules: list[tuple[str, str, str]] = []
        self.values = Parameters()
        inside, rest = False, deque(words)
        while rest:
            word = rest.popleft()
            if word == ROS_ARGS:
                inside = True
            elif inside and word == "--":
                inside = False
            elif inside and word in VALUED:
                if not rest:
                    raise ParameterError(f"{word} after {ROS_ARGS} has no value")
                VALUED[word](self, rest.popleft())
            elif inside and word.startswith("-") and not word.startswith(("--enable-", "--disable-")):
                log.warning("ROS 2: %s after %s is not known; it is left out", word, ROS_ARGS)
            elif ":=" in word and not word.startswith("-"):
                self.remap(word)

    def remap(self, text: str) -> None:
        """A rule ``a:=b``."""
        before, found, after = text.partition(":=")
        if not found:
            raise ParameterError(f"the remapping {text!r} must have the form from:=to")
        node, _, name = before.rpartition(":")
        self.rules.append((node, name, after))

    def set(self, text: str) -> None:
        """A parameter ``name:=value`` or ``node:name:=value``."""
        before, found, value = text.partition(":=")
        node, _, name = before.rpartition(":")
        if not found or not name:
            raise ParameterError(f"the parameter {text!r} must have the form name:=value")
        self.values.set(node, name, value)

    def read(self, path: str) -> None:
        """A file of parameters."""
        self.values.read(Path(path))

    def ignore(self, text: str) -> None:
        """Something that has no effect here."""


# Words after --ros-args that have a value.
VALUED: dict[str, Callable[[_Arguments, str], None]] = {
    **dict.fromkeys(("-r", "--remap"), _Arguments.remap),
    **dict.fromkeys(("-p", "--param"), _Arguments.set),
    "--params-file": _Arguments.read,
    **dict.fromkeys(("--log-level", "--log-config-file", "--log-file-name", "-e", "--enclave"), _Arguments.ignore),
}


def read_names_of_ros2(words: Sequence[str], name: str = "gazebo") -> NodeNames:
    """What the words of a command line say in ROS 2, as its nodes read them: those between ``--ros-args`` and ``--``.

    ``-r a:=b`` remaps, ``-p name:=value`` sets a parameter, ``--params-file FILE`` reads some. ``__node:=x``,
    ``__ns:=y`` and remappings ``a:=b`` are read without these words, too.

    Args:
        words: of the command line.
        name: of the node, if no word says otherwise.

    Raises:
        NotFoundError: there is no such file of parameters.
        ParameterError: a word has no value, or not the form that it must have.
    """
    given = _Arguments(words)
    special = {before: after for node, before, after in given.rules if node in ("", name)}
    space = "/" + special.get("__ns", "").strip("/")
    own = special.get("__node") or special.get("__name") or name
    plain = NodeNames(f"{space.rstrip('/')}/{own.strip('/')}", space, {}, {}, "", "", "")
    remappings = {}
    for node, before, after in given.rules:
        if node in ("", own) and not before.startswith("_"):
            remappings[plain._full(before)] = plain._full(after)
    values = given.values
    return plain._replace(remappings=remappings, parameters=values.of(plain.name), rules=given.rules, values=values)


def _master(special: Mapping[str, str]) -> str:
    uri = special.get("__master") or os.environ.get("ROS_MASTER_URI") or DEFAULT_MASTER
    if not uri.startswith("http://"):
        raise ParameterError(f"ROS_MASTER_URI is {uri!r}; it must begin with http://, such as {DEFAULT_MASTER}")
    return uri


def _host(special: Mapping[str, str], address: str | None) -> tuple[str, str]:
    """(what others call this computer, where to listen)."""
    ip = address or special.get("__ip") or os.environ.get("ROS_IP")
    host = None if address else special.get("__hostname") or os.environ.get("ROS_HOSTNAME")
    if host:
        loopback = host == "localhost" or host.startswith("127.")
        return host, "127.0.0.1" if loopback else ""
    return (ip, ip) if ip else ("127.0.0.1", "127.0.0.1")


def frame_with_prefix(prefix: str, frame: str) -> str:
    """The name of a frame of TF with the prefix that a robot's parameter tf_prefix gives."""
    if frame.startswith("/"):
        return frame.lstrip("/")
    return f"{prefix.strip('/')}/{frame}" if prefix.strip("/") else frame
