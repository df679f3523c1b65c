"""libgazebo in C for old programs: `gazebo.h`, the library's sources, and the code that generates and compiles them."""

from pathlib import Path

FOLDER = Path(__file__).resolve().parent
