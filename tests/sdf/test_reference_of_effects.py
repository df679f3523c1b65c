"""The reference of SDF's elements does not call an element without effect that a reader of it sets."""

import pytest
from commands import run_libgz

from libgz.reference.sdf_elements import sdf_block, sdf_blocks


@pytest.mark.parametrize("path", ["contact/ode/min_depth", "contact/poissons_ratio"])
def test_an_element_that_acts_is_listed_as_such(path):
    rows = [line for block in sdf_blocks() for line in sdf_block(block).splitlines()]
    row = next(line for line in rows if line.startswith(f"| `{path}` |"))
    assert row.split("|")[5].strip().startswith("yes")


def test_the_command_lists_blocks_and_prints_one():
    assert run_libgz("sdf", "--elements").stdout.split() == sdf_blocks()
    assert "| `axis/dynamics/damping` | double |" in run_libgz("sdf", "--elements", "joint").stdout
    wrong = run_libgz("sdf", "--elements", "jiont")
    assert wrong.returncode == 1
    assert "SDF has no block 'jiont'; did you mean 'joint'?" in wrong.stderr
