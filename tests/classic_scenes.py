"""Scenes of classic worlds for tests: visuals, materials, and pictures of them."""

import libgz
from libgz.classic import rendering
from libgz.classic.math import Pose3d
from libgz.classic.server import attach

AMBIENT = "<scene><ambient>1 1 1 1</ambient><background>.2 .4 .6 1</background></scene>"
BOX = "<box><size>1 1 1</size></box>"
FLAT = "<ambient>{0} 1</ambient><diffuse>{0} 1</diffuse>"
BEHIND = (51, 102, 153)


def keep_to(folder, monkeypatch):
    """Plugins, models and materials are looked for in this folder only."""
    monkeypatch.setenv("HOME", str(folder / "home"))
    monkeypatch.setenv("GAZEBO_PLUGIN_PATH", str(folder))
    monkeypatch.delenv("GAZEBO_MODEL_PATH", raising=False)
    monkeypatch.delenv("GAZEBO_RESOURCE_PATH", raising=False)


def worlds_in(folder):
    """Yields what makes a classic world of some elements, and closes all worlds in the end.

    Without a <scene> of its own, all light of a world comes from everywhere.
    """
    worlds = []

    def make(*inside, scene=AMBIENT):
        path = folder / f"w{len(worlds)}.world"
        path.write_text(f"<sdf version='1.6'><world name='default'>{scene}{''.join(inside)}</world></sdf>")
        worlds.append(libgz.World.from_file(path))
        return attach(worlds[-1]).world

    yield make
    for world in worlds:
        world.close()


def material(text):
    return f"<material>{text}</material>"


def script(name, uri=""):
    uris = "".join(f"<uri>{u}</uri>" for u in uri.split())
    return material(f"<script>{uris}<name>{name}</name></script>")


def visual(name="v", looks="", geometry=BOX, pose="0 0 0 0 0 0"):
    return f"<visual name='{name}'><pose>{pose}</pose><geometry>{geometry}</geometry>{looks}</visual>"


def model(name="m", inside=None, pose="3 0 0 0 0 0", static=True):
    inside = visual() if inside is None else inside
    return (
        f"<model name='{name}'><static>{str(static).lower()}</static><pose>{pose}</pose>"
        f"<link name='link'>{inside}</link></model>"
    )


def red(**options):
    return visual(looks=material(FLAT.format("1 0 0")), **options)


def see(world, pose=(0, 0, 0, 0, 0, 0), size=(64, 48), kind=rendering.Camera, **options):
    """One picture, shape (height, width, 3)."""
    with kind(world, "eye", *size, **options) as camera:
        camera.SetWorldPose(Pose3d(*pose))
        rendering.render_frame(world, [camera])
        return camera.pixels.copy()


def middle(pixels):
    return tuple(int(c) for c in pixels[pixels.shape[0] // 2, pixels.shape[1] // 2])
