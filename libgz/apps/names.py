"""What `libgz help NAME` prints: the reference of a model, an interface, or a name of either API."""

from __future__ import annotations

import re

from libgz.apps import api_pages
from libgz.base.errors import ParameterError, nearest
from libgz.interfaces.catalog import INTERFACES
from libgz.interfaces.reference import describe as describe_interface
from libgz.models import MODELS
from libgz.reference import classic_pages
from libgz.reference.catalogue import entry
from libgz.reference.markdown import NOTE
from libgz.reference.pages import page

__all__ = ["reference_of"]


def reference_of(name: str) -> str:
    """The reference of all that has this name, as Markdown without links.

    Args:
        name: a model (`SickLMS200`), an interface (`position`), a class or function of `libgz` (`World`), or of
            `libgz.classic` (`Link`, `physics.Link`, `physics`, `SetLinearVel`).

    Raises:
        ParameterError: nothing has this name.
    """
    found = [page(entry(name))] if name in MODELS else []
    found += [describe_interface(name), api_pages.describe(name), classic_pages.describe(name)]
    text = "\n".join(part.replace(NOTE, "").strip("\n") + "\n" for part in found if part)
    if not text:
        known = [*MODELS, *INTERFACES, *(word for names in api_pages.api_names().values() for word in names)]
        raise ParameterError(f"no command, model, interface or class is called {name!r}{nearest(name, known)}")
    return re.sub(r"\[([^\]\n]+)\]\([^)\n]*\)", r"\1", text)
