"""Write docs/worlds.md and the gallery of docs/README.md, and render their images: ready worlds and examples of SDF.

.venv/bin/python scripts/make_gallery.py               # images and text
.venv/bin/python scripts/make_gallery.py --text        # text only
.venv/bin/python scripts/make_gallery.py shrimp map    # text, and the images of these worlds
"""

from __future__ import annotations

import math
import os
import sys
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

import libgz
from libgz.rendering.camera import Camera
from libgz.rendering.framing import framed, visible_points
from libgz.worldfile.search import ReadyWorld

ROOT = Path(__file__).parents[1]
SIZE = (800, 600)
FINER = 2  # images are rendered larger by this factor, and reduced
HFOV = math.radians(45.0)
LARGE = 150_000  # [bytes]
TIME = 1.0  # [s] of sim time: everything has come to rest, and nothing has moved far
COLUMNS = 3  # of the gallery of docs/README.md
MARK, END = "<!-- gallery: made by scripts/make_gallery.py -->\n", "<!-- end -->"
NO_SUBJECTS = ("GroundPlane", "LightSource", "ObserverCam", "SkyDome", "ground_plane", "sun")


@dataclass(frozen=True)
class Picture:
    """What an image shows, and from where.

    Attributes:
        subjects: ids of the models that fill the image, what is attached to them included; none: all models.
        side: how far the camera stands from where the light comes from, around the subjects [deg].
        azimuth: of the camera, counter-clockwise from +x, instead of `side` [deg].
        elevation: of the camera [deg].
        share: of the image that the subjects fill.
        time: of the image, sim time [s].
    """

    subjects: tuple[str, ...] = ("robot1",)
    side: float = 85.0
    azimuth: float | None = None
    elevation: float = 20.0
    share: float = 0.72
    time: float = TIME


LEGACY = {
    "simplesolids": Picture((), elevation=25.0, share=0.85),
    "shrimp": Picture(("robot1",), azimuth=120.0, share=0.6),
    "canonvcc4": Picture(("post", "arm", "cam1", "crate", "ball", "barrel"), share=0.85),
    "gripper": Picture(("robot1", "block"), azimuth=40.0, share=0.75),
    "heightmap": Picture(("hills",), elevation=35.0, share=1.4),
    "terrain": Picture(azimuth=205.0, elevation=12.0, share=0.2),
    "map": Picture((), elevation=50.0, share=0.95),
    "road": Picture(("robot1",), azimuth=150.0, elevation=22.0, share=0.2),
    "wifi": Picture(("robot1", "robot2", "mast"), share=0.85),
    "truth": Picture(("robot1", "crate"), azimuth=150.0, share=0.85),
    "ptz": Picture(("robot1", "crate", "ball"), azimuth=150.0, share=0.85),
    "stereohead": Picture(("robot1", "crate"), azimuth=150.0, share=0.85),
    "gps": Picture(("robot1", "tower"), share=0.9),
    "pioneer2at": Picture(azimuth=125.0, share=0.5),
    "pioneer2sonars": Picture(("robot1", "barrel"), azimuth=140.0, share=0.85),
    "clodbuster": Picture(share=0.5),
    "bandit": Picture(("robot1", "table", "pedestal"), share=0.9),
    "factory": Picture(share=0.5, time=4.0),
    "peoplebot": Picture(azimuth=-40.0),
    "roomba": Picture(elevation=28.0, share=0.4),
    "wheelchair": Picture(azimuth=150.0),
    "blimp": Picture(share=0.55),
}
SDF = {
    "diff_drive": Picture((), share=0.6),
    "joint_pid": Picture((), share=0.8),
    "camera": Picture((), share=0.8),
    "contact": Picture((), share=0.7),
    "visual": Picture((), share=0.8),
}


def subjects(world: libgz.World, names: tuple[str, ...]) -> list[libgz.Body]:
    """The bodies of models, and of all that is attached to them."""
    models = world.GetModels()
    others = [model for model in models if not {model.GetId(), model.GetName()} & {*NO_SUBJECTS}]
    wanted = {model.GetId() for model in others if not names or model.GetId() in names}
    bodies = [body for model in models if model.GetId() in wanted for body in model.bodies]
    for model in models:
        parent = model.parent
        while parent is not None and parent.GetId() not in wanted:
            parent = parent.parent
        if parent is not None and model.GetId() not in wanted:
            bodies += model.bodies
    return bodies


