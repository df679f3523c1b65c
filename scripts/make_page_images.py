"""Render the images of the page in docs/images, each of a server of its own with a page in headless Chromium.

.venv/bin/python scripts/make_page_images.py               # all
.venv/bin/python scripts/make_page_images.py phone people  # some
"""

from __future__ import annotations

import contextlib
import io
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal

from PIL import Image
from playwright.sync_api import Page, sync_playwright

import libgz
from libgz.base.files import installed_worlds
from libgz.transport.server import free_server_id

FOLDER = Path(__file__).parents[1] / "docs" / "images"
FLAGS = ["--headless=new", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
DESKTOP, PHONE, WIDE = (1280, 800), (390, 844), (800, 500)
PATIENCE = 600_000  # [ms] software rendering of the best quality
QUALITY = 82  # of WebP
FRAMES, STEPS, RATE = 64, 4, 10  # of the animation: images, steps between two, images per second
YARD = """<sdf version="1.7"><world name="yard">
<scene><sky/><background>0.7 0.8 0.95 1</background></scene>
<include><uri>model://sun</uri></include><include><uri>model://ground_plane</uri></include>
<actor name="walker"><skin><filename>file://media/models/walk.dae</filename></skin>
<animation name="walk"><filename>file://media/models/walk.dae</filename><interpolate_x>true</interpolate_x></animation>
<script><trajectory id="0" type="walk"><waypoint><time>0</time><pose>-2 1.2 0 0 0 0</pose></waypoint>
<waypoint><time>4</time><pose>2 1.2 0 0 0 0</pose></waypoint></trajectory></script></actor>
<actor name="waiter"><pose>1.6 -0.2 0 0 0 2.6</pose><skin><filename>file://media/models/stand.dae</filename></skin>
<animation name="stand"><filename>file://media/models/stand.dae</filename></animation>
<script><trajectory id="0" type="stand"/></script></actor>
{solids}</world></sdf>"""


def solid(name: str, pose: str, shape: str, look: str) -> str:
    """A model of one shape."""
    geometry = f"<geometry>{shape}</geometry>"
    material = f"<material>{look}</material>"
    parts = f"<collision name='c'>{geometry}</collision><visual name='v'>{geometry}{material}</visual>"
    return f"<model name='{name}'><static>1</static><pose>{pose}</pose><link name='l'>{parts}</link></model>"


METAL = "<pbr><metal><metalness>0.95</metalness><roughness>0.3</roughness></metal></pbr>"
SOLIDS = (
    ("steel", "0.2 -0.3 0.45 0 0 0", "<cylinder><radius>0.3</radius><length>0.9</length></cylinder>",
     f"<diffuse>0.75 0.77 0.8 1</diffuse>{METAL}"),
    ("glass", "-0.5 -1 0.35 0 0 0", "<sphere><radius>0.35</radius></sphere>", "<diffuse>0.5 0.75 0.9 0.35</diffuse>"),
    ("clay", "-1.2 -0.2 0.25 0 0 0", "<sphere><radius>0.25</radius></sphere>", "<diffuse>0.75 0.2 0.12 1</diffuse>"),
    ("crate", "-0.6 0.2 0.3 0 0 0.4", "<box><size>0.6 0.6 0.6</size></box>",
     "<script><name>Gazebo/WoodPallet</name></script>"),
    ("lamp", "0.9 -1 0.5 0 0 0", "<cylinder><radius>0.06</radius><length>1</length></cylinder>",
     "<diffuse>1 0.6 0.1 1</diffuse><emissive>0.9 0.5 0.05 1</emissive>"),
)  # fmt: skip


class Shown:
    """A page that shows a paused world, and what is done in it."""

    def __init__(self, page: Page, server_id: int) -> None:
        self.page, self.id = page, server_id

    def until(self, condition: str) -> None:
        """Wait for a condition in the page, which its policy does not let Playwright do itself."""
        for _ in range(PATIENCE // 50):
            if self.page.evaluate(f"Boolean({condition})"):
                return
            self.page.wait_for_timeout(50)
        raise TimeoutError(condition)

    def button(self, name: str) -> Any:
        """A button by its name."""
        return self.page.get_by_role("button", name=name, exact=True)

    def select(self, name: str) -> None:
        """Select a model."""
        self.page.evaluate("(name) => libgz.store.select({ entity: libgz.store.ids.get(name) })", name)

    def show(self, *switches: str) -> None:
        """Show marks of all models."""
        for name in switches:
            self.page.evaluate("(name) => libgz.store.setSwitch(name, true)", name)

    def step(self, count: int) -> None:
        """Make steps, and wait until their end is shown."""
        self.until("libgz.store.control")  # a page that renders for long may have lost its connection
        before = self.page.evaluate("libgz.store.state.steps")
        self.page.evaluate("(count) => libgz.store.ask('step', String(count), {})", count)
        self.until(f"libgz.store.state.steps >= {before + count}")

    def drive(self, vx: float, vyaw: float, robot: str = "robot1") -> None:
        """Command a robot [m/s, rad/s]."""
        with libgz.Client(self.id, client_id=-1) as client:
            client.position(robot).command(vx=vx, vyaw=vyaw)

    def look(self, eye: tuple[float, float, float], target: tuple[float, float, float]) -> None:
        """Look from a place to another one [m]."""
        self.page.evaluate(
            """([eye, target]) => {
                const { stage } = libgz.workplace;
                stage.cameras.camera.position.set(...eye);
                stage.cameras.controls.target.set(...target);
                stage.invalidate(true);
            }""",
            [eye, target],
        )

    def image(self) -> Image.Image:
        """What is shown, when nothing moves."""
        self.until("!libgz.workplace.stage.cameras._glide && libgz.workplace.stage._refined")
        return Image.open(io.BytesIO(self.page.screenshot(timeout=PATIENCE))).convert("RGB")


@contextlib.contextmanager
def shown(
    world: Path, size: tuple[int, int], theme: Literal["light", "dark"] = "light", quality: str = "best", **options: Any
) -> Iterator[Shown]:
    """A page that shows a world; without a quality, at that which the page chooses while it waits for still images."""
    server_id = free_server_id(400)
    words = [sys.executable, "-m", "libgz.apps.gazebo", "-u", "-s", str(server_id)]
    words += ["--view", "--view-port", "18900", str(world)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as server, sync_playwright() as playwright:
        try:
            url = next(line.split()[1] for line in server.stdout or () if line.startswith("open "))
            chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
            page = chromium.new_page(
                viewport={"width": size[0], "height": size[1]}, color_scheme=theme, device_scale_factor=1, **options
            )
            page.set_default_timeout(PATIENCE)
            page.goto(f"{url}&quality={quality}" if quality else url)
            found = Shown(page, server_id)
            found.until("window.libgz?.workplace.stage.ready")
            yield found
            chromium.close()
        finally:
            server.terminate()
            server.wait(60.0)


def ready(name: str) -> Path:
    """The file of a packaged world."""
    return installed_worlds() / f"{name}.world"


# The images ----------------------------------------------------------------------------------------------------------


def page() -> Image.Image:
    """A robot that drives, its laser's rays, and plots of its velocity."""
    with shown(ready("pioneer2at"), DESKTOP, quality="") as view:
        view.select("robot1")
        view.page.get_by_role("tab", name="Plots").click()
        for name in ("vx", "vy", "wz"):
            view.button(f"Plot robot1 {name}").click()
        view.button("Close the drive panel").click()
        view.show("lasers", "trails")
        view.page.evaluate("libgz.store.setFollow(libgz.store.ids.get('robot1'))")
        for vx, vyaw, count in ((0.0, 0.0, 40), (0.4, 0.0, 100), (0.4, 0.8, 130), (0.3, -0.5, 130)):
            view.drive(vx, vyaw)
            for _ in range(0, count, 5):
                view.step(5)
        return view.image()


def marks() -> Image.Image:
    """Joint axes, centres of mass, inertia and names, in the dark theme."""
    with shown(ready("pioneer2at"), DESKTOP, "dark") as view:
        view.button("Close the drive panel").click()
        view.show("axes", "masses", "inertia", "names")
        view.select("robot1")
        view.page.keyboard.press("f")
        return view.image()


def catalogue() -> Image.Image:
    """The catalogue, with an image of each model in sight."""
    with shown(ready("pioneer2at"), DESKTOP, quality="") as view:
        view.image()
        view.button("Insert").click()
        view.until("document.querySelectorAll('.card-portrait.shown').length > 12")
        view.page.wait_for_timeout(20_000)  # those that have no image have none later either
        return Image.open(io.BytesIO(view.page.screenshot(timeout=PATIENCE))).convert("RGB")


def people() -> Image.Image:
    """Actors, glass, steel and wood in an SDF world."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "yard.world")
        file.write_text(YARD.format(solids="".join(solid(*one) for one in SOLIDS)))
        with shown(file, DESKTOP) as view:
            view.step(2200)
            view.look((-3.4, -4.0, 1.9), (0.2, 0.0, 0.75))
            return view.image()


def terrain() -> Image.Image:
    """A robot on hills."""
    with shown(ready("terrain"), DESKTOP) as view:
        view.button("Close the drive panel").click()
        view.step(40)
        view.look((-1.8, -2.0, 0.95), (0.3, 0.4, 0.5))
        return view.image()


def phone() -> Image.Image:
    """The page of a phone, with the stick."""
    with shown(ready("pioneer2at"), PHONE, "dark", has_touch=True) as view:
        view.show("lasers")
        view.step(20)
        return view.image()


def driving() -> list[Image.Image]:
    """A robot that fills the frame and drives a curve, with its laser's rays and its trail."""
    frames = []
    with shown(ready("pioneer2at"), WIDE, quality="") as view:
        view.button("Fold the tree").click()  # the inspector is folded in narrow windows
        view.button("Close the drive panel").click()
        view.show("lasers", "trails")
        view.page.evaluate("libgz.store.setFollow(libgz.store.ids.get('robot1'))")
        view.step(20)
        view.look((-0.9, -0.66, 0.62), (0.05, 0.0, 0.16))
        for number in range(FRAMES):
            vyaw = 0.7 if 8 <= number < FRAMES // 2 else -0.7
            view.drive(0.0 if number < 4 else 0.35, vyaw if number >= 8 else 0.0)
            view.step(STEPS)
            frames.append(view.image())
    return frames


IMAGES: dict[str, Callable[[], Image.Image | list[Image.Image]]] = {
    one.__name__: one for one in (page, marks, catalogue, people, terrain, phone, driving)
}


def main(names: list[str]) -> None:
    """Render the images of these names, all by default."""
    unknown = [name for name in names if name not in IMAGES]
    if unknown:
        raise SystemExit(f"there is no image {unknown[0]!r}; allowed are {', '.join(IMAGES)}")
    for name in names or IMAGES:
        made, path = IMAGES[name](), FOLDER / f"{name}.webp"
        first, *others = made if isinstance(made, list) else [made]
        if others:
            first.save(path, quality=60, method=6, save_all=True, append_images=others, duration=1000 // RATE, loop=0)
        else:
            first.save(path, quality=QUALITY, method=6)


if __name__ == "__main__":
    main(sys.argv[1:])
