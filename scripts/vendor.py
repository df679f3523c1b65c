"""Fetch the JavaScript of others that the page uses: unmodified files of npm packages, with their licences.

    .venv/bin/python scripts/vendor.py            # the versions in PACKAGES, to libgz/view/client/vendor

It needs npm. versions.tsv, which it writes, names the package, version, licence and SHA-256 of each file.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
import tarfile
import tempfile
from dataclasses import dataclass
from pathlib import Path

VENDOR = Path(__file__).parents[1] / "libgz" / "view" / "client" / "vendor"


@dataclass(frozen=True)
class Package:
    """An npm package, and what of it the page uses: `files` maps paths in the package to paths in its folder here."""

    name: str
    version: str
    licence: str  # SPDX
    files: dict[str, str]


def _addons(*names: str) -> dict[str, str]:
    return {f"examples/jsm/{name}": f"addons/{name}" for name in names}


PACKAGES = (
    Package(
        "three",
        "0.185.1",  # the last one with minified modules
        "MIT",
        {
            "build/three.module.min.js": "three.module.min.js",
            "build/three.core.min.js": "three.core.min.js",
            "LICENSE": "LICENSE",
        }
        | _addons(
            "controls/OrbitControls.js",
            "controls/TransformControls.js",
            "lines/LineMaterial.js",
            "lines/LineSegments2.js",
            "lines/LineSegmentsGeometry.js",
            "loaders/GLTFLoader.js",
            "utils/BufferGeometryUtils.js",
            "utils/SkeletonUtils.js",
        ),
    ),
    Package(
        "uplot",
        "1.6.32",
        "MIT",
        {"dist/uPlot.esm.js": "uPlot.esm.js", "dist/uPlot.min.css": "uPlot.min.css", "LICENSE": "LICENSE"},
    ),
)


def main() -> None:
    """Replace the folder."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        fresh = Path(folder) / "vendor"
        for package in PACKAGES:
            content = unpack(package, Path(folder))
            for source, name in package.files.items():
                target = fresh / package.name / name
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(content / source, target)
                digest = hashlib.sha256(target.read_bytes()).hexdigest()
                path = target.relative_to(fresh).as_posix()
                rows.append("\t".join((path, package.name, package.version, package.licence, digest)))
        (fresh / "versions.tsv").write_text("\n".join(("file\tpackage\tversion\tlicence\tsha256", *rows, "")))
        shutil.rmtree(VENDOR, ignore_errors=True)
        shutil.copytree(fresh, VENDOR)
    sys.stdout.write(f"{len(rows)} files in {VENDOR}\n")


def unpack(package: Package, folder: Path) -> Path:
    """The content of a package."""
    command = ["npm", "pack", "--silent", f"{package.name}@{package.version}"]
    archive = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True).stdout.split()[-1]
    target = folder / package.name
    with tarfile.open(folder / archive) as packed:
        packed.extractall(target, filter="data")
    return target / "package"


if __name__ == "__main__":
    main()
