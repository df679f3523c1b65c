"""The Pythonic client: connect, open interfaces by name, wait for news."""

from __future__ import annotations

from types import TracebackType
from typing import TypeVar

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

I = TypeVar("I", bound="Interface")  # type: ignore[type-arg]  # noqa: E741


class Client(WireClient):
    """A program's connection to a running server::

        with libgz.Client(server_id=0) as client:
            robot = client.position("robot1")
            robot.command(vx=0.2, vyaw=0.1)
            while client.wait(timeout=1.0):
                print(robot.pose)

    Args:
        server_id: the server's `-s` option.
        client_id: 0 to 7 for users' programs; each program that waits needs its own.
        timeout: how long to wait for the server to appear [s].

    Raises:
        ServerError: the server is not there, or not in time.
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
        """Open an interface object, or give the one of this kind and id that is open already.

        One whose model was removed and made anew is opened anew, too; the old object keeps what was last known.

        Raises:
            InterfaceError: the server serves none of this type and id.
        """
        for opened in self.opened:
            if type(opened) is type(interface) and opened.id == id and not opened.replaced:
                return opened
        interface.open(self, id)
        return interface

    def sim(self) -> Sim:
        """The clock, and the buttons pause, reset and save."""
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
        """A camera's pictures."""
        return self.open(Camera(), id)

    def guicam(self, id: str) -> Guicam:
        """An observer's camera."""
        return self.open(Guicam(), id)

    def stereo(self, id: str) -> Stereo:
        """A stereo camera's pictures and disparities."""
        return self.open(Stereo(), id)

    def factory(self, id: str) -> Factory:
        """The letter-box for new models."""
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
