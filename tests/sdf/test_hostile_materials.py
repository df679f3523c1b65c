"""Material scripts of strangers: numbers, comments and sizes that no renderer has to bear."""

import itertools
import math
import os
import types

import pytest
from PIL import Image

from libgz.sdf import materials
from libgz.sdf.materials import IDLE, LONGEST, _Scripts, find_material

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


@pytest.fixture
def reads(monkeypatch):
    """The scripts that are read."""
    found = []
    read_limited = materials.read_limited
    monkeypatch.setattr(materials, "read_limited", lambda path, most: found.append(path) or read_limited(path, most))
    return found


def test_a_script_is_read_once_whatever_names_it(tmp_path, reads):
    (tmp_path / "a.material").write_text(HEAD)
    for number in range(20):
        assert find_material("a", ["a.material", f"folder{number}"], tmp_path) is not None
        (tmp_path / f"folder{number + 1}").mkdir()
    assert len(reads) == 1


def test_many_scripts_are_read_once_up_to_a_bound(tmp_path, monkeypatch, caplog, reads):
    """Of each visual, all of them would be read again."""
    monkeypatch.setattr(materials, "_kept", _Scripts(150_000))
    names = [f"{number}.material" for number in range(100)]
    for name in names:
        (tmp_path / name).write_text(HEAD.replace("material a", f"material {name[:-9]}"))
    for _ in range(3):
        assert all(find_material(name[:-9], names, tmp_path) for name in names)
    assert len(reads) == 100
    (tmp_path / "more.material").write_text(HEAD + " " * 100_000)
    for _ in range(3):
        assert find_material("a", ["more.material"], tmp_path) is None
    assert caplog.text.count("more.material: not read; all material scripts") == 1
    assert find_material("99", names, tmp_path) is not None
    assert len(reads) == 101


def test_scripts_that_nothing_names_any_more_make_place(tmp_path, monkeypatch):
    """A server that runs for days gets models with ever new scripts."""
    now = 0.0
    monkeypatch.setattr(materials, "time", types.SimpleNamespace(monotonic=lambda: now))
    monkeypatch.setattr(materials, "_kept", _Scripts(100_000))
    for name in ("a", "b", "c"):
        (tmp_path / f"{name}.material").write_text(HEAD.replace("material a", f"material {name}") + " " * 40_000)
    found = {}
    for now, name in ((0.0, "a"), (0.0, "b"), (1.0, "c"), (IDLE, "b"), (IDLE + 1.0, "c"), (IDLE + 2.0, "a")):
        found[now, name] = find_material(name, [f"{name}.material"], tmp_path) is not None
    assert [key for key, value in found.items() if not value] == [(1.0, "c"), (IDLE + 2.0, "a")]


def test_a_script_of_many_blocks_defines_nothing(read, monkeypatch):
    monkeypatch.setattr(materials, "_kept", _Scripts(1 << 20))
    assert read(HEAD + "b{}" * 3000) is None
    assert read(HEAD + "b{}" * 300) is not None


def test_a_material_has_the_image_of_its_parent_or_its_own(read, tmp_path):
    for name in ("p.png", "own.png"):
        Image.new("RGB", (1, 1)).save(tmp_path / name)
    parent = UNIT.format("p.png", "scale 2 2").replace("material a", "material b")
    assert read(parent + "material a : b\n{\n}\n").texture == tmp_path / "p.png"
    own = UNIT.format("own.png", "").replace("material a", "material a : b")
    assert read(parent + own).texture == tmp_path / "own.png"
