"""Scene: all that is drawn of a world, and how."""

from __future__ import annotations

import functools
import logging
import weakref
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from libgz.classic.common import Time
from libgz.classic.math import Color
from libgz.classic.physics import World, get_world
from libgz.classic.rendering.camera import Camera, cameras_of
from libgz.classic.rendering.light import Light
from libgz.classic.rendering.lines import DynamicLines, placed
from libgz.classic.rendering.user_camera import UserCamera
from libgz.classic.rendering.visual import Visual
from libgz.errors import LibraryError, ParameterError, nearest
from libgz.geometry import GzColor, GzPose
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.rendering.overlay import CORNERS, EDGES
from libgz.rendering.renderer import FOGS
from libgz.rendering.shot import Lines, View
from libgz.sdfworld.light import SdfLight
from libgz.sdfworld.model import SdfModel
from libgz.sdfworld.visual import set_sky
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.entity import Entity as CoreModel

if TYPE_CHECKING:
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
    found: Scene | None = world.__dict__.get("scene")
    if found is None:
        found = world.__dict__["scene"] = Scene(world)
    return found


def get_scene(name: str = "") -> Scene:
    """The scene of a world by its name; without one, of the plugin's that is running, or the first.

    Raises:
        NotFoundError: there is no such world.
    """
    return scene_of(get_world(name))


@functools.cache
def _say_once(what: str) -> None:
    log.info("%s", what)


