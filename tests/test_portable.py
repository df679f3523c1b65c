"""The native parts compile for another processor, where its compiler is installed."""

import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
COMPILER = "aarch64-linux-gnu-gcc"
PARTS = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["ext-modules"]


@pytest.mark.skipif(shutil.which(COMPILER) is None, reason=f"{COMPILER} is not installed")
@pytest.mark.parametrize("part", PARTS, ids=[part["name"] for part in PARTS])
def test_a_native_part_compiles_for_aarch64(part):
    sources = [path for pattern in part["sources"] for path in sorted(ROOT.glob(pattern))]
    folders = [f"-I{ROOT / folder}" for folder in part.get("include-dirs", ())]
    options = ["-fsyntax-only", "-Wall", "-Wextra", "-Werror", *part["extra-compile-args"], *folders]
    done = subprocess.run([COMPILER, *options, *sources], capture_output=True, text=True)
    assert sources
    assert not done.returncode, done.stderr
