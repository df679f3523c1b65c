"""The C++ models of this folder and their Python twins move alike to the last bit, and serve the same bytes."""

import shutil
from pathlib import Path

import pytest

import libgz

HERE = Path(__file__).parent
STEPS = 5000

pytestmark = pytest.mark.skipif(not (shutil.which("c++") or shutil.which("g++")), reason="no C++ compiler is installed")


def drive_robot(world: libgz.World, step: int) -> None:
    """Commands of a client at some steps."""
    commands = {10: (0.2, 0.0), 1500: (0.1, 0.8), 3000: (-0.3, -0.4), 4500: (0.0, 0.0)}
    if step in commands:
        world.interface("position", "robot1").command(*commands[step])


def drive_lift(world: libgz.World, step: int) -> None:
    """Commands of a client at some steps."""
    commands = {10: 0.05, 2000: -0.02, 4000: 0.1}
    if step in commands:
        world.interface("position", "lift1").command(vz=commands[step])


def motion(path, drive):
    """All states of a run, and the bytes of its interfaces at the end, without their heads."""
    states = []
    with libgz.World.from_file(path) as world:
        for step in range(STEPS):
            drive(world, step)
            world.step()
            states.append(world.engine.states.tobytes())
        served = {key: value.get_bytes()[152:] for key, value in world.gz_server.interfaces.items() if key[0] != "sim"}
        return states, served, [type(model).__mro__[1].__name__ for model in world.models]


@pytest.mark.parametrize(
    ("name", "world", "twin", "drive"),
    [
        ("ExampleModel", "example.world", HERE.parent / "ExampleModel" / "ExampleModel.py", drive_robot),
        ("LiftScanner", "lift.world", HERE / "twins" / "LiftScanner.py", drive_lift),
    ],
)
def test_the_twin_in_python_moves_alike(tmp_path, name, world, twin, drive):
    from libgz.cxx.build import build

    folders = {"cxx": tmp_path / "cxx", "python": tmp_path / "python"}
    for folder in folders.values():
        folder.mkdir()
        shutil.copy(HERE / world, folder)
    assert not build([HERE / f"{name}.cc"], folders["cxx"] / f"{name}.so")
    shutil.copy(twin, folders["python"])
    compiled, ported = (motion(folder / world, drive) for folder in folders.values())
    assert "CxxModel" in compiled[2]
    assert "CxxModel" not in ported[2]
    first = next((i for i, (a, b) in enumerate(zip(compiled[0], ported[0], strict=True)) if a != b), None)
    assert first is None, f"they differ from step {first} on"
    assert compiled[1] == ported[1]
    assert len(set(compiled[0])) > STEPS / 2  # they move
