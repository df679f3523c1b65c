"""Marks: what is shown beside the scene itself, each behind a switch: sensors, joints, boxes, contacts, trails."""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Collection
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from libgz.base.errors import GazeboError
from libgz.transport.observer import ObservedState
from libgz.view.scene import SceneView
from libgz.view.shapes import compose
from libgz.view.source import Controls

__all__ = ["SWITCHES", "Marks", "image_name", "sensor_name"]

log = logging.getLogger("libgz.view")

SWITCHES = {
    "lasers": "Laser fans",
    "sonars": "Sonar cones",
    "frusta": "Camera frusta",
    "contacts": "Contacts",
    "joints": "Joint axes",
    "masses": "Centres of mass",
    "boxes": "Bounding boxes",
    "trails": "Trails",
}
COLORS = {
    "lasers": (60, 120, 255),
    "sonars": (255, 170, 40),
    "frusta": (120, 60, 180),
    "contacts": (230, 40, 40),
    "joints": (200, 30, 160),
    "masses": (20, 20, 20),
    "boxes": (90, 90, 90),
    "trails": (240, 120, 0),
}
CONE = math.radians(7.5)  # half angle of a sonar's cone, where nothing says it
LONGEST_FRUSTUM = 2.0  # [m]
SCREEN = 0.5  # [m] before a camera, where its image is shown
UPRIGHT = np.array([[0.5, -0.5, 0.5, -0.5]])  # from an image's axes, right and down, to a camera's, which looks along x
TRAIL = 600  # points
TRAIL_STEP = 0.02  # [m] between two of them
TRAIL_HEIGHT = 0.05  # [m] above a model's lowest point, at least: the origin of a robot may lie on the ground
UNIT = np.array([[1.0, 0.0, 0.0, 0.0]])


