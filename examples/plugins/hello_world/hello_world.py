"""The smallest plugin: it prints a line when the world is loaded."""

from libgz.classic import GZ_REGISTER_WORLD_PLUGIN, WorldPlugin


class WorldPluginTutorial(WorldPlugin):
    STATE = ()  # nothing of its own to remember

    def __init__(self):
        super().__init__()
        print("Hello World!", flush=True)

    def Load(self, world, sdf):
        pass


GZ_REGISTER_WORLD_PLUGIN(WorldPluginTutorial)
