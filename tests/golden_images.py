"""Golden images: images that rendering must repeat, compared with a tolerance."""

import os
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).parent


def assert_golden(actual, name, context, mean=0.5, limit=16):
    """An image is the golden one of a name, but for small differences; LIBGZ_NEW_GOLDENS writes that first.

    Of a failure, both and their difference are in build/golden.

    Args:
        actual: shape (height, width, 3).
        name: of the file in tests/rendering/golden.
        context: how it was rendered.
        mean: largest mean difference of pixels, 0 to 255.
        limit: difference that at most one pixel of a hundred exceeds, 0 to 255.
    """
    path = ROOT / "rendering" / "golden" / f"{name}.png"
    if os.environ.get("LIBGZ_NEW_GOLDENS"):
        Image.fromarray(actual).save(path, optimize=True)
    with Image.open(path) as golden:
        expected = np.asarray(golden.convert("RGB"))
    difference = np.abs(actual.astype(int) - expected).max(axis=2)
    if difference.mean() > mean or (difference > limit).mean() > 0.01:
        folder = ROOT.parent / "build" / "golden"
        folder.mkdir(parents=True, exist_ok=True)
        amplified = np.minimum(4 * difference, 255).astype(np.uint8)
        for kind, pixels in (("expected", expected), ("actual", actual), ("difference", amplified)):
            Image.fromarray(pixels).save(folder / f"{name}-{context}-{kind}.png")
        raise AssertionError(f"mean difference {difference.mean():.2f}; see {folder}/{name}-{context}-*.png")
