"""The Pythonic client: connects to a server, opens interfaces by name, and waits for the server's posts."""

from __future__ import annotations

from types import TracebackType
from typing import Any, TypeVar

from libgz.base.errors import ParameterError
from libgz.interfaces.actarray import Actarray
from libgz.interfaces.camera import Camera
from libgz.interfaces.factory import Factory
from libgz.interfaces.fiducial import Fiducial
from libgz.interfaces.gps import Gps
from libgz.interfaces.gripper import Gripper
from libgz.interfaces.guicam import Guicam
from libgz.interfaces.ir import Ir
from libgz.interfaces.joint import Joints
from libgz.interfaces.laser import Laser
from libgz.interfaces.position import Position
from libgz.interfaces.power import Power
from libgz.interfaces.ptz import Ptz
from libgz.interfaces.sim import Sim
from libgz.interfaces.sonar import Sonar
from libgz.interfaces.stereo import Stereo
from libgz.interfaces.truth import Truth
from libgz.interfaces.wifi import Wifi
from libgz.transport.client import Client as WireClient
from libgz.transport.interface import Interface

__all__ = ["Client"]

I = TypeVar("I", bound=Interface[Any])  # noqa: E741


class Client(WireClient):
    """A program's connection to a running server::

        with libgz.Client(server_id=0) as client:
            robot = client.position("robot1")
            robot.command(vx=0.2, vyaw=0.1)
            while client.wait(timeout=1.0):
                print(robot.pose)

    Args:
        server_id: the server's `-s` option.
        client_id: 0 to 7 for users' programs; each program that waits needs its own. Negative: it does not wait.
        timeout: time limit for the server to become ready [s].

    Raises:
        ServerError: the server is not ready before the timeout.
        InterfaceError: the server belongs to another user.
        ParameterError: the client id or the server id is invalid.
    """

    def __init__(self, server_id: int = 0, client_id: int = 0, *, timeout: float = 0.0) -> None:
        super().__init__()
        self.connect(server_id)
        self.wait_for_server(timeout)
        self.connect_wait(server_id, client_id)

    def __enter__(self) -> Client:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.disconnect()

    def open(self, interface: I, id: str) -> I:
        """Open an interface object, or return the one of this kind and id that is open already.

        If the server has created the interface again since then, the new one is opened; the old object keeps its last
        data.

        Args:
            interface: a new interface object.
            id: the interface id.

        Raises:
            InterfaceError: the id is invalid, or the server serves no interface of this type and id.
            ParameterError: this is no interface object.
        """
        if not isinstance(interface, Interface):
            raise ParameterError(f"{interface!r} is no interface object, such as Position()")
        for opened in self.opened:
            if type(opened) is type(interface) and opened.id == id and not opened.replaced:
                return opened
        interface.open(self, id)
        return interface

    def sim(self) -> Sim:
        """The times of the simulation, and the commands pause, reset and save."""
        return self.open(Sim(), "default")

    def position(self, id: str) -> Position:
        """A robot's odometry and velocity commands."""
        return self.open(Position(), id)

    def power(self, id: str) -> Power:
        """A robot's batteries."""
        return self.open(Power(), id)

    def sonar(self, id: str) -> Sonar:
        """A robot's sonars."""
        return self.open(Sonar(), id)

    def laser(self, id: str) -> Laser:
        """A laser range-finder."""
        return self.open(Laser(), id)

    def fiducial(self, id: str) -> Fiducial:
        """The marked objects a sensor recognises."""
        return self.open(Fiducial(), id)

    def ptz(self, id: str) -> Ptz:
        """A pan-tilt-zoom head."""
        return self.open(Ptz(), id)

    def camera(self, id: str) -> Camera:
        """A camera's images."""
        return self.open(Camera(), id)

    def guicam(self, id: str) -> Guicam:
        """An observer's camera."""
        return self.open(Guicam(), id)

    def stereo(self, id: str) -> Stereo:
        """A stereo camera's images and disparities."""
        return self.open(Stereo(), id)

    def factory(self, id: str) -> Factory:
        """Requests to add and remove models."""
        return self.open(Factory(), id)

    def gps(self, id: str) -> Gps:
        """A satellite navigation receiver."""
        return self.open(Gps(), id)

    def gripper(self, id: str) -> Gripper:
        """A gripper."""
        return self.open(Gripper(), id)

    def truth(self, id: str) -> Truth:
        """A model's true pose."""
        return self.open(Truth(), id)

    def wifi(self, id: str) -> Wifi:
        """A robot's wireless links."""
        return self.open(Wifi(), id)

    def joint(self, id: str) -> Joints:
        """A model's joints."""
        return self.open(Joints(), id)

    def ir(self, id: str) -> Ir:
        """A robot's infrared sensors."""
        return self.open(Ir(), id)

    def actarray(self, id: str) -> Actarray:
        """An array of actuators."""
        return self.open(Actarray(), id)
