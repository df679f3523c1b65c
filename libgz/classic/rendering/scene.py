"""Scene: the rendered part of a world."""

from __future__ import annotations

import functools
import logging
import math
import weakref
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from libgz.base.errors import LibraryError, ParameterError, StateError, nearest
from libgz.base.geometry import GzColor, GzPose, VectorLike
from libgz.classic.common import Time
from libgz.classic.math import Color
from libgz.classic.names import takes_names
from libgz.classic.physics import World, get_world
from libgz.classic.rendering.aids import aids_of
from libgz.classic.rendering.camera import Camera
from libgz.classic.rendering.depth_camera import DepthCamera
from libgz.classic.rendering.light import Light
from libgz.classic.rendering.lines import DynamicLines, placed
from libgz.classic.rendering.meshes import distance_along
from libgz.classic.rendering.user_camera import UserCamera
from libgz.classic.rendering.visual import Visual
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.rendering.overlay import CORNERS, EDGES
from libgz.rendering.renderer import FOGS
from libgz.rendering.shot import Lines, View
from libgz.sdfworld.light import SdfLight
from libgz.sdfworld.model import SdfModel
from libgz.sdfworld.visual import set_sky
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic.physics.light import Light as WorldLight
    from libgz.classic.physics.link import Link
    from libgz.classic.physics.model import Model

__all__ = ["Scene", "get_scene", "scene_of"]

log = logging.getLogger("libgz.classic")

C = TypeVar("C", bound=Camera)
UserCamera_ = UserCamera  # inside Scene the name is a method's

CELLS, CELL = 20, 1.0  # of the grid, [m]
GREY, WHITE = (0.3, 0.3, 0.3), (1.0, 1.0, 1.0)
NOON = 10.0  # [h] time of day of a sky that is switched on


def scene_of(world: World) -> Scene:
    """The scene of a world."""
    return world.core.extension(_new_scene)


def _new_scene(core: CoreWorld) -> Scene:
    return Scene(core.facade)


@takes_names
def get_scene(name: str = "") -> Scene:
    """The scene of a world by its name; without one, of the running plugin's world, or the first.

    Raises:
        NotFoundError: there is no such world.
    """
    return scene_of(get_world(name))


@functools.cache
def _log_once(what: str) -> None:
    log.info("%s", what)


