"""SdfActor: a model that follows a script: a trajectory, and animations of a skeleton that bends its skin."""

from __future__ import annotations

import ctypes
import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import Diagnostics, GazeboError, NotFoundError, ParameterError, nearest
from libgz.base.geometry import (
    GzColor,
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzCoordPositionAdd,
    GzPose,
    GzQuatern,
    GzQuaternMul,
    GzVector,
)
from libgz.base.law import law
from libgz.physics.body import Body, place_dummies
from libgz.physics.bone_motion import fitted, read_motion
from libgz.physics.geoms import SkinGeom, SphereGeom
from libgz.physics.skeletons import Figure, SkeletonAnimation, read_figure
from libgz.sdf.element import Element
from libgz.sdf.paths import find_uri
from libgz.sdfworld.mesh_images import found_images
from libgz.sdfworld.model import SdfModel
from libgz.sdfworld.trajectory import Trajectory
from libgz.sdfworld.visual import set_transparency, show_image
from libgz.simulation.plan import Plan, overrides
from libgz.simulation.world import World

__all__ = ["SdfActor"]

Array = NDArray[np.float64]

FRAME = 1.0 / 30.0  # [s] of sim time between two poses, as in Gazebo
JOINT_RADIUS = 0.02  # [m] of the spheres that stand for bones
UNSET = "__default__"
SKIN_COLOR = GzColor(0.7, 0.7, 0.7)


@dataclass
class _Clip:
    """An animation that actors can play."""

    animation: SkeletonAnimation
    by_distance: bool  # whether the way along x chooses the pose, instead of the time


@dataclass
class _Part:
    """A `<trajectory>` of a script.

    Attributes:
        kind: name of the animation.
        start, end: in the script [s].
        way: through its waypoints; None without any.
        stays: whether the animation plays where the actor stands, without the root's way along x.
    """

    number: int
    kind: str
    start: float
    end: float
    way: Trajectory | None
    stays: bool = False


class _LastPose(ctypes.Structure):
    """When the last pose was taken, as laws use it: sim time [s]."""

    _fields_ = [("time", ctypes.c_double)]

    time: float


