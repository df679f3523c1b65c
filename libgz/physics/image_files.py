"""Image files, opened safely: textures, height maps and floor plans."""

from __future__ import annotations

import contextlib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from libgz.base.errors import GazeboError
from libgz.base.files import open_file

if TYPE_CHECKING:
    from PIL import Image

__all__ = ["open_image", "quiet"]

MOST_PIXELS = 8192 * 8192
# Formats of pillow that are plain image files: no others, such as EPS, which runs another program. They are tried in
# this order; beyond the first five, pillow imports the readers of all its formats.
FORMATS: tuple[str, ...] = ("PNG", "JPEG", "BMP", "GIF", "PPM")
FORMATS += ("DDS", "ICO", "JPEG2000", "PCX", "SGI", "TGA", "TIFF", "WEBP", "XPM")


class _TooLarge(GazeboError):
    pass


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Without pillow's warnings, of which a damaged TIFF file causes one for each tag, as long as its names.

    Filters of warnings are those of all threads: another one may lose pillow's warnings too, and no others.
    """
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module=r"PIL\.")
        yield


@contextlib.contextmanager
def open_image(path: Path, most_pixels: int = MOST_PIXELS) -> Iterator[Image.Image]:
    """An image file, whole and in memory, for a `with` block.

    Args:
        path: of the file.
        most_pixels: how many pixels it may have.

    Raises:
        GazeboError: it cannot be read, is damaged, or has too many pixels. What the block raises is reported so, too.
    """
    from PIL import Image, UnidentifiedImageError  # here, because most worlds read no image

    try:
        with open_file(path) as file:
            with quiet():
                image = Image.open(file, formats=FORMATS)
                if image.width * image.height > most_pixels:
                    wide, high = image.size
                    raise _TooLarge(f"image {path} has {wide} x {high} pixels; {most_pixels} are allowed")
                image.load()
            with image:
                yield image
    except GazeboError:
        raise
    except MemoryError:
        raise GazeboError(f"image {path} cannot be read: there is not enough memory for it") from None
    except Exception as error:  # noqa: BLE001 - pillow's readers raise whatever their formats suggest
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        reason = "it is no image, or damaged" if isinstance(error, UnidentifiedImageError) else reason
        raise GazeboError(f"image {path} cannot be read: {reason}") from None
