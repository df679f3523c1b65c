"""Scene: what all cameras of one world share, made by the first of them and released with the last."""

from __future__ import annotations

import logging
import weakref
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from libgz.geometry import GzColor, GzCoordPositionAdd, GzQuaternMul, rotate
from libgz.physics.appearance import RENDER_TRANSPARENT, Backdrop
from libgz.physics.engine import Engine
from libgz.physics.geom import Geom
from libgz.physics.geoms import DomeGeom, FrustrumGeom, LightGeom, PlaneGeom, RayGeom
from libgz.rendering.context import open_context
from libgz.rendering.overlay import overlay_lines
from libgz.rendering.renderer import LIGHTS, Renderer
from libgz.rendering.shot import Content, Fog, Item, Light, Shot, View, pose_matrices

__all__ = ["Scene", "SceneWorld", "draw_beside_physics", "join_scene"]

log = logging.getLogger("libgz.rendering")

NOT_ITEMS = (DomeGeom, FrustrumGeom, LightGeom, PlaneGeom, RayGeom)


class SceneWorld(Protocol):
    """What a scene needs of a world."""

    skyColor: GzColor
    fogEnable: bool
    fogDensity: float
    backdrop: Backdrop

    @property
    def engine(self) -> Engine:
        """Bodies and geoms."""

    @property
    def models(self) -> Sequence[Any]:
        """Models, each with `bodies` and `GetIntId()`."""


class Scene:
    """The geoms of a world, and the context that draws them.

    Raises:
        LibraryError: the chosen OpenGL does not work here.
    """

    def __init__(self, world: SceneWorld) -> None:
        self.world = weakref.proxy(world)
        self.cameras = 0
        self.context = open_context()
        self._renderer: Renderer | None = None
        self.beside = _beside
        self._drawn: Content | None = None
        self._edits = -1
        self._versions: list[int] | None = None
        self._light_count = 0
        if self.context is not None:
            gl = self.context.gl
            self._renderer = self.context.run(lambda: Renderer(gl))
        else:
            log.info("no pictures: OpenGL is switched off")

    @property
    def blind(self) -> bool:
        """Whether OpenGL is switched off, so that nothing is drawn."""
        return self.context is None

    def leave(self) -> None:
        """A camera goes; the last one releases the context."""
        self.cameras -= 1
        if self.cameras <= 0 and self.context is not None:
            self.context.close()

    # From the world ----------------------------------------------------------------------------------------------

    def capture(self, view: View) -> Shot:
        """The world as it is now, to be drawn at leisure."""
        self._refresh()
        world, engine = self.world, self.world.engine
        share = None if self._dome is None else (self._dome, self._dome.day_share)
        return Shot(
            view=view,
            content=self._content,
            poses=self._poses(engine),
            planes=self._planes,
            lights=tuple(_light(geom) for geom in self._lights),
            sky=world.skyColor,
            fog=_fog(world) if world.fogEnable else None,
            dome=share,
            lines=(*overlay_lines(view, engine), *(line for source in world.backdrop.lines for line in source(view))),
            ambient=world.backdrop.ambient,
        )

    def _poses(self, engine: Engine) -> NDArray[np.float64]:
        """Poses of all items now, shape (n, 4, 4)."""
        states = np.empty((len(self._rows), 7))
        real = self._rows >= 0
        states[real] = engine.states[self._rows[real], :7]
        for i, body in self._dummies:
            pose = body.GetPose()
            states[i] = (*pose.pos, *pose.rot)
        return pose_matrices(states)

    def _refresh(self) -> None:
        """Gather what there is to draw, if geoms came, went, or changed their looks."""
        engine = self.world.engine
        if engine.surface_edits != self._edits:
            self._edits = engine.surface_edits
            self._geoms = [geom for _, geom in sorted(engine.geoms.items())]
            self._geoms.sort(key=lambda geom: geom.body.number)
            self._looks = [geom.appearance for geom in self._geoms]
            self._versions = None
        versions = [look.version for look in self._looks]
        if versions != self._versions:
            self._versions = versions
            self._gather()

    def _gather(self) -> None:
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
            groups = [[geom for geom in seen if geom not in clear], *([geom] for geom in clear)]
            for group in groups:
                if group:
                    key = tuple(n for g in group for n in (g.number, g.appearance.version))
                    items.append(Item(tuple(group), owner.get(body, 0), key, group[0] in clear))
                    bodies.append(body)
        self._content = Content(tuple(items))
        self._rows = np.array([body.row for body in bodies], dtype=np.int64)
        self._dummies = [(i, body) for i, body in enumerate(bodies) if body.dummy]

    # To arrays ---------------------------------------------------------------------------------------------------

    def draw(self, shot: Shot, image: NDArray[np.uint8] | None, depth: NDArray[np.float32] | None = None) -> None:
        """Draw a shot into arrays; see `Renderer.draw`."""
        renderer = self._renderer
        if self.context is not None and renderer is not None:
            self.context.run(lambda: renderer.draw(shot, image, depth))

    def start(self, shot: Shot, image: NDArray[np.uint8]) -> Future[None]:
        """Begin to draw a shot; the array is not to be touched until the result is there.

        With `beside`, physics goes on meanwhile; but what has changed since the last shot is drawn at once, for that
        looks at the geoms.
        """
        renderer, done = self._renderer, Future[None]()
        if self.context is None or renderer is None:
            done.set_result(None)
            return done
        drawing = self.context.submit(lambda: renderer.draw(shot, image))
        if not self.beside or shot.content is not self._drawn:
            drawing.result()
        self._drawn = shot.content
        return drawing

    def segment(self, shot: Shot) -> NDArray[np.int32]:
        """The number of the model at each pixel, 0 for none; shape (height, width)."""
        colors = np.zeros((shot.view.height, shot.view.width, 3), dtype=np.uint8)
        renderer = self._renderer
        if self.context is not None and renderer is not None:
            self.context.run(lambda: renderer.segment(shot, colors))
        return colors.astype(np.int32) @ np.array((1, 256, 65536), dtype=np.int32)


def _light(geom: LightGeom) -> Light:
    look, pose = geom.appearance, geom.body.GetPose()
    place = GzCoordPositionAdd(geom.GetRelativePose().pos, pose.pos, pose.rot)
    way = rotate(GzQuaternMul(pose.rot, geom.GetRelativePose().rot), geom.direction)
    return Light(
        (place.x, place.y, place.z),
        look.ambient,
        look.diffuse,
        look.specular,
        (*geom.attenuation,),
        geom.kind,
        (way.x, way.y, way.z),
        geom.spot,
        geom.range,
    )


def _fog(world: SceneWorld) -> Fog:
    back = world.backdrop
    color = world.skyColor if back.fog_color is None else back.fog_color
    return Fog(back.fog_kind, color, world.fogDensity, back.fog_start, back.fog_end)


_beside = False


def draw_beside_physics(on: bool) -> None:
    """Let the pictures of robots' cameras in all scenes made from now on be drawn while physics goes on.

    They are the same pictures, of the same sim times; they are served up to one period later.
    """
    global _beside
    _beside = on


def join_scene(world: SceneWorld) -> Scene:
    """The scene of a world, for one more camera; `Scene.leave` gives it back.

    Raises:
        LibraryError: the chosen OpenGL does not work here.
    """
    # Kept by the world itself: a table of scenes would hold the geoms, and with them the world, for ever.
    scene: Scene | None = vars(world).get("_scene")
    if scene is None or (scene.context is not None and scene.context.closed):
        scene = vars(world)["_scene"] = Scene(world)
    scene.cameras += 1
    return scene