class SdfActor(SdfModel):
    """A model built from an `<actor>`. Nothing moves it but its script or a plugin; what it touches is pushed.

    Its first link carries the skin; each bone of its skeleton is a link, too. Poses change 30 times a second of sim
    time, as in Gazebo.

    Attributes:
        active: whether the script runs.
        script_time: within the present trajectory of the script [s].
        custom: the animation that is played while a plugin moves the actor, at the `script_time` that it sets; None
            while the script moves it.
        clips: animations by name.
        loop: whether the script begins again at its end.
    """

    is_actor = True

    def __init__(
        self, world: World, element: Element, diagnostics: Diagnostics, parent: SdfModel | None = None
    ) -> None:
        super().__init__(world, element, diagnostics, parent)
        self.SetName("actor")
        self.static = True  # forces do not move it
        self.figure: Figure | None = None
        self.skins: list[SkinGeom] = []
        self.clips: dict[str, _Clip] = {}
        self.parts: list[_Part] = []
        self.loop, self.delay, self.active = True, 0.0, True
        self.script_time = 0.0
        self.custom: str | None = None
        self._bones: list[Body] = []
        self._made = self._played = 0.0  # sim time at which the actor was made, and the script began [s]
        self._last_pose = _LastPose()
        self._distance = 0.0  # on the present trajectory [m]
        self._last: tuple[int, GzVector] | None = None  # number of the trajectory, and the place on it
        self._still = GzPose()  # where it stands without waypoints

    @property
    def frame_links(self) -> list[Body]:
        """The links of its bones, in the order of its skeleton."""
        return self._bones

    @property
    def framed(self) -> float:
        """Sim time of its last pose [s]."""
        return self._last_pose.time

    def bones(self) -> list[tuple[str, GzPose, Body]]:
        """(name, pose in the frame of its parent, link) of each bone; the pose of the first one is zero."""
        if self.figure is None:
            return []
        poses = [body.GetPose() for body in self._bones]
        local = [
            GzCoordPoseSub(pose, poses[up]) if up >= 0 else GzPose()
            for pose, up in zip(poses, self.figure.parents, strict=True)
        ]
        return list(zip(self.figure.names, local, self._bones, strict=True))

    def build(self, pose: GzPose) -> None:
        """Make skin, bones and links, and read the script; errors are those of the file."""
        self._still, self._made = pose, self.world.GetSimTime()
        self._played = self._last_pose.time = self._made  # the first pose of a step is due 1/30 s later
        element = self.sdf
        figure = self._read_skin(element)
        own = any(True for _ in element.named("link"))
        if figure is not None or not own:
            self._add_part(f"{self.name}_pose", pose)
        if figure is not None:
            self.figure = figure
            self._add_bones(figure, pose)
        for clip in element.named("animation"):
            self._read_animation(clip)
        if figure is not None and not self.clips and figure.animations:
            self.clips[UNSET] = _Clip(figure.animations[0], False)
        script = element.child("script")
        self._guard(script, self._read_script, script)
        super().build(pose)
        self._begin()

    def _add_part(self, name: str, pose: GzPose) -> Body:
        body = Body(self.world, name, dummy=True)
        body.model = self
        self.links[name] = body
        self.bodies.append(body)
        body.SetPose(pose)
        return body

    def _read_skin(self, element: Element) -> Figure | None:
        if not element.HasElement("skin"):
            return None
        skin = element.child("skin")
        return self._figure(skin)

    def _figure(self, element: Element) -> Figure | None:
        """The figure of a `<skin>` or `<animation>`, in its scale; None, with a warning, if it cannot be read."""
        uri = element.Get(str, "filename")
        if uri in ("", UNSET):
            return None
        folder = Path(element.file).parent if element.file and not element.file.startswith("<") else None
        try:
            path = find_uri(uri, folder)
            figure = self._read(path, element)
        except (GazeboError, NotFoundError) as error:
            self.diagnostics.warn(element, f"{error}; the actor has no such {element.name}")
            return None
        scale = element.Get(float, "scale")
        return figure if scale == 1.0 else figure.scaled(scale)

    @staticmethod
    def _read(path: Path, element: Element) -> Figure:
        """The figure of a file.

        Raises:
            GazeboError: it is of another kind, or cannot be read.
        """
        if path.suffix.lower() == ".bvh" and element.name == "animation":
            return read_motion(path)
        if path.suffix.lower() == ".dae":
            return read_figure(path)
        known = "COLLADA (.dae) and BVH (.bvh)" if element.name == "animation" else "COLLADA (.dae)"
        raise ParameterError(f"{path} is not allowed as a <{element.name}>; files of {known} are")

    def _add_bones(self, figure: Figure, pose: GzPose) -> None:
        places, turns = figure.world(*_arrays(pose), figure.positions, figure.turns)
        for name, place, turn in zip(figure.names, places.tolist(), turns.tolist(), strict=True):
            unique = name
            while unique in self.links:
                unique += "_"
            body = self._add_part(unique, GzPose(GzVector(*place), GzQuatern(*turn)))
            ball = SphereGeom(body, self.modelSpaceId, JOINT_RADIUS)
            ball.appearance.visible = False
            self.geom_names[ball] = f"{unique}_collision"
            self._bones.append(body)
        main = self.bodies[0]
        textures = [part.texture for part in figure.skin if part.texture is not None]
        images = found_images(textures, functools.partial(self.diagnostics.warn, self.sdf.child("skin")))
        for part in figure.skin:
            geom = SkinGeom(main, part, self._bones)
            image = part.texture.image if part.texture is not None else None
            if image is not None and image in images and geom.texture_coordinates is not None:
                show_image(geom.appearance, images[image], part.color)
            else:
                geom.SetColor(SKIN_COLOR if part.color is None else GzColor(*part.color))
                set_transparency(geom.appearance, geom.appearance.transparency)
            self.geom_names[geom] = f"{self.name}_visual"
            self.skins.append(geom)

    # Script ------------------------------------------------------------------------------------------------------

    def _read_animation(self, element: Element) -> None:
        name = element.Get(str, "name")
        if self.figure is None:
            return
        if name == UNSET:
            if self.figure.animations:
                self.clips[UNSET] = _Clip(self.figure.animations[0], False)
            return
        figure = self._figure(element)
        if figure is None:
            return
        if not figure.animations:
            self.diagnostics.warn(element, "its file has no animation; the actor does not play it")
        elif not self.figure.fits(figure):
            self.diagnostics.warn(
                element,
                f"Skin and animation {name} skeletons are not compatible: {len(self.figure.names)} and "
                f"{len(figure.names)} bones; the actor does not play it",
            )
        else:
            animation = fitted(figure, self.figure) if _is_motion(element) else figure.animations[0]
            self.clips[name] = _Clip(animation, element.Get(bool, "interpolate_x"))

    def _read_script(self, script: Element) -> None:
        self.loop, self.delay = script.Get(bool, "loop"), script.Get(float, "delay_start")
        self.active = script.Get(bool, "auto_start")
        for element in script.named("trajectory"):
            self._read_trajectory(element)
        self.parts.sort(key=lambda part: part.number)
        if not self.parts and self.clips:
            name, clip = next(iter(self.clips.items()))
            self.parts.append(_Part(0, name, 0.0, clip.animation.length, None, stays=True))
        time = 0.0
        for part in self.parts:
            part.start, part.end = time, time + part.end
            time = part.end

    def _read_trajectory(self, element: Element) -> None:
        kind, number = element.Get(str, "type"), element.Get(int, "id")
        if self.figure is not None and kind not in self.clips:
            known = ", ".join(name for name in self.clips if name != UNSET) or "none"
            self.diagnostics.warn(
                element,
                f"Resource not found for trajectory of type {kind}: its animations are {known}"
                f"{nearest(kind, self.clips)}; no bone moves on it",
            )
        points: dict[float, GzPose] = {}
        for waypoint in element.named("waypoint"):
            time = waypoint.Get(float, "time")
            if not 0.0 <= time < math.inf:
                raise ParameterError(f"{waypoint.where}: <time> is {time:g}; it must be 0 s or later")
            points[time] = waypoint.Get(GzPose, "pose")
        rows = sorted(points.items())
        tension = element.Get(float, "tension") if "tension" in element.attributes else 0.0
        way = Trajectory(rows, min(max(tension, 0.0), 1.0)) if rows else None
        length = way.duration if way is not None else self.clips[kind].animation.length if kind in self.clips else 0.0
        self.parts.append(_Part(number, kind, 0.0, length, way))

    @property
    def length(self) -> float:
        """The length of the script [s]."""
        return self.parts[-1].end if self.parts else 0.0

    def follow_plugin(self, kind: str) -> None:
        """Play an animation while a plugin moves the actor, which begins at its `<pose>`, not with its script."""
        self.custom = kind
        if self._last_pose.time == self._made:
            self.SetPose(self._still)
            self._play_custom(kind)

    def play(self) -> None:
        """Begin the script."""
        self.active, self._played = True, self.world.GetSimTime()

    def stop(self) -> None:
        """Stop; the actor stays as it is."""
        self.active = False

    def _entity_plan(self, plan: Plan) -> None:
        """A line for what it does in each step, or for the steps with another pose, if it does nothing between."""
        if self.sdf_joints or self.mimics or self.grippers or overrides(self, SdfActor, "MasterUpdate"):
            super()._entity_plan(plan)
            return
        with plan.when(self._is_due):
            plan.do(self.MasterUpdate)

    @law
    def _is_due(self) -> Any:
        """Whether it is time for another pose."""
        return self.world.clock.sim_time - self._last_pose.time >= FRAME - 1e-9

    def MasterUpdate(self, step: float) -> None:
        """Take the pose of the script at the present sim time."""
        super().MasterUpdate(step)
        now = self.world.GetSimTime()
        if step <= 0.0 or not self.active or not self._is_due():
            return
        if self.custom is not None:
            self._last_pose.time = now
            self._play_custom(self.custom)
            return
        time = now - self.delay - self._played
        if time < -1e-9 or not self.parts:
            return
        time = max(time, 0.0)
        if time >= self.length:
            if not self.loop or self.length <= 0.0:
                self._finish(now)
                return
            time %= self.length
            self._played = now - time  # the delay comes before each cycle, as in Gazebo
        part = next((part for part in self.parts if part.start <= time <= part.end), self.parts[-1])
        self._last_pose.time = now
        self.script_time = time - part.start
        self._play(part)

    def _finish(self, now: float) -> None:
        """Take the last pose of a script that does not loop, once."""
        last = self.parts[-1]
        if self.script_time != last.end - last.start:
            self._last_pose.time, self.script_time = now, last.end - last.start
            self._play(last)

    def _begin(self) -> None:
        """Take the first pose: of the script if it begins at once, else of the animation where the actor stands."""
        if not self.parts:
            return
        first = self.parts[0]
        if self.active and self.delay <= 0.0:
            self._play(first)
        else:
            self._show(first, self._still)

    def _play(self, part: _Part) -> None:
        pose = self._still
        if part.way is not None:
            pose = part.way.at(self.script_time)
            self._measure(part, pose.pos)
        self._show(part, pose)

    def _show(self, part: _Part, pose: GzPose) -> None:
        """Take the pose of the present script time, in a frame."""
        clip = self.clips.get(part.kind)
        if self.figure is None or clip is None:
            self.SetPose(pose)
            return
        by_distance = clip.by_distance and part.way is not None
        animation = clip.animation
        positions, turns = animation.at_x(self._distance) if by_distance else animation.at(self.script_time)
        ahead = 0.0 if part.way is not None or part.stays else float(positions[0][0])
        root = GzVector(ahead, *map(float, positions[0][1:]))
        self._bend(
            GzPose(GzCoordPositionAdd(root, pose.pos, pose.rot), GzQuaternMul(pose.rot, GzQuatern(*turns[0].tolist()))),
            positions,
            turns,
        )

    def _measure(self, part: _Part, place: GzVector) -> None:
        """Add the way since the last pose to the distance on a trajectory."""
        if self._last is not None and self._last[0] == part.number:
            self._distance += math.dist(self._last[1], place)
        else:
            self._distance = math.dist(part.way.at(0.0).pos, place) if part.way is not None else 0.0
        self._last = part.number, place

    def _play_custom(self, kind: str) -> None:
        clip = self.clips.get(kind)
        if clip is not None and self.figure is not None:
            self._bend(self.GetPose(), *clip.animation.at(self.script_time))

    def _bend(self, root: GzPose, positions: Array, turns: Array) -> None:
        """Move to a pose of the root, and move the bones to theirs in the frames of their parents."""
        figure = self.figure
        if figure is None:
            return
        before, bones = self.GetPose(), set(self._bones)
        for body in [body for body in self.bodies if body not in bones]:
            body.SetPose(GzCoordPoseAdd(GzCoordPoseSub(body.GetPose(), before), root))
        place_dummies(self.world.engine, self._bones, *figure.world(*_arrays(root), positions, turns))

    # State -------------------------------------------------------------------------------------------------------

    def SaveState(self) -> tuple[Any, ...]:
        """Where it is in its script; the bones' poses are the engine's."""
        last = None if self._last is None else (self._last[0], (*self._last[1],))
        return (self.active, self.script_time, self._played, self.framed, self._distance, last, self.custom)

    def LoadState(self, state: Sequence[Any]) -> None:
        """Take what SaveState returned."""
        self.active, self.script_time, self._played, self._last_pose.time, self._distance, last, self.custom = state
        self._last = None if last is None else (last[0], GzVector(*last[1]))

    def _entity_describe(self, store: Any) -> dict[str, Any]:
        """As of all models; its pose changes, though nothing pushes it."""
        return {**super()._entity_describe(store), "static": False}


def _is_motion(element: Element) -> bool:
    """Whether the file of an `<animation>` has a motion without a skin."""
    return element.Get(str, "filename").strip().lower().endswith(".bvh")


def _arrays(pose: GzPose) -> tuple[Array, Array]:
    return np.array([*pose.pos]), np.array([*pose.rot])
