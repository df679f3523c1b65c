"""ExampleModel: an example of a plugin model.

A box on two wheels and a skid. It serves a `position` interface: a client reads its odometry and sets its velocity.
README.md in this folder explains it step by step.
"""

import math
from dataclasses import dataclass

from libgz import (
    GZ_REGISTER_PLUGIN,
    Body,
    BoxGeom,
    GzColor,
    GzQuaternFromAxis,
    HingeJoint,
    Model,
    SphereGeom,
    UpdateRate,
    WheelGeom,
    dParamFMax,
    dParamVel,
    gz_position_alloc,
    gz_position_create,
    gz_position_destroy,
    gz_position_lock,
    gz_position_unlock,
)
from libgz.worldfile.attributes import color, number, read

WHEEL_RADIUS = 0.08  # [m]
WHEEL_SEPARATION = 0.30  # [m]
MAX_TORQUE = 2.0  # [N m]


@dataclass(frozen=True)
class ExampleAttributes:
    """Attributes of <model:ExampleModel>."""

    updateRate: float = number(10.0, unit="Hz", above=0.0, help="updates of the interface per second")
    color: GzColor = color(0.2, 0.4, 0.9, help="colour of the chassis")


class ExampleModel(Model):
    """Two driven wheels and a skid; the origin is on the ground below the axle."""

    STATE = ("rate", "x", "y", "yaw")  # what changes while it runs: states and resets of the world keep it

    def Load(self, file, node):
        """Create bodies and joints in the model's own frame: x forward, y left, z up."""
        values = read(ExampleAttributes, node)
        self.rate = UpdateRate(values.updateRate)
        self.x = self.y = self.yaw = 0.0  # odometry

        chassis = Body(self.world)
        self.AddBody(chassis, True)  # the canonical body: its pose is the model's pose
        box = BoxGeom(chassis, self.modelSpaceId, 0.36, 0.24, 0.10)
        box.SetRelativePosition((-0.08, 0, 0.10))
        box.SetMass(3.0)
        box.SetColor(values.color)
        skid = SphereGeom(chassis, self.modelSpaceId, 0.03)
        skid.SetRelativePosition((-0.22, 0, 0.03))
        skid.SetMass(0.1)
        skid.SetFriction(0)

        self.left = self.make_wheel("left_wheel", WHEEL_SEPARATION / 2, -math.pi / 2)
        self.right = self.make_wheel("right_wheel", -WHEEL_SEPARATION / 2, math.pi / 2)

    def make_wheel(self, name, y, roll):
        """A wheel and the hinge that drives it."""
        wheel = Body(self.world, name)
        self.AddBody(wheel)
        tire = WheelGeom(wheel, self.modelSpaceId, WHEEL_RADIUS, 0.02)
        tire.SetMass(0.4)
        wheel.SetPosition((0, y, WHEEL_RADIUS))
        wheel.SetRotation(GzQuaternFromAxis(1, 0, 0, roll))  # wheels turn about their own z axis

        hinge = HingeJoint(self.world, name=name)
        hinge.Attach(wheel, self.GetBody())
        hinge.SetAnchor((0, y, WHEEL_RADIUS))
        hinge.SetAxis((0, 1, 0))
        return hinge

    def Init(self, file, node):
        """Create the interface; all models are loaded, and the server is running."""
        self.position = gz_position_alloc()
        owner = (self.GetId(), "ExampleModel", self.GetIntId(), self.GetParentIntId())
        if gz_position_create(self.position, self.world.gz_server, *owner) != 0:
            return -1
        self.position.data.cmd_enable_motors = 1
        return 0

    def Update(self, step):
        """Called once a step; `step` is its length in seconds, 0 while the world is paused."""
        if step == 0:
            return
        left, right = (step * WHEEL_RADIUS * joint.GetAngleRate() for joint in (self.left, self.right))
        self.x += (left + right) / 2 * math.cos(self.yaw)
        self.y += (left + right) / 2 * math.sin(self.yaw)
        self.yaw += (right - left) / WHEEL_SEPARATION
        if self.rate.due(self.world.GetSimTime()) and gz_position_lock(self.position, 1) == 0:
            self.exchange(self.position.data)
            gz_position_unlock(self.position)

    def exchange(self, data):
        """Take the client's command, set the motors, and publish the pose."""
        speed, turn = data.cmd_vel_pos[0], data.cmd_vel_rot[2]
        if not (data.cmd_enable_motors and math.isfinite(speed) and math.isfinite(turn)):
            speed = turn = 0.0
        for joint, side in ((self.left, -1), (self.right, 1)):
            joint.SetParam(dParamVel, (speed + side * turn * WHEEL_SEPARATION / 2) / WHEEL_RADIUS)
            joint.SetParam(dParamFMax, MAX_TORQUE)
        data.time = self.world.GetSimTime()
        data.pos[0], data.pos[1], data.rot[2] = self.x, self.y, self.yaw

    def Fini(self):
        """Destroy the interface; the world ends."""
        gz_position_destroy(self.position)


GZ_REGISTER_PLUGIN("ExampleModel", ExampleModel)