class Marks:
    """Shows marks of the scene's present state.

    Args:
        page: the page's server.
        view: of the scene.
        controls: for readings of interfaces; None shows ranges at their largest.
    """

    def __init__(self, page: viser.ViserServer, view: SceneView, controls: Controls | None) -> None:
        self.page, self.view, self.controls = page, view, controls
        self.on: set[str] = set()
        self.contacts: list[list[float]] = []
        self.ranges: dict[str, list[float]] = {}  # of SDF sensors, by model::link::sensor
        self.images: dict[str, NDArray[np.uint8]] = {}  # of cameras, by id or model::link::sensor
        self._handles: dict[str, Any] = {}
        self._screens: dict[str, tuple[Any, NDArray[np.uint8]]] = {}  # nodes of the cameras' images, and what they show
        self._past: dict[int, deque[NDArray[Any]]] = {}  # trails
        self._lifts: dict[int, float] = {}  # of trails above the models' origins [m]
        self._steps = 0  # of the state whose trails are shown
        self._arrays: dict[str, NDArray[Any]] = {}

    def switch(self, name: str, on: bool) -> None:
        """Show or hide one kind of marks."""
        if on:
            self.on.add(name)
        else:
            self.on.discard(name)
            self._hide(name)
            if name == "trails":
                self._past.clear()
            if name == "frusta":
                self._keep_screens(())

    def clear(self) -> None:
        """Remove all marks, for another run."""
        for name in list(self._handles):
            self._hide(name)
        self._keep_screens(())
        self._past.clear()
        self._arrays.clear()

    def _hide(self, name: str) -> None:
        handle = self._handles.pop(name, None)
        if handle is not None:
            handle.remove()

    def show(self, state: ObservedState) -> None:
        """Bring all marks that are on up to date with a state."""
        for name in SWITCHES:
            if name in self.on:
                getattr(self, f"_{name}")(state)

    def select(self, number: int | None, state: ObservedState) -> None:
        """Show a box around an entity, and what is attached to it."""
        found = [] if number is None else [self.view.bounds(one, state) for one in self.view.family(number)]
        boxes = [box for box in found if box is not None]
        if not boxes:
            self._hide("selection")
            return
        low = np.min([box[0] for box in boxes], axis=0) - 0.01
        high = np.max([box[1] for box in boxes], axis=0) + 0.01
        self._lines("selection", _edges(np.array((low, high))), (255, 140, 0), 2.0)

    # Lines and meshes ------------------------------------------------------------------------------------------------

    def _lines(
        self, name: str, points: NDArray[Any], color: tuple[int, int, int] | None = None, width: float = 1.5
    ) -> None:
        """Show line segments, shape (n, 2, 3)."""
        if not len(points):
            self._hide(name)
            return
        handle = self._handles.get(name)
        points = points.astype(np.float32)
        if handle is not None and handle.points.shape == points.shape:
            if not np.array_equal(handle.points, points):
                handle.points = points
            return
        self._hide(name)
        self._handles[name] = self.page.scene.add_line_segments(
            f"/world/marks/{name}", points, color or COLORS[name], thickness=width, thickness_units="screen"
        )

    def _mesh(self, name: str, vertices: NDArray[Any], faces: NDArray[Any], opacity: float) -> None:
        """Show triangles that can be seen through."""
        if not len(faces):
            self._hide(name)
            return
        handle = self._handles.get(name)
        vertices = vertices.astype(np.float32)
        if handle is not None and handle.vertices.shape == vertices.shape and handle.faces.shape == faces.shape:
            if not np.array_equal(handle.vertices, vertices):
                handle.vertices = vertices
            return
        self._hide(name)
        self._handles[name] = self.page.scene.add_mesh_simple(
            f"/world/marks/{name}",
            vertices,
            faces.astype(np.uint32),
            color=COLORS[name],
            opacity=opacity,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )

    def _frame(self, body: int, state: ObservedState, pose: Any = None) -> NDArray[np.float64] | None:
        """The global pose of a body, or of something with a pose in it; shape (1, 7)."""
        row = self.view.rows.get(body, -1)
        if not 0 <= row < len(state.bodies):
            return None
        frame: NDArray[np.float64] = state.bodies[row : row + 1, :7]
        if pose is None:
            return frame
        own = np.array([pose], dtype=float)
        position, rotation = compose(frame[:, :3], frame[:, 3:], own[:, :3], own[:, 3:])
        return np.concatenate([position, rotation], axis=1)

    # Sensors ---------------------------------------------------------------------------------------------------------

    def _reading(self, entity: dict[str, Any], kind: str) -> Any:
        """The interface of a kind that an entity serves; None if it has none, or that cannot be read."""
        if self.controls is None:
            return None
        for served in entity["interfaces"]:
            if served["type"] == kind:
                try:
                    return self.controls.interface(kind, served["id"])
                except GazeboError:
                    return None
        return None

    def _rays(self, sensor: dict[str, Any]) -> NDArray[Any] | None:
        """Start [m], direction and length [m] of each of a sensor's rays, shape (n, 7)."""
        key = sensor["data"]["file"]
        if key not in self._arrays:
            try:
                self._arrays[key] = np.asarray(self.view.source.data(sensor["data"])["rays"], dtype=float)
            except GazeboError:
                return None
        rays = self._arrays[key]
        return rays.reshape(-1, 7) if rays.size else None

    def _lasers(self, state: ObservedState) -> None:
        """Fans from each laser to where its rays end."""
        parts: list[tuple[NDArray[Any], NDArray[Any]]] = []
        for entity in self.view.entities.values():
            for sensor in entity["sensors"]:
                if sensor["kind"] == "rays" and any(i["type"] in ("laser", "fiducial") for i in entity["interfaces"]):
                    frame, rays = self._frame(sensor["body"], state), self._rays(sensor)
                    if frame is None or rays is None:
                        continue
                    lengths = rays[:, 6].copy()
                    laser = self._reading(entity, "laser")
                    ranges = None if laser is None else np.array(laser.ranges, dtype=float)
                    if ranges is not None and len(ranges) > 1 and len(rays) > 1:
                        share = np.linspace(0.0, len(ranges) - 1.0, len(rays)).round().astype(int)
                        lengths = np.minimum(ranges[share], lengths)
                    parts.append(self._fan(frame, rays[:, :3], rays[:, 3:6], lengths))
                elif "rays" in sensor and sensor["kind"] != "rays":
                    parts += self._sdf_fans(entity, sensor, state)
        vertices, faces = _joined(parts)
        self._mesh("lasers", vertices, faces, 0.22)

    def _sdf_fans(
        self, entity: dict[str, Any], sensor: dict[str, Any], state: ObservedState
    ) -> list[tuple[NDArray[Any], NDArray[Any]]]:
        frame = self._frame(sensor["body"], state, sensor["pose"])
        found = []
        for scan in sensor["rays"] if frame is not None else ():
            flat, upright = scan["horizontal"], scan["vertical"]
            count = int(min(max(flat["samples"], 2), 181))
            angles = np.linspace(flat["min_angle"] or 0.0, flat["max_angle"] or 0.0, count)
            tilts = (
                sorted({float(upright["min_angle"] or 0.0), float(upright["max_angle"] or 0.0)}) if upright else [0.0]
            )
            for tilt in tilts:
                along = np.stack([np.cos(angles) * np.cos(tilt), np.sin(angles) * np.cos(tilt)], axis=1)
                directions = np.column_stack([along, np.full(count, math.sin(tilt))])
                reach = np.full(count, min(float(scan["max"] or 10.0), 30.0))
                ranges = np.array(self.ranges.get(sensor_name(entity, sensor), ()))
                if len(ranges) > 1 and len(tilts) == 1:
                    seen = ranges[np.linspace(0.0, len(ranges) - 1.0, count).round().astype(int)]
                    reach = np.where(seen >= 0.0, np.minimum(seen, reach), reach)
                found.append(self._fan(frame, np.zeros((count, 3)), directions, reach))
        return found

    def _fan(
        self, frame: Any, starts: NDArray[Any], directions: NDArray[Any], lengths: NDArray[Any]
    ) -> tuple[NDArray[Any], NDArray[Any]]:
        ends = starts + directions * lengths[:, None]
        own = np.concatenate([starts[:1], ends])
        vertices, _ = compose(
            np.repeat(frame[:, :3], len(own), 0),
            np.repeat(frame[:, 3:], len(own), 0),
            own,
            np.repeat(UNIT, len(own), 0),
        )
        order = np.arange(1, len(ends))
        return vertices, np.stack([np.zeros_like(order), order, order + 1], axis=1)

    def _sonars(self, state: ObservedState) -> None:
        """A cone for each sonar or infrared sensor, as long as it measures."""
        parts: list[tuple[NDArray[Any], NDArray[Any]]] = []
        for number, entity in self.view.entities.items():
            for kind in ("sonar", "ir"):
                ring = self._reading(entity, kind)
                if ring is None or not ring.count:
                    continue
                pose = self.view.pose(number, state)[None]
                turns = np.array(ring.directions, dtype=float)
                for place, turn, reach in zip(np.array(ring.positions), turns, np.array(ring.ranges), strict=True):
                    own = np.array([[*place, math.cos(turn / 2.0), 0.0, 0.0, math.sin(turn / 2.0)]])
                    position, rotation = compose(pose[:, :3], pose[:, 3:], own[:, :3], own[:, 3:])
                    parts.append(_cone(position, rotation, float(reach), float(reach) * math.tan(CONE)))
            for sensor in entity["sensors"]:
                frame = self._frame(sensor["body"], state, sensor["pose"]) if sensor.get("cones") else None
                if frame is None:
                    continue
                for cone in sensor["cones"]:
                    parts.append(_cone(frame[:, :3], frame[:, 3:], float(cone["max"] or 1.0), float(cone["radius"])))
        vertices, faces = _joined(parts)
        self._mesh("sonars", vertices, faces, 0.16)

    def _frusta(self, state: ObservedState) -> None:
        """The field of view of each camera, up to 2 m, and in it the camera's last image."""
        lines: list[NDArray[Any]] = []
        shown: set[str] = set()
        for entity in self.view.entities.values():
            for sensor in entity["sensors"]:
                cameras = [sensor] if sensor["kind"] == "camera" and "fov" in sensor else sensor.get("cameras") or []
                for camera in cameras:
                    frame = self._frame(sensor["body"], state, sensor["pose"])
                    if frame is not None and camera is not sensor:
                        own = np.array([camera["pose"]], dtype=float)
                        position, rotation = compose(frame[:, :3], frame[:, 3:], own[:, :3], own[:, 3:])
                        frame = np.concatenate([position, rotation], axis=1)
                    if frame is not None:
                        lines.append(_frustum(frame, camera))
                        name = image_name(entity, sensor)
                        if name in self.images and name not in shown:
                            shown.add(name)
                            self._show_screen(name, frame, camera)
        self._lines("frusta", np.concatenate(lines) if lines else np.zeros((0, 2, 3)))
        self._keep_screens(shown)

    def _show_screen(self, name: str, frame: NDArray[Any], camera: dict[str, Any]) -> None:
        """Show a camera's image before it, as large as its field of view is there."""
        image, ahead = self.images[name], np.array([[SCREEN, 0.0, 0.0]])
        position, rotation = compose(frame[:, :3], frame[:, 3:], ahead, UPRIGHT)
        handle, former = self._screens.get(name, (None, None))
        if handle is None:
            width, height = (2.0 * SCREEN * half for half in _halves(camera))
            handle = self.page.scene.add_image(
                f"/world/marks/images/{name.replace('/', '_')}",
                image,
                width,
                height,
                format="jpeg",
                jpeg_quality=75,
                cast_shadow=False,
                receive_shadow=False,
                position=position[0],
                wxyz=rotation[0],
            )
        else:
            if image is not former:
                handle.image = image
            if not np.array_equal(handle.position, position[0]) or not np.array_equal(handle.wxyz, rotation[0]):
                handle.position, handle.wxyz = position[0], rotation[0]
        self._screens[name] = handle, image

    def _keep_screens(self, shown: Collection[str]) -> None:
        """Remove the images of all cameras but these."""
        for name in [name for name in self._screens if name not in shown]:
            self._screens.pop(name)[0].remove()

    # Mechanics -------------------------------------------------------------------------------------------------------

    def _contacts(self, _state: ObservedState) -> None:
        rows = np.array(self.contacts, dtype=float).reshape(-1, 7)
        self._lines("contacts", np.stack([rows[:, :3], rows[:, :3] + 0.15 * rows[:, 3:6]], axis=1), width=3.0)

    def _joints(self, state: ObservedState) -> None:
        lines = []
        for entity in self.view.entities.values():
            for joint in entity["joints"]:
                frame = self._frame(joint["frame"], state)
                if frame is None:
                    frame = np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
                for axis in joint["axes"]:
                    own = np.array([joint["anchor"], np.array(joint["anchor"]) + 0.25 * np.array(axis)], dtype=float)
                    ends, _ = compose(frame[[0, 0], :3], frame[[0, 0], 3:], own, UNIT[[0, 0]])
                    lines.append(ends)
        self._lines("joints", np.array(lines).reshape(-1, 2, 3), width=3.0)

    def _masses(self, state: ObservedState) -> None:
        rows = [
            body["row"]
            for entity in self.view.entities.values()
            for body in entity["bodies"]
            if not body["static"] and 0 <= body["row"] < len(state.bodies)
        ]
        centres = state.bodies[rows, 7:10]
        arms = 0.08 * np.eye(3)
        lines = np.stack([centres[:, None] - arms, centres[:, None] + arms], axis=2)
        self._lines("masses", lines.reshape(-1, 2, 3), width=2.0)

    def _boxes(self, state: ObservedState) -> None:
        found = [self.view.bounds(n, state) for n, entity in self.view.entities.items() if not entity["static"]]
        lines = [_edges(box) for box in found if box is not None]
        self._lines("boxes", np.concatenate(lines) if lines else np.zeros((0, 2, 3)))

    def _trails(self, state: ObservedState) -> None:
        """Where models that move have been."""
        lines = []
        if state.steps < self._steps:  # a reset, or back in time
            self._past.clear()
        self._steps = state.steps
        for number, entity in self.view.entities.items():
            if entity["static"] or entity["parent"] or not entity["bodies"]:
                continue
            here = self.view.pose(number, state)[:3].copy()
            if number not in self._past:
                box = self.view.bounds(number, state)
                self._lifts[number] = 0.0 if box is None else max(box[0][2] + TRAIL_HEIGHT - here[2], 0.0)
            here[2] += self._lifts[number]
            trail = self._past.setdefault(number, deque(maxlen=TRAIL))
            if not trail or np.linalg.norm(here - trail[-1]) > TRAIL_STEP:
                trail.append(here)
            if len(trail) > 1:
                path = np.array(trail)
                lines.append(np.stack([path[:-1], path[1:]], axis=1))
        self._lines("trails", np.concatenate(lines) if lines else np.zeros((0, 2, 3)), width=2.5)


