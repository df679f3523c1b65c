"""How models create their interfaces."""

from __future__ import annotations

from typing import Any

from libgz.legacy.model import Model
from libgz.transport.interface import Interface

__all__ = ["serve"]


def serve(model: Model, interface: Interface[Any]) -> None:
    """Create an interface under the model's id on the server of its world.

    Raises:
        InterfaceError: the id is invalid, or the interface's file cannot be created.
    """
    interface.create(model.world.gz_server, model.GetId(), model.GetName(), model.GetIntId(), model.GetParentIntId())
