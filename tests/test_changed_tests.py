"""What `make check` runs."""

import importlib.util
from pathlib import Path

SCRIPT = Path(__file__).parent.parent / "scripts" / "changed_tests.py"


def test_files_lead_to_the_tests_of_their_packages():
    spec = importlib.util.spec_from_file_location("changed_tests", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    always = ["tests/test_architecture.py", "tests/test_vocabulary.py"]
    for files, folders in {
        (): [],
        ("README.md",): always,
        ("libgz/classic/server.py",): ["tests/classic", *always],
        ("libgz/recording/deep/new.py",): ["tests/recording", *always],
        ("libgz/sdf/reader.py", "libgz/sdf/urdf.py"): ["tests/sdf", *always],
        ("models/robot.py", "interfaces/laser.py"): ["tests/interfaces", "tests/models", *always],
        ("tests/sdf/test_urdf.py",): ["tests/sdf/test_urdf.py", *always],
        ("tests/sdf/test_urdf.py", "libgz/sdf/urdf.py"): ["tests/sdf", *always],
        ("tests/gone/test_gone.py", "libgz/front.py", "tests/trials/test_wheels.py", "tests/data/x.stl"): always,
    }.items():
        assert module.tests_of(list(files)) == folders
    found = module.tests_of(["libgz/classic/sensors/imu.py"])
    assert {"tests/classic/sensors", "tests/classic/test_states.py"} < set(found)
    assert not {"tests/classic", "tests/classic/plugins", "tests/classic/gui"} & set(found)
