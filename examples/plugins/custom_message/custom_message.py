"""A World plugin with messages of its own: asked for the heights along a line, it answers what rays find there.

A message type is declared with its fields. Another program that declares it alike, by importing this file for example,
can ask, too; the test of this example shows how.
"""

from libgz.classic import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin, msgs, transport
from libgz.classic.math import Vector3d

# Fields may be messages: `begin` and `end` are gazebo.msgs.Vector3d. [] makes a list, = a value where none is set.
Survey = msgs.declare("survey.msgs.Survey", "Vector3d begin, Vector3d end, uint32 count = 2, double from_height = 10")
Heights = msgs.declare("survey.msgs.Heights", "survey.msgs.Survey question, double height[], string entity[]")


class Surveyor(WorldPlugin):
    def Load(self, world, sdf):
        # A ray in the world frame.
        self.ray = world.Physics().CreateShape("ray")
        self.node = transport.Node()
        self.node.Init(world.Name())
        self.publisher = self.node.Advertise(Heights, "~/survey/heights")
        self.subscriber = self.node.Subscribe("~/survey", self.OnSurvey)

    def OnSurvey(self, message):
        # Messages are delivered between two iterations: nothing moves while this runs.
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
