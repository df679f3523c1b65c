"""Scene: shared by all cameras of one world; the first camera makes it, the last one closes its context."""

from __future__ import annotations

import logging
import weakref
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import replace
from functools import lru_cache
from operator import attrgetter
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzColor, GzCoordPositionAdd, GzQuaternMul, rotate
from libgz.base.quota import Quota
from libgz.physics.appearance import RENDER_TRANSPARENT, Backdrop
from libgz.physics.engine import Engine
from libgz.physics.geom import Geom
from libgz.physics.geoms import DomeGeom, FrustrumGeom, LightGeom, PlaneGeom, RayGeom, SkinGeom
from libgz.rendering.context import open_context
from libgz.rendering.overlay import overlay_lines
from libgz.rendering.render_thread import RenderThread
from libgz.rendering.renderer import LIGHTS
from libgz.rendering.shot import Content, Fog, Item, Light, Shot, View

__all__ = ["Scene", "SceneWorld"]

log = logging.getLogger("libgz.rendering")

VERSION = attrgetter("version")
MOST_PIXELS = 4 * 8192 * 8192  # of all cameras of a world
NOT_ITEMS = (DomeGeom, FrustrumGeom, LightGeom, PlaneGeom, RayGeom)


E = TypeVar("E")


class SceneWorld(Protocol):
    """The part of a world that a scene uses."""

    skyColor: GzColor
    fogEnable: bool
    fogDensity: float
    backdrop: Backdrop

    @property
    def engine(self) -> Engine:
        """Bodies and geoms."""

    @property
    def entities(self) -> Sequence[Any]:
        """Entities, each with `bodies` and `GetIntId()`."""

    def extension(self, kind: Callable[[Any], E]) -> E:
        """The world's one object of a kind."""


class Scene:
    """The geoms of a world, and the thread that renders them: an extension of the world.

    Attributes:
        pixels: how many all cameras have, and may have.
    """

    def __init__(self, world: SceneWorld) -> None:
        self.world = weakref.proxy(world)
        self.thread: RenderThread | None = None  # while there are cameras and OpenGL is not switched off
        self.pixels = Quota("pixels of cameras", MOST_PIXELS)
        self._cameras = 0
        self._edits = -1
        self._versions: list[int] | None = None
        self._light_count = 0

    @property
    def blind(self) -> bool:
        """Whether OpenGL is switched off, so that nothing is rendered."""
        return self.thread is None

    @property
    def threaded(self) -> bool:
        """Whether images may be served later than the step in which they were taken."""
        return bool(self.world.backdrop.threaded)

    def join(self) -> None:
        """Add one camera; the first one opens a context.

        Raises:
            LibraryError: the chosen OpenGL does not work here.
        """
        if self._cameras == 0:
            context = open_context()
            self.thread = RenderThread(context) if context is not None else None
            if context is None:
                log.info("rendering is disabled: OpenGL is switched off")
        self._cameras += 1

    def leave(self) -> None:
        """Remove one camera; the last one closes the context."""
        self._cameras -= 1
        if self._cameras == 0 and self.thread is not None:
            self.thread.close()

    # To arrays ---------------------------------------------------------------------------------------------------

    def render(self, view: View, image: NDArray[np.uint8], depth: NDArray[np.float32] | None = None) -> Shot:
        """Render the world as it is now into arrays (see `Renderer.render`); returns the shot."""
        shot = self.capture(view)
        if self.thread is not None:
            self.thread.render(shot, image, depth)
        return shot

    def start(self, view: View, image: NDArray[np.uint8]) -> tuple[Shot, Future[None] | None]:
        """Begin to render the world as it is now; do not touch the array before the result is there."""
        shot = self.capture(view)
        return shot, self.thread.start(shot, image) if self.thread is not None else None

    def shade(self, shot: Shot) -> NDArray[np.uint8]:
        """The image of a shot with shadows, unless the scene forbids them; shape (height, width, 3)."""
        image = np.zeros((shot.view.height, shot.view.width, 3), dtype=np.uint8)
        if self.thread is not None:
            self.thread.render(replace(shot, shadows=self.world.backdrop.shadows is not False), image)
        return image

    def depth(self, shot: Shot) -> NDArray[np.float32]:
        """Distance ahead, along the camera's axis [m], shape (height, width)."""
        depth = np.empty((shot.view.height, shot.view.width), dtype=np.float32)
        if self.thread is not None:
            self.thread.render(shot, None, depth)
        return depth

    def segment(self, shot: Shot) -> NDArray[np.int32]:
        """The number of the model at each pixel, 0 for none; shape (height, width)."""
        if self.thread is None:
            return np.zeros((shot.view.height, shot.view.width), dtype=np.int32)
        return self.thread.segment(shot)

    # From the world ----------------------------------------------------------------------------------------------

    def capture(self, view: View) -> Shot:
        """The world as it is now, as plain data to render."""
        self._refresh()
        world, engine = self.world, self.world.engine
        share = None if self._dome is None else (self._dome, self._dome.day_share)
        return Shot(
            view=view,
            content=self._content,
            states=self._states(engine),
            planes=self._planes,
            lights=tuple(_light(geom) for geom in self._lights),
            sky=world.skyColor,
            fog=_fog(world) if world.fogEnable else None,
            dome=share,
            lines=(*overlay_lines(view, engine), *(line for source in world.backdrop.lines for line in source(view))),
            ambient=world.backdrop.ambient,
            shadows=_shadows(view, world.backdrop),
        )

    def _states(self, engine: Engine) -> NDArray[np.float64]:
        """Positions and quaternions of all items now, shape (n, 7)."""
        states = np.empty((len(self._content.items), 7))
        if len(self._rows):
            states[self._moving] = engine.states[self._rows, :7]
        for i, body in self._dummies:
            states[i] = body.frame()
        return states

    def _refresh(self) -> None:
        """Collect the content again, if geoms were added, removed, or changed their appearance."""
        engine = self.world.engine
        if engine.tables.geoms.edits != self._edits:
            self._edits = engine.tables.geoms.edits
            self._geoms = [geom for _, geom in sorted(engine.geoms.items())]
            self._geoms.sort(key=lambda geom: geom.body.number)
            self._looks = [geom.appearance for geom in self._geoms]
            self._skins = [geom for geom in self._geoms if isinstance(geom, SkinGeom)]
            self._versions = None
        versions = [*map(VERSION, self._looks)]
        if self._skins:
            for skin in self._skins:
                skin.bend()
            versions += [skin.bends for skin in self._skins]
        if versions != self._versions:
            self._versions = versions
            self._collect()

    def _collect(self) -> None:
        shown = [geom for geom in self._geoms if geom.appearance.visible]
        of_kind: Callable[[type], list[Any]] = lambda kind: [g for g in shown if isinstance(g, kind)]  # noqa: E731
        lights = of_kind(LightGeom)
        if len(lights) > max(LIGHTS, self._light_count):
            log.warning("there are %d lights; only the first %d are shown", len(lights), LIGHTS)
        self._light_count = len(lights)
        self._lights: list[LightGeom] = lights[:LIGHTS]
        self._planes: tuple[Geom, ...] = tuple(of_kind(PlaneGeom))
        domes = of_kind(DomeGeom)
        self._dome: DomeGeom | None = domes[0] if domes else None
        owner = {body: model.GetIntId() for model in self.world.entities for body in model.bodies}
        items, bodies = [], []
        for body in dict.fromkeys(geom.body for geom in shown):
            seen = [geom for geom in body.geoms if geom.appearance.visible and not isinstance(geom, NOT_ITEMS)]
            clear = [geom for geom in seen if geom.appearance.render_order == RENDER_TRANSPARENT]
            solid = [geom for geom in seen if geom not in clear]
            groups = [[g for g in solid if g.appearance.cast_shadows == casts] for casts in (True, False)]
            for group in (*groups, *([geom] for geom in clear)):
                if group:
                    casts = group[0] not in clear and group[0].appearance.cast_shadows
                    key = tuple(n for g in group for n in (g.number, g.appearance.version, getattr(g, "bends", 0)))
                    items.append(Item(tuple(group), owner.get(body, 0), key, group[0] in clear, casts))
                    bodies.append(body)
        self._content = Content(tuple(items))
        self._moving = np.array([i for i, body in enumerate(bodies) if not body.dummy], dtype=np.int64)
        self._rows = np.array([bodies[i].row for i in self._moving], dtype=np.int64)
        self._dummies = [(i, body) for i, body in enumerate(bodies) if body.dummy]


