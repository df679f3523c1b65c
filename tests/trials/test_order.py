"""All other tests, twice, in random orders."""

import random
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.trial


@pytest.mark.parametrize("run", [1, 2])
def test_tests_pass_in_random_order(run):
    seed, root = random.SystemRandom().randrange(10**6), Path(__file__).parents[2]
    command = [sys.executable, "-m", "pytest", "-q", "-m", "not trial", "-n", "2", "--shuffle", str(seed)]
    found = subprocess.run(command, cwd=root, capture_output=True, text=True)
    assert found.returncode == 0, f"order of seed {seed}:\n{found.stdout[-5000:]}{found.stderr[-2000:]}"
