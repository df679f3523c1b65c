"""A World plugin that inserts models: from a file, from a string, from an SDF document, and by a message."""

from libgz.classic import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin, msgs, sdf, transport
from libgz.classic.math import Pose3d, Quaterniond, Vector3d

SPHERE = """
<sdf version="1.4">
  <model name="sphere">
    <pose>1 0 2 0 0 0</pose>
    <link name="link">
      <collision name="collision">
        <geometry><sphere><radius>0.5</radius></sphere></geometry>
      </collision>
      <visual name="visual">
        <geometry><sphere><radius>0.5</radius></sphere></geometry>
      </visual>
    </link>
  </model>
</sdf>
"""


class Factory(WorldPlugin):
    STATE = ()  # the world remembers what was inserted

    def Load(self, world, element):
        # 1. A file: model:// is searched in GAZEBO_MODEL_PATH and in the models of libgz.
        world.InsertModelFile("model://pioneer2dx")

        # 2. A string.
        world.InsertModelString(SPHERE)

        # 3. An SDF document, which can be edited before: here its name and pose.
        document = sdf.SDF()
        document.SetFromString(SPHERE)
        model = document.Root().GetElement("model")
        model.GetAttribute("name").SetFromString("another_sphere")
        model.GetElement("pose").Set(Pose3d(2.5, 0.0, 3.0, 0.0, 0.0, 0.0))
        world.InsertModelSDF(document)

        # 4. A message, which can also come from another program: here with a pose in addition to the model.
        self.node = transport.Node()
        self.node.Init(world.Name())
        publisher = self.node.Advertise(msgs.Factory, "~/factory")
        message = msgs.Factory()
        message.sdf = SPHERE.replace('sphere"', 'third_sphere"')
        msgs.Set(message.pose, Pose3d(Vector3d(-2.0, 0.0, 1.0), Quaterniond(0.0, 0.0, 0.0)))
        publisher.Publish(message)


GZ_REGISTER_WORLD_PLUGIN(Factory)
