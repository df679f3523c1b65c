"""What the camera plugins have in common: calibration, images, clouds."""

from __future__ import annotations

import io
import logging
import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from libgz.ros.plugin import Endpoint, Parameter, Rate
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.reconfigure import Knob
from libgz.ros.session import Publication
from libgz.ros.types import Message, message_type

if TYPE_CHECKING:
    from collections.abc import Mapping

    from libgz.sdf.element import Element

__all__ = ["CAMERA", "CAMERA_ENDPOINTS", "DEPTH", "DEPTH_ENDPOINTS", "DepthCloud", "RosCamera"]

log = logging.getLogger("libgz.ros")

# Parameters -> their places in the projection matrix.
PROJECTION = {"PFx": 0, "PCx": 2, "Tx": 3, "PFy": 5, "PCy": 6, "Ty": 7}
IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
CAMERA = (
    Parameter("cameraName", "", "the namespace of its topics (in ROS 2 the sensor's name)"),
    Parameter("frameName", "", "frame of the images"),
    Parameter("imageTopicName", "image_raw", "images"),
    Parameter("cameraInfoTopicName", "camera_info", "calibration"),
    Parameter("updateRate", Rate(0.0), "at most so many images a second [Hz]; 0: all"),
    Parameter("Cx", 0.0, "principal point [px]; 0: (width + 1) / 2"),
    Parameter("Cy", 0.0, "principal point [px]; 0: (height + 1) / 2"),
    Parameter("CxPrime", 0.0, "accepted without effect, as in the original"),
    Parameter("focalLength", 0.0, "[px]; 0: width / (2 tan(hfov / 2))"),
    Parameter("hackBaseline", 0.0, "of a stereo pair: P[3] is - focal length * baseline [m]"),
    Parameter("distortionK1", 0.0, "distortion"),
    Parameter("distortionK2", 0.0, "distortion"),
    Parameter("distortionK3", 0.0, "distortion"),
    Parameter("distortionT1", 0.0, "distortion"),
    Parameter("distortionT2", 0.0, "distortion"),
    Parameter("autoDistortion", False, "take the distortion of the camera's `<distortion>`", ros2=True),
    Parameter("borderCrop", True, "crop the black border of a distorted image"),
    Parameter("rectificationMatrix", "", "in ROS 2: of the calibration, nine numbers; none: identity"),
    *(
        Parameter(name, math.nan, f"in ROS 2: P[{place}] of the calibration (nan: as computed)")
        for name, place in PROJECTION.items()
    ),
)
CAMERA_ENDPOINTS = (
    Endpoint("publishes", "<cameraName>/<imageTopicName>", "sensor_msgs/Image"),
    Endpoint("publishes", "<cameraName>/<cameraInfoTopicName>", "sensor_msgs/CameraInfo"),
    Endpoint("publishes", "<cameraName>/<imageTopicName>/compressed", "sensor_msgs/CompressedImage"),
    Endpoint("in ROS 1 serves", "<cameraName>/set_parameters", "dynamic_reconfigure/Reconfigure"),
)
DEPTH = (
    Parameter("depthImageTopicName", "depth/image_raw", "depths"),
    Parameter("depthImageCameraInfoTopicName", "depth/camera_info", "calibration of the depths"),
    Parameter("pointCloudTopicName", "points", "points"),
    Parameter("pointCloudCutoff", 0.4, "nearest depth [m]"),
    Parameter("pointCloudCutoffMax", 5.0, "farthest depth [m]", ros2=math.inf),
    Parameter("useDepth16UC1Format", False, "depths as 16 bits [mm] instead of floats [m]"),
)
DEPTH_ENDPOINTS = (
    Endpoint("publishes", "<cameraName>/<depthImageTopicName>", "sensor_msgs/Image"),
    Endpoint("publishes", "<cameraName>/<depthImageCameraInfoTopicName>", "sensor_msgs/CameraInfo"),
    Endpoint("publishes", "<cameraName>/<pointCloudTopicName>", "sensor_msgs/PointCloud2"),
)

