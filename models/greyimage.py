"""Images read as grey values: height maps and floor plans."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError
from libgz.physics.image_files import open_image

__all__ = ["read_grey"]

MOST_PIXELS = 2048 * 2048


def read_grey(path: Path) -> NDArray[np.float64]:
    """Grey values of an image, 0 black to 255 white, shape (rows, columns), top row first.

    Colours are converted to luma (ITU-R 601), transparent pixels are white; 16-bit images keep their resolution.

    Raises:
        ParameterError: the file is not a readable image, or has more than 2048 x 2048 pixels.
    """
    from PIL import Image  # here, because most worlds read no image

    try:
        with open_image(path, MOST_PIXELS) as image:
            if image.mode.startswith("I"):
                return np.asarray(image, dtype=np.float64) / 257.0
            if image.has_transparency_data:
                on_white = Image.new("RGBA", image.size, "white")
                return np.asarray(Image.alpha_composite(on_white, image.convert("RGBA")).convert("L"), dtype=np.float64)
            return np.asarray(image.convert("L"), dtype=np.float64)
    except GazeboError as error:
        raise ParameterError(str(error)) from None
