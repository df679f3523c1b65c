"""Bandit: the University of Southern California's humanoid torso, with two arms and a head.

Of the original source only the names and the order of the joints are known. Dimensions, masses and axes were chosen for
libgz.
"""

from __future__ import annotations

from typing import ClassVar

from libgz.base.geometry import GzColor, GzPose, GzVectorMul, VectorLike
from libgz.base.law import law
from libgz.base.records import numbers
from libgz.interfaces.joint import JointData, Joints, JointsData
from libgz.legacy.model import Model
from libgz.models.motors import Axis, Servo
from libgz.models.parts import GREY, add_body, fit
from libgz.models.serving import Seen, serve
from libgz.models.wheels import add_hinge
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom
from libgz.physics.joint import FixedJoint, HingeJoint
from libgz.physics.two_axes import UniversalJoint
from libgz.simulation.exchange import Exchange
from libgz.simulation.plan import Plan, handler
from libgz.simulation.rate import UpdateRate
from libgz.transport.guard import Guard
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
UPDATE_RATE = 10.0  # [Hz], of the interface; the joints are controlled in every step
GAIN, TORQUE = 4.0, 5.0  # [1/s], [N m]
LARGEST_ANGLE = 3.1416  # [rad], of a command
SHOULDER, ELBOW, WRIST, NECK = 0.34, 0.07, -0.165, 0.42  # heights of the joints [m]
ARM_SIDE = 0.17  # [m], from the middle
# The bodies of an arm, from the shoulder down: name, size [m], height of the centre [m], mass [kg].
ARM = (
    ("Shoulder", (0.06, 0.06, 0.06), SHOULDER, 0.3),
    ("UpperArm", (0.06, 0.06, 0.22), 0.20, 0.4),
    ("Elbow", (0.05, 0.05, 0.05), ELBOW, 0.3),
    ("LowerArm", (0.05, 0.05, 0.20), -0.055, 0.3),
    ("Hand", (0.08, 0.03, 0.10), -0.225, 0.3),
)
# The hinges of an arm, each between a body and the previous one: name, height [m], axis.
HINGES = (("SHOULDER", SHOULDER, Y), ("UPPERARM", SHOULDER, X), ("ELBOW", ELBOW, Y), ("LOWERARM", ELBOW, Z))


class JointServo:
    """A joint whose axes follow the commands of a client.

    Attributes:
        seen: what the client wrote, valid or not, when `command` followed from it; None if it was set otherwise.
    """

    STATE: ClassVar[tuple[str, ...]] = ("command", "seen")

    def __init__(self, joint: HingeJoint | UniversalJoint) -> None:
        self.joint = joint
        self._command, self._seen = numbers(2)(), Seen(2)
        axes = (1, 2) if isinstance(joint, UniversalJoint) else (1,)
        self._servos = [Servo(Axis(joint, number), GAIN, TORQUE) for number in axes]

    @property
    @law
    def command(self) -> tuple[float, float]:
        """Wanted angle of each axis [rad]; it holds until the client's next tick."""
        return self._command[0], self._command[1]

    @command.setter
    def command(self, angles: tuple[float, float]) -> None:
        self._command[:] = angles
        self._seen.settled = False

    @property
    def seen(self) -> tuple[float, float] | None:  # noqa: D102
        return (self._seen.numbers[0], self._seen.numbers[1]) if self._seen.settled else None

    @seen.setter
    def seen(self, angles: tuple[float, float] | None) -> None:
        self._seen.note(angles or (0.0, 0.0), angles is not None)

    def expect(self, exchange: Exchange, place: str) -> None:
        """Make it a condition of an exchange that the client wrote nothing new."""
        self._seen.expect(exchange, ((f"{place}.{field}", 0) for field in ("cmd_angle", "cmd_angle2")))

    def follow(self, wish: tuple[float, float], guard: Guard, place: tuple[str, str]) -> None:
        """Take what the client wrote, in the fields of these names; what is not finite is ignored."""
        command, seen = self._command, self._seen
        if seen.settled and wish == (seen.numbers[0], seen.numbers[1]):
            return
        command[0] = guard.number(place[0], wish[0], command[0], LARGEST_ANGLE)
        command[1] = guard.number(place[1], wish[1], command[1], LARGEST_ANGLE)
        seen.note(wish)

    @law
    def turn(self) -> None:
        """Turn the axes towards the commanded angles; call it every step."""
        for servo, angle in zip(self._servos, self.command, strict=False):
            servo.turn_to(angle)

    @law
    def publish(self, data: JointData) -> None:
        """Fill in one joint of the interface."""
        joint = self.joint
        data.type = joint.GetType()
        data.anchor[:] = tuple(joint.GetAnchor())
        if isinstance(joint, UniversalJoint):
            data.axis[:] = tuple(GzVectorMul(-1.0, joint.GetAxis1()))
            data.axis2[:] = tuple(GzVectorMul(-1.0, joint.GetAxis2()))
            data.angle2, data.angular_velocity2 = joint.GetAngle2(), joint.GetAngleRate2()
        else:
            data.axis[:] = tuple(joint.GetAxis())
        first = self._servos[0].axis
        data.angle, data.angular_velocity = first.angle(), first.rate()


