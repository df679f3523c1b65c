"""`python -m libgz` is the command `libgz`."""

import sys

from libgz.apps.libgz import main

sys.exit(main())
