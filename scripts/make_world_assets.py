"""Writes the terrains, the road and the floor plan of the ready worlds.

.venv/bin/python scripts/make_world_assets.py

They have the names that existing worlds use, so that those find them if their own files are missing.
"""

import math
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from libgz.models.gzb import write_gzb
from libgz.physics.meshes import grid_strip, grid_triangles, vertex_normals

WORLDS = Path(__file__).resolve().parent.parent / "worlds"
SIZE = 64.0  # [m]
HILLS = ((14.0, 46.0, 6.0, 9.0), (50.0, 50.0, 9.0, 12.0), (48.0, 16.0, 4.0, 8.0), (26.0, 26.0, 1.5, 5.0))


def hills(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Height [m] of smooth hills on a meadow: sums of (centre x, y, height, radius), and a rim around them."""
    rim = np.clip((np.maximum(np.abs(x - SIZE / 2), np.abs(y - SIZE / 2)) - 24.0) / 8.0, 0.0, 1.0)
    bumps = sum(h * np.exp(-((x - cx) ** 2 + (y - cy) ** 2) / (2 * (r / 2) ** 2)) for cx, cy, h, r in HILLS)
    return bumps + 5.0 * rim**2


def make_terrain() -> None:
    """64 x 64 m with a vertex every 2 m; a texture covers 8 m."""
    count, spacing = 33, 2.0
    y, x = (spacing * axis for axis in np.mgrid[:count, :count])
    packed = np.zeros((count * count, 12))
    packed[:, 9:] = np.stack([x, y, hills(x, y)], axis=-1).reshape(-1, 3)
    packed[:, 0:2] = packed[:, 9:11] / 8.0
    packed[:, 2:6] = 1.0
    triangles = grid_triangles(count, count)
    packed[:, 6:9] = vertex_normals(packed[:, 9:], triangles)
    write_gzb(WORLDS / "terrain.gzb", packed, grid_strip(count, count), triangles)


def make_height_map() -> None:
    """The same hills as an image of 65 x 65 pixels; white is 10 m high."""
    y, x = np.mgrid[64:-1:-1, :65].astype(float)
    grey = np.clip(np.rint(hills(x, y) / 10.0 * 255.0), 0, 255)
    Image.fromarray(grey.astype(np.uint8)).save(WORLDS / "terrain.png", optimize=True)


def make_road() -> None:
    """400 m of road in an S with a dip and a crest, a point every 2 m and a sign every 50 m."""
    profile = [0.0, 0.0, 0.0, -0.15, -0.10, -0.03, 0.02, 0.05, 0.02, -0.03, -0.10, -0.15, 0.0, 0.0, 0.0]
    east, north, lines = 500000.0, 4000000.0, []
    for i in range(201):
        s = 2.0 * i
        z = 0.3 + 0.8 * (1.0 - math.cos(2.0 * math.pi * s / 200.0))
        if i % 25 == 0:
            lines.append(f"waypoint {s:.1f} {i // 25} {east:.3f} {north:.3f} {z + 2.0:.3f}")
        heights = " ".join(f"{p:.2f}" for p in profile)
        lines.append(f"track {s:.1f} {i // 25} {east:.3f} {north:.3f} {z:.3f} {len(profile)} {heights}")
        heading = 0.9 * math.sin(2.0 * math.pi * s / 400.0)
        east, north = east + 2.0 * math.cos(heading), north + 2.0 * math.sin(heading)
    (WORLDS / "road.txt").write_text("\n".join(lines) + "\n")


def make_floor_plan() -> None:
    """A hall and rooms, 400 x 400 pixels: black walls on white."""
    image = Image.new("L", (400, 400), 255)
    draw = ImageDraw.Draw(image)
    walls = [(8, 8, 391, 13), (8, 386, 391, 391), (8, 8, 13, 391), (386, 8, 391, 391)]
    for low, high in ((13, 90), (130, 270), (310, 386)):  # doors lie between
        walls += [(low, 128, high, 133), (low, 268, high, 273), (128, low, 133, high), (268, low, 273, high)]
    for wall in walls:
        draw.rectangle(wall, fill=0)
    draw.rectangle((128, 160, 133, 240), fill=255)
    draw.rectangle((268, 160, 273, 240), fill=255)
    draw.rectangle((160, 128, 240, 133), fill=255)
    draw.rectangle((160, 268, 240, 273), fill=255)
    draw.ellipse((310, 310, 340, 340), fill=60)
    draw.rectangle((50, 300, 80, 350), fill=120)
    draw.polygon(((50, 90), (90, 50), (90, 90)), fill=0)
    image.save(WORLDS / "example2.png", optimize=True)


if __name__ == "__main__":
    make_terrain()
    make_height_map()
    make_road()
    make_floor_plan()