@takes_names
class Scene:
    """The rendered part of a world: visuals, lights, cameras, background."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.lines: list[DynamicLines] = []
        self.made: list[Visual] = []  # that plugins made
        self.edited: dict[Visual, tuple[Any, ...]] = {}  # visuals that were changed, with their states before that
        self._cameras: list[Camera] = []
        self._highlighted: list[Visual] = []
        self._marked: list[Visual] = []  # that show wires or aids
        self._static: Body | None = None
        self._root = Visual.of(self, "__world_node__", None, frame=GzPose, members=self._model_visuals)
        world.server.scene = self
        element = world.SDF()
        scene = element.child("scene") if element is not None and element.name == "world" else None
        self.grid = scene.Get(bool, "grid") if scene is not None and scene.HasElement("grid") else True
        # The backdrop belongs to the engine's world, which must not keep this scene alive.
        this = weakref.ref(self)
        world.core.backdrop.lines.append(lambda view: () if (alive := this()) is None else alive._lines_for(view))

    def Name(self) -> str:
        """The world's name."""
        return self.world.Name()

    GetName = Name

    def IsServer(self) -> bool:
        """Whether the scene is the server's: it always is, for clients show pages."""
        return True

    def Initialized(self) -> bool:
        """Whether it can be rendered: always."""
        return True

    GetInitialized = Initialized

    def SimTime(self) -> Time:
        """Simulated time."""
        return self.world.SimTime()

    GetSimTime = SimTime

    # Visuals -----------------------------------------------------------------------------------------------------

    def WorldVisual(self) -> Visual:
        """The visual that contains all others."""
        return self._root

    GetWorldVisual = WorldVisual

    def CreateVisual(self, name: str) -> Visual:
        """A new visual without a shape, at the origin."""
        return Visual(name, self)

    def visuals(self) -> Iterator[Visual]:
        """All visuals, parents first."""
        yield from self._root.tree()

    def GetVisual(self, which: str | int) -> Visual | Any:
        """A visual by its full name ``model::link::visual``, or number; None if there is none."""
        if isinstance(which, int):
            return next((visual for visual in self.visuals() if visual.GetId() == which), None)
        name = which.removeprefix(f"{self.Name()}::")
        return next((visual for visual in self.visuals() if visual.Name() == name), None)

    def VisualCount(self) -> int:
        """The number of visuals, groups included."""
        return sum(1 for _ in self.visuals())

    GetVisualCount = VisualCount

    def GetModelVisualAt(self, camera: Camera, mousePos: Sequence[int]) -> Visual | Any:
        """The model at a pixel of a camera's last image; None for none."""
        x, y = int(mousePos[0]), int(mousePos[1])
        try:
            number = int(camera.core.segmentation[y, x])
        except (IndexError, LibraryError):
            return None
        core = next((core for core in self.world.core.entities if core.GetIntId() == number), None)
        return self.model_visual(self.world.view(core)) if core is not None and not isinstance(core, SdfLight) else None

    ModelVisualAt = GetModelVisualAt

    def VisualAt(self, camera: Camera, mousePos: Sequence[int]) -> Visual | Any:
        """The visual of a link at a pixel of a camera's last image, such as ``m::link::visual``; None for none."""
        model = self.GetModelVisualAt(camera, mousePos)
        if model is None:
            return None
        start, direction = camera.CameraToViewportRay(int(mousePos[0]) + 0.5, int(mousePos[1]) + 0.5)
        nearest_yet, found = math.inf, model  # at its very edge a ray may miss it
        for part in model.tree():
            for geom in part.geoms:
                distance = distance_along(geom, start, direction) if geom.appearance.visible else math.inf
                if distance < nearest_yet:
                    nearest_yet, found = distance, part
        return found

    GetVisualAt = VisualAt

    def RemoveVisual(self, which: Visual | str | int) -> None:
        """Remove a visual that a plugin made, by itself, name or number; others are left."""
        found = which if isinstance(which, Visual) else self.GetVisual(which)
        if found is not None:
            found.Fini()

    def StripSceneName(self, name: str) -> str:
        """A full name without the world's name before it."""
        return name.removeprefix(f"{self.Name()}::")

    def PrintSceneGraph(self) -> str:
        """The names of all visuals, one a line, indented by depth."""
        return "".join(f"{'  ' * visual.GetDepth()}{visual.Name()}\n" for visual in self.visuals())

    def DrawLine(self, start: VectorLike, end: VectorLike, name: str) -> Visual:
        """Show a line between two global points [m], as a visual; one of this name is replaced."""
        old = next((visual for visual in self.made if visual.Name() == name), None)
        if old is not None:
            old.Fini()
        visual = self.CreateVisual(name)
        line = visual.CreateDynamicLine()
        line.AddPoint(start)
        line.AddPoint(end)
        return visual

    # Aids --------------------------------------------------------------------------------------------------------

    def SetWireframe(self, show: bool) -> None:
        """Render all models as the edges of their triangles, or as faces again."""
        for visual in self._root.children():
            visual.SetWireframe(show)

    def SetTransparent(self, show: bool) -> None:
        """Make all models half transparent, or opaque again."""
        for visual in self._root.children():
            visual.SetTransparency(0.5 if show else 0.0)

    def ShowCollisions(self, show: bool) -> None:
        """Show the edges of all collisions, or hide them."""
        for visual in self._root.children():
            visual.ShowCollision(show)

    def ShowJoints(self, show: bool) -> None:
        """Show frames and axes of all joints, or hide them."""
        for visual in self._root.children():
            visual.ShowJoints(show)

    def ShowCOMs(self, show: bool) -> None:
        """Show crosses at all centres of mass, or hide them."""
        for visual in self._root.children():
            visual.ShowCOM(show)

    def ShowInertias(self, show: bool) -> None:
        """Show boxes with the moments of inertia of all links, or hide them."""
        for visual in self._root.children():
            visual.ShowInertia(show)

    def ShowLinkFrames(self, show: bool) -> None:
        """Show the axes of all links' frames, or hide them."""
        for visual in self._root.children():
            visual.ShowLinkFrame(show)

    def _model_visuals(self) -> list[Visual]:
        return [self.model_visual(model) for model in self.world.Models()]

    def model_visual(self, model: Model) -> Visual:
        """The visual of a model."""
        if model.visual is None:
            above = model.GetParent()
            parent = self._root if above is self.world else self.model_visual(above)  # type: ignore[arg-type]
            body = model.core.bodies[0] if model.core.bodies else None
            made = Visual.of(self, model.GetScopedName(), parent, frame=model.pose, body=body)
            made.members = lambda: [
                *(self._link_visual(link, made) for link in model.GetLinks()),
                *(self.model_visual(nested) for nested in model.NestedModels()),
            ]
            model.visual = made
        visual: Visual = model.visual
        return visual

    def _link_visual(self, link: Link, parent: Visual) -> Visual:
        if link.visual is None:
            made = Visual.of(self, link.GetScopedName(), parent, frame=link.body.GetPose, body=link.body)
            made.members = lambda: self._shapes(link, made)
            link.visual = made
        visual: Visual = link.visual
        return visual

    def _shapes(self, link: Link, parent: Visual) -> list[Visual]:
        """The visuals of a link, each with all the geoms that were made for it."""
        core = link.model.core
        elements = core.visual_elements if isinstance(core, SdfModel) else {}
        attached = {geom for part in parent.made for shape in part.tree() for geom in shape.geoms}
        groups: dict[int, list[Geom]] = {}
        for geom in link.body.geoms:
            known = geom in parent.shapes
            if geom not in attached and (known or geom in elements or (not elements and geom.appearance.visible)):
                element = elements.get(geom)
                groups.setdefault(id(geom) if element is None else id(element), []).append(geom)
        parent.shapes = {
            geoms[0]: parent.shapes.get(geoms[0]) or self._of_geoms(link, geoms, parent) for geoms in groups.values()
        }
        return list(parent.shapes.values())

    def _of_geoms(self, link: Link, geoms: list[Geom], parent: Visual) -> Visual:
        core = link.model.core
        sdf = core.visual_elements.get(geoms[0]) if isinstance(core, SdfModel) else None
        name = f"{link.GetScopedName()}::{link.model.geom_name(geoms[0])}"
        return Visual.of(self, name, parent, body=link.body, geoms=geoms, sdf=sdf)

    def static_body(self) -> Body:
        """A body at the origin, for shapes that plugins attach to the world."""
        if self._static is None or self._static.closed:
            self._static = Body(self.world.core, dummy=True)
        return self._static

    # Lights and cameras ------------------------------------------------------------------------------------------

    def lights(self) -> list[Light]:
        """All lights."""
        return [self._light(light) for light in self.world.Lights()]

    @staticmethod
    def _light(light: WorldLight) -> Light:
        if light.visual is None:
            light.visual = Light(light.core)
        visual: Light = light.visual
        return visual

    def LightCount(self) -> int:
        """The number of lights."""
        return len(self.lights())

    GetLightCount = LightCount

    def GetLight(self, which: str | int) -> Light | Any:
        """A light by name or number; None if there is none."""
        lights = self.lights()
        if isinstance(which, int):
            return lights[which] if 0 <= which < len(lights) else None
        return next((light for light in lights if light.Name() == which), None)

    LightByName = LightByIndex = GetLight

    def add_camera(self, camera: Camera) -> None:
        """Add a camera; its constructor does that."""
        self._cameras.append(camera)

    def remove_camera(self, camera: Camera) -> None:
        """Remove a camera; its `close` does that. Can be called twice."""
        if camera in self._cameras:
            self._cameras.remove(camera)

    def cameras(self) -> list[Camera]:
        """All cameras but the user's, oldest first."""
        return [camera for camera in self._cameras if not isinstance(camera, UserCamera)]

    def CameraCount(self) -> int:
        """The number of cameras, the user's not counted."""
        return len(self.cameras())

    GetCameraCount = CameraCount

    def GetCamera(self, which: str | int) -> Camera | Any:
        """A camera by name or number; None if there is none."""
        return _pick(self.cameras(), which)

    def user_cameras(self) -> list[UserCamera]:
        """The cameras of users, oldest first."""
        return [camera for camera in self._cameras if isinstance(camera, UserCamera)]

    def UserCameraCount(self) -> int:
        """The number of cameras of users."""
        return len(self.user_cameras())

    GetUserCameraCount = UserCameraCount

    def GetUserCamera(self, which: str | int = 0) -> UserCamera | Any:
        """The camera of a user by name or number; None if there is none."""
        return _pick(self.user_cameras(), which)

    UserCamera = GetUserCamera

    def CreateCamera(self, name: str, autoRender: bool = True) -> Camera:
        """A new camera; `render_frame` takes its images."""
        return Camera(self.world, name)

    def CreateDepthCamera(self, name: str, autoRender: bool = True) -> DepthCamera:
        """A new depth camera; `render_frame` takes its images."""
        return DepthCamera(self.world, name)

    def CreateUserCamera(self, name: str, width: int = 800, height: int = 600) -> UserCamera_:
        """A new camera of a user."""
        return UserCamera(self.world, name, width, height)

    def RemoveCamera(self, name: str) -> None:
        """Close a camera."""
        for camera in [c for c in self._cameras if name in (c.Name(), c.ScopedName())]:
            camera.close()

    # Background --------------------------------------------------------------------------------------------------

    def AmbientColor(self) -> Color:
        """Light from everywhere."""
        return Color(*self.world.core.backdrop.ambient)

    GetAmbientColor = AmbientColor

    def SetAmbientColor(self, color: GzColor) -> None:
        """Set the light from everywhere."""
        self.world.core.backdrop.ambient = GzColor(*color)

    def BackgroundColor(self) -> Color:
        """The background colour."""
        return Color(*self.world.core.skyColor)

    GetBackgroundColor = BackgroundColor

    def SetBackgroundColor(self, color: GzColor) -> None:
        """Set the background colour."""
        self.world.core.skyColor = GzColor(*color)

    def SetFog(self, type: str, color: GzColor, density: float, start: float, end: float) -> None:
        """Set the fog: type linear from `start` to `end` [m], exp or exp2 with a density [1/m], or none.

        Raises:
            ParameterError: there is no such type.
        """
        if type != "none" and type not in FOGS:
            raise ParameterError(f"there is no fog {type!r}{nearest(type, FOGS)}; there are none, {', '.join(FOGS)}")
        core, back = self.world.core, self.world.core.backdrop
        core.fogEnable, core.fogDensity = type != "none", float(density)
        back.fog_color, back.fog_start, back.fog_end = GzColor(*color), float(start), float(end)
        back.fog_kind = type if core.fogEnable else back.fog_kind

    def SetGrid(self, enabled: bool) -> None:
        """Set whether users' cameras show a metre grid on the ground."""
        self.grid = bool(enabled)

    def SetSky(self, enabled: bool = True, time: float = NOON) -> None:
        """Set whether there is a sky, and its time of day [h]. It has no clouds."""
        _log_once("the sky is rendered without clouds")
        set_sky(self.world.core, time if enabled else None)

    SetSkyXMode = SetSky

    def SetShadowsEnabled(self, value: bool) -> None:
        """Set whether images of all cameras have shadows."""
        self.world.core.backdrop.shadows = bool(value)

    def ShadowsEnabled(self) -> bool:
        """Whether images may have shadows; cameras of sensors have them only if `<shadows>` or a plugin says so."""
        return self.world.core.backdrop.shadows is not False

    GetShadowsEnabled = ShadowsEnabled

    # State -------------------------------------------------------------------------------------------------------

    def save(self) -> tuple[Any, ...] | None:
        """What plugins changed of visuals, as plain data; None for nothing."""
        if not (self.made or self.edited):
            return None
        self.made = [visual for visual in self.made if not visual.deleted]
        self.edited = {visual: before for visual, before in self.edited.items() if not visual.deleted}
        made = [(*_key(visual), list(visual.meshes)) for visual in self.made]
        edited = [(*_key(visual), visual.save()) for visual in self.edited]
        return (made, edited) if made or edited else None

    def load(self, state: Sequence[Any] | None) -> None:
        """Take what `save` returned: visuals that plugins made since go, those that went are made again.

        Raises:
            StateError: the visual that held one of those is missing.
        """
        made, edited = state or ((), ())
        self.lines = [line for line in self.lines if not line.visual.deleted]
        wanted = [(name, above) for name, above, _ in made]
        for visual in [visual for visual in self.made if visual.deleted or _key(visual) not in wanted]:
            visual.Fini()
        present = {_key(visual): visual for visual in self.made}
        for name, above, meshes in made:
            if (name, above) not in present:
                present[name, above] = self._make_again(name, above, meshes)
        self.made = [present[key] for key in wanted]
        if not edited and not self.edited:
            return
        visuals = {_key(visual): visual for visual in self.visuals()}
        rows = {(name, above): row for name, above, row in edited}
        for visual, before in list(self.edited.items()):
            if not visual.deleted and _key(visual) not in rows:
                visual.load(before)
                del self.edited[visual]
        found = [(visuals[key], row) for key, row in rows.items() if key in visuals]
        self.edited = {visual: self.edited.get(visual) or visual.save() for visual, _ in found}
        for visual, row in found:
            visual.load(row)

    def _make_again(self, name: str, above: str, meshes: Sequence[str]) -> Visual:
        parent = self.GetVisual(above)
        if parent is None:
            raise StateError(f"visual {name!r} of this state cannot be made again: there is no visual {above!r}")
        visual = Visual(name, parent)
        for mesh in meshes:
            visual.AttachMesh(mesh)
        return visual

    def shape_again(self) -> None:
        """Make the shapes of visuals that plugins made again: those of models that are built again came before them."""
        for visual in self.made:
            if not visual.deleted:
                visual.shape_again()

    def forget(self, visual: Visual) -> None:
        """A visual that a plugin made was removed."""
        self.made = [other for other in self.made if other is not visual]
        self.edited.pop(visual, None)

    # Lines -------------------------------------------------------------------------------------------------------

    def highlight(self, visual: Visual, on: bool) -> None:
        """Show a box around a visual, or hide it."""
        self._highlighted = [other for other in self._highlighted if other is not visual]
        if on:
            self._highlighted.append(visual)

    def mark(self, visual: Visual) -> None:
        """Note whether a visual shows lines of its own: wires, or aids."""
        self._marked = [other for other in self._marked if other is not visual]
        if visual.aids or visual.Wireframe():
            self._marked.append(visual)

    def _lines_for(self, view: View) -> Iterator[Lines]:
        self._marked = [visual for visual in self._marked if not visual.deleted]
        for visual in self._marked:
            yield from visual.wires()
            yield from aids_of(self.world, visual.Name(), visual.body, visual.aids)
        self.lines = [line for line in self.lines if not line.visual.deleted]
        self._highlighted = [visual for visual in self._highlighted if not visual.deleted]
        if self.grid and view.options.displayGrid:
            yield _grid()
        for line in self.lines:
            yield from line.segments()
        for visual in self._highlighted:
            box = visual.BoundingBox()
            if visual.Visible() and box.Size().Length() > 0.0:
                low, size = np.array(box.Min()), np.array(box.Size())
                ends = [low + CORNERS[end] * size for edge in EDGES for end in edge]
                yield placed(np.array(ends), visual.world_pose(), WHITE)


def _key(visual: Visual) -> tuple[str, str]:
    """The names of a visual and of the one around it."""
    above = visual.GetParent()
    return visual.Name(), above.Name() if above is not None else ""


def _pick(cameras: Sequence[C], which: str | int) -> C | None:
    if isinstance(which, int):
        return cameras[which] if 0 <= which < len(cameras) else None
    return next((camera for camera in cameras if which in (camera.Name(), camera.ScopedName())), None)


@functools.cache
def _grid() -> Lines:
    """A metre grid on the ground around the origin."""
    half = CELLS * CELL / 2.0
    at = np.linspace(-half, half, CELLS + 1)
    z = 0.01  # above a ground plane
    ends = [end for a in at for end in ((a, -half, z), (a, half, z), (-half, a, z), (half, a, z))]
    return Lines(np.array(ends, dtype=np.float32), GREY)
