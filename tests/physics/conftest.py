"""Fixtures of the tests of physics."""

import pytest
from engine_parts import use_classic

from libgz.physics.engine import Engine


@pytest.fixture
def classic_engine():
    """An engine with the classic contact rule."""
    made = Engine(step_time=0.001)
    use_classic(made)
    return made
