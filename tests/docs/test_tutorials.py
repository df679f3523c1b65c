"""What tutorials and how-to guides show works as it is typed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from fresh_root import namespace, needs_namespaces
from master_uri import free_master_uri

ROOT = Path(__file__).parents[2]
PAGES = sorted([*(ROOT / "docs" / "tutorials").glob("*.md"), *(ROOT / "docs" / "howto").glob("*.md")])
LONG = (
    "classic",
    "opengl",
    "plugins101",
    "port_model",
    "port_plugin",
    "to_sdf",
)  # other tests run most of what is in them
SESSION = Path(__file__).parent / "session.py"


@needs_namespaces  # the pages use server id 0, whose semaphores may be another server's outside
@pytest.mark.parametrize(
    "page", [pytest.param(p, id=p.stem, marks=[pytest.mark.trial] * (p.stem in LONG)) for p in PAGES]
)
def test_a_page_works_as_it_is_typed(page, tmp_path):
    environment = {
        **{name: value for name, value in os.environ.items() if not name.startswith("GAZEBO")},
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "HOME": str(tmp_path),
        "TMP": str(tmp_path),
        "USER": "reader",
        "GAZEBO_MASTER_URI": free_master_uri(),
    }
    folder = tmp_path / "work"
    folder.mkdir()
    (folder / "examples").symlink_to(ROOT / "examples")
    command = [*namespace(), sys.executable, str(SESSION), str(page), str(folder)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 0


@needs_namespaces
@pytest.mark.trial
def test_every_program_of_the_other_pages_runs(tmp_path):
    environment = {
        **{name: value for name, value in os.environ.items() if not name.startswith("GAZEBO")},
        "HOME": str(tmp_path),
        "TMP": str(tmp_path),
        "USER": "reader",
        "GAZEBO_MASTER_URI": free_master_uri(),
    }
    command = [*namespace(), sys.executable, str(SESSION.with_name("snippets.py")), str(tmp_path / "work")]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    assert int(done.stdout) > 25
