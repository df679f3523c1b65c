"""SceneView: the scene of a running world as nodes of the page, moved by the table of states."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from libgz.base.errors import NotFoundError
from libgz.physics.skeletons import matrix_turns
from libgz.transport.observer import ObservedState
from libgz.view.shapes import Form, Instance, Shapes, compose, extent_corners
from libgz.view.source import Source

__all__ = ["Look", "SceneView"]

log = logging.getLogger("libgz.view")

FAR = 1000.0  # [m]
WIDE = 30.0  # [m] from which a mesh is terrain, which casts no shadows on itself
FULL = math.pi  # intensity at which a white surface facing the light is white


@dataclass(frozen=True)
class Look:
    """How the scene is shown."""

    wireframe: bool = False
    collisions: bool = False


@dataclass
class _Batch:
    """The instances of one form that move, or of one that do not.

    Attributes:
        rows: of their bodies, -1 for a global pose; `at`, `turn` are poses in the body's frame.
        owners: number of the entity of each.
    """

    form: Form
    instances: list[Instance] = field(default_factory=list)
    rows: list[int] = field(default_factory=list)
    owners: list[int] = field(default_factory=list)
    handle: Any = None
    signature: Any = None
    place: slice = field(default_factory=lambda: slice(0))
    shown: tuple[NDArray[Any], NDArray[Any]] | None = None


@dataclass
class _Skin:
    """A mesh that bones bend.

    Attributes:
        bones: the rows of the bodies that are its bones.
        signature: what it is made from.
    """

    owner: int
    shape: dict[str, Any]
    bones: list[int]
    signature: Any
    handle: Any = None
    shown: NDArray[Any] | None = None


class SceneView:
    """Shows a scene.

    Args:
        page: the page's server.
        source: of the scene.
        on_click: called with the id of the entity that was clicked, and the number of the page's client.
    """

    def __init__(self, page: viser.ViserServer, source: Source, on_click: Callable[[str, int], None]) -> None:
        self.page, self.source = page, source
        self.shapes = Shapes(source)
        self.scene: dict[str, Any] = {}
        self.entities: dict[int, dict[str, Any]] = {}
        self.ids: dict[str, int] = {}
        self.rows: dict[int, int] = {}  # body -> row
        self.look = Look()
        self.shadows = True
        self._on_click = on_click
        self._batches: dict[Any, _Batch] = {}
        self._skins: list[_Skin] = []
        self._leaving: list[Any] = []  # nodes that the next state replaces
        self._made = 0
        self._moving: tuple[NDArray[Any], ...] = ()
        self._lights: list[tuple[Any, int, tuple[float, ...]]] = []
        self._sun: Any = None  # the light that casts shadows
        self._light_signature: list[Any] = []
        self._surroundings: Any = None
        self._sky: Any = None
        self.extents: dict[int, list[tuple[int, Instance]]] = {}  # body row -> instances, of each entity

    # Content ---------------------------------------------------------------------------------------------------------

    def show(self, scene: dict[str, Any]) -> None:
        """Show a scene; what did not change since the last one is left alone."""
        self.scene = scene
        self.entities = {entity["number"]: entity for entity in scene["entities"]}
        self.ids = {entity["id"]: entity["number"] for entity in reversed(scene["entities"])}
        bodies = [(entity, body) for entity in scene["entities"] for body in entity["bodies"]]
        self.rows = {body["id"]: body["row"] for _, body in bodies}
        with self.page.atomic():
            self._fill([*bodies, *(({"number": 0, "static": True}, body) for body in scene["others"])])
            self._show_lights(bodies)
            self._show_surroundings()

    def _fill(self, bodies: list[tuple[dict[str, Any], dict[str, Any]]]) -> None:
        batches: dict[Any, _Batch] = {}
        skins: list[_Skin] = []
        self.extents = {}
        for entity, body in bodies:
            for shape in body["shapes"]:
                bent = "bones" in shape and not self.look.collisions
                still = bool(entity["static"] or body["static"])
                try:
                    found = list(self.shapes.instances(shape, self.look.collisions))
                except NotFoundError:
                    continue  # the scene has changed meanwhile; the next one follows
                if bent and found:
                    skins.append(self._skin(entity, shape))
                    self.extents.setdefault(entity["number"], []).extend((body["row"], one) for one in found)
                    continue
                for instance in found:
                    key = (instance.form.key, still, self.look)
                    batch = batches.setdefault(key, _Batch(instance.form))
                    batch.instances.append(instance)
                    batch.rows.append(-1 if shape["kind"] == "plane" else body["row"])
                    batch.owners.append(entity["number"])
                    if shape["kind"] != "plane":
                        self.extents.setdefault(entity["number"], []).append((body["row"], instance))
        for key, batch in batches.items():
            batch.signature = [(i.pose, i.scale, i.color, i.opacity) for i in batch.instances], batch.owners
            former = self._batches.get(key)
            if former is not None and former.signature == batch.signature:
                batch.handle, batch.shown = former.handle, former.shown
                former.handle = None
        self._leaving += [old.handle for old in self._batches.values() if old.handle is not None]
        self._batches = batches
        former_skins = {skin.shape["id"]: skin for skin in self._skins}
        for skin in skins:
            old = former_skins.get(skin.shape["id"])
            if old is not None and old.signature == skin.signature:
                skin.handle, skin.shown, old.handle = old.handle, old.shown, None
        self._leaving += [skin.handle for skin in self._skins if skin.handle is not None]
        self._skins = skins
        self._gather()

    def _skin(self, entity: dict[str, Any], shape: dict[str, Any]) -> _Skin:
        bones = [self.rows.get(body, -1) for body in shape["bones"]["bodies"]]
        signature = shape["id"], shape["material"], shape["texture"], len(bones), self.look
        return _Skin(entity["number"], shape, bones, signature)

    def _make_skin(self, skin: _Skin) -> None:
        """Add the node of a skin, as its bones are bound to it."""
        shape = skin.shape
        arrays = self.source.data(shape["bones"]["data"])
        places, weights = np.asarray(arrays["places"], dtype=int), np.asarray(arrays["weights"], dtype=float)
        dense = np.zeros((len(weights), len(skin.bones)))
        np.add.at(dense, (np.arange(len(weights))[:, None], places), weights)
        binds = np.linalg.inv(np.asarray(arrays["inverse_binds"], dtype=float).reshape(-1, 4, 4))
        tone, own = self.shapes.tone(shape["texture"]), shape["material"]["diffuse"][:3]  # it shows no images on skins
        red, green, blue = (round(255 * min(max(float(c) * t, 0.0), 1.0)) for c, t in zip(own, tone, strict=True))
        self._made += 1
        skin.handle = self.page.scene.add_mesh_skinned(
            f"/world/{self._made}",
            np.asarray(arrays["rest"], dtype=np.float32),
            np.asarray(self.source.data(shape["data"])["triangles"], dtype=np.uint32),
            bone_wxyzs=matrix_turns(binds),
            bone_positions=binds[:, :3, 3],
            skin_weights=dense,
            color=(red, green, blue),
            wireframe=self.look.wireframe,
            side="double",
        )
        owner = skin.owner

        def clicked(event: Any) -> None:
            entity = self.entities.get(owner)
            self._on_click("" if entity is None else entity["id"], event.client_id)

        skin.handle.on_click(clicked)

    def _move_skins(self, state: ObservedState) -> None:
        for skin in self._skins:
            rows = np.array(skin.bones, dtype=int)
            if len(rows) == 0 or rows.min() < 0 or rows.max() >= len(state.bodies):
                continue
            if skin.handle is None:
                try:
                    self._make_skin(skin)
                except NotFoundError:
                    continue  # the scene has changed meanwhile; the next one follows
            poses = np.array(state.bodies[rows, :7])
            if skin.shown is not None and np.array_equal(poses, skin.shown):
                continue
            skin.shown = poses
            for bone, pose in zip(skin.handle.bones, poses, strict=True):
                bone.position, bone.wxyz = pose[:3], pose[3:]

    def _gather(self) -> None:
        """Put the poses of all instances into common arrays, so that a state moves all of them at once."""
        instances, rows, start = [], [], 0
        for batch in self._batches.values():
            instances += [instance.pose for instance in batch.instances]
            rows += batch.rows
            batch.place = slice(start, len(rows))
            start = len(rows)
        poses = np.array(instances, dtype=float).reshape(-1, 7)
        self._moving = (np.array(rows, dtype=int), poses[:, :3], poses[:, 3:])

    def _make(self, batch: _Batch, positions: NDArray[Any], rotations: NDArray[Any]) -> None:
        """Add the node of a batch."""
        form, scene = batch.form, self.page.scene
        self._made += 1
        name = f"/world/{self._made}"
        ground = form.key[0] == "plane"
        common: dict[str, Any] = {
            "batched_wxyzs": rotations,
            "batched_positions": positions,
            "batched_scales": np.array([i.scale for i in batch.instances], dtype=np.float32),
            "lod": "off",
            "cast_shadow": not ground and not form.clear and bool(np.ptp(form.vertices, axis=0).max() < WIDE),
            "receive_shadow": True,
        }
        if form.glb is not None and not self.look.wireframe and not self.look.collisions:
            batch.handle = scene.add_batched_glb(name, form.glb, **common)
        else:
            batch.handle = scene.add_batched_meshes_simple(
                name,
                form.vertices,
                form.faces,
                batched_colors=np.array([i.color for i in batch.instances], dtype=np.uint8),
                batched_opacities=np.array([i.opacity for i in batch.instances], dtype=np.float32)
                if form.clear
                else None,
                opacity=1.0 if form.clear else None,
                wireframe=self.look.wireframe,
                side="double" if form.both else "front",
                **common,
            )
        owners = list(batch.owners)

        def clicked(event: Any) -> None:
            index = event.instance_index
            number = owners[index] if index is not None and index < len(owners) else owners[0]
            entity = self.entities.get(number)
            self._on_click("" if entity is None or ground else entity["id"], event.client_id)

        batch.handle.on_click(clicked)

    # Surroundings ----------------------------------------------------------------------------------------------------

    def _show_surroundings(self) -> None:
        scene = self.scene
        present = [scene[key] for key in ("background", "fog", "ambient")]
        present.append(None if scene["sky"] is None else scene["sky"]["texture"])
        if present == self._surroundings:
            return
        self._surroundings = present
        nodes = self.page.scene
        color = np.clip(np.array(scene["background"][:3], dtype=float), 0.0, 1.0)
        fog = scene["fog"]
        horizon = self.shapes.horizon(scene)
        if horizon is not None:
            color = horizon
        if fog is not None:
            color = np.clip(np.array(fog["color"][:3], dtype=float), 0.0, 1.0)
        nodes.set_background_image(np.full((2, 2, 3), np.round(255 * color), dtype=np.uint8), format="png")
        if fog is None:
            nodes.configure_fog(1.0, 1000.0, enabled=False)
        else:
            density = max(float(fog["density"]), 1e-6)
            near, far = (fog["start"], fog["end"]) if fog["kind"] == "linear" else (0.1 / density, 2.5 / density)
            nodes.configure_fog(
                float(near or 0.0),
                max(float(far or 100.0), float(near or 0.0) + 0.01),
                color=tuple(int(c) for c in np.round(255 * color)),  # type: ignore[arg-type]
            )
        ambient = min(max(float(np.mean(scene["ambient"][:3])), 0.0), 1.0)
        nodes.configure_default_lights(enabled=False)
        nodes.configure_environment_map(None)
        nodes.add_light_hemisphere(
            "/light/ambient",
            sky_color=(255, 255, 255),
            ground_color=(175, 170, 165),
            intensity=FULL * (0.32 + 0.6 * ambient),
        )
        if self._sky is not None:
            self._sky.remove()
            self._sky = None
        glb = self.shapes.sky(scene)
        if glb is not None:
            self._sky = nodes.add_glb("/sky", glb, cast_shadow=False, receive_shadow=False)

    def _show_lights(self, bodies: list[tuple[dict[str, Any], dict[str, Any]]]) -> None:
        found = [
            (entity, body, shape)
            for entity, body in bodies
            for shape in body["shapes"]
            if shape["kind"] == "light" and shape["visible"]
        ]
        signature = [(body["row"], shape) for _, body, shape in found]
        if signature == self._light_signature and self._lights:
            return
        self._light_signature = signature
        for handle, _, _ in self._lights:
            handle.remove()
        self._lights, self._sun = [], None
        strong = [entry for entry in found if max(entry[2]["material"]["diffuse"][:3]) > 0.0]
        share = 1.0 / max(1.0, math.sqrt(len(strong)))
        sun = next((e for e in strong if e[2]["light"] == "directional"), strong[0] if strong else None)
        for i, (entity, body, shape) in enumerate(strong):
            shadow = (entity, body, shape) == sun and entity.get("cast_shadows", True) is not False
            handle = self._light(i, shape, share, shadow)
            self._lights.append((handle, body["row"], tuple(shape["pose"])))
            self._sun = handle if shadow else self._sun
        if not found:
            handle = self.page.scene.add_light_directional(
                "/light/sun", intensity=0.6 * FULL, cast_shadow=True, position=_opposite((0.4, 0.3, -0.9))
            )
            self._lights.append((handle, -1, ()))
            self._sun = handle
        self.show_shadows(self.shadows)

    def show_shadows(self, on: bool) -> None:
        """Whether there are shadows, as far as the scene allows them."""
        self.shadows = on
        if self._sun is not None and self._sun.cast_shadow != on:
            self._sun.cast_shadow = on

    def _light(self, number: int, shape: dict[str, Any], share: float, shadow: bool) -> Any:
        diffuse = shape["material"]["diffuse"]
        color = tuple(round(255 * min(max(float(c), 0.0), 1.0)) for c in diffuse[:3])
        nodes, name, kind = self.page.scene, f"/light/{number}", shape["light"]
        options: dict[str, Any] = {"color": color, "cast_shadow": shadow}
        if kind == "point" and shadow:
            # It shines from its place to the middle of the world: such shadows are sharp at any distance.
            return nodes.add_light_directional(name, intensity=0.7 * FULL * share, **options)
        if kind == "directional":
            return nodes.add_light_directional(name, intensity=0.7 * FULL * share, **options)
        constant, linear, quadratic = (float(value or 0.0) for value in shape["attenuation"])
        strength = 0.7 * FULL * share / max(constant, 0.2)
        fades = linear + quadratic
        options |= {"intensity": strength * (1.0 if not fades else 4.0), "decay": 0.0 if not fades else 0.7}
        if kind == "spot":
            inner, outer, _ = (float(value or 0.0) for value in shape["spot"])
            half = min(max(outer / 2.0, 0.02), math.pi / 2.0)
            return nodes.add_light_spot(
                name,
                angle=half,
                penumbra=min(max(1.0 - inner / outer if outer else 0.0, 0.0), 1.0),
                direction=tuple(map(float, shape["direction"])),  # type: ignore[arg-type]
                **options,
            )
        return nodes.add_light_point(name, **options)

    # States ----------------------------------------------------------------------------------------------------------

    def move(self, state: ObservedState) -> None:
        """Move everything to where it is in a state that belongs to the scene."""
        rows, at, turn = self._moving
        bodies = state.bodies
        valid = np.clip(rows, 0, max(len(bodies) - 1, 0))
        frames = np.tile(np.array((0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)), (len(rows), 1))
        if len(bodies) and len(rows):
            frames = np.where((rows >= 0)[:, None], bodies[valid, :7], frames)
        positions, rotations = compose(frames[:, :3], frames[:, 3:], at, turn)
        positions, rotations = positions.astype(np.float32), rotations.astype(np.float32)
        with self.page.atomic():
            for handle in self._leaving:
                handle.remove()
            self._leaving = []
            for batch in self._batches.values():
                here = positions[batch.place], rotations[batch.place]
                if batch.handle is None:
                    self._make(batch, *here)
                elif batch.shown is None or not np.array_equal(here[0], batch.shown[0]):
                    batch.handle.batched_positions = here[0]
                    batch.handle.batched_wxyzs = here[1]
                elif not np.array_equal(here[1], batch.shown[1]):
                    batch.handle.batched_wxyzs = here[1]
                batch.shown = here
            self._move_skins(state)
            self._move_lights(state)

    def _move_lights(self, state: ObservedState) -> None:
        for (handle, row, pose), (_, shape) in zip(self._lights, self._light_signature, strict=False):
            if not 0 <= row < len(state.bodies):
                continue
            frame, own = state.bodies[row : row + 1, :7], np.array([pose])
            position, rotation = compose(frame[:, :3], frame[:, 3:], own[:, :3], own[:, 3:])
            if shape["light"] == "directional":
                zero, unit = np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]])
                along, _ = compose(zero, rotation, np.array([shape["direction"]], dtype=float), unit)
                position, rotation = np.array([_opposite(along[0])]), unit
            if not np.allclose(handle.position, position[0]) or not np.allclose(handle.wxyz, rotation[0]):
                handle.position, handle.wxyz = position[0], rotation[0]

    # Questions -------------------------------------------------------------------------------------------------------

    def pose(self, number: int, state: ObservedState) -> NDArray[np.float64]:
        """The global pose of an entity: position [m] and quaternion (u, x, y, z)."""
        entity = self.entities[number]
        own = np.array([entity["pose"]], dtype=float)
        row = self.rows.get(entity["body"], -1)
        if not 0 <= row < len(state.bodies):
            alone: NDArray[np.float64] = own[0]
            return alone
        frame = state.bodies[row : row + 1, :7]
        position, rotation = compose(frame[:, :3], frame[:, 3:], own[:, :3], own[:, 3:])
        return np.concatenate([position[0], rotation[0]])

    def family(self, number: int) -> list[int]:
        """An entity, and all that is attached to it or nested in it."""
        found = [number]
        for one in found:
            found += [n for n, entity in self.entities.items() if entity["parent"] == one and n not in found]
        return found

    def bounds(self, number: int, state: ObservedState) -> NDArray[np.float64] | None:
        """The smallest and largest corner of an entity's shapes along the world's axes [m]; None without shapes."""
        corners = []
        for row, instance in self.extents.get(number, ()):
            if not 0 <= row < len(state.bodies):
                continue
            pose = np.array([instance.pose])
            frame = state.bodies[row : row + 1, :7]
            position, rotation = compose(frame[:, :3], frame[:, 3:], pose[:, :3], pose[:, 3:])
            own = extent_corners(instance.extent)
            unit = np.tile((1.0, 0.0, 0.0, 0.0), (8, 1))
            placed, _ = compose(np.tile(position, (8, 1)), np.tile(rotation, (8, 1)), own, unit)
            corners.append(placed)
        if not corners:
            return None
        everything = np.concatenate(corners)
        return np.array((everything.min(axis=0), everything.max(axis=0)))

    def clear(self) -> None:
        """Remove everything, for another run."""
        for batch in self._batches.values():
            if batch.handle is not None:
                batch.handle.remove()
        for skin in self._skins:
            if skin.handle is not None:
                skin.handle.remove()
        for handle, _, _ in self._lights:
            handle.remove()
        self._skins = []
        self._batches, self._lights, self._light_signature, self._surroundings = {}, [], [], None
        self.shapes.clear()


def _opposite(direction: Any) -> tuple[float, float, float]:
    """Where the page's directional light stands to shine in a direction: it shines towards the origin."""
    d = np.asarray(direction, dtype=float)
    x, y, z = (-FAR * d / (np.linalg.norm(d) or 1.0)).tolist()
    return x, y, z
