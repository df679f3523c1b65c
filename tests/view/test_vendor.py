"""The JavaScript of others that the page uses: unmodified, with versions and licences."""

import csv
import hashlib
from pathlib import Path

VENDOR = Path(__file__).parents[2] / "libgz" / "view" / "client" / "vendor"
NOTICE = Path(__file__).parents[2] / "NOTICE"


def rows():
    return list(csv.DictReader((VENDOR / "versions.tsv").read_text().splitlines(), delimiter="\t"))


def test_every_file_is_the_one_of_its_package():
    found = {path.relative_to(VENDOR).as_posix(): path for path in VENDOR.rglob("*") if path.is_file()}
    del found["versions.tsv"]
    assert {row["file"]: row["sha256"] for row in rows()} == {
        name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in found.items()
    }


def test_every_package_has_its_licence():
    for name in {row["package"] for row in rows()}:
        assert "Permission is hereby granted" in (VENDOR / name / "LICENSE").read_text()
        assert f"vendor/{name}/LICENSE" in NOTICE.read_text()
    assert {row["licence"] for row in rows()} == {"MIT"}
