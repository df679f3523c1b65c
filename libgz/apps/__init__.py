"""The commands."""

import os

# The threads of OpenBLAS cost a command 100 ms of CPU at its start, and no simulation uses them.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
