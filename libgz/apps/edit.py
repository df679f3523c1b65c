"""libgz edit: run a world paused, with a page in the browser that edits it."""

from __future__ import annotations

import argparse
import errno
import os
from pathlib import Path

from libgz.apps.console import port_number, say, writing
from libgz.apps.untrusted import add_untrusted_option
from libgz.apps.view_process import HOST, PORT
from libgz.base.errors import ParameterError
from libgz.base.files import exists, is_file, write_whole
from libgz.reference.catalogue import NAMESPACE
from libgz.sdf.recognition import is_sdf

__all__ = ["configure", "empty_world", "run"]

LEGACY = f"""<?xml version="1.0"?>
<gz:world
  xmlns:gz="{NAMESPACE}gz"
  xmlns:model="{NAMESPACE}model"
  xmlns:param="{NAMESPACE}param">

  <param:Global>
    <gravity>0 0 -9.8</gravity>
  </param:Global>

  <model:LightSource>
    <id>sun</id>
    <xyz>-5 5 10</xyz>
  </model:LightSource>

  <model:GroundPlane>
    <id>ground</id>
    <color>0.6 0.62 0.6</color>
  </model:GroundPlane>
</gz:world>
"""
SDF = """<?xml version="1.0"?>
<sdf version="1.6">
  <world name="default">
    <include>
      <uri>model://sun</uri>
    </include>
    <include>
      <uri>model://ground_plane</uri>
    </include>
  </world>
</sdf>
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("file", type=Path, metavar="WORLD", help="the world to edit; it is created if there is none")
    parser.add_argument(
        "--sdf", action="store_true", help="create an SDF world, whatever the file's name; *.sdf and *.sdf.world are"
    )
    parser.add_argument("--no-open", action="store_true", help="only print the page's address")
    add_untrusted_option(parser)
    add = parser.add_argument
    add("--view-port", type=port_number, default=PORT, metavar="PORT", help="first port to try (default 8080)")
    add("--view-host", default=HOST, metavar="ADDRESS", help="address to bind (default 127.0.0.1)")


def empty_world(path: Path, sdf: bool = False) -> str:
    """The text of a world with ground and a sun: SDF for files ``*.sdf``, or where that is asked for."""
    return SDF if sdf or ".sdf" in path.suffixes else LEGACY


def take_free_port() -> None:
    """Take another port where that of GAZEBO_MASTER_URI is taken: several worlds can be edited at a time."""
    from libgz.classic.transport.address import get_master_uri, listening_sockets

    address = get_master_uri()
    try:
        for one in listening_sockets(address):
            one.close()
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            os.environ["GAZEBO_MASTER_URI"] = address._replace(port=0).uri


def run(options: argparse.Namespace) -> int:
    """Edit a world until Ctrl-C.

    Raises:
        ParameterError: the name is that of something else than a file.
        GazeboError: the file cannot be created.
    """
    from libgz.apps.gazebo import main

    path: Path = options.file
    if not exists(path):
        with writing():
            write_whole(path, empty_world(path, options.sdf).encode())
        say(f"{path} is new: an empty world", flush=True)
    elif not is_file(path):
        raise ParameterError(f"{str(path)!r} is no file")
    words = ["--pause", "--view", "--view-host", options.view_host, "--view-port", str(options.view_port)]
    words += [] if options.no_open else ["--open"]
    if is_sdf(path):  # -s of classic names a plugin
        take_free_port()
    else:
        words += ["-s", "auto"]
    words += ["--untrusted"] if options.untrusted else []
    return main([*words, str(path.absolute())])
