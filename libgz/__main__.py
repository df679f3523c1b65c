"""`python -m libgz` is the command `libgz`."""

import sys

from libgz.apps.launch import libgz

sys.exit(libgz())
