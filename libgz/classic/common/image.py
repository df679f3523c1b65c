"""Image: an image file, or the data of a camera."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError
from libgz.classic.common.system_paths import SystemPaths
from libgz.classic.math.color import Color
from libgz.classic.names import takes_names
from libgz.physics.image_files import open_image

__all__ = ["Image"]

# In the order of their numbers, as in Gazebo.
FORMATS = (
    "UNKNOWN_PIXEL_FORMAT",
    "L_INT8",
    "L_INT16",
    "RGB_INT8",
    "RGBA_INT8",
    "BGRA_INT8",
    "RGB_INT16",
    "RGB_INT32",
    "BGR_INT8",
    "BGR_INT16",
    "BGR_INT32",
    "R_FLOAT16",
    "RGB_FLOAT16",
    "R_FLOAT32",
    "RGB_FLOAT32",
    "BAYER_RGGB8",
    "BAYER_RGGR8",
    "BAYER_GBRG8",
    "BAYER_GRBG8",
)
# What `<image><format>` calls them besides.
CAMERA_FORMATS = {
    "L8": 1,
    "L16": 2,
    "L_UINT16": 2,
    "R8G8B8": 3,
    "R8G8B8A8": 4,
    "R16G16B16": 6,
    "RGB_UINT16": 6,
    "B8G8R8": 8,
    "FLOAT32": 13,
    "BAYER_BGGR8": 16,
}
CHANNELS = {1: 1, 3: 3, 4: 4, 5: 4, 8: 3}  # of formats of one byte a channel that SetFromData takes


@takes_names
class Image:
    """An image: `Image("file.png")`, or `Image()` and Load or SetFromData."""

    UNKNOWN_PIXEL_FORMAT, L_INT8, L_INT16, RGB_INT8, RGBA_INT8, BGRA_INT8, RGB_INT16, RGB_INT32, BGR_INT8 = range(9)

    def __init__(self, filename: str = "") -> None:
        self._pixels: NDArray[np.uint8] = np.zeros((0, 0, 3), dtype=np.uint8)
        self._filename = ""
        if filename and self.Load(filename) != 0:
            raise GazeboError(f"image {filename!r} cannot be read; the log says why")

    def Load(self, filename: str) -> int:
        """Read a file, by path or URI: 0, or -1 if that fails, which is logged."""
        from libgz.classic.common.console import gzerr

        path = SystemPaths.Instance().FindFile(filename)
        if not path:
            return -1
        try:
            with open_image(Path(path)) as file:
                mode = "L" if file.mode in ("L", "1", "I", "I;16", "F") else "RGBA" if "A" in file.mode else "RGB"
                pixels = np.array(file.convert(mode), dtype=np.uint8)
        except GazeboError as error:
            gzerr(error)
            return -1
        self._pixels, self._filename = np.atleast_3d(pixels), path
        return 0

    def SavePNG(self, filename: str) -> None:
        """Write it to a PNG file.

        Raises:
            GazeboError: the file cannot be written, or there is no image.
        """
        from PIL import Image as Pillow

        if not self.Valid():
            raise GazeboError("an image without data cannot be written")
        try:
            Pillow.fromarray(self._pixels.squeeze()).save(filename, format="PNG")
        except OSError as error:
            raise GazeboError(f"image {filename} cannot be written: {error.strerror}") from None

    def SetFromData(self, data: bytes, width: int, height: int, format: int) -> None:
        """Take the data of a camera, top row first.

        Args:
            data: as ImageData() returns it.
            width, height: [px].
            format: L_INT8, RGB_INT8, RGBA_INT8, BGRA_INT8 or BGR_INT8.

        Raises:
            ParameterError: the format is another one, or the data has another size.
        """
        channels = CHANNELS.get(format)
        if channels is None:
            known = ", ".join(FORMATS[number] for number in CHANNELS)
            raise ParameterError(f"SetFromData does not take pixel format {format!r}; it takes {known}")
        if len(data) != width * height * channels:
            raise ParameterError(f"the data of the image has {len(data)} bytes, expected {width * height * channels}")
        pixels = np.frombuffer(bytes(data), dtype=np.uint8).reshape(height, width, channels)
        if format in (self.BGRA_INT8, self.BGR_INT8):
            pixels = pixels[:, :, [2, 1, 0, 3][:channels]]
        self._pixels, self._filename = pixels.copy(), ""

    def GetData(self) -> bytes:
        """Its bytes, top row first."""
        return self._pixels.tobytes()

    def GetRGBData(self) -> bytes:
        """Red, green and blue of each pixel, top row first."""
        return self._rgb().tobytes()

    def _rgb(self) -> NDArray[np.uint8]:
        return np.repeat(self._pixels, 3, axis=2) if self._pixels.shape[2] == 1 else self._pixels[:, :, :3]

    def GetWidth(self) -> int:
        """The width [px]."""
        return int(self._pixels.shape[1])

    def GetHeight(self) -> int:
        """The height [px]."""
        return int(self._pixels.shape[0])

    def GetBPP(self) -> int:
        """Bits of a pixel."""
        return int(8 * self._pixels.shape[2])

    def GetPitch(self) -> int:
        """Bytes of a row."""
        return int(self._pixels.shape[1] * self._pixels.shape[2])

    def GetFilename(self) -> str:
        """The path of the file; an empty string for none."""
        return self._filename

    def GetPixelFormat(self) -> int:
        """L_INT8, RGB_INT8 or RGBA_INT8."""
        if not self.Valid():
            return self.UNKNOWN_PIXEL_FORMAT
        return {1: self.L_INT8, 3: self.RGB_INT8, 4: self.RGBA_INT8}[self._pixels.shape[2]]

    @staticmethod
    def ConvertPixelFormat(format: str) -> int:
        """The number of a pixel format by its name, or a camera's; UNKNOWN_PIXEL_FORMAT for another one."""
        return FORMATS.index(format) if format in FORMATS else CAMERA_FORMATS.get(format, 0)

    def Valid(self) -> bool:
        """Whether there is an image."""
        return self._pixels.size > 0

    def GetPixel(self, x: int, y: int) -> Color:
        """The colour of a pixel; x counts from the left, y from the bottom, as in Gazebo.

        Raises:
            ParameterError: there is no such pixel.
        """
        height, width, _ = self._pixels.shape
        if not (0 <= x < width and 0 <= y < height):
            raise ParameterError(f"the image has no pixel ({x}, {y}); it is {width} x {height}")
        return Color(*(float(value) / 255.0 for value in self._rgb()[height - 1 - y, x]))

    Pixel = GetPixel

    def AvgColor(self) -> Color:
        """The mean of all pixels; black without an image."""
        if not self.Valid():
            return Color()
        return Color(*(self._rgb().reshape(-1, 3).mean(axis=0) / 255.0).tolist())

    def MaxColor(self) -> Color:
        """The pixel with the largest sum of red, green and blue; black without an image."""
        if not self.Valid():
            return Color()
        pixels = self._rgb().reshape(-1, 3)
        return Color(*(pixels[pixels.sum(axis=1, dtype=np.int64).argmax()] / 255.0).tolist())

    def Rescale(self, width: int, height: int) -> None:
        """Change its size [px].

        Raises:
            ParameterError: one is below 1, or there is no image.
        """
        from PIL import Image as Pillow

        if not self.Valid() or width < 1 or height < 1:
            raise ParameterError(
                f"an image of {self.GetWidth()} x {self.GetHeight()} px cannot become {width} x {height}"
            )
        scaled = Pillow.fromarray(self._pixels.squeeze()).resize((int(width), int(height)), Pillow.Resampling.BILINEAR)
        self._pixels = np.array(scaled, dtype=np.uint8).reshape(int(height), int(width), -1)

    def __repr__(self) -> str:
        return f"<Image {self._filename!r} {self.GetWidth()} x {self.GetHeight()} px, {self.GetBPP()} bits>"

    GetAvgColor, GetMaxColor = AvgColor, MaxColor
