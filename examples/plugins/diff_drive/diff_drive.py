"""A Model plugin that drives its model around a square by the topic that the ready DiffDrivePlugin subscribes to.

The model has two plugins: libDiffDrivePlugin, which comes with libgz, turns messages into wheel speeds; this one sends
the messages. Another program could do so as well.
"""

import math

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin, msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Pose3d

TURN_RATE = 0.5  # [rad/s]


class DriveSquare(ModelPlugin):
    """Elements: `<side>` [m], `<speed>` [m/s]."""

    STATE = ("sent",)

    def Load(self, model, sdf):
        side, speed = self.LoadParam(sdf, "side", 1.0), self.LoadParam(sdf, "speed", 0.2)
        # (end [s], forward [m/s], turn [rad/s]) of one side and one corner, repeated.
        self.straight, self.corner = side / speed, math.pi / 2.0 / TURN_RATE
        self.speed = speed
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.Pose, f"~/{model.GetName()}/vel_cmd")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        self.Reset()

    def Reset(self):
        self.sent = None

    def OnUpdate(self, info):
        phase = info.simTime.Double() % (self.straight + self.corner)
        # position.x is the forward speed, the yaw of the orientation the turn rate; a positive one turns right.
        command = (self.speed, 0.0) if phase < self.straight else (0.0, -TURN_RATE)
        if command != self.sent:
            message = msgs.Pose()
            msgs.Set(message, Pose3d(command[0], 0.0, 0.0, 0.0, 0.0, command[1]))
            self.publisher.Publish(message)
            self.sent = command


GZ_REGISTER_MODEL_PLUGIN(DriveSquare)
