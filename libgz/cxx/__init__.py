"""C++ plugin models of Gazebo 0.5 to 0.7: headers to compile them with, and the adapter that runs them.

A C++ object of a plugin holds the handle of an object of `libgz.legacy` or `libgz.physics`, and each of its methods
calls a Python function through a table (`table.py`), so that all state stays in one place.
"""

from pathlib import Path

FOLDER = Path(__file__).resolve().parent
