"""Write docs/worlds.md and render its images: one for each ready world.

.venv/bin/python scripts/make_gallery.py           # images and text
.venv/bin/python scripts/make_gallery.py --text    # text only
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

import libgz
from libgz.geometry import GzPose, GzQuaternFromEuler, GzVector
from libgz.rendering.camera import Camera
from libgz.worldfile.search import ReadyWorld

ROOT = Path(__file__).parents[1]
SIZE = (400, 300)
TIME = 1.0  # [s] of sim time: everything has come to rest, and nothing has moved far
DEFAULT_VIEW = GzPose(GzVector(-3.2, 2.4, 2.4), GzQuaternFromEuler(0.0, 0.5, -0.62))  # of worlds without an observer


def render(path: Path, image: Path) -> None:
    """Render a world from the pose of its observer, after TIME."""
    with libgz.World.from_file(path) as world:
        observer = next((m for m in world.GetModels() if m.GetName() == "ObserverCam"), None)
        world.run(TIME)
        with Camera(world, *SIZE) as camera:
            camera.SetPose(observer.GetPose() if observer else DEFAULT_VIEW)
            camera.options.displaySkins = True
            pixels = camera.Update()
        Image.fromarray(pixels).quantize(128).save(image, optimize=True)


def main() -> None:
    """Render all ready worlds, unless only the text is wanted, and write the page."""
    images = ROOT / "docs" / "worlds"
    images.mkdir(exist_ok=True)
    rows = []
    for path in sorted((ROOT / "worlds").glob("*.world")):
        if "--text" not in sys.argv[1:]:
            render(path, images / f"{path.stem}.png")
        rows.append(f"## {path.name}\n\n{ReadyWorld(path).summary}\n\n![{path.stem}](worlds/{path.stem}.png)\n")
    head = (
        "# Ready worlds\n\n`gazebo NAME` runs one of them, from any directory; `libgz worlds` lists them. "
        "`scripts/make_gallery.py` writes this page.\n"
    )
    (ROOT / "docs" / "worlds.md").write_text("\n".join([head, *rows]))


if __name__ == "__main__":
    main()