def sensor_name(entity: dict[str, Any], sensor: dict[str, Any]) -> str:
    """``model::link::sensor``."""
    body = next((body["name"] for body in entity["bodies"] if body["id"] == sensor["body"]), "")
    return f"{entity['id']}::{body}::{sensor.get('name', '')}"


def image_name(entity: dict[str, Any], sensor: dict[str, Any]) -> str:
    """The name of a camera's image: the id of its interface, or ``model::link::sensor``; empty for none."""
    if "name" in sensor:
        return sensor_name(entity, sensor)
    return next((str(served["id"]) for served in entity["interfaces"] if served["type"] == "camera"), "")


def _joined(parts: list[tuple[NDArray[Any], NDArray[Any]]]) -> tuple[NDArray[Any], NDArray[Any]]:
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    if not parts:
        return np.zeros((0, 3)), np.zeros((0, 3), int)
    return (
        np.concatenate([vertices for vertices, _ in parts]),
        np.concatenate([faces + start for (_, faces), start in zip(parts, starts, strict=False)]),
    )


def _cone(position: Any, rotation: Any, length: float, radius: float) -> tuple[NDArray[Any], NDArray[Any]]:
    """A cone along x."""
    angles = np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False)
    rim = np.column_stack([np.full(12, length), radius * np.cos(angles), radius * np.sin(angles)])
    own = np.concatenate([np.zeros((1, 3)), rim])
    vertices, _ = compose(np.repeat(position, 13, 0), np.repeat(rotation, 13, 0), own, np.repeat(UNIT, 13, 0))
    order = np.arange(12)
    return vertices, np.stack([np.zeros_like(order), order + 1, (order + 1) % 12 + 1], axis=1)


