"""Material scripts of strangers: numbers, comments and sizes that no renderer has to bear."""

import itertools
import math
import os

import pytest
from PIL import Image

from libgz.sdf.materials import LONGEST, find_material

HEAD = "material a\n{\ndiffuse 0.5 0.5 0.5\n}\n"
UNIT = "material a\n{{\ntechnique\n{{\npass\n{{\ntexture_unit\n{{\ntexture {}\n{}\n}}\n}}\n}}\n}}\n"


@pytest.fixture
def read(tmp_path):
    """Reads the material `a` of a script."""
    names = (f"{number}.material" for number in itertools.count())  # scripts are read once

    def find(text):
        name = next(names)
        (tmp_path / name).write_text(text)
        return find_material("a", [name], tmp_path)

    return find


def test_comments_that_do_not_end_reach_to_the_end(read):
    found = read(HEAD + "/* " * 500_000 + "*\nmaterial b\n{\n}\n")  # in time that grows with their length
    assert found.diffuse == (0.5, 0.5, 0.5, 1.0)


def test_a_script_that_is_too_long_defines_nothing(read):
    assert read(HEAD + " " * (LONGEST - len(HEAD))) is not None
    assert read(HEAD + " " * (LONGEST + 1 - len(HEAD))) is None


def test_numbers_of_a_script_have_bounds(read):
    found = read(
        HEAD.replace(
            "}",
            "ambient 1e400 -1e308 1\ndiffuse nan 1 1\nspecular 1 1 1 inf\n"
            "alpha_rejection greater nan\nalpha_op_ex source1 src_manual src_current nan\n}",
        )
    )
    assert found.ambient == (1e9, -1e9, 1.0, 1.0)
    assert found.diffuse == (0.5, 0.5, 0.5, 1.0)
    assert found.shininess == 1e9
    assert found.alpha_rejection == 0.0


@pytest.mark.parametrize(
    "lines", ["scale 1e-320 1", "scale 1e400 1\nscroll 1e308 -1e308\nrotate 1e308", "scroll nan 0"]
)
def test_the_matrix_of_an_image_is_finite(read, tmp_path, lines):
    Image.new("RGB", (1, 1)).save(tmp_path / "a.png")
    found = read(UNIT.format("a.png", lines))
    assert found.texture == tmp_path / "a.png"
    assert all(map(math.isfinite, found.texture_matrix))


def test_textures_of_a_script_are_plain_files(read, tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for name in ("pipe", "/dev/zero", "a\0b", "a" * 5000, ".."):
        assert read(UNIT.format(name, "")).texture is None


def test_blocks_and_parents_without_an_end_are_read(read):
    found = read("material a : b\n{\ndiffuse 0 0 1\n}\nmaterial b : a\n{\n}\nmaterial c\n" + "{\n" * 100_000 + "}}" * 9)
    assert found.diffuse == (0.0, 0.0, 1.0, 1.0)