def _light(geom: LightGeom) -> Light:
    look, on_body = geom.appearance, geom.GetRelativePose()
    return _placed_light(
        (*geom.body.frame(), *on_body.pos, *on_body.rot, *geom.direction),
        ((*look.ambient,), (*look.diffuse,), (*look.specular,)),
        (*geom.attenuation,),
        geom.kind,
        geom.spot,
        geom.range,
        geom.cast_shadows,
    )


@lru_cache(64)
def _placed_light(
    places: tuple[float, ...],
    colors: tuple[tuple[float, ...], ...],
    attenuation: tuple[float, float, float],
    kind: str,
    spot: tuple[float, float, float],
    range: float,
    shadows: bool,
) -> Light:
    """A light, the same object while nothing of it changes; `places`: of its body, on it, and its direction."""
    body_pos, body_rot, pos, rot, direction = (places[a:b] for a, b in ((0, 3), (3, 7), (7, 10), (10, 14), (14, 17)))
    place = GzCoordPositionAdd(pos, body_pos, body_rot)
    way = rotate(GzQuaternMul(body_rot, rot), direction)
    ambient, diffuse, specular = (GzColor(*color) for color in colors)
    return Light(
        (place.x, place.y, place.z),
        ambient,
        diffuse,
        specular,
        attenuation,
        kind,
        (way.x, way.y, way.z),
        spot,
        range,
        shadows,
    )


def _shadows(view: View, back: Backdrop) -> bool:
    """Whether a view has shadows."""
    wanted = view.options.shadows
    return back.shadows is True if wanted is None else wanted and back.shadows is not False


def _fog(world: SceneWorld) -> Fog:
    back = world.backdrop
    color = world.skyColor if back.fog_color is None else back.fog_color
    return Fog(back.fog_kind, color, world.fogDensity, back.fog_start, back.fog_end)
