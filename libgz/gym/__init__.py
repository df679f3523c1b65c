"""Worlds as environments of Gymnasium; `import libgz.gym` registers them. The extra ``gym`` installs what it needs.

::

    import gymnasium
    import libgz.gym

    env = gymnasium.make("libgz/ReachGoal-v0")
"""

from __future__ import annotations

import os

from libgz.base.errors import LibraryError
from libgz.base.extras import install

try:
    import gymnasium
except ImportError as error:
    raise LibraryError(f"libgz.gym needs the extra `gym`: {install('gym')} ({error})") from None

# Mesa's threads do not survive a fork, and AsyncVectorEnv makes an environment before it forks its processes.
os.environ.setdefault("LP_NUM_THREADS", "0")

from libgz.gym.env import WorldEnv
from libgz.gym.tasks import TASKS
from libgz.gym.vector import KINDS, WorldVectorEnv

__all__ = ["TASKS", "WorldEnv", "WorldVectorEnv"]

for _name, _kind in KINDS.items():
    gymnasium.register(
        f"libgz/{_name}-v0",
        f"{_kind.__module__}:{_kind.__name__}",
        vector_entry_point=f"libgz.gym.vector:{_name}",
    )
