"""Ground and walls compared with a bare plane: `python benchmarks/ground.py`. Compare the ratios of one run."""

import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

import libgz
from libgz.physics.body import Body
from libgz.physics.engine import Engine
from libgz.physics.geoms import HeightfieldGeom
from libgz.physics.space import Space
from libgz.physics.surfaces import TerrainGeom

SETTINGS = "<param:Global><utmOffset>500000 4000000</utmOffset></param:Global>"
HEAD = f"<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>{SETTINGS}"
LASER = "<model:SickLMS200><id>l</id><xyz>0 0 .101</xyz></model:SickLMS200>"
ROBOT = "<model:Pioneer2DX><id>r</id><xyz>{}</xyz>" + LASER + "</model:Pioneer2DX>"
PLANE = "<model:GroundPlane/>"
STEPS = 2000


def make_plan(path: Path) -> None:
    """500 x 500 pixels with walls and three hundred round obstacles."""
    random = np.random.default_rng(3)
    image = Image.new("L", (500, 500), 255)
    draw = ImageDraw.Draw(image)
    for _ in range(300):
        x, y = random.integers(0, 490, 2)
        draw.ellipse((x, y, x + random.integers(3, 9), y + random.integers(3, 9)), fill=0)
    draw.rectangle((170, 200, 330, 300), fill=0)
    draw.rectangle((180, 210, 320, 290), fill=255)
    image.save(path)


def worlds(plan: Path) -> dict[str, str]:
    """Name -> the models of the world."""
    walls = (
        f"<model:MapExtruder><imageFile>{plan}</imageFile><scale>0.05</scale><errBound>1</errBound></model:MapExtruder>"
    )
    terrain = "<model:Terrain><terrainFile>terrain.gzb</terrainFile><xyz>-32 -32 0</xyz></model:Terrain>"
    road = "<model:Road><roadFile>road.txt</roadFile></model:Road>"
    return {
        "plane": PLANE + ROBOT.format("0 0 .24"),
        "walls of a 500 x 500 plan": PLANE + walls + ROBOT.format("0 0 .24"),
        "terrain of 2048 triangles": terrain + ROBOT.format("0 0 .26"),
        "road of 400 m": road + ROBOT.format("8 1 .6"),
    }


def scan_time(geom: TerrainGeom | HeightfieldGeom, heights: float) -> float:
    """Seconds for 2000 slanting rays."""
    random = np.random.default_rng(0)
    start, end = random.uniform(-14, 14, (2000, 3)), random.uniform(-14, 14, (2000, 3))
    start[:, 2], end[:, 2] = heights + 1.0, -1.0
    way = end - start
    length = np.linalg.norm(way, axis=1, keepdims=True)
    rays = np.concatenate([start, way / length, length], axis=1)
    ranges, rows = np.empty(2000), np.empty(2000, dtype=np.int64)
    begin = time.perf_counter()
    geom.body.engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), rays, 0, ranges, rows)
    return time.perf_counter() - begin


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        plan = Path(folder) / "plan.png"
        make_plan(plan)
        base = 0.0
        for name, body in worlds(plan).items():
            begin = time.perf_counter()
            with libgz.World.from_string(f"{HEAD}{body}</gz:world>") as world:
                loaded = time.perf_counter() - begin
                world.step(STEPS // 10)
                begin = time.perf_counter()
                world.step(STEPS)
                step = (time.perf_counter() - begin) / STEPS
                base = base or step
                print(f"{name:28} load {loaded:6.3f} s   step {1e6 * step:5.0f} us = {step / base:4.2f} of the plane's")
    engine = Engine()
    space = Space(engine)
    y, x = np.mgrid[:65, :65] / 2.0
    heights = 4.0 + 2.0 * np.sin(x / 3.0) + 2.0 * np.cos(y / 4.0)
    field = HeightfieldGeom(Body(engine, dummy=True), space, heights, 32.0, 32.0)
    slow = scan_time(field, 9.0)
    field.close()
    mesh = TerrainGeom(Body(engine, dummy=True), space)
    mesh.LoadGrid(heights, 0.5)
    mesh.body.SetPosition((-16.0, -16.0, 0.0))
    print(f"rays on a height field take {slow / scan_time(mesh, 9.0):.0f} times as long as on the same mesh")
    engine.close()


if __name__ == "__main__":
    main()
