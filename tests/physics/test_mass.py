"""Moments of inertia: which of them a body can have."""

import numpy as np
import pytest

from libgz.physics.mass import positive_definite


@pytest.mark.parametrize(
    "moments",
    [
        (1.0, 2.0, 3.0, 0.0, 0.0, 0.0),
        (1.0, 0.0, 3.0, 0.0, -0.0, 0.0),
        (1.0, 2.0, -1e-12, 0.0, 0.0, 0.0),
        (1.0, 1e-300, 1e9, 0.0, 0.0, 0.0),
        (1.0, 1.0, 1.0, 0.9, 0.0, 0.0),
        (1.0, 1.0, 1.0, 1.1, 0.0, 0.0),
        (1.0, 1.0, 1.0, 0.0, 0.0, -2.0),
        (1.0, 2.0, 3.0, 0.0, 0.5, 0.4),
    ],
)
def test_they_are_positive_about_every_axis(moments):
    ixx, iyy, izz, ixy, ixz, iyz = moments
    matrix = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    assert positive_definite(moments) == bool(np.linalg.eigvalsh(matrix).min() > 0.0)


def test_what_is_no_number_is_not_positive():
    assert not positive_definite((float("nan"), 1.0, 1.0, 0.0, 0.0, 0.0))