def render(path: Path, image: Path, picture: Picture) -> None:
    """Render a world with shadows, its subjects in the middle, after a time."""
    with libgz.World.from_file(path) as world:
        world.run(picture.time)
        width, height = (FINER * side for side in SIZE)
        with Camera(world, width, height, HFOV, near=0.05, far=300.0) as camera:
            camera.options.shadows = True
            lights = [geom for geom in world.engine.geoms.values() if isinstance(geom, libgz.LightGeom)]
            x, y, _ = lights[0].GetPose().pos if lights and lights[0].kind == "point" else (-0.5, -0.1, 1.0)
            sides = [math.atan2(y, x) + sign * math.radians(picture.side) for sign in (-1.0, 1.0)]
            azimuth = max(sides, key=math.cos)  # where robots are seen from ahead
            if picture.azimuth is not None:
                azimuth = math.radians(picture.azimuth)
            points = visible_points(subjects(world, picture.subjects))
            camera.SetPose(framed(points, azimuth, math.radians(picture.elevation), SIZE, HFOV, picture.share))
            pixels = camera.Update()
    save(Image.fromarray(pixels).resize(SIZE, Image.Resampling.LANCZOS), image)


def save(image: Image.Image, path: Path) -> None:
    """Save an image; with a palette only where textures make it large and hide the palette's steps."""
    image.save(path, optimize=True)
    if path.stat().st_size > LARGE:
        image.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)


def main() -> None:
    """Render all ready worlds and examples, unless only the text is wanted, and write the page."""
    images = ROOT / "docs" / "worlds"
    (images / "sdf").mkdir(parents=True, exist_ok=True)
    asked = [word for word in sys.argv[1:] if not word.startswith("--")]

    entries = all_entries()
    for path, name, _ in (entry for group in entries.values() for entry in group):
        if "--text" not in sys.argv[1:] and (not asked or name in asked):
            os.environ["GAZEBO_PLUGIN_PATH"] = str(path.parent)
            picture = SDF[path.stem] if name.startswith("sdf/") else LEGACY.get(path.stem, Picture())
            render(path, images / f"{name}.png", picture)
    write_text(entries)


def all_entries() -> dict[str, list[tuple[Path, str, str]]]:
    """Title of each part of the gallery -> (world, name of its image, command)."""
    entries: dict[str, list[tuple[Path, str, str]]] = {"Worldfiles": [], "SDF worlds": []}  # world, name, command
    for path in sorted((ROOT / "worlds").glob("*.world")):
        entries["Worldfiles"].append((path, path.stem, f"gazebo {path.stem}"))
    for name in SDF:
        path = ROOT / "examples" / "plugins" / name / f"{name}.world"
        entries["SDF worlds"].append((path, f"sdf/{name}", f"gzserver {path.relative_to(ROOT)}"))
    return entries


def write_text(entries: dict[str, list[tuple[Path, str, str]]]) -> None:
    """Write docs/worlds.md, and the gallery between the marks of docs/README.md."""
    rows = ["<!-- Made by scripts/make_gallery.py; do not edit. -->\n", "# Gallery\n"]
    rows.append(
        "Each world runs by the command below its image; worldfiles do from any directory: `libgz worlds` lists them.\n"
    )
    cells = []
    for title, group in entries.items():
        rows.append(f"## {title}\n")
        for path, name, command in group:
            rows.append(
                f"### {path.stem}\n\n{ReadyWorld(path).summary}\n\n![{path.stem}](worlds/{name}.png)\n\n    {command}\n"
            )
            cells.append(f"![{path.stem}](worlds/{name}.png)<br>`{command.replace('examples/plugins/', '')}`")
    (ROOT / "docs" / "worlds.md").write_text("\n".join(rows))
    cells += [""] * (-len(cells) % COLUMNS)
    table = [f"|{'|'.join(['   '] * COLUMNS)}|", f"|{'|'.join(['---'] * COLUMNS)}|"]
    table += [f"| {' | '.join(cells[i : i + COLUMNS])} |" for i in range(0, len(cells), COLUMNS)]
    page = ROOT / "docs" / "README.md"
    head, mark, rest = page.read_text().partition(MARK)
    about = "## Gallery\n\nThe commands of SDF worlds are for [examples/plugins](../examples/plugins/README.md).\n\n"
    page.write_text(f"{head}{mark}\n{about}" + "\n".join(table) + f"\n\n{END}{rest.partition(END)[2]}")


if __name__ == "__main__":
    main()
