"""A System plugin for the server: it is loaded before any world, and receives the events of all worlds.

gzserver -s libsystem_gui.so --iters 100 system_gui.world
"""

from libgz.classic import GZ_REGISTER_SYSTEM_PLUGIN, SystemPlugin, gzmsg
from libgz.classic.event import Events


class ServerWatcher(SystemPlugin):
    def Load(self, argc, argv):
        # The whole command line, including options for plugins that the server does not know.
        gzmsg(f"started as {' '.join(argv)}")
        self.updates = 0

    def Init(self):
        self.connections = [
            Events.ConnectWorldCreated(lambda name: gzmsg(f"world {name} is there")),
            Events.ConnectWorldUpdateBegin(self.OnUpdate),
            Events.ConnectStop(self.OnStop),
            Events.ConnectSigInt(lambda: gzmsg("somebody pressed Ctrl-C")),
        ]

    def OnUpdate(self, info):
        self.updates += 1
        if self.updates % 50 == 0:
            gzmsg(f"{info.worldName} has reached {info.simTime.Double():.3f} s")

    def OnStop(self):
        gzmsg(f"{self.updates} updates in all")


GZ_REGISTER_SYSTEM_PLUGIN(ServerWatcher)
