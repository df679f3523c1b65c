"""Ready tasks: environments with a world, a start, a reward and an end of their own. docs/gym.md describes them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import (
    GzPose,
    GzPosePointAt,
    GzQuaternFromEuler,
    GzQuaternToEuler,
    GzVector,
    GzVectorAdd,
    rotate,
)
from libgz.base.law import Number, atan2, clamp, cos, hypot, law, least, sin, where
from libgz.front import World
from libgz.gym.env import WorldEnv
from libgz.models.pantilt import EYE
from libgz.physics.check import finite
from libgz.sdfworld.joint import SdfJoint

__all__ = ["TASKS", "Balance", "DoublePendulum", "FollowWall", "PendulumSwingUp", "ReachGoal", "TrackBall"]

WORLDS = Path(__file__).parent / "worlds"
Array = NDArray[np.float64]


def _box(*bounds: tuple[float, float]) -> spaces.Box:
    low, high = (np.array(ends, np.float64) for ends in zip(*bounds, strict=True))
    return spaces.Box(low, high, dtype=np.float64)


def _clipped(values: Any, space: spaces.Box) -> Array:
    clipped: Array = np.minimum(np.maximum(np.array(values, float), space.low), space.high)
    return clipped


def _flat_pose(x: float, y: float, z: float, yaw: float) -> GzPose:
    return GzPose(GzVector(x, y, z), GzQuaternFromEuler(0.0, 0.0, yaw))


class ReachGoal(WorldEnv):
    """A Pioneer2AT drives to a place 1.5 to 5 m away.

    Actions: forward speed -0.5 to 0.7 m/s, turn rate -1.5 to 1.5 rad/s. Observation: distance to the goal [m], cosine
        and
    sine of its bearing, forward speed [m/s], turn rate [rad/s]. Reward: the metres by which the goal came nearer, less
    0.01
    a step, and 10 at the goal. It ends within 0.35 m of the goal, and 8 m away from it. `reset(options={"goal": (x,
    y)})` sets the goal [m].
    """

    REACHED, LOST, FARTHEST = 0.35, 8.0, 16.0  # [m]
    space = _box((0.0, FARTHEST), (-1.0, 1.0), (-1.0, 1.0), (-3.0, 3.0), (-10.0, 10.0))

    STATE: ClassVar[tuple[str, ...]] = ("goal_x", "goal_y")

    goal_x, goal_y = Number(), Number()  # [m]

    def __init__(self, **options: Any) -> None:
        super().__init__(
            WORLDS / "reach_goal.world",
            {"position.robot1": {"cmd_vel_pos[0]": (-0.5, 0.7), "cmd_vel_rot[2]": (-1.5, 1.5)}},
            self.space,
            start=self.begin,
            info=lambda world: {"reached": bool(self.outcome.seen[0] < self.REACHED)},
            **{
                "time_limit": 30.0,
                "camera": GzPosePointAt((-6.0, -6.0, 8.0), (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
                **options,
            },
        )

    def begin(self, world: World, random: np.random.Generator, options: dict[str, Any]) -> None:
        """Place the robot at the origin with a random yaw, and the goal."""
        away, bearing, yaw = random.uniform((1.5, -math.pi, -math.pi), (5.0, math.pi, math.pi)).tolist()
        goal = options.get("goal", (away * math.cos(bearing), away * math.sin(bearing)))
        try:
            x, y = (finite(float(number), "goal [m]") for number in goal)
        except (TypeError, ValueError):
            raise ParameterError(f"goal is {goal!r}; it must be two finite numbers, x and y [m]") from None
        self.goal_x, self.goal_y = x, y
        marker = world.model("goal")
        marker.GetBody().SetGravityMode(False)
        world.SetModelPose(marker, _flat_pose(x, y, 1.2, 0.0))
        robot = world.model("robot1")
        world.SetModelPose(robot, _flat_pose(0.0, 0.0, robot.GetPose().pos.z, yaw))
        self._chassis = robot.GetBody()

    @law
    def measure(self) -> None:
        """What the robot sees, how much nearer it is, and whether the goal is reached or lost."""
        now, pose = self.outcome, self._chassis.GetPose()
        yaw = GzQuaternToEuler(pose.rot).z
        east, north = self.goal_x - pose.pos.x, self.goal_y - pose.pos.y
        bearing = atan2(north, east) - yaw
        velocity = self._chassis.GetLinearVel()
        speed = velocity.x * cos(yaw) + velocity.y * sin(yaw)
        turn = self._chassis.GetAngularRate().z
        before, distance = now.seen[0], least(hypot(east, north), self.FARTHEST)
        now.seen[:] = (distance, cos(bearing), sin(bearing), clamp(speed, 3.0), clamp(turn, 10.0))
        now.reward = before - distance - 0.01 + where(distance < self.REACHED, 10.0, 0.0)
        now.ended = where((distance < self.REACHED) | (distance > self.LOST), 1.0, 0.0)


class FollowWall(WorldEnv):
    """A Pioneer2DX follows the wall on its right at 0.6 m by its laser.

    Actions: forward speed 0 to 0.5 m/s, turn rate -1 to 1 rad/s. Observation: 37 ranges from right to left [m], forward
    speed [m/s], turn rate [rad/s]. Reward: the metres it drove, times 1 at the right distance down to 0 where that is
    wrong by 0.4 m, and -5 for touching something, which ends the episode.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_nearest",)

    DISTANCE, TOLERANCE, TOUCH, REACH = 0.6, 0.4, 0.25, 8.0  # [m]
    RAYS = 37
    space = _box(*[(0.0, REACH)] * RAYS, (-3.0, 3.0), (-10.0, 10.0))

    def __init__(self, **options: Any) -> None:
        self._nearest = math.inf  # smallest range at the last reward [m]
        super().__init__(
            WORLDS / "follow_wall.world",
            {"position.robot1": {"cmd_vel_pos[0]": (0.0, 0.5), "cmd_vel_rot[2]": (-1.0, 1.0)}},
            (self.observe, self.space),
            self.score,
            lambda world, seen: self._nearest < self.TOUCH,
            start=self.begin,
            **{"time_limit": 40.0, **options},
        )

    def begin(self, world: World, random: np.random.Generator, options: dict[str, Any]) -> None:
        """Place the robot beside the south wall."""
        x, away, yaw = random.uniform((-2.5, 0.45, -0.3), (1.0, 0.9, 0.3)).tolist()
        robot = world.model("robot1")
        world.SetModelPose(robot, _flat_pose(x, -2.95 + away, robot.GetPose().pos.z, yaw))
        self._laser, self._position = world.interface("laser", "laser1"), world.interface("position", "robot1")

    def observe(self, world: World) -> Array:
        """What the robot measures."""
        data = self._position.data
        seen = np.empty(self.RAYS + 2)
        seen[: self.RAYS] = self._laser.ranges
        seen[self.RAYS :] = data.vel_pos[0], data.vel_rot[2]
        return _clipped(seen, self.space)

    def score(self, world: World, seen: Array, action: Any) -> float:
        """The reward."""
        values: list[float] = seen.tolist()
        right = min(values[: self.RAYS // 2])
        self._nearest = min(right, min(values[self.RAYS // 2 : self.RAYS]))
        if self._nearest < self.TOUCH:
            return -5.0
        wrong = abs(right - self.DISTANCE)
        return values[self.RAYS] * self.period * max(0.0, 1.0 - wrong / self.TOLERANCE)


class Balance(WorldEnv):
    """A SegwayRMP whose own controller is off balances by the torques of its wheels.

    Action: torque of each of the two wheels, -20 to 20 N m. Observation: pitch [rad], pitch rate [rad/s], travel [m],
    speed [m/s]. Reward: 1 a step, less what pitch, travel and torque cost. It ends beyond 0.5 rad, and 3 m away.
    """

    TORQUE, LARGEST_PITCH, FARTHEST = 20.0, 0.5, 3.0  # [N m], [rad], [m]
    HEIGHT = 0.24  # of the axle [m]
    space = _box((-math.pi, math.pi), (-20.0, 20.0), (-10.0, 10.0), (-10.0, 10.0))

    def __init__(self, **options: Any) -> None:
        super().__init__(
            WORLDS / "balance.world",
            {
                "robot1::left": {"effort": (-self.TORQUE, self.TORQUE)},
                "robot1::right": {"effort": (-self.TORQUE, self.TORQUE)},
            },
            self.space,
            start=self.begin,
            **{"period": 0.05, "settle": 0.0, "time_limit": 10.0, **options},
        )

    def begin(self, world: World, random: np.random.Generator, options: dict[str, Any]) -> None:
        """Lean the robot, and switch its controller off."""
        pitch = random.uniform(-0.1, 0.1)
        lowered = self.HEIGHT * (1.0 - math.cos(pitch))  # its frame is on the ground, the wheels turn about the axle
        pose = GzPose(GzVector(-self.HEIGHT * math.sin(pitch), 0.0, lowered), GzQuaternFromEuler(0.0, pitch, 0.0))
        robot = world.model("robot1")
        world.SetModelPose(robot, pose)
        world.interface("position", "robot1").enable_motors(False)
        self._base = robot.GetBody()

    @law
    def measure(self) -> None:
        """What the robot measures, the reward, and whether it has fallen or is too far away."""
        now, base = self.outcome, self._base
        pose = base.GetPose()
        pitch, travel = GzQuaternToEuler(pose.rot).y, clamp(pose.pos.x, 10.0)
        rate, speed = base.GetAngularRate().y, base.GetLinearVel().x
        now.seen[:] = (pitch, clamp(rate, 20.0), travel, clamp(speed, 10.0))
        left, right = now.action[0], now.action[1]
        effort = (left * left + right * right) / self.TORQUE**2
        lean, away = pitch / self.LARGEST_PITCH, travel / self.FARTHEST
        now.reward = 1.0 - lean * lean - 0.1 * (away * away) - 0.01 * effort
        now.ended = where((abs(pitch) > self.LARGEST_PITCH) | (abs(travel) > self.FARTHEST), 1.0, 0.0)


class TrackBall(WorldEnv):
    """A pan-tilt camera keeps a moving ball in view, by its images.

    Actions: pan -0.94 to 0.94 rad and tilt -0.6 to 0.6 rad that the head turns to. Observations: the image, 48 by 64
        pixels,
    and pan and tilt [rad]. Reward: 1 while the ball is in the middle of the image, down to 0 at its edge and beyond.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_rates", "_phases")

    AWAY, HEIGHT = 3.0, 1.05  # of the middle of the ball's path [m]
    WIDTH, RISE = 2.0, 0.7  # of the path to each side [m]

    def __init__(self, **options: Any) -> None:
        super().__init__(
            WORLDS / "track_ball.world",
            {"ptz.cam1": {"cmd_pan": (-0.94, 0.94), "cmd_tilt": (-0.6, 0.6)}},
            {"camera.cam1": ["image"], "ptz.cam1": ["pan", "tilt"]},
            self.score,
            start=self.begin,
            update=self.move,
            **{"time_limit": 20.0, **options},
        )

    def begin(self, world: World, random: np.random.Generator, options: dict[str, Any]) -> None:
        """Choose the ball's path."""
        self._rates = random.uniform((0.5, 0.4), (0.9, 0.8)).tolist()  # [rad/s]
        self._phases = random.uniform(-math.pi, math.pi, 2).tolist()
        ball = self._ball = world.model("ball")
        ball.GetBody().SetGravityMode(False)
        self._head, self._half_view = world.body("cam1", "head"), math.radians(30.0)
        self.move(world)

    def move(self, world: World) -> None:
        """Move the ball along its path."""
        now = world.GetSimTime()
        side, up = (math.sin(rate * now + phase) for rate, phase in zip(self._rates, self._phases, strict=True))
        world.SetModelPose(
            self._ball, _flat_pose(self.AWAY, self.WIDTH * side, self.HEIGHT + self.RISE * up - 0.2, 0.0)
        )

    def offset(self) -> float:
        """Angle between the camera's axis and the ball [rad]."""
        pose = self._head.GetPose()
        eye = GzVectorAdd(pose.pos, rotate(pose.rot, EYE.pos))
        ball = self._ball.GetPose().pos
        x, y, z = (there - here for there, here in zip((ball.x, ball.y, ball.z + 0.2), eye, strict=True))
        axis = rotate(pose.rot, (1.0, 0.0, 0.0))
        along = x * axis.x + y * axis.y + z * axis.z
        return math.acos(min(1.0, max(-1.0, along / math.sqrt(x * x + y * y + z * z))))

    def score(self, world: World, seen: Any, action: Any) -> float:
        """The reward."""
        return max(0.0, 1.0 - self.offset() / self._half_view)


class PendulumSwingUp(WorldEnv):
    """A pendulum of SDF is swung up by a motor that is too weak to lift it at once, and held upright.

    Action: torque -2 to 2 N m. Observation: cosine and sine of the angle from upright, rate [rad/s]. Reward:
    -(angle^2 + 0.1 rate^2 + 0.001 torque^2), the angle within +-pi [rad].
    """

    space = _box((-1.0, 1.0), (-1.0, 1.0), (-16.0, 16.0))

    def __init__(self, **options: Any) -> None:
        super().__init__(
            WORLDS / "pendulum.world",
            {"pendulum::pivot": ["effort"]},
            self.space,
            start=self.begin,
            **{"period": 0.05, "time_limit": 10.0, **options},
        )

    def begin(self, world: World, random: np.random.Generator, options: dict[str, Any]) -> None:
        """A random angle and rate."""
        angle, rate = random.uniform((-math.pi, -1.0), (math.pi, 1.0)).tolist()
        self._joint = _joints(world, "pendulum")["pivot"]
        self._joint.set_position(angle)
        self._joint.set_velocity(rate)

    @law
    def measure(self) -> None:
        """What is measured, and the reward."""
        now, rate = self.outcome, clamp(self._joint.velocity(), 16.0)
        cosine, sine = cos(self._joint.position()), sin(self._joint.position())
        now.seen[:] = (cosine, sine, rate)
        angle, torque = atan2(sine, cosine), now.action[0]
        now.reward = -(angle * angle + 0.1 * (rate * rate) + 0.001 * (torque * torque))


class DoublePendulum(WorldEnv):
    """Two rods of SDF, one on the other, are balanced on a cart.

    Action: force on the cart, -40 to 40 N. Observation: place of the cart [m], sine and cosine of both angles (of the
        lower
    rod from upright, of the upper one from the lower), their rates and the cart's speed. Reward: 1 a step, less what
    the
    tip's height and the cart's place cost. It ends when the tip sinks by 0.3 m, or the cart is near an end of its rail.
    """

    ROD, SUNK, END = 0.6, 0.3, 2.2  # [m]
    space = _box((-3.0, 3.0), *[(-1.0, 1.0)] * 4, (-20.0, 20.0), (-50.0, 50.0), (-50.0, 50.0))

    def __init__(self, **options: Any) -> None:
        super().__init__(
            WORLDS / "double_pendulum.world",
            {"robot::rail": ["effort"]},
            self.space,
            start=self.begin,
            **{"period": 0.02, "time_limit": 10.0, **options},
        )

    def begin(self, world: World, random: np.random.Generator, options: dict[str, Any]) -> None:
        """Small random angles."""
        joints = _joints(world, "robot")
        self._joints = tuple(joints[name] for name in ("rail", "shoulder", "elbow"))
        for joint, place in zip(self._joints, random.uniform(-0.03, 0.03, 3).tolist(), strict=True):
            joint.set_position(place)

    @law
    def measure(self) -> None:
        """What is measured, the reward, and whether the tip has sunk or the cart is near an end."""
        now, (rail, shoulder, elbow) = self.outcome, self._joints
        place, one, two = clamp(rail.position(), 3.0), shoulder.position(), elbow.position()
        sine, cosine, sine2, cosine2 = sin(one), cos(one), sin(two), cos(two)
        rates = (clamp(rail.velocity(), 20.0), clamp(shoulder.velocity(), 50.0), clamp(elbow.velocity(), 50.0))
        now.seen[:] = (place, sine, cosine, sine2, cosine2, *rates)
        sunk = self.ROD * (2.0 - cosine - (cosine * cosine2 - sine * sine2))
        away = place / self.END
        now.reward = 1.0 - sunk / self.SUNK - 0.1 * (away * away)
        now.ended = where((sunk > self.SUNK) | (abs(place) > self.END), 1.0, 0.0)


def _joints(world: World, model: str) -> dict[str, SdfJoint]:
    found: dict[str, SdfJoint] = getattr(world.model(model), "sdf_joints", {})
    return found


# The name after "libgz/", without its version -> the class.
TASKS: dict[str, type[WorldEnv]] = {
    "ReachGoal": ReachGoal,
    "FollowWall": FollowWall,
    "Balance": Balance,
    "TrackBall": TrackBall,
    "PendulumSwingUp": PendulumSwingUp,
    "DoublePendulum": DoublePendulum,
}
