"""Images of which only a part is rendered: `alpha_rejection` of material scripts, as leaves and fences have it."""

import io

import numpy as np
import pytest
from PIL import Image

from libgz import GzPose, GzVector, World
from libgz.physics.image_files import open_image
from libgz.rendering.camera import Camera
from libgz.sdf.materials import find_material
from libgz.view.assets import Assets
from libgz.view.local import LocalSource

SCRIPT = """material leaf
{
  technique
  {
    pass
    {
      lighting off
      alpha_rejection RULE
      texture_unit
      {
        texture leaf.png
      }
    }
  }
}
"""
WORLD = """<sdf version='1.6'><world name='w'><scene><background>0 0 1 1</background></scene>
<model name='m'><static>1</static><link name='l'><visual name='v'><geometry><box><size>1 1 1</size></box></geometry>
<material><script><uri>m.material</uri><name>leaf</name></script></material></visual></link></model></world></sdf>"""


@pytest.fixture
def written(tmp_path):
    """Writes the world with a rule; its image has an alpha of 100 on the left and of 200 on the right."""
    pixels = np.zeros((8, 8, 4), dtype=np.uint8)
    pixels[..., 0], pixels[:, :4, 3], pixels[:, 4:, 3] = 255, 100, 200
    Image.fromarray(pixels).save(tmp_path / "leaf.png")

    def write(rule):
        (tmp_path / "m.material").write_text(SCRIPT.replace("alpha_rejection RULE", rule and f"alpha_rejection {rule}"))
        (tmp_path / "w.world").write_text(WORLD)
        return tmp_path / "w.world"

    return write


@pytest.mark.parametrize(
    ("rule", "shares"),
    [
        ("", (1, 1)),
        ("greater 128", (0, 1)),
        ("greater 99", (1, 1)),
        ("greater 100", (0, 1)),
        ("greater_equal 100", (1, 1)),
        ("greater_equal 201", (0, 0)),
        ("always_pass 128", (1, 1)),
        ("greater", (1, 1)),
    ],
)
@pytest.mark.parametrize("shadows", [False, True])
def test_what_has_too_little_alpha_is_not_rendered(written, rule, shares, shadows):
    with World.from_file(written(rule)) as world, Camera(world, 60, 60, hfov=0.6) as camera:
        world.backdrop.shadows = shadows
        camera.SetPose(GzPose(GzVector(-2.0, 0.0, 0.0)))
        row = camera.Update()[30].astype(int)
        red = row[:, 0] - row[:, 2] > 100
    front = np.flatnonzero(red)
    assert (red[5:24].mean(), red[36:55].mean()) == shares, front


def test_pages_get_the_alpha_and_its_bound(written):
    with World.from_file(written("greater 128")) as world:
        source = LocalSource(world)
        assets = Assets(source)
        (shape,) = (
            shape for entity in source.scene["entities"] for body in entity["bodies"] for shape in body["shapes"]
        )
        assert shape["texture"]["alpha_rejection"] == 128.0 / 255.0
        address = assets.of_scene(source.scene)[str(shape["texture"]["file"])]
        image = Image.open(io.BytesIO(assets.get(address).body))
    assert image.getpixel((0, 0))[3] == 100


def test_numbers_out_of_range_are_clamped(written):
    folder = written("greater 1e9").parent
    assert find_material("leaf", ["m.material"], folder).alpha_rejection == 254.0 / 255.0
    with open_image(folder / "leaf.png") as image:
        assert image.mode == "RGBA"
