"""Worlds with ground from files, for tests: what lies below a point, a ball to roll."""

import numpy as np

import libgz

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"


def world_of(folder, body, settings=""):
    path = folder / "test.world"
    path.write_text(f"{HEAD}<param:Global>{settings}</param:Global>{body}</gz:world>")
    return libgz.World.from_file(path)


def heights_below(world, points, top=50.0):
    """Height of the first thing under each (x, y) [m]; NaN where there is nothing."""
    points = np.asarray(points, dtype=float)
    rays = np.zeros((len(points), 7))
    rays[:, :2], rays[:, 2], rays[:, 5], rays[:, 6] = points, top, -1.0, 2 * top
    ranges, rows = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    world.engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), rays, 0, ranges, rows)
    return np.where(rows >= 0, top - ranges, np.nan)


def ball(x, y, z, radius=0.2):
    return (
        f"<model:SimpleSolid><id>ball</id><xyz>{x} {y} {z}</xyz><shape>sphere</shape><size>{2 * radius}</size>"
        "<surfaceHardness>1e5 100</surfaceHardness></model:SimpleSolid>"
    )
