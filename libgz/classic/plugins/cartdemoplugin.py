"""CartDemoPlugin: a cart that accelerates, brakes, drives at a speed and then to a position."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.common import PID
from libgz.classic.event import Events
from libgz.classic.math import Vector2d, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

# Until when [s] of sim time a wheel has a share of its effort; then it is controlled.
PROGRAMME = ((10.0, 0.0), (20.0, 1.0), (40.0, -1.0), (50.0, 1.0))
SPEED_UNTIL = 60.0  # [s] its speed is controlled, and then its position


class _Axis:
    """A joint with its element's numbers."""

    STATE = ("pid",)

    def __init__(self, model: Model, sdf: Element, tag: str, limited: bool = False) -> None:
        self.joint = named_joint(model, sdf, tag)
        self.position, self.velocity = sdf.Get(float, f"{tag}_pos"), sdf.Get(float, f"{tag}_vel")
        self.effort = sdf.Get(float, f"{tag}_eff")
        low, high = sdf.Get(Vector2d, f"{tag}_ilim")
        p, i, d = sdf.Get(Vector3d, f"{tag}_pid")
        most, least = (self.effort, -self.effort) if limited else (-1.0, 0.0)  # none
        self.pid = PID(p, i, d, high, low, most, least)

    def hold(self, seconds: float) -> None:
        """Apply the effort that leads to the position."""
        self.joint.SetForce(0, self.pid.Update(self.joint.Position(0) - self.position, seconds))

    def drive(self, now: float, seconds: float) -> None:
        """Apply the effort of a wheel at a sim time [s]."""
        share = next((share for until, share in PROGRAMME if now < until), None)
        if share is not None:
            self.joint.SetForce(0, share * self.effort)
        elif now < SPEED_UNTIL:
            self.joint.SetForce(0, self.pid.Update(self.joint.GetVelocity(0) - self.velocity, seconds))
        else:
            self.hold(seconds)


class CartDemoPlugin(ModelPlugin):
    """Steers a cart with two driven wheels, which are at rest until 10 s of sim time.

    They accelerate with their effort until 20 s, brake and reverse with it until 40 s, and accelerate again until 50 s;
    a PID controls their velocity until 60 s, and then their position. The steering joint is held at its position.

    Elements:
        steer, right, left: the joints.
        steer_pid, ...: the gains P I D.
        steer_ilim, ...: the least and the most of the integral term.
        steer_pos, ...: the position [rad] to which the joint is controlled.
        right_vel, left_vel: the velocity [rad/s].
        right_eff, left_eff: the effort [N m]; steer_eff: the most of that of the steering joint.
    """

    STATE = ("last", "steer", "wheels")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints.

        Raises:
            NotFoundError: a joint is missing.
        """
        self.steer = _Axis(model, sdf, "steer", limited=True)
        self.wheels = [_Axis(model, sdf, tag) for tag in ("right", "left")]
        self.world = model.GetWorld()
        self.last = self.world.SimTime().Double()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Begin again."""
        self.last = self.world.SimTime().Double()
        for axis in (self.steer, *self.wheels):
            axis.pid.Reset()

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply the efforts."""
        now = info.simTime.Double()
        seconds, self.last = now - self.last, now
        self.steer.hold(seconds)
        for wheel in self.wheels:
            wheel.drive(now, seconds)


GZ_REGISTER_MODEL_PLUGIN(CartDemoPlugin)
