"""Pioneer2Gripper: ActivMedia's gripper for the Pioneer 2: two paddles on a lift."""

from __future__ import annotations

from libgz.geometry import GzColor, GzVector
from libgz.interfaces import gripper as codes
from libgz.interfaces.gripper import Gripper
from libgz.ode.types import dParamBounce, dParamFMax, dParamHiStop, dParamLoStop, dParamVel
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom
from libgz.physics.joint import SliderJoint
from libgz.sensors.rays import RayProximity
from libgz.simulation.model import Model
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

LIFT_TRAVEL, PADDLE_TRAVEL = 0.0625, 0.105  # [m]
LIFT_FORCE, PADDLE_FORCE = 50.0, 10.0  # [N]
SPEED = 0.5  # of lift and paddles [m/s]
THICKNESS = 0.025  # of a paddle [m]
BEAMS = (0.03, -0.02)  # x of the outer and the inner beam on the paddles [m]
AT_STOP = 0.002  # [m]; nearer to a stop than this is at it
STILL, STILL_FOR = 0.01, 0.1  # [m/s], [s]: paddles that close and have been this slow for so long hold something

# command -> (what the paddles do, what the lift does): 1 close or rise, -1 open or sink, 0 stop, None as before
COMMANDS: dict[int, tuple[int | None, int | None]] = {
    codes.OPEN: (-1, None),
    codes.CLOSE: (1, None),
    codes.STOP: (0, None),
    codes.LIFT_UP: (None, 1),
    codes.LIFT_DOWN: (None, -1),
    codes.LIFT_STOP: (None, 0),
    codes.STORE: (1, 1),
    codes.DEPLOY: (-1, -1),
    codes.HALT: (0, 0),
}


