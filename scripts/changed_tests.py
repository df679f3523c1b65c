"""Print the folders and files of tests for what changed against main, one a line; with --base REV, against that."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def changed(base: str) -> list[str]:
    """Files that differ from where this branch left `base`, uncommitted and new ones included."""

    def git(*words: str) -> list[str]:
        return subprocess.run(["git", *words], cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()

    (fork,) = git("merge-base", base, "HEAD")
    return [*git("diff", "--name-only", fork), *git("ls-files", "--others", "--exclude-standard")]


def tests_of(files: list[str]) -> list[str]:
    """The tests of the packages that files belong to, and test files that changed themselves."""
    found = {"tests/test_architecture.py", "tests/test_vocabulary.py"} if files else set()
    for top, *rest in (Path(file).parts for file in files):
        if top == "libgz" and rest:
            found |= _of_package(Path("tests", *rest[:-1]))
        elif top in ("models", "interfaces", "docs"):
            found.add(f"tests/{top}")
        elif top == "tests" and rest and rest[-1].startswith("test_"):
            found.add("/".join([top, *rest]))
        elif top == "tests" and len(rest) > 1 and rest[0] != "data":
            found.add(f"tests/{rest[0]}")
    there = {one for one in found if (ROOT / one).exists() and not one.startswith("tests/trials")}
    return sorted(one for one in there if not any(str(above) in there for above in Path(one).parents))


def _of_package(folder: Path) -> set[str]:
    """The tests of a package; those of one in it, such as classic/sensors, are a folder and the files beside that."""
    while folder.name != "tests" and not (ROOT / folder).is_dir():
        folder = folder.parent
    if len(folder.parts) < 3:
        return {str(folder)} if folder.name != "tests" else set()
    return {str(folder), *(str(file.relative_to(ROOT)) for file in (ROOT / folder.parent).glob("test_*.py"))}


def main() -> None:
    """Print them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", default="main")
    sys.stdout.writelines(f"{one}\n" for one in tests_of(changed(parser.parse_args().base)))


if __name__ == "__main__":
    main()
