"""Stock: the models that can be inserted into a running world by name, each with its title and where it is from."""

from __future__ import annotations

import contextlib
import functools
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

from libgz.base.errors import GazeboError, NotFoundError
from libgz.base.files import read_limited, xml_parser, xml_text
from libgz.front import World
from libgz.sdf.paths import BUILT_IN, find_model, model_directories
from libgz.worldfile.file import WorldFile
from libgz.worldfile.search import ready_worlds

__all__ = ["SHAPES", "Item", "Stock", "sdf_shape"]

MOST_LISTED = 2000  # with their titles
LONGEST_TITLE, LONGEST_ABOUT = 80, 300  # characters
SCENERY = frozenset({"LightSource", "GroundPlane", "ObserverCam", "SkyDome"})  # of a ready world: nobody looks for them
SHAPES = {
    "box": "<box><size>1 1 1</size></box>",
    "sphere": "<sphere><radius>0.5</radius></sphere>",
    "cylinder": "<cylinder><radius>0.5</radius><length>1</length></cylinder>",
}


@dataclass(frozen=True)
class Item:
    """A model that can be inserted.

    Attributes:
        name: by which it is inserted.
        title: for users.
        group: where it is from.
        about: a line about it; may be empty.
    """

    name: str
    title: str
    group: str
    about: str = ""


@dataclass(frozen=True)
class _Ready:
    """A model of a world that is installed with libgz."""

    path: Path
    index: int  # among the models of the file
    item: Item


class Stock:
    """The models for a world of its era.

    Args:
        world: into which they are inserted.
    """

    def __init__(self, world: World) -> None:
        self._world = world

    def names(self) -> list[str]:
        """All names."""
        if self._world.sdf is None:
            from libgz.reference.catalogue import entries

            return [*(one.name for one in entries()), *_ready_models()]
        return [*SHAPES, *sorted(_folders())]

    def items(self) -> list[Item]:
        """The first ones, with their titles."""
        if self._world.sdf is None:
            from libgz.reference.catalogue import entries

            own = [Item(one.name, one.name, "built-in", one.summary) for one in entries()]
            return [*own, *(one.item for one in _ready_models().values())][:MOST_LISTED]
        shapes = [Item(name, name, "shapes") for name in SHAPES]
        return [*shapes, *(_described(name, folder) for name, folder in sorted(_folders().items()))][:MOST_LISTED]

    def text(self, name: str) -> str:
        """What is inserted for a name: an element of a worldfile or of an SDF world, with ids that are free.

        Raises:
            NotFoundError: there is no such model.
        """
        taken = {entity.GetId() for entity in self._world.entities}
        if self._world.sdf is not None:
            return (
                sdf_shape(name)
                if name in SHAPES
                else f"<include><uri>{xml_text(str(find_model(name)))}</uri></include>"
            )
        ready = _ready_models().get(name)
        if ready is not None:
            from libgz.legacy.editor import copied_text

            return copied_text(WorldFile.from_file(ready.path), ready.index, taken)
        from libgz.reference.catalogue import entry

        found = entry(name)
        return f"<model:{found.name}>\n  <id>{self.free(name.lower())}</id>\n</model:{found.name}>"

    def free(self, stem: str) -> str:
        """An id that no model of the world has: `robot3`."""
        taken = {entity.GetId() for entity in self._world.entities}
        return next(f"{stem}{i}" for i in range(1, len(taken) + 2) if f"{stem}{i}" not in taken)


@functools.cache
def _ready_models() -> dict[str, _Ready]:
    """The models of the installed legacy worlds, by names such as ``pioneer2at/crate``."""
    found = {}
    for world in ready_worlds():
        with contextlib.suppress(GazeboError):  # one of SDF
            file = WorldFile.from_file(world.path)
            for index, node in enumerate(file.models):
                given = (node.GetString("id", "") or "").strip()
                top = node.parent is not None and node.parent.prefix == "gz"
                if top and given and node.GetName() not in SCENERY:
                    name, inside = (
                        f"{world.name}/{given}",
                        [one.GetName() for one in node.walk() if one.prefix == "model"],
                    )
                    about = f"{', '.join(dict.fromkeys(inside))} of the world {world.name}. {world.summary}"
                    item = Item(name, f"{node.GetName()} {given}", f"world {world.name}", about[:LONGEST_ABOUT])
                    found[name] = _Ready(world.path, index, item)
    return found


def _folders() -> dict[str, Path]:
    """The folders of the models that SDF worlds include, by their URIs."""
    roots = {root: sorted(path.parent for path in root.glob("*/model.config")) for root in model_directories()}
    return {f"model://{folder.name}": folder for folders in reversed(roots.values()) for folder in folders}


def _described(name: str, folder: Path) -> Item:
    """A model by what its `model.config` says."""
    title, about = folder.name, ""
    with contextlib.suppress(OSError, NotFoundError, etree.XMLSyntaxError):
        config = etree.fromstring(read_limited(folder / "model.config"), xml_parser())
        title = (config.findtext("name") or "").strip()[:LONGEST_TITLE] or title
        about = " ".join((config.findtext("description") or "").split())[:LONGEST_ABOUT]
    return Item(name, title, "libgz" if folder.parent == BUILT_IN else str(folder.parent), about)


def sdf_shape(name: str) -> str:
    """A model of SDF that is one of `SHAPES`."""
    shape = SHAPES[name]
    parts = "".join(f"<{part} name='{part}'><geometry>{shape}</geometry></{part}>" for part in ("collision", "visual"))
    return f"<model name='{name}'><link name='link'><pose>0 0 0.5 0 0 0</pose>{parts}</link></model>"
