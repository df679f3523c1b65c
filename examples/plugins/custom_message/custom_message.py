"""A World plugin with its own message types: it responds to a request with heights along a line, measured by rays.

A message type is declared with its fields. Another program with the same declaration,
for example by importing this file, can send requests; the test of this example shows how.
"""

from libgz.classic import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin, msgs, transport
from libgz.classic.math import Vector3d

# Fields may be messages: `begin` and `end` are gazebo.msgs.Vector3d. [] declares a list, = a default.
Survey = msgs.declare("survey.msgs.Survey", "Vector3d begin, Vector3d end, uint32 count = 2, double from_height = 10")
Heights = msgs.declare("survey.msgs.Heights", "survey.msgs.Survey question, double height[], string entity[]")


class Surveyor(WorldPlugin):
    STATE = ()  # nothing of its own to remember

    def Load(self, world, sdf):
        # A ray without a link; its ends are set below.
        self.ray = world.Physics().CreateShape("ray")
        self.node = transport.Node()
        self.node.Init(world.Name())
        self.publisher = self.node.Advertise(Heights, "~/survey/heights")
        self.subscriber = self.node.Subscribe("~/survey", self.OnSurvey)

    def OnSurvey(self, message):
        # Messages are delivered between two iterations, so nothing moves during this callback.
        begin, end = (Vector3d(msgs.ConvertIgn(point)) for point in (message.begin, message.end))
        answer = Heights(question=message)
        for number in range(message.count):
            point = begin + (end - begin) * (number / max(1, message.count - 1))
            above = Vector3d(point.X(), point.Y(), message.from_height)
            below = Vector3d(point.X(), point.Y(), point.Z() - 1.0)
            self.ray.SetPoints(above, below)
            distance, entity = self.ray.GetIntersection()
            answer.height.append(message.from_height - distance if entity else 0.0)
            answer.entity.append(entity)
        self.publisher.Publish(answer)


GZ_REGISTER_WORLD_PLUGIN(Surveyor)
