"""Simulator: the connection to the server whose interfaces Player's devices read and write. It may come and go."""

from __future__ import annotations

import json
import logging
from pathlib import Path
from typing import Any

from libgz.base.errors import GazeboError, InterfaceError
from libgz.base.geometry import GzPose, GzQuatern, GzQuaternFromEuler, GzQuaternToEuler, GzVector
from libgz.interfaces.catalog import new_interface
from libgz.interfaces.sim import Sim
from libgz.player.drivers import RefusedError, check_finite
from libgz.player.records import Values
from libgz.transport.client import Client
from libgz.transport.control import ask
from libgz.transport.interface import Interface
from libgz.transport.observer import Observer

__all__ = ["Simulator"]

log = logging.getLogger("libgz.player")

CHECK_PERIOD = 0.5  # [s] between two looks at whether the server is there
PATIENCE = 5.0  # [s] for an answer of the server


class Simulator:
    """The server with an id, and its interfaces.

    Attributes:
        server_id: of the server.
        session: grows by one whenever interfaces were closed, because another server, or a new model, has their names.
    """

    def __init__(self, server_id: int) -> None:
        self.server_id = server_id
        self.session = 0
        self._client: Client | None = None
        self._sim: Sim | None = None
        self._next_check = 0.0
        self._missed = False

    @property
    def connected(self) -> bool:
        """Whether the server is there."""
        return self._sim is not None

    @property
    def time(self) -> float:
        """Sim time [s]; 0 without a server."""
        return 0.0 if self._sim is None else float(self._sim.data.sim_time)

    def check(self, now: float) -> None:
        """Look, now and then, whether the server is there, and connect again where another has started."""
        if now < self._next_check:
            return
        self._next_check = now + CHECK_PERIOD
        if self._sim is not None and (not self._present() or self._sim.replaced):
            log.warning("server %d has ended; its devices have no data until it starts again", self.server_id)
            self.close()
            self._missed = True
        if self._sim is None:
            self._connect()
        elif self._client is not None and (gone := [one for one in self._client.opened if one.replaced]):
            for one in gone:
                one.close()
            self.session += 1

    def _present(self) -> bool:
        try:
            return Client.query(self.server_id)
        except InterfaceError:
            return False

    def _connect(self) -> None:
        client = Client()
        try:
            client.connect(self.server_id)
            if not (self._present() and Path(client.path, "sim.default").exists()):
                raise InterfaceError(f"server {self.server_id} does not appear to be running")
            self._sim = Sim()
            self._sim.open(client, "default")
        except GazeboError as error:
            self._sim = None
            if not self._missed:
                log.warning("%s; waiting for it", error)
            self._missed = True
            return
        self._client, self._missed = client, False
        self.session += 1
        log.info("connected to server %d", self.server_id)

    def open(self, kind: str, id: str) -> Interface[Any]:
        """The interface of a type and id, which devices share.

        Raises:
            InterfaceError: the server is not running, or does not serve it.
        """
        if self._client is None:
            raise InterfaceError(f"server {self.server_id} does not appear to be running")
        for opened in self._client.opened:
            if opened.type == kind and opened.id == id and not opened.replaced:
                return opened
        interface = new_interface(kind)
        interface.open(self._client, id)
        return interface

    def close(self) -> None:
        """Disconnect. Can be called twice."""
        if self._client is not None:
            self._client.disconnect()
        self._client = self._sim = None

    # Requests about models, which the server itself answers; called in a thread of their own -------------------------

    def answer(self, name: str, values: Values) -> Values | None:
        """Answer a request of the simulation interface; what to reply, None for nothing.

        Raises:
            RefusedError: there is no such model, a number is not finite, or the server does not answer.
        """
        check_finite(values)
        model = str(values["name"])
        if not model:
            raise RefusedError("the request names no model")
        try:
            if name.startswith("get"):
                return self._get_pose(model)
            self._set_pose(model, values)
            return None
        except RefusedError:
            raise
        except GazeboError as error:
            raise RefusedError(str(error)) from None

    def _get_pose(self, model: str) -> Values:
        with Observer(self.server_id, timeout=PATIENCE) as observer:
            pose = observer.pose(model)
        angles = GzQuaternToEuler(pose.rot)
        found = dict(zip(("px", "py", "pz", "roll", "pitch", "yaw"), (*pose.pos, *angles), strict=True))
        return {**found, "name": model, "pa": angles[2], "time": self.time}

    def _set_pose(self, model: str, values: Values) -> None:
        """Move a model, and wait until it is there; a pose in the plane keeps height, roll and pitch."""
        old = self._get_pose(model)
        given = {**old, **values}
        if "pa" in values:
            given["yaw"] = values["pa"]
        rotation = GzQuaternFromEuler(*(float(given[name]) for name in ("roll", "pitch", "yaw")))
        pose = GzPose(GzVector(*(float(given[name]) for name in ("px", "py", "pz"))), GzQuatern(*rotation))
        content = {"name": model, "pose": [*pose.pos, *pose.rot]}
        ask(self.server_id, "move", "-", json.dumps(content).encode(), timeout=PATIENCE)
        with Observer(self.server_id) as observer:
            observer.wait(newer_than=observer.state(), timeout=PATIENCE)
