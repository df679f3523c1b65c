"""PresetManager: physics profiles of a world: its `<physics>` elements, and those created at run time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, nearest
from libgz.classic.names import takes_names
from libgz.sdfworld.physics import PHYSICS, read_physics
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.state import encode

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["PresetManager"]


@takes_names
class PresetManager:
    """The physics profiles of a world."""

    STATE = ("_profiles", "_current")

    def __init__(self, world: World) -> None:
        self._world = world
        self._profiles: dict[str, dict[str, Any]] = {}
        self._current = ""
        self._settings = world.core.extension(SdfWorld).settings
        for name, element in self._settings.profiles.items():
            self._profiles[name] = read_physics(element)
            if element is self._settings.physics:
                self._current = name

    def AllProfiles(self) -> list[str]:
        """The names of all profiles, sorted."""
        return sorted(self._profiles)

    def HasProfile(self, name: str) -> bool:
        """Whether there is a profile of this name."""
        return name in self._profiles

    def CurrentProfile(self, name: str | None = None) -> str | bool:
        """The name of the current profile, empty once it was removed; with a name, switch to that one, and return True.

        Raises:
            NotFoundError: there is no such profile.
        """
        if name is None:
            return self._current
        parameters = self._profile(name)
        if name in self._settings.profiles:
            self._world.core.extension(SdfWorld).apply_profile(name)
        for key, value in list(parameters.items()):  # they may have been changed since
            self._world.Physics().SetParam(key, value)
        self._current = name
        return True

    def _profile(self, name: str) -> dict[str, Any]:
        if name not in self._profiles:
            known = ", ".join(self._profiles) or "none"
            hint = nearest(name, self._profiles)
            raise NotFoundError(f"Specified profile [{name}] was not found; there are {known}{hint}")
        return self._profiles[name]

    def CreateProfile(self, name: str) -> str:
        """Add a profile with the present parameters; returns its name."""
        physics = self._world.Physics()
        self._profiles[name] = {key: physics.GetParam(key) for key in PHYSICS}
        return name

    def RemoveProfile(self, name: str) -> None:
        """Remove a profile."""
        self._profiles.pop(name, None)
        if name == self._current:
            self._current = ""

    def ProfileParam(self, name: str, key: str) -> Any:
        """A parameter of a profile."""
        return self._profile(name).get(key)

    def SetProfileParam(self, name: str, key: str, value: Any) -> bool:
        """Set a parameter of a profile, and of the engine if it is the current one; returns True.

        Raises:
            NotFoundError: there is no such profile.
            ParameterError: the engine does not take the value, or a state could not hold it.
        """
        profile = self._profile(name)
        encode(value)
        if name == self._current:
            self._world.Physics().SetParam(key, value)
        profile[key] = value
        return True

    def CurrentProfileParam(self, key: str) -> Any:
        """A parameter of the current profile."""
        return self.ProfileParam(self._current, key)

    GetProfileParam, GetCurrentProfileParam = ProfileParam, CurrentProfileParam

    def SetCurrentProfileParam(self, key: str, value: Any) -> bool:
        """Set a parameter of the current profile; returns True."""
        return self.SetProfileParam(self._current, key, value)
