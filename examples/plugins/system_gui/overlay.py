"""A GUI plugin for the client: a widget in its window shows the sim time and has a button that adds a sphere.

gzserver system_gui.world          # in one terminal
gzclient --verbose                 # in another: the world names this plugin in <gui>
"""

from libgz.classic import GZ_REGISTER_GUI_PLUGIN, GUIPlugin, gui, msgs, transport

SPHERE = """
<sdf version="1.5">
  <model name="{name}">
    <pose>0 0 3 0 0 0</pose>
    <link name="link">
      <collision name="collision">
        <geometry><sphere><radius>0.3</radius></sphere></geometry>
      </collision>
      <visual name="visual">
        <geometry><sphere><radius>0.3</radius></sphere></geometry>
      </visual>
    </link>
  </model>
</sdf>
"""


class Overlay(GUIPlugin):
    def Load(self, sdf):
        self.gui.Move(10, 10)
        self.gui.Resize(200, 40)
        self.gui.AddButton("Spawn sphere", self.OnButton)
        self.count = 0
        self.node = transport.Node()
        self.node.Init(gui.get_world())
        # The server is another process, so the client requests changes by a topic.
        self.publisher = self.node.Advertise(msgs.Factory, "~/factory")
        self.subscriber = self.node.Subscribe("~/world_stats", self.OnStatistics)

    def OnStatistics(self, message):
        self.gui.SetText(f"{message.sim_time.sec + 1e-9 * message.sim_time.nsec:.2f} s")

    def OnButton(self):
        # Messages are lost until the server has connected to a new publisher.
        self.publisher.WaitForConnection(5.0)
        self.publisher.Publish(msgs.Factory(sdf=SPHERE.format(name=f"sphere_{self.count}")))
        self.count += 1


GZ_REGISTER_GUI_PLUGIN(Overlay)
