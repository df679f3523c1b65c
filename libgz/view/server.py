"""ServerControls: commands a running server by its control socket, and robots by their interfaces."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

from libgz.base.errors import ServerError
from libgz.base.files import exists
from libgz.interfaces.catalog import new_interface
from libgz.interfaces.client import Client
from libgz.transport.control import ask
from libgz.transport.paths import CONTROL_SOCKET, server_directory

__all__ = ["ServerControls"]

PATIENCE = 30.0  # [s] for a server whose first steps take long
ALONE = frozenset({"interfaces"})  # of a server that takes no requests, such as a program's world


class ServerControls:
    """The controls of a server. Every call is safe in every thread.

    Args:
        server_id: of the server.
        abilities: what is offered to users; None for all that the server answers. Interfaces can be read in any case.
    """

    def __init__(self, server_id: int, abilities: frozenset[str] | None = None) -> None:
        self.server_id = server_id
        self._client: Client | None = None
        self._offered = self._abilities = abilities
        self._lock = threading.Lock()

    @property
    def abilities(self) -> frozenset[str]:
        """The requests that the server answers: a log that is played has others than a world that runs.

        A server that takes requests, but does not answer in time, has none.
        """
        if self._abilities is None:
            try:
                self._abilities = frozenset(json.loads(ask(self.server_id, "abilities", timeout=PATIENCE)))
            except ServerError:
                # One that takes requests, and is slow to answer, may be one that is only watched.
                slow = exists(Path(server_directory(self.server_id), CONTROL_SOCKET))
                self._abilities = frozenset() if slow else ALONE
        return self._abilities

    def ask(self, verb: str, argument: str = "-", **content: Any) -> Any:
        """Send a request; the answer is what its JSON says, or None.

        Raises:
            ServerError: the server does not run, or refuses.
        """
        answer = ask(self.server_id, verb, argument, json.dumps(content).encode() if content else b"")
        return json.loads(answer) if answer else None

    def interface(self, kind: str, id: str) -> Any:
        """An open interface of the server.

        Raises:
            GazeboError: there is none.
        """
        with self._lock:
            if self._client is None:
                self._client = Client(self.server_id, client_id=-1)
            return self._client.open(new_interface(kind), id)

    def reconnect(self) -> None:
        """Close the connection; the next use opens another one."""
        with self._lock:
            client, self._client = self._client, None
            self._abilities = self._offered
            if client is not None:
                client.disconnect()

    close = reconnect
