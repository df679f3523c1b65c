"""Writes docs/classic: the reference of the plugin API of Gazebo classic, from its classes."""

from pathlib import Path

from libgz.reference.classic_pages import write_classic_pages

if __name__ == "__main__":
    write_classic_pages(Path(__file__).parent.parent / "docs" / "classic")