def _halves(camera: dict[str, Any]) -> tuple[float, float]:
    """Half of the width and of the height of a camera's field of view, 1 m before it [m]."""
    half = math.tan(min(float(camera["fov"]), 3.0) / 2.0)
    return half, half / max(float(camera["aspect"] or 1.0), 1e-3)


def _frustum(frame: Any, camera: dict[str, Any]) -> NDArray[Any]:
    """The edges of a pyramid along x, shape (8, 2, 3)."""
    depth = min(float(camera["far"] or LONGEST_FRUSTUM), LONGEST_FRUSTUM)
    half, upright = (depth * part for part in _halves(camera))
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    own = np.array([(0.0, 0.0, 0.0), *((depth, half * y, upright * z) for y, z in signs)])
    corners, _ = compose(np.repeat(frame[:, :3], 5, 0), np.repeat(frame[:, 3:], 5, 0), own, np.repeat(UNIT, 5, 0))
    pairs = [(0, i) for i in range(1, 5)] + [(i, i % 4 + 1) for i in range(1, 5)]
    return np.array([(corners[a], corners[b]) for a, b in pairs])


def _edges(box: NDArray[Any]) -> NDArray[Any]:
    """The twelve edges of a box, shape (12, 2, 3)."""
    picks = [[(i >> k) & 1 for k in range(3)] for i in range(8)]
    corners = np.array([[box[pick[k]][k] for k in range(3)] for pick in picks])
    return np.array([(corners[i], corners[i | 1 << k]) for i in range(8) for k in range(3) if not i >> k & 1])
