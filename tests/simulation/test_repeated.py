"""What clients cause in the log."""

import re
from pathlib import Path

from libgz.simulation.repeated import PARTS

OTHERS = {"gazebo", "gym", "lsp", "player", "plugin", "sweep"}  # plugins, and what handles no client of a world


def test_all_loggers_that_a_message_can_reach_are_counted():
    sources = (Path(__file__).parents[2] / "libgz").rglob("*.py")
    found = {name for source in sources for name in re.findall(r'getLogger\("libgz\.(\w+)', source.read_text("utf-8"))}
    assert found - OTHERS == set(PARTS)