class Bandit(Model):
    """A torso that is fixed to the world or to its parent model; its hands reach 28 cm below its origin.

    The origin is the centre of the torso's bottom. Serves joint, in this order: left SHOULDER, UPPERARM, ELBOW,
    LOWERARM and WRIST, the same of the right, and HEAD. Wrists and head turn about two axes: x and y, z and y.
    Dimensions and layout chosen for libgz.
    """

    STATE: ClassVar[tuple[str, ...]] = ("rate", "servos")

    behaviour = "motors that move and hold its joints (arms and head hang down)"
    example = """
    <model:Bandit>
      <id>robot1</id>
      <xyz>0 0 0.8</xyz>
    </model:Bandit>
    """

    interfaces = ("joint",)

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.rate = UpdateRate(UPDATE_RATE)
        self.servos: list[JointServo] = []
        self.base: FixedJoint | None = None
        torso = add_body(self)
        fit(BoxGeom(torso, self.modelSpaceId, 0.18, 0.26, 0.40), (0.0, 0.0, 0.20), 5.0, GzColor(0.2, 0.3, 0.6))
        self._add_arm(torso, "left", ARM_SIDE)
        self._add_arm(torso, "right", -ARM_SIDE)
        head = self._add_part("head", (0.14, 0.16, 0.18), (0.0, 0.0, 0.52), 1.0)
        self._add_universal("HEAD", head, torso, (0.0, 0.0, NECK), Z, Y)
        if self.parent is None:
            self.base = FixedJoint(self.world, name="base")
            self.base.Attach(torso, None)

    def _add_part(self, name: str, size: tuple[float, float, float], position: VectorLike, mass: float) -> Body:
        body = add_body(self, name)
        color = GREY if min(size) == max(size) else GzColor(0.75, 0.75, 0.8)  # cubes: shoulders and elbows
        fit(BoxGeom(body, self.modelSpaceId, *size), (0.0, 0.0, 0.0), mass, color)
        body.SetPosition(position)
        return body

    def _add_arm(self, torso: Body, side: str, y: float) -> None:
        """Five bodies on four hinges and a wrist with two axes."""
        bodies = [torso]
        for name, size, height, mass in ARM:
            bodies.append(self._add_part(f"{side}{name}", size, (0.0, y, height), mass))
        letter = side[0].upper()
        for i, (name, height, axis) in enumerate(HINGES):
            hinge = add_hinge(self, bodies[i + 1], bodies[i], (0.0, y, height), axis, f"{letter}_{name}")
            self.servos.append(JointServo(hinge))
        self._add_universal(f"{letter}_WRIST", bodies[5], bodies[4], (0.0, y, WRIST), X, Y)

    def _add_universal(
        self, name: str, moving: Body, base: Body, anchor: VectorLike, axis1: VectorLike, axis2: VectorLike
    ) -> None:
        """A joint with two axes: the first is fixed to the base, the second to the moving body."""
        joint = UniversalJoint(self.world, name=name)
        joint.Attach(base, moving)
        joint.SetAnchor(anchor)
        # The first body has to be the base; that reverses the signs.
        joint.SetAxis1(GzVectorMul(-1.0, axis1))
        joint.SetAxis2(GzVectorMul(-1.0, axis2))
        self.servos.append(JointServo(joint))

    def SetPose(self, pose: GzPose) -> None:
        """Move all bodies together, and fix the torso at its new place."""
        super().SetPose(pose)
        if self.base is not None:
            self.base.SetFixed()

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.interface = Joints()
        self.guard = Guard(f"joint.{self.GetId()}")
        self._places = [(f"joints[{i}].cmd_angle", f"joints[{i}].cmd_angle2") for i in range(len(self.servos))]
        serve(self, self.interface)
        self.interface.data.joint_count = len(self.servos)

    def Fini(self) -> None:  # noqa: D102
        self.interface.destroy()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        with plan.due(self.rate):
            plan.exchange(self.interface, self._publish)
            plan.exchange(self.interface, None, unless=self._expect, otherwise=self._take)
        for servo in self.servos:
            plan.call(servo.turn)

    @law
    def _publish(self, data: JointsData) -> None:
        """Publish the joints."""
        data.time, data.joint_count = self.world.GetSimTime(), len(self.servos)
        for servo, joint in zip(self.servos, data.joints, strict=False):
            servo.publish(joint)

    def _expect(self, exchange: Exchange) -> None:
        """The condition that no command changes."""
        for i, servo in enumerate(self.servos):
            servo.expect(exchange, f"joints[{i}]")

    @handler
    def _take(self) -> None:
        """Take the commands; numbers that are not finite are ignored."""
        if not self.interface.lock():
            return
        wishes = [(joint.cmd_angle, joint.cmd_angle2) for joint in self.interface.data.joints[: len(self.servos)]]
        self.interface.unlock()
        if not self.interface.intact():
            return
        for servo, place, wish in zip(self.servos, self._places, wishes, strict=True):
            servo.follow(wish, self.guard, place)
