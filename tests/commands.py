"""The command `libgz`, as users run it."""

import subprocess
import sys


def run_libgz(*arguments, **options):
    """The finished process of ``libgz ...``, with its output as text."""
    command = [sys.executable, "-m", "libgz.apps.libgz", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, **options)
