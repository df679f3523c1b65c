"""Packages of ROS are found as rospack finds them: anywhere below ROS_PACKAGE_PATH, by the names in their manifests."""

import os

import pytest

from libgz.base.errors import NotFoundError
from libgz.sdf.paths import find_uri


@pytest.fixture
def workspace(tmp_path, monkeypatch):
    for name in ("GAZEBO_MODEL_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    return tmp_path


def add_package(folder, name):
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes" / "a.stl").touch()
    (folder / "package.xml").write_text(f"<package><name>{name}</name></package>")
    return folder


@pytest.mark.parametrize("scheme", ["package", "model"])
def test_a_package_in_a_repository_and_one_in_a_folder_of_another_name(workspace, scheme):
    robot = add_package(workspace / "repository" / "robots" / "bot_description", "bot_description")
    laser = add_package(workspace / "LMS", "lms1xx")
    assert find_uri(f"{scheme}://bot_description/meshes/a.stl") == robot / "meshes" / "a.stl"
    assert find_uri(f"{scheme}://lms1xx") == laser
    with pytest.raises(NotFoundError, match="Unable to find uri"):
        find_uri(f"{scheme}://lms1xx/meshes/b.stl")


def test_a_package_that_comes_later_is_found_and_an_ignored_one_is_not(workspace):
    with pytest.raises(NotFoundError):
        find_uri("package://late")
    late = add_package(workspace / "late_repository" / "late", "late")
    os.utime(workspace, ns=(1, 1))  # its time has changed, whatever the clock's resolution
    assert find_uri("package://late") == late
    ignored = add_package(workspace / "other" / "ignored", "ignored")
    (ignored.parent / "CATKIN_IGNORE").touch()
    os.utime(workspace, ns=(2, 2))
    with pytest.raises(NotFoundError):
        find_uri("package://ignored")


def test_links_in_a_circle_and_a_pipe_for_a_manifest_are_passed_over(workspace):
    (workspace / "a_circle").symlink_to("a_circle")
    (workspace / "a_pipe").mkdir()
    os.mkfifo(workspace / "a_pipe" / "package.xml")
    linked = add_package(workspace / ".hidden" / "robots" / "real", "linked")
    (workspace / "robots").symlink_to(linked.parent)
    assert find_uri("package://linked").samefile(linked)
