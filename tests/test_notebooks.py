"""The example notebooks run, and show images, plots and text; what objects show of themselves."""

import json
import math
import subprocess
import sys
import time
import urllib.request
from pathlib import Path

import pytest
from PIL import Image

import libgz
from libgz.base.errors import ClosedError, LibraryError, NotFoundError, ParameterError
from libgz.base.files import installed_worlds
from libgz.classic.server import attach

NOTEBOOKS = sorted((Path(__file__).parent.parent / "examples" / "notebooks").glob("*.ipynb"))
RUN = """
import json, sys, nbformat, nbclient
notebook = nbformat.read(sys.argv[1], 4)
nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute(cwd=sys.argv[2])
print([out.get("data", {}).get("text/html") for c in notebook.cells for out in c.get("outputs", [])])
print(json.dumps([list(out.get("data", {"error": 0})) for c in notebook.cells for out in c.get("outputs", [])
                  if out.output_type != "stream"]))
"""

SENSORS = """
<sdf version='1.6'><world name='d'><gravity>0 0 0</gravity><model name='m'><pose>1 2 3 0 0 1.5707963</pose>
  <link name='a'><sensor name='imu' type='imu'><pose>0.1 0 0 0 0 0</pose></sensor></link><link name='b'/>
  <joint name='j' type='fixed'><parent>a</parent><child>b</child>
    <sensor name='felt' type='force_torque'><pose>0 0 0.2 0 0 0</pose></sensor></joint>
</model></world></sdf>
"""


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook, tmp_path):
    done = subprocess.run([sys.executable, "-c", RUN, notebook, tmp_path], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    shown = json.loads(done.stdout.splitlines()[-1])
    assert sum("image/png" in kinds for kinds in shown) >= 3
    assert sum(kinds == ["text/plain"] for kinds in shown) >= 2
    assert done.stdout.count("<iframe src=") == 1  # the live view


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


def test_what_interfaces_geoms_and_sensors_show():
    with libgz.World.from_file(installed_worlds() / "pioneer2at.world") as world:
        position, (geom, *_) = world.interface("position", "robot1"), world.body("robot1").geoms
        position.data.pos[:], position.data.rot[2] = (1.5, -2.0, 0.0), math.inf  # a client can write anything
        assert repr(position) == "<Position position.robot1 at (1.5, -2, 0) m, rpy (0, 0, inf) deg>"
        assert repr(geom).startswith("<BoxGeom of robot1::canonical at (")
        assert " m, rpy (" in repr(geom)
    assert repr(position) == "<Position position.robot1, closed>"
    assert repr(geom) == "<BoxGeom of robot1::canonical>"
    with libgz.World.from_string(SENSORS) as world:
        imu, felt = attach(world).sensors.sensors.values()
        assert repr(imu) == "<ImuSensor 'd::m::a::imu' at (1, 2.1, 3) m, rpy (0, 0, 90) deg>"
        assert repr(felt) == "<ForceTorqueSensor 'd::m::j::felt' at (1, 2, 3.2) m, rpy (0, 0, 90) deg>"
    assert repr(felt) == "<ForceTorqueSensor 'd::m::j::felt'>"


def test_errors_name_objects_without_their_poses():
    with libgz.World.from_file(installed_worlds() / "pioneer2at.world") as world:
        body, joint = world.body("robot1"), world.joint("robot1", "left_front")
        with pytest.raises(ParameterError, match=r"^HingeJoint 'left_front' cannot join body 'robot1::canonical' with"):
            joint.Attach(body, body)
        with pytest.raises(ParameterError, match=r"^body 'robot1::canonical' was added to a model already; a body"):
            world.model("robot1").AddBody(body)
        with pytest.raises(ParameterError, match=r"^SliderJoint 'unnamed' must be attached to a body first"):
            libgz.SliderJoint(world).SetAxis(0.0, 0.0, 1.0)


def test_a_view_without_a_viewer_names_the_extra(monkeypatch):
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: ())
    with libgz.World() as world, pytest.raises(LibraryError, match=r"there is no viewer here: pip install .*aiohttp"):
        world.view()


def test_a_view_is_embedded_and_runs_the_world():
    with libgz.World.from_file("pioneer2at") as world:
        shown = world.view(port=18990)
        assert world.view() is shown
        assert f'<iframe src="{shown.url}" ' in shown._repr_html_()
        with urllib.request.urlopen(shown.url, timeout=20.0) as answer:
            assert answer.geturl().count("/") == 4  # with the token
            assert b'type="importmap"' in answer.read()
        controls, source = shown.viewer.controls, shown.viewer.source
        assert "keep" not in controls.abilities
        world.step(10)
        assert source.state().sim_time == pytest.approx(0.2)
        controls.ask("pause", "off")
        while world.GetSimTime() < 0.4:
            time.sleep(0.01)
        assert not source.state().paused
        controls.ask("pause", "on")
        while not source.state().paused:
            time.sleep(0.01)
        stopped = world.GetSimTime()
        controls.ask("step", "3")
        deadline = time.monotonic() + 20.0
        while world.GetSimTime() < stopped + 0.0599 and time.monotonic() < deadline:
            time.sleep(0.01)
        assert world.GetSimTime() == pytest.approx(stopped + 0.06)
        controls.ask("reset")
        assert source.state().sim_time <= stopped
        shown.close()
        assert "closed" in repr(shown)
    with pytest.raises(ClosedError):
        world.view()
