"""Foxglove: says again what a log holds in messages of Foxglove's schemas, which its viewer shows without settings.

Frames are `world` and the bodies, as `entity::body`; odometry has a frame of its own, `entity/odom`.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.LocationFix_pb2 import LocationFix
from foxglove_schemas_protobuf.Odometry_pb2 import Odometry
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from PIL import Image

from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzQuatern, GzQuaternFromEuler, GzVector
from libgz.recording.own_messages import States
from libgz.recording.templates import Encoded, joints_template, packed_field, transforms_template

__all__ = ["Converter"]

PERIOD = 1.0 / 30.0  # [s] between two messages of frames and joints
PLANE = 100.0  # [m], half a side of what is shown of an infinite plane
SHOWN = ("box", "sphere", "cylinder", "wheel", "capsule", "mesh", "heightfield", "plane")
QUALITY = 90  # of JPEG images

_TRANSFORM_ORDER = (0, 1, 2, 4, 5, 6, 3)  # of a pose: the quaternion's real part comes last
Output = tuple[str, Any]  # topic and message


def _stamp(target: Any, nanoseconds: int) -> None:
    target.seconds, target.nanos = divmod(nanoseconds, 1_000_000_000)


def _set_pose(target: Any, pose: GzPose | list[float]) -> None:
    x, y, z, qu, qx, qy, qz = (*pose.pos, *pose.rot) if isinstance(pose, GzPose) else pose
    target.position.x, target.position.y, target.position.z = x, y, z
    rotation = target.orientation
    rotation.w, rotation.x, rotation.y, rotation.z = qu, qx, qy, qz


def _as_pose(values: list[float]) -> GzPose:
    return GzPose(GzVector(*values[:3]), GzQuatern(*values[3:]))


class Converter:
    """Makes such messages from the messages of a log, in their order."""

    def __init__(self) -> None:
        self._scene: dict[str, Any] = {"entities": [], "others": []}
        self._owners: dict[tuple[str, str], dict[str, Any]] = {}  # entity by interface
        self._frames: dict[int, tuple[str, int]] = {}  # frame and row by number of the body
        self._contents: dict[str, bytes] = {}
        self._states: States | None = None
        self._due = -math.inf
        self._odometry: dict[str, GzPose] = {}  # poses of frames of odometry
        self._shown: set[str] = set()
        self._images: dict[str, float] = {}
        self._scene_number = 0
        self._placed = (-1, 0, 0)
        self._rows = self._joint_rows = np.zeros(0, dtype=int)
        self._fixed = np.zeros((0, 7))
        self._tf, self._joints = transforms_template([]), joints_template([])
        self._readers: dict[str, Callable[[str, Any, int], Iterator[Output]]] = {
            "laser": self._laser,
            "position": self._position,
            "truth": self._truth,
            "gps": self._gps,
            "camera": self._camera,
            "guicam": self._camera,
            "stereo": self._camera,
        }

    # What the world shows ------------------------------------------------------------------------------------------

    def file(self, name: str, content: bytes) -> None:
        """Arrays that a scene will refer to."""
        if not name.startswith("/"):
            self._contents[name] = content

    def scene(self, content: bytes, time: int) -> Iterator[Output]:
        """A new scene, at a time of the log [ns]."""
        self._scene = scene = json.loads(content)
        self._scene_number += 1
        self._owners, self._frames = {}, {}
        for entity in scene["entities"]:
            for one in entity["interfaces"]:
                self._owners[one["type"], one["id"]] = entity
            for body in entity["bodies"]:
                self._frames[body["id"]] = f"{entity['id']}::{body['name'] or body['id']}", body["row"]
        for body in scene["others"]:
            self._frames[body["id"]] = f"body{body['id']}", body["row"]
        self._due = -math.inf
        update = SceneUpdate()
        shown: set[str] = set()
        every = [body for entity in scene["entities"] for body in entity["bodies"]] + scene["others"]
        for body in every:
            shapes = [shape for shape in body["shapes"] if shape["visible"] and shape["kind"] in SHOWN]
            if shapes:
                self._add_entity(update, body, shapes, time)
                shown.add(self._frames[body["id"]][0])
        for name in self._shown - shown:
            gone = update.deletions.add(id=name)
            _stamp(gone.timestamp, time)
        self._shown = shown
        yield "/scene", update

    def _add_entity(self, update: Any, body: dict[str, Any], shapes: list[dict[str, Any]], time: int) -> None:
        frame = self._frames[body["id"]][0]
        entity = update.entities.add(frame_id=frame, id=frame, frame_locked=True)
        _stamp(entity.timestamp, time)
        for shape in shapes:
            self._add_shape(entity, shape)

    def _add_shape(self, entity: Any, shape: dict[str, Any]) -> None:
        kind = shape["kind"]
        if kind == "box":
            made = entity.cubes.add()
            made.size.x, made.size.y, made.size.z = shape["size"]
        elif kind == "sphere":
            made = entity.spheres.add()
            made.size.x = made.size.y = made.size.z = 2.0 * shape["radius"]
        elif kind in ("cylinder", "wheel", "capsule"):
            made = entity.cylinders.add(bottom_scale=1.0, top_scale=1.0)
            tire = shape.get("tire_radius", 0.0)
            made.size.x = made.size.y = 2.0 * (shape["radius"] + tire)
            made.size.z = shape.get("length", 2.0 * tire)
        else:
            made = entity.triangles.add()
            points, indices = self._triangles(shape)
            for x, y, z in points.tolist():
                made.points.add(x=x, y=y, z=z)
            made.indices.extend(indices.ravel().tolist())
        _set_pose(made.pose, shape["pose"] if kind != "plane" else [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        material = shape["material"]
        made.color.r, made.color.g, made.color.b = (float(part) for part in material["diffuse"][:3])
        made.color.a = float(material["opacity"])

    def _triangles(self, shape: dict[str, Any]) -> tuple[Any, Any]:
        """Points, shape (n, 3), and indices, shape (m, 3)."""
        if shape["kind"] == "plane":
            normal = np.asarray(shape["normal"], float)
            side = np.cross(normal, [1.0, 0.0, 0.0] if abs(normal[0]) < 0.9 else [0.0, 1.0, 0.0])
            side /= np.linalg.norm(side)
            other = np.cross(normal, side)
            centre = normal * shape["altitude"]
            corners = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
            points = np.array([centre + PLANE * (a * side + b * other) for a, b in corners])
            return points, np.array([[0, 1, 2], [0, 2, 3]])
        arrays = self._arrays(shape["data"])
        if shape["kind"] == "mesh":
            return arrays["vertices"], arrays["triangles"]
        heights = arrays["heights"]
        rows, columns = heights.shape
        width, depth = shape["size"]
        x, y = np.meshgrid(np.linspace(-width / 2, width / 2, columns), np.linspace(-depth / 2, depth / 2, rows))
        points = np.column_stack([x.ravel(), y.ravel(), heights.ravel()])
        corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
        first = np.column_stack([corner, corner + 1, corner + columns])
        return points, np.concatenate([first, np.column_stack([corner + 1, corner + columns + 1, corner + columns])])

    def _arrays(self, reference: dict[str, Any]) -> dict[str, Any]:
        content = self._contents.get(reference["file"], b"")
        found = {}
        for name, part in reference["arrays"].items():
            count = int(np.prod(part["shape"]))
            found[name] = np.frombuffer(content, part["type"], count, part["offset"]).reshape(part["shape"])
        return found

    def states(self, states: States) -> None:
        """New states; they are shown at the end of a step, if it is time."""
        self._states = states

    def end(self, time: int) -> Iterator[Output]:
        """Frames and joints, if they are due at a time of the log [ns]."""
        if self._states is None or time * 1e-9 < self._due - 1e-9:
            return
        self._due = time * 1e-9 + PERIOD
        bodies, joints = self._states.body_rows, self._states.joint_rows
        self._place_frames(len(bodies))
        poses = np.concatenate([bodies[self._rows, :7], self._fixed])
        yield "/tf", self._tf.message(time, poses[:, _TRANSFORM_ORDER])
        if len(self._joint_rows):
            values = joints[self._joint_rows][:, (0, 2)]
            yield "/joint_states", self._joints.message(time, values)

    def _place_frames(self, count: int) -> None:
        """Prepare the messages of frames and joints for a new scene, or new frames of odometry."""
        if self._placed == (self._scene_number, len(self._odometry), count):
            return
        self._placed = self._scene_number, len(self._odometry), count
        frames = [(name, row) for name, row in self._frames.values() if 0 <= row < count]
        self._rows = np.array([row for _, row in frames], dtype=int)
        odometry = {f"{name}/odom": [*pose.pos, *pose.rot] for name, pose in self._odometry.items()}
        self._fixed = np.array(list(odometry.values()), dtype=float).reshape(-1, 7)
        self._tf = transforms_template([*(name for name, _ in frames), *odometry])
        joints = [
            (f"{entity['id']}::{joint['name']}", joint["row"])
            for entity in self._scene["entities"]
            for joint in entity["joints"]
            if joint["row"] >= 0
        ]
        self._joint_rows = np.array([row for _, row in joints], dtype=int)
        self._joints = joints_template([name for name, _ in joints])

    # Interfaces ------------------------------------------------------------------------------------------------------

    def interface(self, kind: str, name: str, data: Any, time: int) -> Iterator[Output]:
        """New data of an interface, a struct, at a time of the log [ns]."""
        reader = self._readers.get(kind)
        if reader is not None:
            yield from reader(f"{kind}.{name}", data, time)

    def _frame_of(self, key: str) -> tuple[str, list[float]]:
        """The frame of an interface's entity, and its pose in it."""
        kind, _, name = key.partition(".")
        entity = self._owners.get((kind, name))
        if entity is None:
            return "world", [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
        frame = self._frames.get(entity["body"])
        return (frame[0] if frame is not None else "world"), entity["pose"]

    def _pose_of(self, key: str) -> GzPose:
        """The present global pose of an interface's entity [m]."""
        kind, _, name = key.partition(".")
        entity = self._owners.get((kind, name))
        row = self._frames.get(entity["body"], ("", -1))[1] if entity is not None else -1
        if entity is None or self._states is None or row < 0:
            return GzPose()
        return GzCoordPoseAdd(_as_pose(entity["pose"]), _as_pose(self._states.body_rows[row, :7].tolist()))

    def _laser(self, key: str, data: Any, time: int) -> Iterator[Output]:
        count = max(0, min(data.range_count, len(data.ranges)))
        frame, pose = self._frame_of(key)
        scan = LaserScan(frame_id=frame, start_angle=data.min_angle, end_angle=data.max_angle)
        _stamp(scan.timestamp, time)
        _set_pose(scan.pose, pose)
        ranges = np.frombuffer(data.ranges, dtype=float)[:count]
        intensities = np.frombuffer(data.intensity, dtype=np.int32)[:count].astype(float)
        parts = (
            packed_field(LaserScan, name, part) for name, part in (("ranges", ranges), ("intensities", intensities))
        )
        yield f"/{key.replace('.', '/')}/scan", Encoded(LaserScan, scan.SerializeToString() + b"".join(parts))

    def _position(self, key: str, data: Any, time: int) -> Iterator[Output]:
        name = key.partition(".")[2]
        pose = GzPose(GzVector(*data.pos), GzQuaternFromEuler(*data.rot))
        if name not in self._odometry and self._states is not None:
            self._odometry[name] = self._pose_of(key)
        odometry = Odometry(frame_id=f"{name}/odom", body_frame_id=self._frame_of(key)[0])
        _stamp(odometry.timestamp, time)
        _set_pose(odometry.pose, pose)
        linear, angular = odometry.linear_velocity, odometry.angular_velocity
        linear.x, linear.y, linear.z = data.vel_pos
        angular.x, angular.y, angular.z = data.vel_rot
        yield f"/{key.replace('.', '/')}/odometry", odometry

    def _truth(self, key: str, data: Any, time: int) -> Iterator[Output]:
        rotation = GzQuatern(*data.rot) if len(data.rot) == 4 else GzQuaternFromEuler(*data.rot)
        message = PoseInFrame(frame_id="world")
        _stamp(message.timestamp, time)
        _set_pose(message.pose, GzPose(GzVector(*data.pos), rotation))
        yield f"/{key.replace('.', '/')}/pose", message

    def _gps(self, key: str, data: Any, time: int) -> Iterator[Output]:
        fix = LocationFix(latitude=data.latitude, longitude=data.longitude, altitude=data.altitude)
        fix.frame_id = self._frame_of(key)[0]
        _stamp(fix.timestamp, time)
        yield f"/{key.replace('.', '/')}/fix", fix

    def _camera(self, key: str, data: Any, time: int) -> Iterator[Output]:
        taken = data.time if hasattr(data, "time") else data.sim_time + data.pause_time
        size = data.left_image_size if hasattr(data, "left_image_size") else data.image_size
        if not size or self._images.get(key) == taken:
            return
        self._images[key] = taken
        pixels = memoryview(data.left_image if hasattr(data, "left_image") else data.image).cast("B")
        yield from self._image(key, (data.width, data.height), bytes(pixels[:size]), time)

    def _image(self, key: str, size: tuple[int, int], pixels: bytes, time: int) -> Iterator[Output]:
        if not size[0] * size[1] or len(pixels) != 3 * size[0] * size[1]:
            return
        out = io.BytesIO()
        Image.frombytes("RGB", size, pixels).save(out, "JPEG", quality=QUALITY)
        image = CompressedImage(frame_id=self._frame_of(key)[0], data=out.getvalue(), format="jpeg")
        _stamp(image.timestamp, time)
        yield f"/{key.replace('.', '/')}/image", image

    # Topics of classic worlds ----------------------------------------------------------------------------------------

    def topic(self, name: str, message: Any, time: int) -> Iterator[Output]:
        """A message of a topic of a classic world, at a time of the log [ns]."""
        kind = message.GetTypeName()
        if kind == "gazebo.msgs.LaserScanStamped":
            scan = message.scan
            made = LaserScan(frame_id="world", start_angle=scan.angle_min, end_angle=scan.angle_max)
            _stamp(made.timestamp, time)
            place, turn = scan.world_pose.position, scan.world_pose.orientation
            _set_pose(made.pose, [place.x, place.y, place.z, turn.w, turn.x, turn.y, turn.z])
            made.ranges.extend(scan.ranges[: scan.count or len(scan.ranges)])
            made.intensities.extend(scan.intensities[: scan.count or len(scan.intensities)])
            yield f"{name}/scan", made
        elif kind == "gazebo.msgs.ImageStamped" and message.image.step == 3 * message.image.width:
            image = message.image
            for _, made in self._image("", (image.width, image.height), image.data, time):
                yield f"{name}/image", made
