"""The reference page of the interfaces."""

from pathlib import Path

import libgz.interfaces.reference


def test_the_page_is_up_to_date():
    page = Path(__file__).parents[2] / "docs" / "interfaces.md"
    again = "run `python -m libgz.interfaces.reference > docs/interfaces.md`"
    assert page.read_text() == libgz.interfaces.reference.reference(), again
