"""libgz interfaces: list the interfaces of a running server."""

from __future__ import annotations

import argparse
import json
from typing import Any

from libgz.apps.console import say
from libgz.apps.target import add_server, connect
from libgz.base.errors import InterfaceError, ParameterError
from libgz.base.visible import one_line
from libgz.interfaces.catalog import new_interface
from libgz.interfaces.client import Client

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    add_server(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON array")


def run(options: argparse.Namespace) -> int:
    """Print a line for each interface.

    Raises:
        ServerError: there is no such server.
    """
    with connect(options) as client:
        rows = [_row(client, kind, name) for kind, name in client.interfaces()]
    if options.json:
        say(json.dumps(rows))
        return 0
    width = max([len(row["interface"]) for row in rows], default=0) + 2
    for row in rows:
        say(one_line(f"{row['interface']:{width}}{row['model'] or '-':16}{row['about']}"))
    return 0


def _row(client: Client, kind: str, name: str) -> dict[str, Any]:
    """The description of one interface."""
    row: dict[str, Any] = {"interface": f"{kind}.{name}", "type": kind, "id": name, "model": "", "about": ""}
    try:
        interface = client.open(new_interface(kind), name)
    except (InterfaceError, ParameterError) as error:
        row["about"] = str(error)
        return row
    row["model"] = interface.data.head.model_type.decode(errors="replace")
    row["version"] = interface.data.head.version
    row["about"] = (type(interface).__doc__ or "").partition(".")[0]
    return row
