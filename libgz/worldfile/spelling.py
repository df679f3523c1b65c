"""Older spellings: the tags of Gazebo 0.3 and 0.4, read as their successors in 0.5.

Each element's own tags decide, whatever the file's age. Where both spellings are present, the newer one counts.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from libgz.worldfile.number import atof

__all__ = [
    "IGNORED",
    "IMPLIED",
    "NAMES_ONLY",
    "OLD_ORIGIN_HEIGHT",
    "OLD_TAGS",
    "Renamed",
    "ignored_tags",
    "renamed_keys",
    "renamed_tags",
]

DEFAULT_STEP = 0.02  # [s]


class Renamed(NamedTuple):
    """An older place of an attribute: its path below the model, and the conversion of its text to the newer form."""

    path: tuple[str, ...]
    convert: Callable[[str, float], str] = lambda text, _step: text


def _rate_of_period(text: str, _step: float) -> str:
    """A period [s] as a rate [Hz]."""
    period = atof(text)
    return repr(1.0 / period) if period > 0.0 else "0"


def _hardness_of_cfm(text: str, step: float) -> str:
    """ODE's constraint force mixing as a spring: kp = 1 / (step cfm) [N/m], without a damper."""
    cfm = atof(text)
    return f"{1.0 / (step * cfm)!r} 0" if cfm > 0.0 else "inf 0"


def _is(word: str) -> Callable[[str, float], str]:
    return lambda text, _step: "true" if text.strip().lower() == word else "false"


_EVERYWHERE: dict[str, tuple[Renamed, ...]] = {
    "xyz": (Renamed(("pos",)),),
    "rpy": (Renamed(("rot",)),),
    "updateRate": (Renamed(("updatePeriod",), _rate_of_period),),
    "imageSize": (Renamed(("imgSize",)), Renamed(("window", "size"))),
    "hfov": (Renamed(("lens", "hfov")),),
    "nearClip": (Renamed(("lens", "nearClip")),),
    "farClip": (Renamed(("lens", "farClip")),),
    "textureFile": (Renamed(("texture2D",)),),
}
_BY_MODEL: dict[str, dict[str, tuple[Renamed, ...]]] = {
    "ObserverCam": {
        "displayRays": (Renamed(("displayLaser",)),),
        "shadeSmooth": (Renamed(("shadeModel",), _is("smooth")),),
        "polygonFill": (Renamed(("polygonMode",), _is("fill")),),
    },
    "SimpleSolid": {"surfaceHardness": (Renamed(("cfm",), _hardness_of_cfm),)},
}

# Paths that have no counterpart and change nothing, by model; "" is every model.
IGNORED: dict[str, tuple[tuple[str, ...], ...]] = {
    "": (
        ("window",),
        ("window", "title"),
        ("window", "pos"),
        ("window", "xyz"),
        ("window", "enableInput"),
        ("lens",),
        ("lens", "vfov"),
        ("canBeGrip",),
    ),
    "SonyVID30": (("displayLaser",),),
    "CanonVCC4": (("displayLaser",),),
    "MonoCam": (("displayLaser",),),
    "GroundPlane": (("cfm",),),
    "Terrain": (("errorBound",),),
}

# Attributes that models of a file of 0.4 have without naming them: model -> key -> text.
IMPLIED: dict[str, dict[str, str]] = {"SegwayRMP": {"softLanding": "true"}}

# A file with a model that has one of these children, or of one of these kinds, was written for 0.4.
OLD_TAGS = frozenset({"window", "lens", "updatePeriod", "displayLaser", "imgSize", "cfm"})
OLD_MODELS = frozenset({"MapExtruder", "Pioneer2Sonars"})

# Models of 0.4 of which only the name is known -> end of the warning about them.
NAMES_ONLY = {
    "PointSet": "; its attributes are not documented: it only displayed points, without collisions",
    "TotemPole": "; its attributes are not documented: SimpleSolids on top of each other can replace it",
}

# Height of the origin of 0.4 above that of 0.5 [m]; SimpleSolid's was at its centre.
OLD_ORIGIN_HEIGHT = {"SickLMS200": 0.10, "Pioneer2AT": 0.195}


def renamed_tags(model: str, key: str) -> tuple[Renamed, ...]:
    """Older places of `key` in a model of this kind."""
    return _BY_MODEL.get(model, {}).get(key, ()) + _EVERYWHERE.get(key, ())


def renamed_keys(model: str) -> tuple[str, ...]:
    """All keys that have older places in a model of this kind."""
    return (*_BY_MODEL.get(model, {}), *_EVERYWHERE)


def ignored_tags(model: str) -> tuple[tuple[str, ...], ...]:
    """Paths that are known and without effect in a model of this kind."""
    return IGNORED[""] + IGNORED.get(model, ())