# Formats of Gazebo -> encoding of ROS, bytes of a pixel.
ENCODINGS = {
    "L8": ("mono8", 1),
    "L_INT8": ("mono8", 1),
    "L16": ("mono16", 2),
    "L_INT16": ("mono16", 2),
    "L_UINT16": ("mono16", 2),
    "R8G8B8": ("rgb8", 3),
    "RGB_INT8": ("rgb8", 3),
    "B8G8R8": ("bgr8", 3),
    "BGR_INT8": ("bgr8", 3),
    "R16G16B16": ("rgb16", 6),
    "RGB_INT16": ("rgb16", 6),
    "BAYER_RGGB8": ("bayer_rggb8", 1),
    "BAYER_BGGR8": ("bayer_bggr8", 1),
    "BAYER_GBRG8": ("bayer_gbrg8", 1),
    "BAYER_GRBG8": ("bayer_grbg8", 1),
}
# Encodings -> modes of Pillow, of the image and of its bytes; what the JPEG has.
JPEGS = {"rgb8": ("RGB", "RGB", "bgr8"), "bgr8": ("RGB", "BGR", "bgr8"), "mono8": ("L", "L", "mono8")}
KNOBS = (Knob("imager_rate", 2.0, 1.0, 50.0, "Rate of the camera [Hz]", 3),)
JPEG_QUALITY = 80  # as that of image_transport
POINT_STEP = 32  # bytes: x, y, z and a pad, the colour and a pad


class RosCamera(RosSensor):
    """Publishes the images of one camera of its sensor, with their calibration.

    Attributes:
        wanted: how many images triggers ask for; None: all.
    """

    STATE = ("wanted",)
    wanted: int | None = None

    def open_camera(self, camera: Any, suffix: str = "", baseline: float | None = None) -> None:
        """Advertise images and calibration.

        Args:
            camera: the camera.
            suffix: of its name.
            baseline: instead of that of the parameter [m].
        """
        given, self.camera = self.given, camera
        space = given.cameraName or (self.sensor.Name() if self.two else "")
        self.camera_space = f"{space}{suffix}"
        self.frame_name = self.frame_of(given.frameName) if self.two else self.frame(given.frameName)
        self.baseline = given.hackBaseline if baseline is None else baseline
        self.rectification = _matrix(given.rectificationMatrix) if self.two else IDENTITY
        self.images = self.advertise(given.imageTopicName, "sensor_msgs/Image", 2, self.camera_space)
        topic = f"{given.imageTopicName}/compressed"
        self.compressed = self.advertise(topic, "sensor_msgs/CompressedImage", 2, self.camera_space)
        self.infos = self.advertise(given.cameraInfoTopicName, "sensor_msgs/CameraInfo", 2, self.camera_space)
        if given.cameraName and not self.two:
            self.knobs = self.offer(KNOBS, self.OnReconfigure, self.camera_space)

    def OnReconfigure(self, values: Mapping[str, Any]) -> None:
        """A tool has set the rate; until then it is that of the sensor, whatever the parameter says, as in Gazebo."""
        self.sensor.SetUpdateRate(values["imager_rate"])

    def open_trigger(self, topic: str) -> None:
        """Publish one image for each message of a topic only."""
        self.wanted = 0
        self.triggers = self.subscribe(topic, "std_msgs/Empty", self.OnTrigger, 1, self.camera_space)

    def OnTrigger(self, _message: Any) -> None:
        """One more image is wanted."""
        if self.wanted is not None:
            self.wanted += 1
            self.match_activity()

    def match_activity(self) -> None:
        """Let the sensor measure if somebody listens, or while triggers want an image."""
        if self.wanted is None:
            super().match_activity()
        else:
            self.sensor.SetActive(self.wanted > 0)

    def info(self) -> Message:
        """The calibration."""
        given, camera = self.given, self.camera
        width, height = camera.ImageWidth(), camera.ImageHeight()
        focal = given.focalLength or width / (2.0 * math.tan(float(camera.HFOV()) / 2.0))
        cx, cy = given.Cx or (width + 1.0) / 2.0, given.Cy or (height + 1.0) / 2.0
        found: Any = message_type("sensor_msgs/CameraInfo")(width=width, height=height, distortion_model="plumb_bob")
        found.D = self._distortion()
        found.K = [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0]
        found.R = list(self.rectification)
        found.P = [focal, 0.0, cx, -focal * self.baseline, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0]
        for name, place in PROJECTION.items():
            value = getattr(given, name) if self.two else math.nan
            found.P[place] = found.P[place] if math.isnan(value) else value
        self.stamp(found)
        found.header.frame_id = self.frame_name
        return found  # type: ignore[no-any-return]

    def _distortion(self) -> list[float]:
        """k1, k2, t1, t2, k3."""
        given, lens = self.given, self.camera.LensDistortion() if self.given.autoDistortion else None
        if lens is not None:
            return [lens.K1(), lens.K2(), lens.P1(), lens.P2(), lens.K3()]
        return [given.distortionK1, given.distortionK2, given.distortionT1, given.distortionT2, given.distortionK3]

    def image(self) -> Message:
        """The image."""
        camera = self.camera
        encoding, size = ENCODINGS.get(camera.ImageFormat(), ("rgb8", 3))
        width, height = camera.ImageWidth(), camera.ImageHeight()
        data = camera.pixels.reshape(-1) if encoding == "rgb8" else camera.ImageData()
        found: Any = message_type("sensor_msgs/Image")(
            width=width, height=height, encoding=encoding, step=size * width, data=data
        )
        self.stamp(found)
        found.header.frame_id = self.frame_name
        return found  # type: ignore[no-any-return]

    def send(self) -> None:
        """Publish image and calibration."""
        if self.wanted == 0:
            return
        if self.images.listened:
            self.images.publish(self.image())
        if self.compressed.listened:
            self.send_compressed()
        if self.infos.listened:
            self.infos.publish(self.info())
        self.count_image()

    def count_image(self) -> None:
        """A trigger has got its image."""
        if self.wanted is not None:
            self.wanted -= 1
            self.match_activity()

    def send_compressed(self) -> None:
        """Publish the image as a JPEG; formats that JPEG does not have are left out."""
        camera = self.camera
        encoding, _ = ENCODINGS.get(camera.ImageFormat(), ("rgb8", 3))
        if encoding not in JPEGS:
            return
        mode, raw, inner = JPEGS[encoding]
        size = camera.ImageWidth(), camera.ImageHeight()
        file = io.BytesIO()
        Image.frombytes(mode, size, bytes(camera.ImageData()), "raw", raw).save(file, "JPEG", quality=JPEG_QUALITY)
        message: Any = message_type("sensor_msgs/CompressedImage")(
            format=f"{encoding}; jpeg compressed {inner}", data=file.getvalue()
        )
        self.stamp(message)
        message.header.frame_id = self.frame_name
        self.compressed.publish(message)


