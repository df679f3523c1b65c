"""The reference page of SDF's elements does not call an element without effect that a reader of it sets."""

from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "sdf_elements.md"


@pytest.mark.parametrize("path", ["ode/constraints/contact_surface_layer", "contact/poissons_ratio"])
def test_an_element_that_acts_is_listed_as_such(path):
    row = next(line for line in PAGE.read_text().splitlines() if line.startswith(f"| `{path}` |"))
    assert row.split("|")[5].strip().startswith("yes")