class Pioneer2Gripper(Model):
    """A gripper, mostly nested in a Pioneer2DX at (0.14003, 0, -0.0975). Serves gripper.

    It begins open and down. A command holds until the next one; other numbers than the interface's do nothing. What it
    tells of itself is measured: open and closed, up and down within 2 mm of the end; closed also if the paddles press
    on something. Two beams, near the paddles' tips and deep between them, tell whether something is there; they run at
    half the paddles' height, 7.5 cm above the ground while the gripper of a Pioneer2DX is down.

    With the quirk gripperState open, closed, up and down are told when the command arrives, as the old server did, the
    inner beam never tells anything, and limits are never reached.
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        base = self._box(None, (0.05, 0.125, 0.13), (0.0, 0.0, 0.0), 0.1, 0.0)
        # The bar and the paddles once weighed next to nothing, and flew apart when they gripped.
        featherweight = "setMassZero" in self.world.engine.quirks
        bar = self._box("bar", (0.07, 0.315, 0.065), (0.06, 0.0, -0.065), 0.0 if featherweight else 0.25, 0.5)
        weight = 0.0 if featherweight else 0.05
        size = (0.095, THICKNESS, 0.04)
        # Left and right are as the old server had them: left at -y.
        left = self._box("left_paddle", size, (0.1425, -0.1175, -0.065), weight, 0.2)
        right = self._box("right_paddle", size, (0.1425, 0.1175, -0.065), weight, 0.2)
        self.lift = self._slider("lift", bar, base, (0.0, 0.0, 1.0), (0.0, LIFT_TRAVEL), LIFT_FORCE)
        self.left = self._slider("left_paddle", left, bar, (0.0, 1.0, 0.0), (0.0, PADDLE_TRAVEL), PADDLE_FORCE)
        self.right = self._slider("right_paddle", right, bar, (0.0, 1.0, 0.0), (-PADDLE_TRAVEL, 0.0), PADDLE_FORCE)
        self.span = 0.235  # between the paddles' centres when they are open [m]
        self.beams = RayProximity(self.world, left, len(BEAMS))
        self.paddles = self.lifting = 0  # what they were told: 1 close or rise, -1 open or sink, 0 stop
        self.told = (0, 0)  # the last command of each that was not a stop
        self.slow_for = 0.0  # how long the paddles have been slow while closing [s]
        self.gripper = Gripper()

    def _box(
        self,
        name: str | None,
        size: tuple[float, float, float],
        position: tuple[float, float, float],
        mass: float,
        grey: float,
    ) -> Body:
        """A body of one box; without a name it is the canonical one."""
        body = Body(self.world, name)
        self.AddBody(body, name is None)
        geom = BoxGeom(body, self.modelSpaceId, *size)
        body.UpdateCoM()
        geom.SetMass(mass)
        geom.SetColor(GzColor(grey, grey, grey))
        body.SetPosition(GzVector(*position))
        return body

    def _slider(
        self,
        name: str,
        moving: Body,
        carrier: Body,
        axis: tuple[float, float, float],
        stops: tuple[float, float],
        force: float,
    ) -> SliderJoint:
        """A driven slider, held where it is."""
        joint = SliderJoint(self.world, name=name)
        joint.Attach(moving, carrier)
        joint.SetAxis(*axis)
        settings = {dParamLoStop: stops[0], dParamHiStop: stops[1], dParamBounce: 0.0, dParamVel: 0.0}
        for parameter, value in settings.items():
            joint.SetParam(parameter, value)
        joint.SetParam(dParamFMax, force)
        return joint

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.gripper.create(self.world.gz_server, self.GetId(), self.GetName(), self.GetIntId(), self.GetParentIntId())
        self._publish()

    def Fini(self) -> None:  # noqa: D102
        self.gripper.destroy()

    def Update(self, step: float) -> None:  # noqa: D102
        if self.gripper.lock():
            command = int(self.gripper.data.cmd)
            self.gripper.unlock()
            self._obey(command)
        slow = max(abs(self.left.GetPositionRate()), abs(self.right.GetPositionRate())) < STILL
        if self.paddles > 0 and slow:
            self.slow_for += step
        elif self.paddles != 0 or not slow:  # a grip that is stopped still holds
            self.slow_for = 0.0
        self._cast_beams()
        self._publish()

    def _obey(self, command: int) -> None:
        """Set the motors as a command says."""
        paddles, lift = COMMANDS.get(command, (None, None))
        if paddles is not None and paddles != self.paddles:
            self.paddles = paddles
            self.left.SetParam(dParamVel, SPEED * paddles)
            self.right.SetParam(dParamVel, -SPEED * paddles)
        if lift is not None and lift != self.lifting:
            self.lifting = lift
            self.lift.SetParam(dParamVel, SPEED * lift)
        self.told = (self.paddles or self.told[0], self.lifting or self.told[1])

    def _cast_beams(self) -> None:
        """Look across from the middle of the left paddle, which the beams do not see, to the face of the right one.

        The old server's beams began in front of the paddle, inside what it held, and then did not see that.
        """
        gap = self.span - self.left.GetPosition() + self.right.GetPosition()
        for i, x in enumerate(BEAMS):
            self.beams.SetRay(i, (x, 0.0, 0.0), (x, max(gap - THICKNESS / 2.0 - 0.001, 0.001), 0.0))
        self.beams.Update()

    # State -------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, bool]:
        """What the interface tells, by its fields' names, as measured."""
        height, left, right = self.lift.GetPosition(), self.left.GetPosition(), -self.right.GetPosition()
        left_open, right_open = left < AT_STOP, right < AT_STOP
        opened = left_open and right_open
        shut = min(left, right) > PADDLE_TRAVEL - AT_STOP
        holding = self.slow_for >= STILL_FOR - 1e-9 and not opened
        up, down = height > LIFT_TRAVEL - AT_STOP, height < AT_STOP
        outer, inner = (row >= 0 for row in self.beams.rows.tolist())
        return {
            "left_paddle_open": left_open,
            "right_paddle_open": right_open,
            "paddles_opened": opened,
            "paddles_closed": shut or holding,
            "paddles_moving": not (opened or shut or holding),
            "paddles_error": False,
            "lift_up": up,
            "lift_down": down,
            "lift_moving": not (up or down),
            "lift_error": False,
            "grip_limit_reach": all(p < AT_STOP or p > PADDLE_TRAVEL - AT_STOP for p in (left, right)),
            "lift_limit_reach": up or down,
            "outer_beam_obstruct": outer,
            "inner_beam_obstruct": inner,
        }

    def _old_state(self) -> dict[str, bool]:
        """The same by the faults of the old server."""
        state = self.state()
        paddles, lift = self.told
        opened, closed, up, down = paddles < 0, paddles > 0, lift > 0, lift < 0
        state |= {"left_paddle_open": opened, "right_paddle_open": opened, "paddles_opened": opened}
        state |= {"paddles_closed": closed, "paddles_moving": not (opened or closed)}
        state |= {"lift_up": up, "lift_down": down, "lift_moving": not (up or down)}
        state |= {"grip_limit_reach": False, "lift_limit_reach": False, "inner_beam_obstruct": False}
        return state

    def _publish(self) -> None:
        state = self._old_state() if "gripperState" in self.world.engine.quirks else self.state()
        if self.gripper.lock():
            data = self.gripper.data
            data.time = self.world.GetSimTime()
            for name, value in state.items():
                setattr(data, name, int(value))
            self.gripper.unlock()
