"""The example notebooks run, and show images, plots and text; what objects show of themselves."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

import libgz
from libgz.errors import LibraryError, NotFoundError
from libgz.files import installed_worlds

NOTEBOOKS = sorted((Path(__file__).parent.parent / "examples" / "notebooks").glob("*.ipynb"))
RUN = """
import json, sys, nbformat, nbclient
notebook = nbformat.read(sys.argv[1], 4)
nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute(cwd=sys.argv[2])
print(json.dumps([list(out.get("data", {"error": 0})) for c in notebook.cells for out in c.get("outputs", [])
                  if out.output_type != "stream"]))
"""


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook, tmp_path):
    done = subprocess.run([sys.executable, "-c", RUN, notebook, tmp_path], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    shown = json.loads(done.stdout.splitlines()[-1])
    assert sum("image/png" in kinds for kinds in shown) >= 3
    assert sum(kinds == ["text/plain"] for kinds in shown) >= 2


def test_a_notebook_stores_no_output():
    assert len(NOTEBOOKS) == 2
    for notebook in NOTEBOOKS:
        assert not any(cell.get("outputs") for cell in json.loads(notebook.read_text())["cells"])


def test_what_objects_show(tmp_path):
    with libgz.World.from_file(installed_worlds() / "pioneer2at.world") as world:
        world.step(50)
        assert repr(world) == "<World 'default', legacy, sim time 1.000 s, 7 models>"
        assert repr(world.model("robot1")).startswith("<Pioneer2AT 'robot1' at (")
        assert " m, rpy (" in repr(world.body("robot1"))
        assert repr(world.joint("robot1", "left_front")).endswith(" rad>")
        image = world.image(320, 240)
        assert image.shape == (240, 320, 3)
        assert image.std() > 10.0
        (tmp_path / "world.png").write_bytes(world._repr_png_())
        with Image.open(tmp_path / "world.png") as shown:
            assert shown.size == (640, 480)
        figure = world.plot("robot1", "laser.laser1")
        assert [axes.get_title() for axes in figure.axes][-1] == "laser.laser1"
        with pytest.raises(NotFoundError, match="did you mean 'laser1'"):
            world.plot("laser2")
        robot = world.body("robot1")
    assert "closed" in repr(world)
    assert repr(robot) == "<Body canonical>"


def test_a_view_without_a_viewer_names_the_extra(monkeypatch):
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: ())
    with libgz.World() as world, pytest.raises(LibraryError, match=r"libgz\[view\]"):
        world.view()
