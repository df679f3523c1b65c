"""What the drives have in common: commands, odometry, transforms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from libgz.base.errors import NotFoundError, nearest
from libgz.base.law import Number, constant, cos, law, sin, where
from libgz.classic.plugins._planar import heading
from libgz.ros.packed import PackedMessage
from libgz.ros.plugin import Endpoint, Parameter, RosPlugin
from libgz.ros.session import Publication, finite
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Link, Model

__all__ = [
    "COMMAND",
    "COMMANDS",
    "COVARIANCES",
    "ODOMETRY",
    "Command",
    "Drive",
    "EncoderPose",
    "Motion",
    "drive_joint",
    "send_transform",
]

COMMANDS = (
    Parameter("commandTopic", "cmd_vel", "commands"),
    Parameter("odometryTopic", "odom", "odometry"),
    Parameter("odometryFrame", "odom", "frame of the odometry"),
    Parameter("robotBaseFrame", "base_footprint", "frame of the robot in it"),
)
VARIANCES = (1e-5, 1e-5, 1e-3)  # of x, y [m^2] and yaw [rad^2]
COVARIANCES = tuple(
    Parameter(f"covariance{name}", value, f"in ROS 2: variance of {name.lower()}, of pose and twist")
    for name, value in zip(("X", "Y", "Yaw"), VARIANCES, strict=True)
)
COMMAND = Endpoint("subscribes", "<commandTopic>", "geometry_msgs/Twist")
ODOMETRY = (
    Endpoint("publishes", "<odometryTopic>", "nav_msgs/Odometry"),
    Endpoint("publishes", "/tf", "tf2_msgs/TFMessage"),
)
UNKNOWN = 1e12  # variance of what a robot on the ground does not measure


class Motion(NamedTuple):
    """Where a robot is, and how it moves in its plane.

    Attributes:
        place: [m].
        turn: x, y, z, w.
        velocity: ahead, to the left [m/s]; turn rate [rad/s].
    """

    place: tuple[Any, Any, Any]
    turn: tuple[Any, Any, Any, Any]
    velocity: tuple[Any, Any, Any]


class Command:
    """What a drive is to do."""

    STATE = ("ahead", "aside", "turn")

    ahead, aside = Number(), Number()  # [m/s]
    turn = Number()  # [rad/s]

    def give(self, ahead: float = 0.0, aside: float = 0.0, turn: float = 0.0) -> None:
        """Set it; by default, to stop [m/s], [rad/s]."""
        self.ahead, self.aside, self.turn = ahead, aside, turn


class EncoderPose:
    """A pose in the plane, summed up from the ways of two wheels."""

    STATE = ("x", "y", "yaw", "way", "turn", "last", "elapsed")

    x, y, yaw = Number(), Number(), Number()
    way, turn = Number(), Number()  # of the last move [m], [rad]
    last, elapsed = Number(), Number()  # its sim time, and how long it took [s]

    def __init__(self, now: float) -> None:
        self.last = now

    @law
    def move(self, now: Any, left: Any, right: Any, radius: float, separation: float) -> None:
        """Move by the rates of the wheels [rad/s] up to a sim time [s]."""
        elapsed = now - self.last
        left, right = left * radius * elapsed, right * radius * elapsed
        turn, way = (right - left) / separation, (left + right) / 2.0
        ahead = self.yaw + turn / 2.0
        self.x, self.y, self.yaw = self.x + way * cos(ahead), self.y + way * sin(ahead), self.yaw + turn
        self.way, self.turn, self.last, self.elapsed = way, turn, now, elapsed


class Drive(RosPlugin):
    """Takes commands, and publishes odometry.

    Attributes:
        command: the last one.
        odometry: the message as it is at first; what stays is set after `open_drive`.
        publication: of the odometry; None: it is not published.
    """

    command: Command
    publication: Publication | None = None
    _packed: PackedMessage | None = None
    _moved: PackedMessage | None = None
    _wheels: Sequence[tuple[Link, PackedMessage]] = ()

    def open_drive(
        self, model: Model, variances: tuple[float, float, float] = VARIANCES, *, of_twist: bool = False
    ) -> None:
        """Subscribe and advertise.

        Args:
            model: the model.
            variances: of x, y and yaw of the pose.
            of_twist: whether they are those of the twist, too.
        """
        self.model, self.world = model, model.GetWorld()
        given = self.given
        self.odometry = message_type("nav_msgs/Odometry")()
        self.odometry.header.frame_id = self.frame(given.odometryFrame)
        self.odometry.child_frame_id = self.frame(given.robotBaseFrame)
        x, y, yaw = variances
        self.odometry.pose.covariance[::7] = (x, y, UNKNOWN, UNKNOWN, UNKNOWN, yaw)
        if of_twist:
            self.odometry.twist.covariance[:] = self.odometry.pose.covariance
        self.odometry.pose.pose.orientation.w = 1.0
        self.command = Command()
        self.commands = self.subscribe(given.commandTopic, "geometry_msgs/Twist", self.OnCommand)

    def advertise_odometry(
        self,
        *,
        publish: bool = True,
        transform: bool = True,
        wheels: Sequence[Joint] = (),
        of_joints: bool = False,
    ) -> None:
        """Advertise.

        Args:
            publish: odometry.
            transform: its transform; /tf is advertised in any case, as the original does.
            wheels: joints whose children's transforms are published.
            of_joints: whether their frames are named after the joints.
        """
        changed, message = self.world.core.update_rows_changed, self.odometry
        if publish:
            self.publication = self.publish(self.given.odometryTopic, "nav_msgs/Odometry", changed=changed)
            self._packed = PackedMessage(self.publication, message)
        self.transforms = self.ros.transforms(self.own_node)
        if transform:
            self._moved = self.ros.pack_transform(
                message.header.frame_id, message.child_frame_id, changed, self.own_node
            )
        self._wheels = [
            (
                joint.GetChild(),
                self.ros.pack_transform(
                    self.frame(joint.GetParent().GetName()),
                    self.frame((joint if of_joints else joint.GetChild()).GetName()),
                    changed,
                    self.own_node,
                ),
            )
            for joint in wheels
        ]

    @property
    @constant
    def heard(self) -> bool:
        """Whether somebody listens to odometry or transforms."""
        every = (self._packed, self._moved, *(message for _, message in self._wheels))
        return any(message.publication.listened for message in every if message is not None)

    @property
    def variances(self) -> tuple[float, float, float]:
        """Of x, y and yaw: in ROS 2, those of the parameters COVARIANCES."""
        given = self.given
        return (given.covarianceX, given.covarianceY, given.covarianceYaw) if self.two else VARIANCES

    def OnCommand(self, message: Any) -> None:
        """A new command."""
        if finite(message):
            self.command.give(message.linear.x, message.linear.y, message.angular.z)
            self.commanded(self.world.core.GetSimTime())

    def commanded(self, now: float) -> None:
        """A command came at sim time `now` [s]."""

    @law
    def motion_in_world(self) -> Motion:
        """The model's pose in the world, and its velocities in the plane."""
        pose, velocity = self.model.WorldPose(), self.model.WorldLinearVel()
        (px, py, pz), (w, x, y, z), (cosine, sine) = pose.Pos(), pose.Rot(), heading(pose.Rot())
        ahead = cosine * velocity.X() + sine * velocity.Y()
        aside = cosine * velocity.Y() - sine * velocity.X()
        return Motion((px, py, pz), (x, y, z, w), (ahead, aside, self.model.WorldAngularVel().Z()))

    @law
    def motion_of_encoders(self, pose: EncoderPose) -> Motion:
        """A pose of encoders, and its last move."""
        elapsed = where(pose.elapsed > 0.0, pose.elapsed, 1.0)
        turn = (0.0, 0.0, sin(pose.yaw / 2.0), cos(pose.yaw / 2.0))
        return Motion((pose.x, pose.y, 0.0), turn, (abs(pose.way) / elapsed, 0.0, pose.turn / elapsed))

    @law
    def publish_odometry(self, now: Any, motion: Motion) -> None:
        """Publish a motion at a sim time [s], if somebody listens."""
        if self._packed is not None and self._packed.publication.listened:
            message, (ahead, aside, turning) = self._packed, motion.velocity
            message.stamp(now)
            message.put("pose.pose", (*motion.place, *motion.turn))
            message.put("twist.twist", (ahead, aside, 0.0, 0.0, 0.0, turning))
            message.send()

    @law
    def publish_transforms(self, now: Any, motion: Motion) -> None:
        """Publish the transforms of the odometry, of a motion at a sim time [s], and of the wheels, if anybody
        listens."""
        if self._moved is not None and self._moved.publication.listened:
            send_transform(self._moved, now, motion.place, motion.turn)
        for link, message in self._wheels:
            if message.publication.listened:
                pose = link.RelativePose()
                w, x, y, z = pose.Rot()
                send_transform(message, now, pose.Pos(), (x, y, z, w))


def send_transform(message: PackedMessage, now: Any, place: Any, turn: Any) -> None:
    """Publish the one transform of a message at a sim time [s]: a place [m], and a turn x, y, z, w."""
    message.stamp(now, "transforms.0.header.stamp")
    message.put("transforms.0.transform", (*place, *turn))
    message.send()


def drive_joint(model: Model, name: str, where: str, tag: str) -> Joint:
    """A joint of the model.

    Raises:
        NotFoundError: there is none of this name.
    """
    joint = model.GetJoint(name)
    if joint is None:
        known = [one.GetName() for one in model.all_joints()]
        raise NotFoundError(
            f"{where}: <{tag}> is {name!r}; model {model.GetName()!r} has {', '.join(known) or 'none'}"
            f"{nearest(name, known)}"
        )
    return joint
