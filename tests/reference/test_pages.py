"""Pages of the documentation that are generated, or that list what there is."""

import re
from pathlib import Path

from libgz.apps.libgz import COMMANDS
from libgz.models import MODELS
from libgz.reference.pages import pages, write_pages

ROOT = Path(__file__).parents[2]


def test_pages_are_written_once(tmp_path):
    assert len(write_pages(tmp_path)) == len(MODELS) + 1
    assert write_pages(tmp_path) == []


def test_pages_link_to_pages_that_exist():
    found = pages()
    for name, text in found.items():
        for target in re.findall(r"\]\(([^)#]+)", text):
            assert target in found, (name, target)


def test_every_ready_world_has_its_image():
    page = (ROOT / "docs/worlds.md").read_text()
    worlds = sorted(path.stem for path in (ROOT / "worlds").glob("*.world"))
    assert re.findall(r"^!\[\w+\]\(worlds/(\w+)\.png\)$", page, re.MULTILINE) == worlds
    assert sorted(path.stem for path in (ROOT / "docs/worlds").glob("*.png")) == worlds, "run scripts/make_gallery.py"


def test_every_model_is_in_a_ready_world():
    text = "".join(path.read_text() for path in (ROOT / "worlds").glob("*.world"))
    assert set(re.findall(r"<model:(\w+)", text)) >= set(MODELS)


def test_the_tools_page_names_all_commands():
    text = (ROOT / "docs" / "tools.md").read_text()
    for command in ("check", "models", "schema", "upgrade", "convert"):
        assert command in COMMANDS
        assert f"`libgz {command} " in text or f"`libgz {command}`" in text
