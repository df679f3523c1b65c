"""Pioneer2Gripper: ActivMedia's gripper for the Pioneer 2: two paddles on a lift."""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.base.geometry import GzColor, GzVector
from libgz.base.law import Number, law, whole
from libgz.base.records import numbers
from libgz.interfaces import gripper as codes
from libgz.interfaces.gripper import Gripper, GripperData
from libgz.legacy.model import Model
from libgz.models.parts import add_body
from libgz.models.serving import serve
from libgz.ode.types import dParamBounce, dParamFMax, dParamHiStop, dParamLoStop, dParamVel
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom
from libgz.physics.joint import SliderJoint
from libgz.physics.rays import RayProximity
from libgz.simulation.plan import Plan
from libgz.simulation.world import World
from libgz.worldfile.attributes import boolean, declaration, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

LIFT_TRAVEL, PADDLE_TRAVEL = 0.0625, 0.105  # [m]
LIFT_FORCE, PADDLE_FORCE = 50.0, 10.0  # [N]
SPEED = 0.5  # of lift and paddles [m/s]
THICKNESS = 0.025  # of a paddle [m]
BEAMS = (0.03, -0.02)  # x of the outer and the inner beam on the paddles [m]
AT_END = 0.002  # [m]; tolerance of being at an end
OLD_REACH = 0.02, 0.035  # [m]; how far the old beams began and ended from the middles of the paddles
MOST_FIELDS = 15  # that are published, in either struct
STILL, STILL_FOR = 0.01, 0.1  # [m/s], [s]: closing paddles that are slower than this for this long hold something

# command -> (direction of the paddles, of the lift): 1 close or rise, -1 open or lower, 0 stop, None unchanged
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


@declaration
class GripperAttributes:
    """Attributes of `<model:Pioneer2Gripper>`."""

    laterInterface: bool = boolean(
        False, help="serve the struct of November 2006, with `state`: for programs compiled with GAZEBO_GRIPPER_CVS"
    )


class _Slide:
    """A driven slider that moves from 0 to the end of its travel [m], which is negative if it moves backwards."""

    STATE: ClassVar[tuple[str, ...]] = ("direction", "rate", "_before")

    def __init__(
        self,
        world: World,
        name: str,
        moving: Body,
        carrier: Body,
        axis: tuple[float, float, float],
        travel: float,
        force: float,
    ) -> None:
        self.travel, self._sign = abs(travel), math.copysign(1.0, travel)
        self.direction = 0  # 1 towards the end, -1 back, 0 stop
        self.rate = self._before = 0.0  # speed [m/s]; position in the previous step [m]
        self.joint = SliderJoint(world, name=name)
        self.joint.Attach(moving, carrier)
        self.joint.SetAxis(*axis)
        self.joint.SetParam(dParamLoStop, min(0.0, travel))
        self.joint.SetParam(dParamHiStop, max(0.0, travel))
        self.joint.SetParam(dParamBounce, 0.0)
        self.joint.SetParam(dParamVel, 0.0)
        self.joint.SetParam(dParamFMax, force)

    @property
    def position(self) -> float:
        """How far it is from 0, towards the end [m]."""
        return self._sign * self.joint.GetPosition()

    def measure(self, step: float) -> None:
        """Update `rate` after a step [s].

        ODE's own rate is the difference of the bodies' velocities, which is not zero while both turn with the robot.
        """
        self.rate = (self.position - self._before) / step
        self._before = self.position

    @property
    def at_start(self) -> bool:
        """Whether it is at 0."""
        return self.position < AT_END

    @property
    def at_end(self) -> bool:
        """Whether it is at the end of its travel."""
        return self.position > self.travel - AT_END

    def drive(self, direction: int) -> None:
        """Run the motor towards the end (1) or back (-1), or hold (0); it runs on against a stop."""
        if direction != self.direction:
            self.direction = direction
            self.joint.SetParam(dParamVel, self._sign * direction * SPEED)


