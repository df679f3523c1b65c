"""Controllers: which of the pages that may control a world controls it now. Only one does; it can hand over."""

from __future__ import annotations

import json
import time
from typing import Any

from libgz.base.errors import GazeboError
from libgz.view.pages import Page

__all__ = ["Controllers"]

PATIENCE = 15.0  # [s] after which a controller that does not answer has handed over


class Controllers:
    """The first page with the token controls, until it is closed or hands over.

    Attributes:
        page: that controls; None if none does.
    """

    def __init__(self) -> None:
        self.page: Page | None = None
        self._able: dict[int, Page] = {}
        self._asking: Page | None = None
        self._until = 0.0  # when the asking page takes control

    def open(self, page: Page) -> None:
        """A page was opened."""
        if page.may_control:
            self._able[page.number] = page
            if self.page is None:
                self.page = page
            self._notify()

    def close(self, page: Page) -> None:
        """A page was closed."""
        self._able.pop(page.number, None)
        if page is self._asking:
            self._asking = None
        if page is self.page:
            self._hand_over()
        self._notify()

    def act(self) -> None:
        """Hand over from a page that does not answer."""
        if self._asking is not None and time.monotonic() >= self._until:
            self._hand_over()
            self._notify()

    def request(self, page: Page, what: str) -> None:
        """What a page wants: ask, take, give, keep.

        Raises:
            GazeboError: it cannot have that.
        """
        if not page.may_control:
            raise GazeboError("this address has no valid token: its pages only watch")
        if what in ("ask", "take"):
            if self.page is None:
                self.page = page
            elif page is not self.page and self._asking is None:
                self._asking, self._until = page, time.monotonic() + PATIENCE
            elif page is not self.page and page is not self._asking:
                raise GazeboError("another page asks for control already")
        elif what in ("give", "keep"):
            if page is not self.page:
                raise GazeboError("this page does not control the world")
            if what == "give":
                self._hand_over()
            self._asking = None
        else:
            raise GazeboError(f"control is {what!r}; allowed are ask, take, give and keep")
        self._notify()

    def _hand_over(self) -> None:
        """Give control to the page that asks for it, else to the one of the others that has been open for longest."""
        others = (page for page in self._able.values() if page is not self.page)
        self.page, self._asking = self._asking or next(others, None), None

    def state_of(self, page: Page) -> dict[str, Any]:
        """What a page shows of who controls."""
        here = page is self.page
        return {
            "here": here,
            "other": len(self._able) > 1 if here else self.page is not None,
            "canAsk": page.number in self._able and not here,
            "asked": f"page {self._asking.number}" if here and self._asking is not None else "",
        }

    def _notify(self) -> None:
        for page in self._able.values():
            page.post("control", json.dumps({"control": self.state_of(page)}))