def _matrix(text: str) -> tuple[float, ...]:
    """Nine numbers; the identity where they are none."""
    try:
        numbers = tuple(map(float, text.split()))
    except ValueError:
        numbers = ()
    if len(numbers) == len(IDENTITY):
        return numbers
    if text:
        log.warning("<rectification_matrix> is %.200r; it must be nine numbers: the identity is taken", text)
    return IDENTITY


class _Part(RosCamera):
    """One camera of several."""

    parameters = CAMERA


def open_each(owner: RosSensor, sensor: Any, sdf: Element) -> list[RosCamera]:
    """Open each camera of a sensor with several.

    In ROS 1, names with `left` and `right` are `/left` and `/right` of the namespace, others have numbers, and the
    right one has the baseline of `<hackBaseline>`. In ROS 2, names are the cameras', and each has that baseline.

    Args:
        owner: the plugin; what the cameras publish is its own, too.
        sensor: the sensor.
        sdf: the plugin's element.
    """
    found: list[RosCamera] = []
    for index in range(sensor.CameraCount()):
        camera = sensor.Camera(index)
        name = str(camera.Name()).rpartition("::")[2]
        side = "left" if "left" in name else "right" if "right" in name else ""
        part = _Part()
        part.open(sdf, model_of(sensor))
        part.open_sensor(sensor, sdf)
        part.match_activity = owner.match_activity  # type: ignore[method-assign]
        if part.two:
            part.open_camera(camera, f"/{name}")
        else:
            part.open_camera(camera, f"/{side or index}", None if side == "right" else 0.0)
        owner.publications += part.publications
        found.append(part)
    return found