class Scene:
    """A view on what is drawn of a world: visuals, lights, cameras, and what is behind them."""

    def __init__(self, world: World) -> None:
        self.world = world
        self.lines: list[DynamicLines] = []
        self._highlighted: list[Visual] = []
        self._still: Body | None = None
        self._root = Visual.of(self, "__world_node__", None, home=GzPose, members=self._model_visuals)
        element = world.SDF()
        scene = element.child("scene") if element is not None and element.name == "world" else None
        self.grid = scene.Get(bool, "grid") if scene is not None and scene.HasElement("grid") else True
        self._shadows = scene.Get(bool, "shadows") if scene is not None else True
        # The backdrop belongs to the engine's world and must not keep this scene alive.
        this = weakref.ref(self)
        world.core.backdrop.lines.append(lambda view: () if (alive := this()) is None else alive._drawn(view))

    def Name(self) -> str:
        """The world's name."""
        return self.world.Name()

    GetName = Name

    def Initialized(self) -> bool:
        """Whether it can be drawn: always."""
        return True

    GetInitialized = Initialized

    def SimTime(self) -> Time:
        """Simulated time."""
        return self.world.SimTime()

    GetSimTime = SimTime

    # Visuals -----------------------------------------------------------------------------------------------------

    def WorldVisual(self) -> Visual:
        """The visual that all others are in."""
        return self._root

    GetWorldVisual = WorldVisual

    def CreateVisual(self, name: str) -> Visual:
        """A new visual without a shape, at the origin."""
        return Visual(name, self)

    def visuals(self) -> Iterator[Visual]:
        """All visuals, parents first."""
        yield from self._root.tree()

    def GetVisual(self, which: str | int) -> Visual | None:
        """A visual by its full name ``model::link::visual``, or number; None if there is none."""
        if isinstance(which, int):
            return next((visual for visual in self.visuals() if visual.GetId() == which), None)
        name = which.removeprefix(f"{self.Name()}::")
        return next((visual for visual in self.visuals() if visual.Name() == name), None)

    def VisualCount(self) -> int:
        """How many visuals there are, groups counted."""
        return sum(1 for _ in self.visuals())

    GetVisualCount = VisualCount

    def GetModelVisualAt(self, camera: Camera, mousePos: Sequence[int]) -> Visual | None:
        """The model that a camera saw at a pixel of its last picture; None for none."""
        x, y = int(mousePos[0]), int(mousePos[1])
        try:
            number = int(camera.view.segmentation[y, x])
        except (IndexError, LibraryError):
            return None
        core = next((core for core in self.world.core.entities if core.GetIntId() == number), None)
        return self.model_visual(core) if core is not None and not isinstance(core, SdfLight) else None

    GetVisualAt = GetModelVisualAt

    def _model_visuals(self) -> list[Visual]:
        return [self.model_visual(model.core) for model in self.world.Models()]

    def model_visual(self, core: CoreModel) -> Visual:
        """The visual of a model of the engine."""
        model = self.world.view(core)
        return self._visual_of(core, lambda: self._of_model(model))

    @staticmethod
    def _visual_of(core: Any, make: Any) -> Visual:
        """The one visual of an object of the engine, made when it is first asked for."""
        found: Visual | None = core.__dict__.get("classic_visual")
        if found is None:
            found = core.__dict__["classic_visual"] = make()
        return found

    def _of_model(self, model: Model) -> Visual:
        above = model.GetParent()
        parent = self.model_visual(above.core) if above is not None else self._root  # type: ignore[attr-defined]
        body = model.core.bodies[0] if model.core.bodies else None
        made = Visual.of(self, model.GetScopedName(), parent, home=model.pose, body=body, sdf=None)
        made.members = lambda: [
            *(self._visual_of(link.body, lambda link=link: self._of_link(link, made)) for link in model.GetLinks()),
            *(self.model_visual(nested.core) for nested in model.NestedModels()),
        ]
        return made

    def _of_link(self, link: Link, parent: Visual) -> Visual:
        made = Visual.of(self, link.GetScopedName(), parent, home=link.body.GetPose, body=link.body)
        made.members = lambda: self._shapes(link, made)
        return made

    def _shapes(self, link: Link, parent: Visual) -> list[Visual]:
        """The visuals of a link, each with all the geoms that were made for it."""
        core = link.model.core
        elements = core.visual_elements if isinstance(core, SdfModel) else {}
        mine = {geom for part in parent.made for shape in part.tree() for geom in shape.geoms}
        groups: dict[int, list[Geom]] = {}
        for geom in link.body.geoms:
            known = "classic_visual" in geom.__dict__
            if geom not in mine and (known or geom in elements or (not elements and geom.appearance.visible)):
                element = elements.get(geom)
                groups.setdefault(id(geom) if element is None else id(element), []).append(geom)
        return [
            self._visual_of(geoms[0], lambda geoms=geoms: self._of_geoms(link, geoms, parent))
            for geoms in groups.values()
        ]

    def _of_geoms(self, link: Link, geoms: list[Geom], parent: Visual) -> Visual:
        core = link.model.core
        sdf = core.visual_elements.get(geoms[0]) if isinstance(core, SdfModel) else None
        name = f"{link.GetScopedName()}::{link.model.geom_name(geoms[0])}"
        return Visual.of(self, name, parent, body=link.body, geoms=geoms, sdf=sdf)

    def still_body(self) -> Body:
        """A body at the origin, for what plugins draw in the world."""
        if self._still is None:
            self._still = Body(self.world.core, dummy=True)
        return self._still

    # Lights and cameras ------------------------------------------------------------------------------------------

    def lights(self) -> list[Light]:
        """All lights."""
        cores = self.world.core.extension(SdfWorld).lights
        return [core.__dict__.setdefault("classic_visual", Light(core)) for core in cores]

    def LightCount(self) -> int:
        """How many lights there are."""
        return len(self.lights())

    GetLightCount = LightCount

    def GetLight(self, which: str | int) -> Light | None:
        """A light by name or number; None if there is none."""
        lights = self.lights()
        if isinstance(which, int):
            return lights[which] if 0 <= which < len(lights) else None
        return next((light for light in lights if light.Name() == which), None)

    LightByName = LightByIndex = GetLight

    def cameras(self) -> list[Camera]:
        """All cameras but the user's."""
        return [camera for camera in cameras_of(self.world) if not isinstance(camera, UserCamera)]

    def CameraCount(self) -> int:
        """How many cameras there are, the user's not counted."""
        return len(self.cameras())

    GetCameraCount = CameraCount

    def GetCamera(self, which: str | int) -> Camera | None:
        """A camera by name or number; None if there is none."""
        return _pick(self.cameras(), which)

    def user_cameras(self) -> list[UserCamera]:
        """The cameras of users."""
        return [camera for camera in cameras_of(self.world) if isinstance(camera, UserCamera)]

    def UserCameraCount(self) -> int:
        """How many cameras of users there are."""
        return len(self.user_cameras())

    GetUserCameraCount = UserCameraCount

    def GetUserCamera(self, which: str | int = 0) -> UserCamera | None:
        """The camera of a user by name or number; None if there is none."""
        return _pick(self.user_cameras(), which)

    UserCamera = GetUserCamera

    def CreateCamera(self, name: str, autoRender: bool = True) -> Camera:
        """A new camera; `draw_frame` takes its pictures."""
        return Camera(self.world, name)

    def CreateUserCamera(self, name: str, width: int = 800, height: int = 600) -> UserCamera_:
        """A new camera of a user."""
        return UserCamera(self.world, name, width, height)

    def RemoveCamera(self, name: str) -> None:
        """Let a camera go."""
        for camera in [c for c in cameras_of(self.world) if name in (c.Name(), c.ScopedName())]:
            camera.close()

    # What is behind ----------------------------------------------------------------------------------------------

    def AmbientColor(self) -> Color:
        """Light from everywhere."""
        return Color(*self.world.core.backdrop.ambient)

    GetAmbientColor = AmbientColor

    def SetAmbientColor(self, color: GzColor) -> None:
        """Set the light from everywhere."""
        self.world.core.backdrop.ambient = GzColor(*color)

    def BackgroundColor(self) -> Color:
        """What is seen where there is nothing."""
        return Color(*self.world.core.skyColor)

    GetBackgroundColor = BackgroundColor

    def SetBackgroundColor(self, color: GzColor) -> None:
        """Set what is seen where there is nothing."""
        self.world.core.skyColor = GzColor(*color)

    def SetFog(self, type: str, color: GzColor, density: float, start: float, end: float) -> None:
        """Let distance fade: type linear from `start` to `end` [m], exp or exp2 with a density [1/m], or none.

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
        """Whether users' cameras show a grid of metres on the ground."""
        self.grid = bool(enabled)

    def SetSky(self, enabled: bool = True, time: float = NOON) -> None:
        """Whether there is a sky, of a time of day [h]. It has no clouds."""
        _say_once("the sky is drawn without clouds")
        set_sky(self.world.core, time if enabled else None)

    SetSkyXMode = SetSky

    def SetShadowsEnabled(self, value: bool) -> None:
        """Kept: there are no shadows."""
        _say_once("pictures have no shadows")
        self._shadows = bool(value)

    def ShadowsEnabled(self) -> bool:
        """The value last set."""
        return self._shadows

    GetShadowsEnabled = ShadowsEnabled

    # Lines -------------------------------------------------------------------------------------------------------

    def highlight(self, visual: Visual, on: bool) -> None:
        """Draw a box around a visual, or no more."""
        self._highlighted = [other for other in self._highlighted if other is not visual]
        if on:
            self._highlighted.append(visual)

    def _drawn(self, view: View) -> Iterator[Lines]:
        self.lines = [line for line in self.lines if not line.visual.gone]
        self._highlighted = [visual for visual in self._highlighted if not visual.gone]
        if self.grid and view.options.displayGrid:
            yield _grid()
        for line in self.lines:
            yield from line.segments()
        for visual in self._highlighted:
            box = visual.BoundingBox()
            if visual.Visible() and box.Size().Length() > 0.0:
                low, size = np.array(box.Min()), np.array(box.Size())
                ends = [low + CORNERS[end] * size for edge in EDGES for end in edge]
                yield placed(np.array(ends), visual._world(), WHITE)


def _pick(cameras: Sequence[C], which: str | int) -> C | None:
    if isinstance(which, int):
        return cameras[which] if 0 <= which < len(cameras) else None
    return next((camera for camera in cameras if which in (camera.Name(), camera.ScopedName())), None)


@functools.cache
def _grid() -> Lines:
    """Metres on the ground around the origin."""
    half = CELLS * CELL / 2.0
    at = np.linspace(-half, half, CELLS + 1)
    z = 0.01  # above a ground plane
    ends = [end for a in at for end in ((a, -half, z), (a, half, z), (-half, a, z), (half, a, z))]
    return Lines(np.array(ends, dtype=np.float32), GREY)
