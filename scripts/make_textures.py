"""Generates the textures of the ready worlds from formulas: the same bytes each time.

python scripts/make_textures.py
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

WORLDS = Path(__file__).parent.parent / "worlds"
SIZE = 128  # [px]

Pixels = NDArray[np.float64]


def noise(random: np.random.Generator, octaves: tuple[tuple[int, int], ...]) -> Pixels:
    """Smooth noise from 0 to 1 that repeats at the edges: a sum of waves with whole numbers of periods."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] * (2.0 * np.pi / SIZE)
    result = np.zeros((SIZE, SIZE))
    for highest, count in octaves:
        for _ in range(count):
            kx, ky = random.integers(-highest, highest + 1, 2)
            result += np.cos(kx * x + ky * y + random.uniform(0.0, 2.0 * np.pi)) / (1.0 + np.hypot(kx, ky)) ** 0.7
    low, high = result.min(), result.max()
    return (result - low) / (high - low)


def blend(share: Pixels, dark: tuple[int, ...], light: tuple[int, ...]) -> Pixels:
    """Colours between two, shape (SIZE, SIZE, 3)."""
    return np.array(dark) + share[..., None] * (np.array(light) - np.array(dark))


def grass(random: np.random.Generator) -> Pixels:
    """Short grass."""
    return blend(
        0.5 * noise(random, ((4, 12), (20, 80))) + 0.5 * random.random((SIZE, SIZE)), (38, 84, 30), (126, 164, 78)
    )


def wood(random: np.random.Generator) -> Pixels:
    """Boards with grain along their length."""
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    board = y // (SIZE // 4)
    bend = noise(random, ((2, 6),)) * 6.0 + board * 3.7
    grain = 0.5 + 0.5 * np.sin((y % (SIZE // 4)) * 0.9 + bend + 0.6 * np.sin(x * 2.0 * np.pi / SIZE + board))
    result = blend(0.75 * grain + 0.25 * noise(random, ((30, 60),)), (112, 70, 34), (196, 142, 84))
    result[y % (SIZE // 4) == 0] *= 0.45
    return result


def tiles(random: np.random.Generator) -> Pixels:
    """Two by two floor tiles with joints."""
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    checks = ((x // (SIZE // 2)) + (y // (SIZE // 2))) % 2
    result = blend(checks * 0.8 + 0.2 * noise(random, ((10, 40),)), (128, 132, 138), (206, 204, 198))
    result[(x % (SIZE // 2) < 2) | (y % (SIZE // 2) < 2)] = (90, 90, 92)
    return result


def grid(random: np.random.Generator) -> Pixels:
    """A black grid on white, finer lines in between, and spots that distinguish the fields."""
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    result = np.full((SIZE, SIZE, 3), 235.0)
    result[(x % 16 < 1) | (y % 16 < 1)] = 150.0
    result[(x % 64 < 3) | (y % 64 < 3)] = 25.0
    for _ in range(24):
        column, row = random.integers(8, SIZE - 8, 2)
        result[np.hypot(x - column, y - row) < random.uniform(2.0, 5.0)] = random.uniform(30.0, 220.0, 3)
    return result


def sky(random: np.random.Generator) -> Pixels:
    """A tone map: midnight to midnight from left to right, zenith on top, horizon below."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] / (SIZE - 1.0)
    height = -np.cos(x * 2.0 * np.pi)  # of the sun, -1 to 1
    day = np.clip(height * 2.0 + 0.5, 0.0, 1.0)[..., None]
    dusk = np.exp(-((height / 0.25) ** 2))[..., None] * (y**2)[..., None]
    night = blend(y, (6, 8, 24), (22, 26, 48))
    noon = blend(y, (58, 110, 196), (178, 208, 236))
    return (night * (1.0 - day) + noon * day) * (1.0 - 0.7 * dusk) + 0.7 * dusk * np.array((246, 146, 78))


def bricks(random: np.random.Generator) -> Pixels:
    """Courses of bricks, each shifted by half a brick, with light joints."""
    y, x = np.mgrid[0:SIZE, 0:SIZE]
    height, width = SIZE // 8, SIZE // 4
    course = y // height
    along = (x + (course % 2) * width // 2) % SIZE
    tone = random.random((8, 4))[course, along // width]
    result = blend(0.6 * tone + 0.4 * noise(random, ((20, 60),)), (126, 52, 38), (178, 92, 66))
    result[(y % height < 2) | (along % width < 2)] = (188, 182, 172)
    return result


def main() -> None:
    """Write all of them."""
    kinds: tuple[Callable[[np.random.Generator], Pixels], ...] = (grass, wood, tiles, grid, sky, bricks)
    for seed, kind in enumerate(kinds):
        pixels = np.clip(kind(np.random.default_rng(seed)), 0.0, 255.0).astype(np.uint8)
        Image.fromarray(pixels).save(WORLDS / f"{kind.__name__}.png", optimize=True)


if __name__ == "__main__":
    main()