class DepthCloud(RosCamera):
    """Publishes depths and points beside images.

    Attributes:
        flat: whether the points are one row, instead of those of the image.
    """

    flat = False

    depths: Publication
    depth_infos: Publication
    points: Publication

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise images, depths and points of a depth camera."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        self.open_camera(sensor.Camera())
        self.open_depths()
        self.begin()

    @property
    def farthest(self) -> float:
        """Depths from here on are not seen [m]."""
        return float(self.given.pointCloudCutoffMax)

    def depth_data(self) -> NDArray[np.float32]:
        """Depths [m], a row for each of the image."""
        camera = self.camera
        return np.asarray(self.sensor.DepthData(), np.float32).reshape(camera.ImageHeight(), camera.ImageWidth())

    def open_depths(self) -> None:
        """Advertise depths and points."""
        given, space = self.given, self.camera_space
        self.depths = self.advertise(given.depthImageTopicName, "sensor_msgs/Image", 2, space)
        self.depth_infos = self.advertise(given.depthImageCameraInfoTopicName, "sensor_msgs/CameraInfo", 1, space)
        self.points = self.advertise(given.pointCloudTopicName, "sensor_msgs/PointCloud2", 1, space)

    def send(self) -> None:
        """Publish all that has subscribers."""
        if self.wanted == 0:
            return
        super().send()
        if self.depth_infos.listened:
            self.depth_infos.publish(self.info())
        if not (self.depths.listened or self.points.listened):
            return
        depths = self.depth_data()
        seen = (depths > self.given.pointCloudCutoff) & (depths < self.farthest)
        if self.depths.listened:
            self.depths.publish(self._depth_image(depths, seen))
        if self.points.listened:
            self.points.publish(self._cloud(depths, seen))

    def _unseen(self, depths: NDArray[np.float32]) -> Any:
        """What stands for depths that are not seen: NaN; in ROS 2 an infinity, negative where they are too near."""
        if not self.two:
            return np.float32(math.nan)
        return np.where(depths <= self.given.pointCloudCutoff, np.float32(-math.inf), np.float32(math.inf))

    def _depth_image(self, depths: NDArray[np.float32], seen: NDArray[np.bool_]) -> Message:
        height, width = depths.shape
        if self.given.useDepth16UC1Format:
            encoding, values = "16UC1", np.where(seen, depths * 1000.0, 0.0).astype("<u2")
        else:
            encoding, values = "32FC1", np.where(seen, depths, self._unseen(depths)).astype("<f4")
        found: Any = message_type("sensor_msgs/Image")(
            width=width, height=height, encoding=encoding, step=values.itemsize * width, data=values.tobytes()
        )
        self.stamp(found)
        found.header.frame_id = self.frame_name
        return found  # type: ignore[no-any-return]

    def _cloud(self, depths: NDArray[np.float32], seen: NDArray[np.bool_]) -> Message:
        """The points in the frame of an optical camera: x to the right, y down, z ahead; `_unseen` for each of them."""
        height, width = depths.shape
        focal = width / (2.0 * math.tan(float(self.camera.HFOV()) / 2.0))
        across = (np.arange(width) - 0.5 * (width - 1)) / focal
        down = (np.arange(height) - 0.5 * (height - 1)) / focal
        z = np.where(seen, depths, np.float32(0.0))
        data = np.zeros((height, width, POINT_STEP // 4), "<f4")
        data[..., 0], data[..., 1], data[..., 2] = z * across, z * down[:, None], z
        data[..., :3] = np.where(seen[..., None], data[..., :3], np.expand_dims(self._unseen(depths), -1))
        colours = data.view(np.uint8).reshape(height, width, POINT_STEP)[..., 16:19]
        _, size = ENCODINGS.get(self.camera.ImageFormat(), ("", 0))
        image = np.frombuffer(self.camera.ImageData(), np.uint8)
        if size in (1, 3) and len(image) == height * width * size:
            colours[...] = image.reshape(height, width, size)
        field = message_type("sensor_msgs/PointField")
        found: Any = message_type("sensor_msgs/PointCloud2")(width=width, height=height, data=data.tobytes())
        offsets = {"x": 0, "y": 4, "z": 8, "rgb": 16}
        found.fields = [field(name=name, offset=at, datatype=7, count=1) for name, at in offsets.items()]
        if self.flat:
            found.width, found.height = width * height, 1
        found.point_step, found.row_step, found.is_dense = POINT_STEP, POINT_STEP * found.width, bool(seen.all())
        self.stamp(found)
        found.header.frame_id = self.frame_name
        return found  # type: ignore[no-any-return]
