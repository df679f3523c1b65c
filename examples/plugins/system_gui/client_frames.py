"""A System plugin for the client: it saves the first images of the user camera in a folder.

Options that gzclient does not know are left to its plugins:

    gzclient -g libclient_frames.so --frames-to=frames
"""

from libgz.classic import GZ_REGISTER_SYSTEM_PLUGIN, SystemPlugin, gui, gzmsg
from libgz.classic.event import Events

OPTION = "--frames-to="
FRAMES = 5


class ClientFrames(SystemPlugin):
    def Load(self, argc, argv):
        self.folder = next((word.removeprefix(OPTION) for word in argv if word.startswith(OPTION)), ".")
        self.frames = 0

    def Init(self):
        # There is no camera yet: the window is created after the System plugins.
        self.connections = [Events.ConnectPreRender(self.OnPreRender)]

    def OnPreRender(self):
        camera = gui.get_active_camera()
        if camera is not None and len(self.connections) == 1:
            camera.SetSaveFramePathname(self.folder)
            camera.EnableSaveFrame(True)
            self.connections.append(camera.ConnectNewImageFrame(self.OnFrame))
            gzmsg(f"saving {FRAMES} frames of {camera.Name()} in {self.folder}")
        if self.frames == FRAMES:
            camera.EnableSaveFrame(False)
            self.connections.clear()

    def OnFrame(self):
        self.frames += 1


GZ_REGISTER_SYSTEM_PLUGIN(ClientFrames)
