"""Client: shows a server's world to GUI and Visual plugins, and takes images of it."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from libgz.base.closing import Closing
from libgz.base.errors import NotFoundError, PluginError
from libgz.base.geometry import GzPose
from libgz.classic import msgs
from libgz.classic.commands import reload_response
from libgz.classic.event import Connection
from libgz.classic.gui import Events, MainWindow, set_main_window
from libgz.classic.gui.named import gui_of, named_plugins
from libgz.classic.gui.scene_link import SceneLink
from libgz.classic.gui.window import Desktop
from libgz.classic.loading import LoadedPlugin, new_plugin, reload_all
from libgz.classic.math import Vector3d
from libgz.classic.rendering.camera import render_frame
from libgz.classic.rendering.scene import scene_of
from libgz.classic.rendering.user_camera import UserCamera
from libgz.classic.transport import Subscriber, request
from libgz.sdf.element import Element

__all__ = ["Client"]

log = logging.getLogger("libgz.classic")

SIZE = (800, 600)  # [px]
NEAR, FAR = 0.1, 1000.0  # [m]


class Client(Closing):
    """A client without a window: its main window is an object, its user camera renders into memory.

    Args:
        size: of the user camera's image [px].
        pose: of the user camera [m]; else from the world's `<gui>`, or Gazebo's default.
        filenames: GUI plugins of the command line.

    Raises:
        ServerError: no world answers.
        LibraryError: OpenGL does not work here.
    """

    def __init__(self, size: tuple[int, int] = SIZE, pose: GzPose | None = None, filenames: Sequence[str] = ()) -> None:
        self.plugins: list[LoadedPlugin] = []
        self._connections: Sequence[object] = ()
        self.link = SceneLink()
        self.world = self.link.world
        try:
            camera = UserCamera(self.world, "user_camera", *size, near=NEAR, far=FAR)
            controls = self.link.node.Advertise(msgs.WorldControl, "~/world_control")
            self.window = MainWindow(scene_of(self.world), camera, controls)
            self.window.frame = self.frame
            set_main_window(self.window)
            self._aim(camera, pose)
            for filename, name, element in named_plugins(filenames, self.world.SDF()):
                self._load(filename, name, element)
            self.world.server.serve_visuals().add()
            self._responses = self.link.node.Advertise(msgs.Response, "~/response")
            self._reloads = self.link.node.Subscribe("~/plugin/reload", self._on_reload)
            self._connections = [*self._obey(), *self._report()]
            Events.mainWindowReady()
            self._report_all()
        except BaseException:
            self.close()
            raise

    def _aim(self, camera: UserCamera, pose: GzPose | None) -> None:
        """Place the user camera."""
        gui = gui_of(self.world.SDF())
        element = next(gui.named("camera"), None) if gui is not None else None
        if pose is None and element is not None and element.HasElement("pose"):
            pose = element.Get(GzPose, "pose")
        if pose is not None:
            camera.SetDefaultPose(pose)
        if element is not None:
            camera.SetViewController(element.Get(str, "view_controller"))
            name = element.child("track_visual").Get(str, "name") if element.HasElement("track_visual") else ""
            if name not in ("", "__default__"):
                track = element.child("track_visual")
                camera.TrackVisual(name)
                camera.SetTrackMinDistance(track.Get(float, "min_dist", 0.0)[0])
                camera.SetTrackMaxDistance(track.Get(float, "max_dist", 0.0)[0])
                camera.SetTrackIsStatic(track.Get(bool, "static", False)[0])
                camera.SetTrackUseModelFrame(track.Get(bool, "use_model_frame", True)[0])
                camera.SetTrackInheritYaw(track.Get(bool, "inherit_yaw", False)[0])
                camera.SetTrackPosition(track.Get(Vector3d, "xyz", Vector3d(-5.0, 0.0, 3.0))[0])

    # Events ------------------------------------------------------------------------------------------------------

    def _obey(self) -> Sequence[Connection]:
        """Obey what plugins signal, as Gazebo's window does."""
        window, camera = self.window, self.window.camera

        def show(shown: Callable[[Desktop, bool], object]) -> Callable[[bool], object]:
            return lambda on: shown(window.desktop, on) if window.desktop is not None else None

        return (
            Events.ConnectFollow(camera.TrackVisual),
            Events.ConnectFPS(lambda: camera.SetViewController("fps")),
            Events.ConnectOrbit(lambda: camera.SetViewController("orbit")),
            Events.ConnectFullScreen(show(lambda desktop, on: desktop.show_full_screen(on))),
            Events.ConnectLeftPaneVisibility(show(lambda desktop, on: desktop.show_left_pane(on))),
        )

    def _report(self) -> Sequence[Subscriber]:
        """Signal the models and lights that the server publishes."""
        topics = {"~/model/info": Events.modelUpdate, "~/light/modify": Events.lightUpdate}
        topics["~/factory/light"] = Events.lightUpdate
        return [self.link.node.Subscribe(topic, event) for topic, event in topics.items()]

    def _report_all(self) -> None:
        """Signal the models and lights that there are."""
        if Events.modelUpdate:
            answer = request(self.link.node.GetTopicNamespace(), "entity_list")
            for model in msgs.Model_V.FromString(answer.serialized_data).models:
                Events.modelUpdate(model)
        for light in self.world.Lights() if Events.lightUpdate else ():
            message = msgs.Light()
            light.FillMsg(message)
            Events.lightUpdate(message)

    # Plugins -----------------------------------------------------------------------------------------------------

    def _load(self, filename: str, name: str, element: Element) -> None:
        where = element.where if element.line else ""
        loaded = new_plugin("GUI", filename, name, "System", self.world.core.events, where=where)
        if loaded is None or loaded.plugin is None:
            log.error("Unable to create gui overlay plugin with filename[%s]", filename)
            return
        loaded.prepare = lambda plugin: setattr(plugin, "gui", self.window.AddPlace(name))
        if loaded.start(element):
            self.plugins.append(loaded)

    # Reload ------------------------------------------------------------------------------------------------------

    def reload_plugin(self, name: str) -> list[str]:
        """Load the edited files of GUI, Visual and System plugins of this process again; what was replaced.

        Raises:
            NotFoundError: no plugin has this name.
            PluginError: an edited file fails; what ran before runs on.
        """
        own = [plugin for plugin in self.plugins if plugin.called(name, "")]
        others = self.world.server.plugins
        if not own and not others.has_plugin(name):
            names = [*(plugin.name for plugin in self.plugins), *others.plugin_names()]
            raise NotFoundError(f"the client has no plugin {name!r}; it has {', '.join(names) or 'none'}")
        places = dict(self.window.places)
        try:
            reload_all(own)
        except PluginError:
            self.window.places.update(places)
            raise
        return [*(f"GUI plugin {plugin.name}" for plugin in own), *others.reload_plugin(name)]

    def _on_reload(self, message: Any) -> None:
        self._responses.Publish(reload_response(message, self.reload_plugin))

    # Frames ------------------------------------------------------------------------------------------------------

    def frame(self, image: bool = False) -> None:
        """Update the world from the server, and render if an image is requested here or by callbacks."""
        self.link.update()
        camera = self.window.camera
        camera.Update()
        render_frame(self.world, [camera] if image or camera.wanted else [])

    def run(self, rate: float) -> Iterator[None]:
        """Take frames at a rate of wall-clock time [Hz] until the window is closed, one per `next`."""
        due = time.monotonic()
        while self.window.open:
            self.frame()
            yield
            due = max(due + 1.0 / rate, time.monotonic())
            wait = max(due - time.monotonic(), 0.0)
            if self.window.desktop is not None:
                self.window.desktop.turn(wait)
            else:
                time.sleep(wait)

    def close(self) -> None:
        """Close the client. Can be called twice."""
        for plugin in self.plugins:
            plugin.drop()
        self.plugins.clear()
        self._connections = ()
        window: MainWindow | None = getattr(self, "window", None)
        if window is not None:
            if window.desktop is not None:
                window.desktop.close()
            window.camera.close()
        set_main_window(None)
        self.link.close()
