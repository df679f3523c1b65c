"""Mutation testing of what faces strangers, by cosmic-ray: mutants that narrow tests do not notice are printed.

Mutants are made in a copy of the installed package, never in the sources; TRIAL_MUTANTS says how many of each part are
tried, SEED which. A survivor is a missing test, or a mutant without effect: someone has to look at it.
"""

from __future__ import annotations

import os
import random
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from trials.table import trial

import libgz

pytestmark = pytest.mark.trial

ROOT = Path(__file__).parents[2]
MUTANTS = int(os.environ.get("TRIAL_MUTANTS") or 40)
LONGEST = 300.0  # [s] of the tests of one mutant; one that loops is noticed
# Part -> (modules, tests).
PARTS = {
    "gate": (("view/gate.py",), ("view/test_gate.py",)),
    "state": (
        ("base/encoding.py", "physics/state.py"),
        ("simulation/test_state_values.py", "simulation/test_state_attacks.py"),
    ),
    "transport": (
        ("transport/guard.py", "transport/segment.py", "transport/server.py", "base/files.py", "base/entities.py"),
        ("transport", "base/test_files.py", "worldfile/test_worldfile.py"),
    ),
    "recording": (
        ("recording/reader.py", "recording/mcap_file.py", "base/budget.py"),
        ("recording", "base/test_budget.py"),
    ),
}
IN_ANNOTATIONS = "core/ReplaceBinaryOperator_BitOr"  # mostly of `str | None`, which is never evaluated
CONFIG = """[cosmic-ray]
module-path = {modules}
timeout = {timeout}
excluded-modules = []
test-command = "{python} -P -m pytest -x -q -p no:cacheprovider -m 'not trial' {tests}"
[cosmic-ray.distributor]
name = "local"
"""


def run(folder: Path, *words: str) -> None:
    """A command of cosmic-ray, whose tests import the copy."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", "cosmic_ray.cli", *words]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def survivors(part: str, folder: Path, seed: int) -> tuple[int, list[str]]:
    """How many mutants of a part were tried, and those that its tests did not notice."""
    db: Any = pytest.importorskip("cosmic_ray.work_db")
    items: Any = pytest.importorskip("cosmic_ray.work_item")
    shutil.copytree(Path(libgz.__file__).parent, folder / "libgz", ignore=shutil.ignore_patterns("__pycache__"))
    modules, tests = PARTS[part]
    config, session = folder / "config.toml", folder / "session.sqlite"
    config.write_text(
        CONFIG.format(
            modules=[str(folder / "libgz" / module) for module in modules],
            tests=" ".join(f"tests/{name}" for name in tests),
            python=sys.executable,
            timeout=LONGEST,
        )
    )
    run(folder, "init", str(config), str(session))
    with db.use_db(str(session)) as work:
        items_of = {item.job_id: item.mutations[0].operator_name for item in work.work_items}
        useful = sorted(job for job, operator in items_of.items() if not operator.startswith(IN_ANNOTATIONS))
        jobs = random.Random(seed).sample(useful, min(MUTANTS, len(useful)))
        skipped = set(items_of) - set(jobs)
        for job in skipped:
            work.set_result(job, items.WorkResult(items.WorkerOutcome.SKIPPED))
    run(folder, "baseline", str(config))
    run(folder, "exec", str(config), str(session))
    found = []
    with db.use_db(str(session)) as work:
        for item, result in work.completed_work_items:
            if result.test_outcome == items.TestOutcome.SURVIVED:
                mutation = item.mutations[0]
                place = f"{mutation.module_path.relative_to(folder)}:{mutation.start_pos[0]}"
                found.append(f"{place}: {mutation.operator_name.removeprefix('core/')}\n{result.diff}")
    return len(jobs), found


@pytest.mark.parametrize("part", PARTS)
def test_tests_notice_what_mutants_change(part: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cosmic_ray", reason="pip install -r tests/trials/requirements.txt")
    with trial(f"mutants: {part}") as row:
        row.count, found = survivors(part, tmp_path, row.seed)
        row.result = f"{len(found)} survived"
        with capfd.disabled():
            sys.stdout.write("".join(f"\n{text}\n" for text in found))
        assert 2 * len(found) < row.count
