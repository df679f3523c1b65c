"""gazebo_ros_diff_drive: drives a model with two wheels, or several on each side."""

from __future__ import annotations

from itertools import zip_longest
from typing import TYPE_CHECKING, Any, NamedTuple

from libgz.base.errors import ParameterError
from libgz.base.law import law
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.packed import PackedMessage
from libgz.ros.plugin import Endpoint, Parameter, Periodic, Rate, Ticks
from libgz.ros.plugins._drive import COMMAND, COMMANDS, COVARIANCES, ODOMETRY, Drive, EncoderPose, drive_joint

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

REACHED = 0.01  # [m/s]; nearer to the wanted speed, the acceleration is not limited


class Pair(NamedTuple):
    """A left and a right wheel, with the distance between them and their radius [m]."""

    left: Joint
    right: Joint
    separation: float
    radius: float


class GazeboRosDiffDrive(Drive, Periodic, ModelPlugin):
    """Turns the wheels by their motors, and publishes odometry of the world or of the wheels."""

    STATE = ("command", "ticks", "pose", "speeds")

    own_namespace = True
    parameters = (
        *COMMANDS,
        Parameter("leftJoint", [], "joints of the left wheels (left_joint)"),
        Parameter("rightJoint", [], "joints of the right wheels (right_joint)"),
        Parameter("wheelSeparation", 0.34, "between left and right [m]; in ROS 2, one for each pair of joints"),
        Parameter("wheelDiameter", 0.15, "[m]; in ROS 2, one for each pair"),
        Parameter("numWheelPairs", 1, "in ROS 2: accepted without effect: as many as there are joints"),
        Parameter("wheelAcceleration", 0.0, "most change of a wheel's speed [m/s^2]; 0: at once"),
        Parameter("wheelTorque", 5.0, "of each motor [N m]"),
        Parameter("updateRate", Rate(100.0), "of commands and odometry [Hz]"),
        Parameter("odometrySource", "world", "world or encoder; in ROS 2, 1 or 0"),
        Parameter("publishTf", True, "publish odometry (in ROS 2 publish_odom)", ros2=False),
        Parameter("publishOdomTF", True, "publish its transform (in ROS 2 publish_odom_tf)", ros2=False),
        Parameter("publishWheelTF", False, "publish the wheels' transforms"),
        Parameter("publishWheelJointState", False, "publish the wheels' joint states"),
        *COVARIANCES,
    )
    endpoints = (COMMAND, *ODOMETRY, Endpoint("publishes", "joint_states", "sensor_msgs/JointState"))

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, subscribe and advertise."""
        self.open(sdf, model.GetName())
        given = self.given
        source = {"0": "encoder", "1": "world"}.get(given.odometrySource, given.odometrySource)
        if source not in ("world", "encoder"):
            raise ParameterError(f"{sdf.where}: <odometrySource> is {source!r}; it must be world or encoder")
        self.encoders = source == "encoder"
        left, right = given.leftJoint or ["left_joint"], given.rightJoint or ["right_joint"]
        self.left = [drive_joint(model, name, sdf.where, "leftJoint") for name in left]
        self.right = [drive_joint(model, name, sdf.where, "rightJoint") for name in right]
        for joint in (*self.left, *self.right):
            joint.SetParam("fmax", 0, given.wheelTorque)
        self.pairs = self._pairs(sdf)
        self.ticks = Ticks(given.updateRate)
        self._stop(model.GetWorld().core.GetSimTime())
        self.open_drive(model, self.variances, of_twist=self.two)
        joints = [*self.left, *self.right]
        wheels = joints if given.publishWheelTF else ()
        self.advertise_odometry(publish=given.publishTf, transform=given.publishOdomTF, wheels=wheels)
        self.reported, self.joint_states = [*self.right, *self.left], None
        if given.publishWheelJointState:
            changed = self.world.core.update_rows_changed
            publication = self.publish("joint_states", "sensor_msgs/JointState", 1000, changed=changed)
            names, zeros = [joint.GetName() for joint in self.reported], [0.0] * len(joints)
            self.joint_states = PackedMessage(publication, publication.kind(name=names, position=zeros))
        self.acceleration = given.wheelAcceleration if given.updateRate > 0.0 else 0.0
        self.lawful = not self.two and not self.acceleration > 0.0
        self.run()

    def _pairs(self, sdf: Element) -> list[Pair]:
        """The pairs of wheels; the longer side has the other one's last wheel.

        Raises:
            ParameterError: a separation or diameter is not positive.
        """
        parameters, sizes = {one.name: one for one in self.parameters}, []
        for tag in ("wheelSeparation", "wheelDiameter"):
            found = [one.Get(float) for one in ros_elements(sdf).named(tag)][: None if self.two else 1]
            if not all(value > 0.0 for value in found):
                raise ParameterError(f"{sdf.where}: <wheelSeparation> and <wheelDiameter> must be positive")
            first = found[0] if found and not self.two else parameters[tag].default
            sizes.append(found + [first] * max(len(self.left), len(self.right)))
        wheels = list(zip_longest(self.left, self.right))
        return [
            Pair(left or self.left[-1], right or self.right[-1], separation, diameter / 2.0)
            for (left, right), separation, diameter in zip(wheels, *sizes, strict=False)
        ]

    def _stop(self, now: float) -> None:
        self.speeds = ((0.0, 0.0),) * len(self.pairs)
        self.pose = EncoderPose(now)

    def Reset(self) -> None:
        """Stop, with odometry at zero."""
        self.command.give()
        self._stop(self.world.core.GetSimTime())
        for joint in (*self.left, *self.right):
            joint.SetParam("fmax", 0, self.given.wheelTorque)

    @law
    def measure(self, now: Any) -> None:
        """Add the ways of the wheels since the last iteration."""
        if self.encoders:
            pair = self.pairs[0]
            self.pose.move(now, pair.left.GetVelocity(0), pair.right.GetVelocity(0), pair.radius, pair.separation)

    @law
    def work(self, now: Any) -> None:
        """Publish; run the wheels."""
        if self.heard:
            motion = self.motion_of_encoders(self.pose) if self.encoders else self.motion_in_world()
            self.publish_transforms(now, motion)
            self.publish_odometry(now, motion)
        if self.joint_states is not None and self.joint_states.publication.listened:
            self.joint_states.stamp(now)
            self.joint_states.put("position", [joint.Position(0) for joint in self.reported])
            self.joint_states.send()
        if self.acceleration > 0.0:
            self._accelerate()
            return
        ahead, turn = self.command.ahead, self.command.turn
        for pair in self.pairs:
            half = turn * pair.separation / 2.0
            pair.left.core.run_motor((ahead - half) / pair.radius)
            pair.right.core.run_motor((ahead + half) / pair.radius)

    def _accelerate(self) -> None:
        """Bring the speeds of the motors nearer to the wanted ones."""
        most = self.acceleration / self.given.updateRate
        speeds = [self._speeds_of(pair, before, most) for pair, before in zip(self.pairs, self.speeds, strict=True)]
        self.speeds = tuple(speeds)
        for pair, (left, right) in zip(self.pairs, speeds, strict=True):
            pair.left.core.run_motor(left / pair.radius)
            pair.right.core.run_motor(right / pair.radius)

    def _speeds_of(self, pair: Pair, before: tuple[float, float], most: float) -> tuple[float, float]:
        """The next speeds of a pair [m/s], at most so far from those before, unless both wheels have their speeds."""
        half = self.command.turn * pair.separation / 2.0
        wanted = self.command.ahead - half, self.command.ahead + half
        off = [want - joint.GetVelocity(0) * pair.radius for want, joint in zip(wanted, pair[:2], strict=True)]
        if any(abs(one) < REACHED for one in off):
            return wanted
        left, right = (last + max(-most, min(most, one)) for last, one in zip(before, off, strict=True))
        return left, right


GZ_REGISTER_MODEL_PLUGIN(GazeboRosDiffDrive)
