"""The pytest plugin, as users run it: pytest in a process of its own, in a folder of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import libgz
from libgz.rendering.image import read_image
from libgz.transport.server import on_free_server_id

CI = Path(__file__).parents[2] / "examples" / "ci"


def run_pytest(folder, *options):
    (folder / "pytest.ini").write_text("[pytest]\n")  # this folder is the root
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=180)


def test_a_world_is_strict_served_and_ended(tmp_path):
    (tmp_path / "mine.world").write_text((CI / "course.world").read_text())
    (tmp_path / "test_it.py").write_text(
        """
import os
import pytest, libgz
from libgz.transport.paths import server_directory

WORLD = "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>%s</gz:world>"
ended = []

def test_it(libgz_world):
    world, second, text = libgz_world("mine"), libgz_world("pioneer2at"), libgz_world(WORLD % "")
    assert len({world.server_id, second.server_id, text.server_id}) == 3
    with libgz.Client(world.server_id) as client:
        client.position("robot1").command(vx=0.2)
        world.run(1.0)
        assert client.position("robot1").pose[0] > 0.1
    assert libgz_world(WORLD % "", server_id=None).server_id is None
    with pytest.raises(libgz.StrictError):
        libgz_world(WORLD % "<model:SimpleSolid><no>1</no></model:SimpleSolid>")
    libgz_world(WORLD % "<model:SimpleSolid><no>1</no></model:SimpleSolid>", strict=False)
    ended.append(world)

def test_it_is_ended():
    [world] = ended
    assert not world.running
    assert not os.path.exists(server_directory(world.server_id))
"""
    )
    done = run_pytest(tmp_path)
    assert done.returncode == 0, done.stdout
    assert "2 passed" in done.stdout
    assert not (tmp_path / "libgz-record").exists()


def test_what_fails_is_kept(tmp_path):
    (tmp_path / "course.world").write_text((CI / "course.world").read_text())
    (tmp_path / "test_it.py").write_text(
        """
import logging

def test_good(libgz_world):
    libgz_world("course").step(2)

def test_bad(libgz_world):
    world = libgz_world("course")
    world.run(0.5)
    logging.getLogger("libgz").info("what was logged")
    assert world.GetSimTime() > 9.0, "too early"
"""
    )
    done = run_pytest(tmp_path, "--libgz-record")
    assert done.returncode == 1
    assert "1 failed, 1 passed" in done.stdout
    [place] = (tmp_path / "libgz-record").iterdir()
    assert place.name == "test_it.py-test_bad"
    assert f"images and log are in {place}" in done.stdout
    text = (place / "log.txt").read_text()
    for words in ("what was logged", "sim time 0.500 s", "robot1:", "too early"):
        assert words in text
    assert read_image(place / "world-cam1.png").shape == (120, 160, 3)
    seen = read_image(place / "world-overview.png")
    assert seen.shape == (480, 640, 3)
    assert seen.std() > 5.0  # something is to be seen
    done = run_pytest(tmp_path, "--libgz-record", "--libgz-record-dir", "kept", "test_it.py", "-k", "bad")
    assert (tmp_path / "kept" / "test_it.py-test_bad" / "log.txt").is_file()


def test_parallel_tests_of_one_world_never_meet(tmp_path):
    """Each drives its robot at a speed of its own, by a client in another process, and finds its own odometry."""
    (tmp_path / "drive.py").write_text(
        """
import sys, libgz
with libgz.Client(int(sys.argv[1]), timeout=20.0) as client:
    robot = client.position("robot1")
    robot.command(vx=float(sys.argv[2]))
    while client.wait(timeout=20.0) and robot.time < 0.5:
        pass
    print(client.position("robot1").cmd_vel_pos[0])
"""
    )
    (tmp_path / "test_it.py").write_text(
        """
import pathlib, subprocess, sys, time
import pytest

@pytest.mark.parametrize("number", range(2))
def test_it(libgz_world, number):
    world = libgz_world("pioneer2at")
    begin, speed = time.time(), 0.05 * (number + 1)
    pathlib.Path(f"begun{number}").touch()
    while len(list(pathlib.Path().glob("begun*"))) < 2 and time.time() < begin + 60.0:  # both run at the same time
        time.sleep(0.01)
    program = subprocess.Popen([sys.executable, "drive.py", str(world.server_id), str(speed)], stdout=subprocess.PIPE)
    while program.poll() is None and time.time() < begin + 60.0:
        world.step()
        time.sleep(0.002)
    assert float(program.communicate()[0]) == speed
    assert world.interface("position", "robot1").cmd_vel_pos[0] == speed
    with open("served", "a") as file:
        file.write(f"{world.server_id} {begin} {time.time()}\\n")
"""
    )
    done = run_pytest(tmp_path, "-n", "2")
    assert done.returncode == 0, done.stdout
    runs = [tuple(map(float, line.split())) for line in (tmp_path / "served").read_text().splitlines()]
    assert len(runs) == 2
    (one, *times), (other, *others) = runs
    assert times[0] < others[1]
    assert others[0] < times[1]
    assert one != other


def test_an_id_that_another_one_takes_first_is_not_used(wire, monkeypatch):
    monkeypatch.setattr("libgz.transport.server.free_server_id", iter([wire, wire + 1, wire + 1]).__next__)
    first = libgz.World.from_file("empty", server_id=wire)
    second = on_free_server_id(lambda server_id: libgz.World.from_file("empty", server_id=server_id))
    assert second.server_id == wire + 1
    second.close()
    first.close()


def test_the_example_runs():
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(CI)],
        cwd=CI,
        capture_output=True,
        text=True,
        timeout=120,
        env={key: value for key, value in os.environ.items() if not key.startswith("PYTEST")},
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("module", ["numpy", "libgz.front"])
def test_other_tests_do_not_pay_for_the_plugin(module):
    code = f"import sys, libgz.testing.plugin; sys.exit({module!r} in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=60).returncode == 0
