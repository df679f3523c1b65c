"""All other tests, twice, in random orders."""

import subprocess
import sys

import pytest
from trials.table import ROOT, trial

pytestmark = pytest.mark.trial


@pytest.mark.parametrize("run", [1, 2])
def test_tests_pass_in_random_order(run):
    with trial(f"tests in random order, run {run}") as row:
        order = row.seed + run - 1
        command = [sys.executable, "-P", "-m", "pytest", "-q", "-m", "not trial", "-n", "2", "--shuffle", str(order)]
        found = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
        row.count, row.result = 1, found.stdout.strip().rpartition("\n")[2]
        assert found.returncode == 0, f"--shuffle {order}:\n{found.stdout[-5000:]}{found.stderr[-2000:]}"
