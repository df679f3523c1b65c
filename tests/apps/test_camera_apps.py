"""The commands for images and videos, as users run them."""

import numpy as np
import pytest
from commands import run_libgz as libgz
from imageio import v3
from PIL import Image

from libgz import World
from libgz.base.files import installed_worlds

PTZ = installed_worlds() / "ptz.world"
BODY = (
    "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'><param:Global><gravity>0 0 -10</gravity></param:Global>"
    "<model:SimpleSolid><xyz>3 0 {}</xyz><size>1 1 1</size></model:SimpleSolid>"
    "<model:MonoCam><id>eye</id><gravity>false</gravity></model:MonoCam></gz:world>"
)


def test_picture_saves_the_image_of_a_camera(tmp_path):
    for camera, size in (("cam1", (320, 240)), ("observer", (640, 480))):
        done = libgz("picture", PTZ, "--camera", camera, "-o", tmp_path / "out.png")
        assert (done.returncode, done.stderr) == (0, "")
        with Image.open(tmp_path / "out.png") as picture:
            assert picture.size == size
            pixels = np.asarray(picture)
        assert pixels[-10:, :, 1].mean() > pixels[-10:, :, 2].mean() + 30  # grass


def test_picture_has_shadows_unless_told_otherwise(tmp_path):
    images = {}
    for word in ("--shadows", "--no-shadows"):
        done = libgz("picture", PTZ, "--camera", "cam1", word, "-o", tmp_path / "out.png")
        assert done.returncode == 0, done.stderr
        images[word] = np.asarray(Image.open(tmp_path / "out.png").convert("RGB")).copy()
    with World.from_file(PTZ) as world:
        world.step()
        assert np.array_equal(world.interface("camera", "cam1").image, images["--no-shadows"])
    assert (np.abs(images["--shadows"].astype(int) - images["--no-shadows"]) > 30).any()


def test_picture_of_a_later_time(tmp_path):
    world = tmp_path / "fall.world"
    world.write_text(BODY.format(-0.5))
    seen = {}
    for time in (0.0, 0.1, 0.5):
        done = libgz("picture", world, "-o", tmp_path / "out.png", "--time", time)
        assert done.returncode == 0, done.stderr
        rows = np.nonzero(np.asarray(Image.open(tmp_path / "out.png").convert("RGB"))[:, 160, 2] < 100)[0]
        seen[time] = rows.min() if len(rows) else 240
    # The top of the falling box sinks by half g t squared; its front edge is 2.5 m away, and the rear one, which is
    # the upper one in the picture once the top is below the eye, 3.5 m.
    focal, eye = 277.128, 0.025
    for time, row in seen.items():
        top = 0.5 - 0.5 * 10 * time * (time + 0.02) - eye
        assert row == pytest.approx(min(240, 120 - focal * top / (2.5 if top > 0 else 3.5)), abs=1.5)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("--camera", "cam2"), "no camera has the id 'cam2'; there are cam1, observer; did you mean 'cam1'?"),
        (("--gl", "none"), "has no image: rendering is disabled"),
        (("-o", "picture.nonsense"), "image picture.nonsense cannot be written"),
        (("--time", "-1"), "it must not be negative"),
    ],
)
def test_errors_of_picture(words, complaint):
    done = libgz("picture", PTZ, *words)
    assert done.returncode == 1
    assert complaint in done.stderr


def test_record_streams_a_video(gazebo, tmp_path):
    video = tmp_path / "run.mp4"
    process = gazebo(PTZ, "-n", "--steps", "60", "--record", f"cam1={video}", ready=False)
    out, err = process.process.communicate(timeout=60)
    assert process.process.returncode == 0, out + err
    frames = v3.imread(video, plugin="pyav")
    assert frames.shape == (12, 240, 320, 3)  # 60 steps of 20 ms at 10 Hz
    assert v3.immeta(video, plugin="pyav")["fps"] == 10.0
    assert frames[-1, -20:, :, 1].mean() > frames[-1, -20:, :, 2].mean() + 30


@pytest.mark.parametrize(
    ("request_", "complaint"),
    [("cam1", "it must be ID=FILE"), ("cam9=a.mp4", "no camera has the id 'cam9'; there are cam1, observer")],
)
def test_errors_of_record(gazebo, request_, complaint):
    process = gazebo(PTZ, "--steps", "1", "--record", request_, ready=False)
    _, err = process.process.communicate(timeout=60)
    assert process.process.returncode == 1
    assert complaint in err


def test_doctor_shows_which_contexts_work():
    lines = {line.split()[1]: line for line in libgz("doctor").stdout.splitlines()}
    for name in ("osmesa", "egl"):
        assert lines[name].startswith("ok")
        assert "renders: " in lines[name]


SDF = """
<sdf version='1.6'><world name='w'>
  <light name='sun' type='directional'><direction>1 0 -1</direction></light>
  <model name='m'><static>1</static>
    <link name='l'><sensor name='eye' type='camera'><camera><horizontal_fov>1</horizontal_fov>
      <image><width>64</width><height>48</height></image><clip><near>.1</near><far>50</far></clip></camera></sensor>
    </link></model>
  <model name='ball'><pose>4 0 0 0 0 0</pose><static>1</static><link name='l'>
    <visual name='v'><geometry><sphere><radius>1</radius></sphere></geometry>
      <material><ambient>1 0 0 1</ambient><diffuse>1 0 0 1</diffuse></material></visual></link></model>
</world></sdf>
"""


@pytest.mark.parametrize(
    ("words", "size"), [([], (64, 48)), (["--camera", "eye"], (64, 48)), (["--pose", "0 0 0 0 0 0"], (640, 480))]
)
def test_picture_of_an_sdf_world(words, size, tmp_path):
    world, out = tmp_path / "w.world", tmp_path / "out.png"
    world.write_text(SDF)
    done = libgz("picture", world, "-o", out, *words)
    assert (done.returncode, done.stderr) == (0, "")
    with Image.open(out) as picture:
        assert picture.size == size
        pixels = np.asarray(picture).astype(int)
    middle = pixels[size[1] // 2, size[0] // 2]
    assert middle[0] > middle[1] + 50  # the ball is red


def test_picture_names_the_sensors_there_are(tmp_path):
    world = tmp_path / "w.world"
    world.write_text(SDF)
    done = libgz("picture", world, "--camera", "ey")
    assert done.returncode == 1
    assert "no camera has the name 'ey'; there are w::m::l::eye" in done.stderr
