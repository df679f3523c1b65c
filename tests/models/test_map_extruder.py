"""Floor plans: outlines of images, and the walls on them."""

import logging
import math

import numpy as np
import pytest
from ground_worlds import heights_below, world_of
from PIL import Image, ImageDraw

import libgz
from libgz.models.contours import outlines, simplified


def test_outlines_of_a_small_image():
    mask = np.zeros((6, 7), dtype=bool)
    mask[1:4, 2:5] = True
    mask[2, 3] = False  # a hole
    mask[4, 5] = True  # touches at a corner only
    found = [{tuple(corner) for corner in polygon.tolist()} for polygon in outlines(mask)]
    assert found == [
        {(1, 2), (1, 5), (4, 5), (4, 2)},
        {(2, 3), (2, 4), (3, 4), (3, 3)},
        {(4, 5), (4, 6), (5, 6), (5, 5)},
    ]
    assert [len(polygon) for polygon in outlines(np.ones((3, 4), dtype=bool))] == [4]
    assert outlines(np.zeros((3, 4), dtype=bool)) == []


def area(polygon):
    """By the shoelace formula; clockwise on the picture is positive."""
    rows, columns = np.array(polygon, dtype=float).T
    return 0.5 * float(np.sum(columns * np.roll(rows, -1) - rows * np.roll(columns, -1)))


@pytest.mark.parametrize("seed", range(5))
def test_outlines_enclose_solid_pixels(seed):
    mask = np.random.default_rng(seed).random((40, 50)) < 0.1 + 0.2 * seed
    assert sum(area(polygon) for polygon in outlines(mask)) == mask.sum()


@pytest.mark.parametrize("tolerance", [0.0, 1.0, 3.0])
def test_simplified_outlines_stay_within_the_tolerance(tolerance):
    y, x = np.mgrid[:200, :200]
    (polygon,) = outlines(np.hypot(x - 100, y - 100) < 80)
    corners = simplified(polygon, tolerance)
    if tolerance == 0.0:
        assert np.array_equal(corners, polygon)
    else:
        assert len(corners) < len(polygon) / 8
    ends = np.roll(corners, -1, axis=0)
    along = (ends - corners).astype(float)
    for point in polygon:
        share = np.clip(((point - corners) * along).sum(1) / (along**2).sum(1), 0, 1)
        assert np.linalg.norm(point - corners - share[:, None] * along, axis=1).min() <= tolerance + 1e-9


MAP = "<model:MapExtruder><id>map</id><imageFile>map.png</imageFile><xyz>{}</xyz>{}</model:MapExtruder>"


def test_walls_stand_on_the_outlines(tmp_path):
    image = Image.new("L", (100, 60), 255)
    ImageDraw.Draw(image).rectangle((60, 10, 79, 19), fill=199)
    ImageDraw.Draw(image).rectangle((10, 40, 19, 49), fill=200)  # not below the threshold
    image.save(tmp_path / "map.png")
    attributes = "<scale>0.1</scale><height>2</height><width>0.2</width><errBound>0.5</errBound><color>0 1 0</color>"
    with world_of(tmp_path, MAP.format("1 2 0", attributes)) as world:
        model = world.model("map")
        walls = np.array(model.walls)
        # The rectangle's corners, from the picture's middle: x 1 to 3, y 1 to 2.
        assert walls[..., 0].min() == pytest.approx(1.0)
        assert walls[..., 0].max() == pytest.approx(3.0)
        assert walls[..., 1].min() == pytest.approx(1.0)
        assert walls[..., 1].max() == pytest.approx(2.0)
        assert len(walls) == len(model.GetBody().geoms) == 4
        sizes = np.array(sorted(geom.size for geom in model.GetBody().geoms))
        assert sizes == pytest.approx(np.array([(1.2, 0.2, 2)] * 2 + [(2.2, 0.2, 2)] * 2))
        tops = heights_below(world, [(2.0, 3.5), (3.0, 3.05), (3.0, 3.95), (3.0, 3.5), (5.0, 5.0)])
        assert tops[[0, 1, 2]] == pytest.approx(2.0)
        assert np.isnan(tops[3:]).all()


def test_a_large_plan_becomes_walls_and_a_laser_sees_them(tmp_path):
    rng = np.random.default_rng(3)
    image = Image.new("L", (500, 500), 255)
    draw = ImageDraw.Draw(image)
    for _ in range(300):  # clutter round about
        x, y = rng.integers(0, 490, 2)
        draw.ellipse((x, y, x + rng.integers(3, 9), y + rng.integers(3, 9)), fill=int(rng.integers(0, 190)))
    draw.rectangle((170, 200, 330, 300), fill=0)
    draw.rectangle((180, 210, 320, 290), fill=255)  # a room of 141 x 81 pixels, its middle at pixel (250.5, 250.5)
    image.save(tmp_path / "map.png")
    attributes = "<scale>0.05</scale><width>0.02</width><errBound>1</errBound><height>1</height>"
    laser = "<model:SickLMS200><id>laser1</id><xyz>0 0 0.2</xyz><rangeMax>10</rangeMax></model:SickLMS200>"
    with world_of(tmp_path, MAP.format("0 0 0", attributes) + laser, "<gravity>0 0 0</gravity>") as world:
        assert len(world.model("map").walls) > 300
        world.step(6)
        rays = world.model("laser1").rays.ranges + 0.2  # from the eye; readings mix neighbours
        x_face, y_face = 71 * 0.05 - 0.01, 41 * 0.05 - 0.01  # right wall, and lower wall: -y
        up_face = 40 * 0.05 - 0.01
        for degrees in range(-90, 91, 2):
            angle = math.radians(degrees)
            to_x = x_face / math.cos(angle) if abs(degrees) < 90 else math.inf
            to_y = (up_face if degrees > 0 else y_face) / abs(math.sin(angle)) if degrees else math.inf
            assert rays[45 + degrees // 2] == pytest.approx(min(to_x, to_y), abs=1e-5), degrees


@pytest.mark.parametrize(
    ("content", "words"), [(None, "file 'map.png' was not found"), (b"no picture", "cannot be read")]
)
def test_a_plan_that_cannot_be_read_is_one_warning_and_no_walls(tmp_path, caplog, content, words):
    if content is not None:
        (tmp_path / "map.png").write_bytes(content)
    with caplog.at_level(logging.WARNING), world_of(tmp_path, MAP.format("0 0 0", "")) as world:
        assert len(world.model("map").walls) == 0
    assert [words in r.getMessage() for r in caplog.records] == [True]


def test_a_plan_must_be_named(tmp_path):
    for model, words in (("MapExtruder", "needs an <imageFile>"), ("Road", "needs a <roadFile>")):
        with pytest.raises(libgz.WorldFileError, match=words):
            world_of(tmp_path, f"<model:{model}/>")


def test_robots_cannot_pass_walls(tmp_path):
    image = Image.new("L", (100, 100), 0)
    ImageDraw.Draw(image).rectangle((20, 20, 79, 79), fill=255)
    image.save(tmp_path / "map.png")
    robot = "<model:Pioneer2DX><id>r</id><xyz>0 0 .238</xyz></model:Pioneer2DX>"
    body = "<model:GroundPlane/>" + MAP.format("0 0 0", "<scale>0.05</scale>") + robot
    with world_of(tmp_path, body) as world:
        world.interface("position", "r").command(vx=0.5)
        world.run(6.0)
        assert 1.2 < world.model("r").GetPose().pos.x < 1.5
