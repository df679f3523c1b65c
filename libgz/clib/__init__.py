"""libgazebo in C for programs of the time: `gazebo.h`, the library's sources, and what makes them."""

from pathlib import Path

FOLDER = Path(__file__).resolve().parent
