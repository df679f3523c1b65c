"""Write docs/drive.png, an animated PNG: a Pioneer 2 AT drives past solids, with shadows.

.venv/bin/python scripts/make_animation.py
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from PIL import Image

import libgz
from libgz.rendering.camera import Camera
from libgz.rendering.framing import framed

ROOT = Path(__file__).parents[1]
SIZE, FINER = (640, 400), 2  # [px]; images are rendered larger, and reduced
RATE, LENGTH = 12.5, 13.4  # [Hz], [s]: once around
HFOV = math.radians(45.0)
COMMAND = {"vx": 0.55, "vyaw": 0.62}  # [m/s], [rad/s]
CORNERS = [(x, y, z) for x in (-1.3, 1.9) for y in (-0.9, 2.7) for z in (0.0, 0.6)]  # [m] of what is in view

WORLD = """
<gz:world xmlns:gz="g" xmlns:model="m" xmlns:param="p">
  <param:Global><stepTime>0.020</stepTime><skyColor>0.69 0.81 0.92</skyColor></param:Global>
  <model:LightSource>
    <xyz>-9 -5 13</xyz><ambientColor>0.4 0.4 0.45</ambientColor><diffuseColor>0.9 0.9 0.85</diffuseColor>
  </model:LightSource>
  <model:GroundPlane><color>0.62 0.66 0.60</color></model:GroundPlane>
  <model:Pioneer2AT>
    <id>robot1</id>
    <model:SickLMS200><id>laser1</id><xyz>0.10 0 0.311</xyz></model:SickLMS200>
  </model:Pioneer2AT>
  <model:SimpleSolid><xyz>0.1 1.05 0</xyz><shape>cylinder</shape><size>0.5 0.7</size><color>0.2 0.4 0.8</color>
  </model:SimpleSolid>
  <model:SimpleSolid><xyz>1.8 -0.4 0</xyz><rpy>0 0 25</rpy><size>0.5 0.5 0.5</size><color>0.8 0.5 0.2</color>
  </model:SimpleSolid>
  <model:SimpleSolid><xyz>-1.5 0.3 0</xyz><shape>sphere</shape><size>0.5</size><color>0.9 0.75 0.15</color>
  </model:SimpleSolid>
  <model:SimpleSolid><xyz>1.1 2.9 0</xyz><size>1.6 0.2 0.6</size><color>0.75 0.75 0.72</color></model:SimpleSolid>
</gz:world>
"""


def frames() -> list[Image.Image]:
    """The images of the run."""
    found = []
    with libgz.World.from_string(WORLD) as world:
        robot = world.interface("position", "robot1")
        with Camera(world, FINER * SIZE[0], FINER * SIZE[1], HFOV, near=0.1, far=100.0) as camera:
            camera.options.shadows = True
            camera.SetPose(framed(np.array(CORNERS), math.radians(-55.0), math.radians(32.0), SIZE, HFOV, 0.95))
            for _ in range(round(RATE * LENGTH)):
                robot.command(**COMMAND)
                world.run(1.0 / RATE)
                found.append(Image.fromarray(camera.Update()).resize(SIZE, Image.Resampling.LANCZOS))
    return found


def main() -> None:
    """Render the run, and write it; of each image only what differs from the one before is kept."""
    images = frames()
    path = ROOT / "docs" / "drive.png"
    images[0].save(path, save_all=True, append_images=images[1:], duration=1000.0 / RATE, loop=0, optimize=True)


if __name__ == "__main__":
    main()
