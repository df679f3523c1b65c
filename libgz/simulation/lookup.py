"""Lookup: what a world holds, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.errors import InterfaceError, NotFoundError, nearest

if TYPE_CHECKING:
    from libgz.legacy.model import Model
    from libgz.physics.body import Body
    from libgz.physics.engine import Engine
    from libgz.physics.joint import Joint
    from libgz.physics.space import Space
    from libgz.transport.interface import Interface
    from libgz.transport.server import LocalServer

__all__ = ["Lookup"]


class Lookup:
    """Base of World: finds models, bodies, joints and interfaces."""

    engine: Engine
    gz_server: LocalServer
    models: list[Model]

    def GetNumModels(self) -> int:
        """How many models there are."""
        return len(self.models)

    def GetModels(self) -> list[Model]:
        """All models, in order of the worldfile."""
        return list(self.models)

    def GetSpaceId(self) -> Space:
        """The top space, in which the models' own spaces lie."""
        return self.engine.top

    def model(self, id: str) -> Model:
        """The first model with this id.

        Raises:
            NotFoundError: there is none.
        """
        for model in self.models:
            if model.GetId() == id:
                return model
        ids = [model.GetId() for model in self.models]
        raise NotFoundError(
            f"there is no model {id!r}; there are {', '.join(map(repr, ids)) or 'none'}{nearest(id, ids)}"
        )

    def body(self, model: str, name: str = "canonical") -> Body:
        """A body by the id of its model and its own name.

        Raises:
            NotFoundError: there is none.
        """
        return self.model(model).GetBody(name)

    def joint(self, model: str, name: str) -> Joint:
        """A joint by the id of its model and its own name.

        Raises:
            NotFoundError: there is none.
        """
        return self.model(model).GetJoint(name)

    def interface(self, type: str, id: str) -> Interface[Any]:
        """An interface that a model serves, by its type and id; commands to it act at the model's next tick.

        Raises:
            InterfaceError: there is none.
        """
        found = self.gz_server.interfaces.get((type, id))
        if found is None:
            names = [f"{kind}.{name}" for kind, name in self.gz_server.interfaces]
            raise InterfaceError(
                f"no model serves {type}.{id}; there are {', '.join(names) or 'none'}" + nearest(f"{type}.{id}", names)
            )
        return found
