"""Outlines of polylines: how long they may take to be cut into triangles."""

import numpy as np
import pytest

from libgz.base.errors import ParameterError
from libgz.physics import outlines


def test_an_outline_that_would_take_minutes_is_refused(monkeypatch):
    """Work grows with the cube of its corners."""
    monkeypatch.setattr(outlines, "MOST_WORK", 10**6)
    crossed = [(i % 7, i * 7919 % 1000) for i in range(2000)]
    with pytest.raises(ParameterError, match="2000 corners takes too long"):
        outlines.extrude([crossed], 1.0)


def test_a_round_outline_of_many_corners_is_cut():
    angles = np.arange(1000) * 2.0 * np.pi / 1000
    _, triangles = outlines.extrude([np.column_stack([np.cos(angles), np.sin(angles)])], 1.0)
    assert len(triangles) == 2 * 998 + 2 * 1000
