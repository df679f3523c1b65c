"""Fixtures of the tests of physics."""

import pytest
from engine_parts import FORMS, use_classic, use_form

from libgz.physics.engine import Engine


@pytest.fixture(params=FORMS)
def form(request, monkeypatch):
    """A form of the step, by name."""
    use_form(request.param, monkeypatch)
    return request.param


@pytest.fixture
def classic_engine(form):
    """An engine with the classic contact rule, in each form of the step."""
    made = Engine(step_time=0.001)
    use_classic(made)
    return made
