"""ModelDatabase: the models on the search path."""

from __future__ import annotations

import os

from lxml import etree

from libgz.base.errors import NotFoundError
from libgz.base.files import is_file, open_file
from libgz.classic.names import takes_names
from libgz.sdf.paths import find_model, find_uri, model_directories

__all__ = ["ModelDatabase"]


@takes_names
class ModelDatabase:
    """The models of GAZEBO_MODEL_PATH and of libgz. Nothing is downloaded."""

    _instance: ModelDatabase | None = None

    @classmethod
    def Instance(cls) -> ModelDatabase:
        """The only one."""
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    def GetURI(self) -> str:
        """The address of a database: empty, for nothing is downloaded."""
        return ""

    def GetModelPath(self, uri: str, forceDownload: bool = False) -> str:
        """The folder of a model, by ``model://name``; an empty string if there is none."""
        try:
            return str(find_uri(uri))
        except NotFoundError:
            return ""

    def GetModelFile(self, uri: str) -> str:
        """The SDF file of a model, by ``model://name``; an empty string if there is none."""
        try:
            return str(find_model(uri))
        except NotFoundError:
            return ""

    def HasModel(self, name: str) -> bool:
        """Whether there is a model, by ``model://name``."""
        return bool(self.GetModelFile(name))

    def GetModelName(self, uri: str) -> str:
        """The name in the model.config of a model; an empty string if there is none."""
        return self._name(self.GetModelPath(uri))

    @staticmethod
    def _name(folder: str) -> str:
        try:
            config = f"{folder}/model.config"
            with open_file(config):  # which checks it
                root = etree.parse(os.fsencode(config), etree.XMLParser(resolve_entities=False, no_network=True))
        except (OSError, etree.XMLSyntaxError):
            return ""
        return (root.findtext("name") or "").strip()

    def GetModels(self) -> dict[str, str]:
        """All models: ``model://`` and folder -> name; the first of a name on the search path counts."""
        found: dict[str, str] = {}
        for place in model_directories():
            for folder in sorted(place.iterdir()) if place.is_dir() else ():
                if is_file(folder / "model.config"):
                    found.setdefault(f"model://{folder.name}", self._name(str(folder)) or folder.name)
        return found
