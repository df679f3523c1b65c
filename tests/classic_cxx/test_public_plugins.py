"""A trial: public plugins that need no ROS, by repository and path; nothing of them is kept here.

Each is compiled unmodified, with the folders of its repository that have headers; the share that has no errors is held.
"""

import csv
import subprocess
from pathlib import Path

import pytest

from libgz.classic_cxx.build import check

LIST = Path(__file__).with_name("public_plugins.tsv")
SHARE = 0.85  # of those that could be fetched


def folders_of(repository):
    """The folders with headers, and those above them, which includes begin with."""
    found = {path.parent for suffix in ("h", "hh", "hpp") for path in repository.rglob(f"*.{suffix}")}
    return sorted(found | {folder.parent for folder in found})


@pytest.mark.trial
def test_public_plugins_compile_unmodified(library, tmp_path):
    rows = list(csv.DictReader(LIST.read_text().splitlines(), delimiter="\t"))
    results = {}
    for repository in sorted({row["repository"] for row in rows}):
        place = tmp_path / repository.replace("/", "+")
        fetch = ["git", "clone", "-q", "--depth", "1", f"https://github.com/{repository}", str(place)]
        if subprocess.run(fetch, capture_output=True, check=False, timeout=600).returncode != 0:
            continue
        include = [f"-I{folder}" for folder in folders_of(place)]
        for row in rows:
            source = place / row["file"]
            if row["repository"] == repository and source.is_file():
                results[repository, row["file"]] = check([source], options=include)
    for (repository, file), errors in results.items():
        print(repository, file, errors[0] if errors else "compiles")
    if not results:
        pytest.skip("no repository could be fetched")
    assert sum(not errors for errors in results.values()) >= SHARE * len(results)