class Pioneer2Gripper(Model):
    """Two paddles on a lift, usually nested in a Pioneer2DX at (0.14003, 0, -0.0975).

    It starts open and down. A command holds until the next one; invalid commands are ignored. The published state is
    measured: open and closed, up and down within 2 mm of the end; closed also if the paddles press on something. Two
    beams, near the paddles' tips and deep between them, detect objects; they are at half the paddles' height, 7 cm
    above the ground while the gripper of a Pioneer2DX is down.

    Bar and paddles weigh 1 kg each and have moments of inertia of 1 kg m^2, as in the original server, which gave them
    no mass, so that ODE's default remained.

    With the quirk gripperState the state is that of the original server: open, closed, up and down are set when the
    command arrives, and all are 1 before the first one; the inner beam detects nothing, the outer one detects the right
    paddle when the paddles are shut and begins inside of what they hold, and limits are never reached.
    """

    STATE: ClassVar[tuple[str, ...]] = ("lift", "left", "right", "beams", "commanded", "slow_for", "_values")

    _command = Number()  # that was taken in this step; 0: none

    active_while_paused = True
    behaviour = "motors that move and hold its paddles and its lift; the beams between the paddles"
    attributes = GripperAttributes
    interfaces = ("gripper",)
    example = """
        <model:Pioneer2DX>
          <id>robot1</id>
          <xyz>0 0 0.24</xyz>
          <model:Pioneer2Gripper>
            <id>gripper1</id>
            <xyz>0.14003 0 -0.0975</xyz>
          </model:Pioneer2Gripper>
        </model:Pioneer2DX>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        base = self._box(None, (0.05, 0.125, 0.13), (0.0, 0.0, 0.0), 0.0)
        base.geoms[0].SetMass(0.1)
        bar = self._box("bar", (0.07, 0.315, 0.065), (0.06, 0.0, -0.065), 0.5)
        size = (0.095, THICKNESS, 0.04)
        # Left and right as in the original server: left is at -y.
        left = self._box("left_paddle", size, (0.1425, -0.1175, -0.065), 0.2)
        right = self._box("right_paddle", size, (0.1425, 0.1175, -0.065), 0.2)
        for body in (bar, left, right):
            body.SetMassMatrix(body.GetMass())  # which is ODE's default, 1 kg: nothing has set another one
        self.lift = _Slide(self.world, "lift", bar, base, (0.0, 0.0, 1.0), LIFT_TRAVEL, LIFT_FORCE)
        self.right = _Slide(self.world, "right_paddle", right, bar, (0.0, 1.0, 0.0), -PADDLE_TRAVEL, PADDLE_FORCE)
        self.left = _Slide(self.world, "left_paddle", left, bar, (0.0, 1.0, 0.0), PADDLE_TRAVEL, PADDLE_FORCE)
        self.span = 0.235  # between the paddles' centres when they are open [m]
        self.beams = RayProximity(self.world, left, len(BEAMS))
        self._old = "gripperState" in self.world.engine.quirks
        self.commanded = (0, 0)  # last directions of paddles and lift other than stop; 0 before the first
        self._values = numbers(MOST_FIELDS)()  # what is published, in the order of the fields
        self.slow_for = 0.0  # how long the paddles have been slow while closing [s]
        self.gripper = Gripper(read(GripperAttributes, node).laterInterface)

    def _box(
        self,
        name: str | None,
        size: tuple[float, float, float],
        position: tuple[float, float, float],
        grey: float,
    ) -> Body:
        """A body of one box; without a name it is the canonical one."""
        body = add_body(self, name)
        geom = BoxGeom(body, self.modelSpaceId, *size)
        geom.SetColor(GzColor(grey, grey, grey))
        body.SetPosition(GzVector(*position))
        return body

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        serve(self, self.gripper)
        self._names = [name for name in (*self.state(), "state") if hasattr(self.gripper.layout, name)]
        self._note()
        with self.gripper.locked() as data:
            self._publish(data)

    def Fini(self) -> None:  # noqa: D102
        self.gripper.destroy()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        plan.exchange(self.gripper, self._take)
        plan.do(self._act)
        plan.exchange(self.gripper, self._publish)

    @law
    def _take(self, data: GripperData) -> None:
        """Take the client's command."""
        self._command = data.cmd

    def _act(self, step: float) -> None:
        """Obey the command that was taken, if any, and measure."""
        command, self._command = int(self._command), 0.0
        self._obey(command)
        if step > 0.0:
            self._watch_grip(step)
        if self._old:
            self.beams.Update()
            self._aim_old_beams()
        else:
            self._cast_beams()
        self._note()

    def _obey(self, command: int) -> None:
        """Set the directions that a command requests."""
        paddles, lift = COMMANDS.get(command, (None, None))
        if paddles is not None:
            self.left.drive(paddles)
            self.right.drive(paddles)
        if lift is not None:
            self.lift.drive(lift)
        self.commanded = (self.left.direction or self.commanded[0], self.lift.direction or self.commanded[1])

    def _watch_grip(self, step: float) -> None:
        """Measure how long the paddles have been slow while closing; a stop command keeps the grip."""
        for paddle in (self.left, self.right):
            paddle.measure(step)
        slow = max(abs(self.left.rate), abs(self.right.rate)) < STILL
        if slow and self.left.direction > 0:
            self.slow_for += step
        elif not slow or self.left.direction < 0:
            self.slow_for = 0.0

    def _cast_beams(self) -> None:
        """Cast beams from the middle of the left paddle, which they do not hit, to the face of the right one.

        The original server's beams began in front of the paddle, inside a held object, and did not detect it.
        """
        gap = self.span - self.left.position - self.right.position
        for i, x in enumerate(BEAMS):
            self.beams.SetRay(i, (x, 0.0, 0.0), (x, max(gap - THICKNESS / 2.0 - 0.001, 0.001), 0.0))
        self.beams.Update()

    def _aim_old_beams(self) -> None:
        """Aim the beams of the next step as the original server did, along the left paddle's y.

        They point backwards, into the right paddle, when the paddles are nearly shut.
        """
        begin, short = OLD_REACH
        end = self.span - self.left.position - self.right.position - short
        for i, x in enumerate(BEAMS):
            self.beams.SetRay(i, (x, begin, 0.0), (x, end if abs(end - begin) > 1e-6 else begin + 1e-6, 0.0))

    # State -------------------------------------------------------------------------------------------------------

    def state(self) -> dict[str, bool]:
        """The measured state, by the names of the interface's fields."""
        paddles = (self.left, self.right)
        opened, shut = all(p.at_start for p in paddles), all(p.at_end for p in paddles)
        holding = self.slow_for >= STILL_FOR - 1e-9 and not opened
        up, down = self.lift.at_end, self.lift.at_start
        outer, inner = (row >= 0 for row in self.beams.rows.tolist())
        return {
            "left_paddle_open": self.left.at_start,
            "right_paddle_open": self.right.at_start,
            "paddles_opened": opened,
            "paddles_closed": shut or holding,
            "paddles_moving": not (opened or shut or holding),
            "paddles_error": False,
            "lift_up": up,
            "lift_down": down,
            "lift_moving": not (up or down),
            "lift_error": False,
            "grip_limit_reach": all(p.at_start or p.at_end for p in paddles),
            "lift_limit_reach": up or down,
            "outer_beam_obstruct": outer,
            "inner_beam_obstruct": inner,
        }

    def _old_state(self) -> dict[str, bool]:
        """The state as the original server published it."""
        state = self.state()
        paddles, lift = self.commanded
        opened = paddles <= 0  # these flags are 1 before the first command, up and down at once
        state |= {"left_paddle_open": opened, "right_paddle_open": opened, "paddles_opened": opened}
        state |= {"paddles_closed": not opened, "paddles_moving": False}
        state |= {"lift_up": lift >= 0, "lift_down": lift <= 0, "lift_moving": False}
        state |= {"grip_limit_reach": False, "lift_limit_reach": False, "inner_beam_obstruct": False}
        return state

    def _code(self, state: dict[str, bool]) -> int:
        """The state of the paddles in the later struct: a value of the header, or that of the original server."""
        if state["paddles_opened"]:
            return 0 if self._old else codes.GAZEBO_GRIPPER_STATE_OPEN
        if state["paddles_closed"]:
            return 1 if self._old else codes.GAZEBO_GRIPPER_STATE_CLOSED
        return 4 if self._old else codes.GAZEBO_GRIPPER_STATE_MOVING

    def _note(self) -> None:
        """Note what is to be published."""
        state = self._old_state() if self._old else self.state()
        found = {**state, "state": self._code(state)}
        for i, name in enumerate(self._names):
            self._values[i] = found[name]

    @law
    def _publish(self, data: GripperData) -> None:
        """Write the state."""
        data.time = self.world.GetSimTime()
        for name, value in zip(self._names, self._values, strict=False):
            setattr(data, name, whole(value))
