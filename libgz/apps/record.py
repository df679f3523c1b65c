"""Recorders: write the images of a camera, or of the whole world, to a video file. They need the extra [video]."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, LibraryError, NotFoundError, ParameterError, nearest
from libgz.base.extras import install
from libgz.front import World
from libgz.simulation.rate import TIME_SLACK

if TYPE_CHECKING:
    from libgz.classic.sensors import CameraSensor

__all__ = ["Recorder", "SensorRecorder", "VideoRecorder", "ViewRecorder", "new_recorder", "record_videos"]

KINDS = {"camera": "image", "guicam": "image", "stereo": "left_image"}  # interface type -> field of the image
VIEW, VIEW_RATE, VIEW_SIZE = "view", 25.0, (640, 480)  # name, images a second of sim time, and size [px]


class VideoRecorder(Protocol):
    """What writes a video while a world runs."""

    def take(self) -> None:
        """Write an image, if there is a new one."""

    def close(self) -> None:
        """Finish the file."""


def new_recorder(world: World, request: str, shadows: bool = True) -> VideoRecorder:
    """The recorder of a request, ``ID=FILE`` or ``view=FILE``; a camera that is called view is a camera.

    In a world of SDF the name of a camera sensor stands for its id: the full one, or the last part of it.

    Raises:
        ParameterError: the request has another format.
        NotFoundError: there is no such camera.
        LibraryError: rendering is disabled.
        GazeboError: the packages are missing, or the file cannot be written.
    """
    name, _, file = request.partition("=")
    if not (name and file):
        raise ParameterError(f"--record {request!r}: it must be ID=FILE, a camera's id and a video file")
    if any((kind, name) in world.gz_server.interfaces for kind in KINDS):
        return Recorder(world, name, Path(file), shadows=shadows)
    sensors = _sensors_of(world)
    if name in sensors:
        return SensorRecorder(sensors[name], Path(file))
    if name == VIEW:
        return ViewRecorder(world, Path(file), shadows)
    ids = [known for kind, known in world.gz_server.interfaces if kind in KINDS]
    ids += sorted({sensor.ScopedName() for sensor in sensors.values()})
    raise NotFoundError(
        f"no camera has the id {name!r}; there are {', '.join(ids) or 'none'}{nearest(name, ids)}; "
        "view=FILE records the whole world"
    )


def _sensors_of(world: World) -> dict[str, CameraSensor]:
    """The camera sensors of a world of SDF by their full names and, the first of each, by their short ones."""
    if world.sdf is None:
        return {}
    from libgz.recording.images import camera_sensors  # it loads classic, which legacy worlds do without

    found = camera_sensors(world)
    short = {sensor.Name(): sensor for sensor in reversed(found)}
    return {**short, **{sensor.ScopedName(): sensor for sensor in found}}


@contextlib.contextmanager
def record_videos(world: World, requests: Iterable[str], shadows: bool = True) -> Iterator[list[VideoRecorder]]:
    """The recorders of requests, closed at the end.

    Raises:
        GazeboError: as `new_recorder`.
    """
    with contextlib.ExitStack() as stack:
        recorders: list[VideoRecorder] = []
        for request in requests:
            recorders.append(new_recorder(world, request, shadows))
            stack.callback(recorders[-1].close)
        yield recorders


class ViewRecorder:
    """Renders the world from where a user's view begins, and writes a video: 25 images a second.

    Args:
        world: an initialized world.
        path: of the video.
        shadows: whether it has shadows, unless an SDF scene forbids them.

    Raises:
        LibraryError: rendering is disabled, or OpenGL does not work here.
        GazeboError: the packages are missing, or the file cannot be written.
    """

    def __init__(self, world: World, path: Path, shadows: bool = True) -> None:
        from libgz.rendering.framing import free_camera  # only who records loads OpenGL

        pose = world.start_pose(*VIEW_SIZE)
        self._world, self._video = world, _Video(path, VIEW_RATE)
        self._camera = free_camera(world, pose, VIEW_SIZE, shadows)
        if self._camera.blind:
            self.close()
            raise LibraryError("--record view=... needs rendering, which is disabled (--gl none or LIBGZ_GL)")
        self._due = -1.0

    def take(self) -> None:
        """Write an image, if it is time.

        Raises:
            GazeboError: the file cannot be written.
        """
        now = self._world.GetSimTime() + self._world.GetPauseTime()
        if now < self._due - TIME_SLACK and now > self._due - 2.0 / VIEW_RATE:  # else the world was reset
            return
        self._due = (now if self._due < 0.0 or now < self._due - TIME_SLACK else self._due) + 1.0 / VIEW_RATE
        self._video.write(self._camera.Update())

    def close(self) -> None:
        """Finish the file; a second call does nothing.

        Raises:
            GazeboError: the file cannot be written.
        """
        self._camera.close()
        self._video.close()


class Recorder:
    """Writes each new image of one camera to a video file; keeps none in memory.

    Args:
        world: an initialized world.
        name: the camera's id.
        path: of the video (.mp4, .mkv, ...).
        shadows: whether the video has shadows, unless the world's scene forbids them; clients get images without.

    Raises:
        GazeboError: the packages are missing, or the file cannot be written.
    """

    def __init__(self, world: World, name: str, path: Path, *, shadows: bool = True) -> None:
        from libgz.models.camera import eye_of  # only who records loads OpenGL

        interfaces = world.gz_server.interfaces
        kind = next(kind for kind in KINDS if (kind, name) in interfaces)
        self._interface, self._field = interfaces[kind, name], KINDS[kind]
        self._eye = eye_of(world.model(name)) if shadows else None
        self._rate = float(getattr(world.model(name), "values").updateRate)  # noqa: B009 - of the camera models
        self._last = -1.0
        self._video = _Video(path, self._rate)

    def take(self) -> None:
        """Write the camera's image, if it is new.

        Raises:
            GazeboError: the file cannot be written.
        """
        data: Any = self._interface.data
        now = data.sim_time + data.pause_time if self._interface.type == "guicam" else data.time
        image = getattr(self._interface, self._field)
        if now == self._last or not image.size:
            return
        self._last = now
        if self._eye is not None:
            image = self._eye.shaded()
        self._video.write(image)

    def close(self) -> None:
        """Finish the file; a second call does nothing.

        Raises:
            GazeboError: the file cannot be written.
        """
        self._video.close()


class SensorRecorder:
    """Writes each image that a camera sensor of an SDF world takes, at most 25 a second if it has no rate.

    Args:
        sensor: the sensor; it measures from now on, whether or not somebody reads it.
        path: of the video (.mp4, .mkv, ...).

    Raises:
        LibraryError: rendering is disabled, or OpenGL does not work here.
        GazeboError: the packages are missing, or the file cannot be written.
    """

    def __init__(self, sensor: CameraSensor, path: Path) -> None:
        if sensor.Camera().core.blind:
            name = sensor.ScopedName()
            raise LibraryError(f"--record {name}=... needs rendering, which is disabled (--gl none or LIBGZ_GL)")
        self._sensor, self._rate = sensor, sensor.UpdateRate() or VIEW_RATE
        self._video = _Video(path, self._rate)
        self._last = sensor.LastMeasurementTime().Double()
        sensor.SetActive(True)

    def take(self) -> None:
        """Write the sensor's image, if it is new.

        Raises:
            GazeboError: the file cannot be written.
        """
        now = self._sensor.LastMeasurementTime().Double()
        if self._last - TIME_SLACK <= now < self._last + 1.0 / self._rate - TIME_SLACK:  # else the world was reset
            return
        self._last = now
        self._video.write(self._sensor.Camera().pixels)

    def close(self) -> None:
        """Finish the file; a second call does nothing.

        Raises:
            GazeboError: the file cannot be written.
        """
        self._video.close()


class _Video:
    """A video file that is being written."""

    def __init__(self, path: Path, rate: float) -> None:
        self.path, self._rate = path, rate
        self._file: Any = _open(path)
        self._started = False

    def write(self, image: NDArray[np.uint8]) -> None:
        """Append an image.

        Raises:
            GazeboError: the file cannot be written.
        """
        try:
            if not self._started:
                self._file.init_video_stream("libx264", fps=max(self._rate, 1.0))
                self._started = True
            even = image[: image.shape[0] // 2 * 2, : image.shape[1] // 2 * 2]  # the encoder needs even sides
            self._file.write_frame(even)
        except (OSError, ValueError, EOFError) as error:  # av raises EOFError when a disk is full
            raise GazeboError(f"video {self.path} cannot be written: {error}") from None

    def close(self) -> None:
        """Finish the file; a second call does nothing.

        Raises:
            GazeboError: the file cannot be written.
        """
        file, self._file = self._file, None
        if file is not None:
            try:
                file.close()
            except (OSError, ValueError, EOFError) as error:
                raise GazeboError(f"video {self.path} cannot be written: {error}") from None


def _open(path: Path) -> Any:
    try:
        from imageio import v3
        from imageio.plugins import pyav  # noqa: F401 - raises ImportError here if av is missing
    except ImportError:
        raise GazeboError(f"--record needs the packages imageio and av: {install('video')}") from None
    try:
        return v3.imopen(path, "w", plugin="pyav")
    except (OSError, ValueError) as error:
        raise GazeboError(f"video {path} cannot be written: {error}") from None
