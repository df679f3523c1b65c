"""What an installation wrote, and what of it is removed."""

import hashlib

import pytest

from libgz.base.manifest import Manifest


@pytest.fixture
def installed(tmp_path):
    """A manifest of a folder with a file, a program in Python and a link."""
    prefix = tmp_path / "prefix"
    (prefix / "lib").mkdir(parents=True)
    (prefix / "lib" / "a b.txt").write_text("a")
    (prefix / "lib" / "run.py").write_text("")
    (prefix / "lib" / "link").symlink_to("a b.txt")
    found = Manifest(prefix, "share/list.txt")
    found.write(["lib/a b.txt", "lib/run.py", "lib/link"])
    return found


def test_all_that_was_written_is_removed_with_the_folders_that_are_empty_then(installed):
    cache = installed.prefix / "lib" / "__pycache__"
    cache.mkdir()
    (cache / "run.cpython-311.pyc").touch()
    assert installed.paths() == ["lib/a b.txt", "lib/run.py", "lib/link"]
    assert len(installed.remove_all()) == 4
    assert not installed.prefix.exists()


def test_what_was_changed_stays(installed):
    (installed.prefix / "lib" / "a b.txt").write_text("mine")
    (installed.prefix / "lib" / "link").unlink()
    (installed.prefix / "lib" / "link").symlink_to("run.py")
    assert installed.paths() == ["lib/run.py"]
    installed.remove_all()
    assert sorted(path.name for path in (installed.prefix / "lib").iterdir()) == ["a b.txt", "link"]


def test_lines_that_name_something_else_remove_nothing(installed, tmp_path):
    """Somebody else may have made the folder, with sums of what is elsewhere."""
    mine = tmp_path / "mine.txt"
    mine.write_text("a")
    (installed.prefix / "elsewhere").symlink_to(tmp_path)
    (installed.prefix / "circle").symlink_to("circle")
    names = ["../mine.txt", str(mine), "elsewhere/mine.txt", "lib/../../mine.txt", "circle/x", "nul\0", ".", "lib", ""]
    sum_ = hashlib.sha256(b"a").hexdigest()
    with installed.file.open("a") as file:
        file.write("".join(f"{sum_} {name}\n" for name in names) + "lib/run.py\n")
    assert installed.paths() == ["lib/a b.txt", "lib/run.py", "lib/link"]
    installed.remove_all()
    assert mine.exists()
    assert sorted(path.name for path in installed.prefix.iterdir()) == ["circle", "elsewhere"]


def test_without_a_manifest_nothing_was_written(tmp_path):
    assert Manifest(tmp_path, "list.txt").paths() == []
