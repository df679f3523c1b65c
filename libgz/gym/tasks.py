"""Ready tasks: environments with a world, a start, a reward and an end of their own. docs/gym.md describes them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

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

    def __init__(self, **options: Any) -> None:
        self._before = 0.0  # distance [m]
        super().__init__(
            WORLDS / "reach_goal.world",
            {"position.robot1": {"cmd_vel_pos[0]": (-0.5, 0.7), "cmd_vel_rot[2]": (-1.5, 1.5)}},
            (self.observe, self.space),
            self.score,
            self.ended,
            start=self.begin,
            info=lambda world: {"reached": self._before < self.REACHED},
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
        self._goal = x, y
        marker = world.model("goal")
        marker.GetBody().SetGravityMode(False)
        world.SetModelPose(marker, _flat_pose(x, y, 1.2, 0.0))
        robot = world.model("robot1")
        world.SetModelPose(robot, _flat_pose(0.0, 0.0, robot.GetPose().pos.z, yaw))
        self._chassis = robot.GetBody()
        self._before = math.hypot(x, y)

    def observe(self, world: World) -> Array:
        """What the robot sees."""
        body = self._chassis
        (x, y, _), rotation = body.GetPosition(), body.GetRotation()
        yaw = GzQuaternToEuler(rotation).z
        east, north = self._goal[0] - x, self._goal[1] - y
        bearing = math.atan2(north, east) - yaw
        velocity = body.GetLinearVel()
        speed = velocity.x * math.cos(yaw) + velocity.y * math.sin(yaw)
        turn = body.GetAngularRate().z
        return _clipped((math.hypot(east, north), math.cos(bearing), math.sin(bearing), speed, turn), self.space)

    def score(self, world: World, seen: Array, action: Any) -> float:
        """The reward."""
        before, self._before = self._before, float(seen[0])
        return before - self._before - 0.01 + (10.0 if self._before < self.REACHED else 0.0)

    def ended(self, world: World, seen: Array) -> bool:
        """Whether the goal is reached or lost."""
        return not self.REACHED <= seen[0] <= self.LOST


class FollowWall(WorldEnv):
    """A Pioneer2DX follows the wall on its right at 0.6 m by its laser.

    Actions: forward speed 0 to 0.5 m/s, turn rate -1 to 1 rad/s. Observation: 37 ranges from right to left [m], forward
    speed [m/s], turn rate [rad/s]. Reward: the metres it drove, times 1 at the right distance down to 0 where that is
    wrong by 0.4 m, and -5 for touching something, which ends the episode.
    """

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
        self._pitch = self._travel = 0.0  # to either side, when scored [rad], [m]
        super().__init__(
            WORLDS / "balance.world",
            {
                "robot1::left": {"effort": (-self.TORQUE, self.TORQUE)},
                "robot1::right": {"effort": (-self.TORQUE, self.TORQUE)},
            },
            (self.observe, self.space),
            self.score,
            lambda world, seen: self._pitch > self.LARGEST_PITCH or self._travel > self.FARTHEST,
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

    def observe(self, world: World) -> Array:
        """What the robot measures."""
        base = self._base
        position, rotation, velocity = base.GetPosition(), base.GetRotation(), base.GetLinearVel()
        pitch = GzQuaternToEuler(rotation).y
        return _clipped((pitch, base.GetAngularRate().y, position.x, velocity.x), self.space)

    def score(self, world: World, seen: Array, action: Any) -> float:
        """The reward."""
        pitch, _, travel, _ = seen.tolist()
        self._pitch, self._travel = abs(pitch), abs(travel)
        left, right = (min(abs(float(one)), self.TORQUE) for one in action)
        effort = (left**2 + right**2) / self.TORQUE**2
        return float(1.0 - (pitch / self.LARGEST_PITCH) ** 2 - 0.1 * (travel / self.FARTHEST) ** 2 - 0.01 * effort)


class TrackBall(WorldEnv):
    """A pan-tilt camera keeps a moving ball in view, by its images.

    Actions: pan -0.94 to 0.94 rad and tilt -0.6 to 0.6 rad that the head turns to. Observations: the image, 48 by 64
        pixels,
    and pan and tilt [rad]. Reward: 1 while the ball is in the middle of the image, down to 0 at its edge and beyond.
    """

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
            (self.observe, self.space),
            self.score,
            start=self.begin,
            **{"period": 0.05, "time_limit": 10.0, **options},
        )

    def begin(self, world: World, random: np.random.Generator, options: dict[str, Any]) -> None:
        """A random angle and rate."""
        angle, rate = random.uniform((-math.pi, -1.0), (math.pi, 1.0)).tolist()
        self._joint = _joints(world, "pendulum")["pivot"]
        self._joint.set_position(angle)
        self._joint.set_velocity(rate)

    def observe(self, world: World) -> Array:
        """What is measured."""
        angle = self._joint.position()
        return _clipped((math.cos(angle), math.sin(angle), self._joint.velocity()), self.space)

    def score(self, world: World, seen: Array, action: Any) -> float:
        """The reward."""
        cosine, sine, rate = seen.tolist()
        angle, torque = math.atan2(sine, cosine), min(abs(float(action[0])), 2.0)
        return float(-(angle**2 + 0.1 * rate**2 + 0.001 * torque**2))


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
        self._sunk = self._away = 0.0  # tip below its highest place, cart from the middle, when scored [m]
        super().__init__(
            WORLDS / "double_pendulum.world",
            {"robot::rail": ["effort"]},
            (self.observe, self.space),
            self.score,
            lambda world, seen: self._sunk > self.SUNK or self._away > self.END,
            start=self.begin,
            **{"period": 0.02, "time_limit": 10.0, **options},
        )

    def begin(self, world: World, random: np.random.Generator, options: dict[str, Any]) -> None:
        """Small random angles."""
        joints = _joints(world, "robot")
        self._joints = [joints[name] for name in ("rail", "shoulder", "elbow")]
        for joint, place in zip(self._joints, random.uniform(-0.03, 0.03, 3).tolist(), strict=True):
            joint.set_position(place)

    def observe(self, world: World) -> Array:
        """What is measured."""
        rail, shoulder, elbow = self._joints
        one, two = shoulder.position(), elbow.position()
        angles = (math.sin(one), math.cos(one), math.sin(two), math.cos(two))
        rates = (rail.velocity(), shoulder.velocity(), elbow.velocity())
        return _clipped((rail.position(), *angles, *rates), self.space)

    def score(self, world: World, seen: Array, action: Any) -> float:
        """The reward."""
        place, sine, cosine, sine2, cosine2, *_ = seen.tolist()
        self._sunk = self.ROD * (2.0 - cosine - (cosine * cosine2 - sine * sine2))
        self._away = abs(place)
        return float(1.0 - self._sunk / self.SUNK - 0.1 * (place / self.END) ** 2)


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
