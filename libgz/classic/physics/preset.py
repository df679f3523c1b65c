"""PresetManager: the `<physics>` elements of a world as profiles to switch between."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.errors import NotFoundError, nearest
from libgz.sdf.element import Element
from libgz.sdfworld.world import SdfWorld

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["PresetManager"]

# Engine parameters and where a <physics> element has them.
PLACES = {
    "max_step_size": (),
    "real_time_update_rate": (),
    "max_contacts": (),
    "solver_type": ("ode", "solver", "type"),
    "iters": ("ode", "solver"),
    "sor": ("ode", "solver"),
    "erp": ("ode", "constraints"),
    "cfm": ("ode", "constraints"),
    "contact_max_correcting_vel": ("ode", "constraints"),
    "contact_surface_layer": ("ode", "constraints"),
}


def read_profile(element: Element) -> dict[str, Any]:
    """Engine parameters of a `<physics>` element."""
    found: dict[str, Any] = {}
    for key, path in PLACES.items():
        holder = element
        for name in path[:2]:
            holder = holder.child(name)
        kind = int if key in ("iters", "max_contacts") else str if key == "solver_type" else float
        found[key] = holder.Get(kind, path[2] if len(path) == 3 else key)
    return found


class PresetManager:
    """The profiles of a world."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._profiles: dict[str, dict[str, Any]] = {}
        self._current = ""
        self._settings = world.core.extension(SdfWorld).settings
        for name, element in self._settings.profiles.items():
            self._profiles[name] = read_profile(element)
            if element is self._settings.physics:
                self._current = name

    def AllProfiles(self) -> list[str]:
        """The names of all profiles."""
        return list(self._profiles)

    def HasProfile(self, name: str) -> bool:
        """Whether there is a profile of this name."""
        return name in self._profiles

    def CurrentProfile(self, name: str | None = None) -> str | bool:
        """The name of the profile in force; with a name, take that one: true.

        Raises:
            NotFoundError: there is no such profile.
        """
        if name is None:
            return self._current
        parameters = self._profile(name)
        if name in self._settings.profiles:
            self._world.core.extension(SdfWorld).apply_profile(name)
        for key, value in parameters.items():  # as they were set since
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
        """Add a profile with the present parameters; its name."""
        physics = self._world.Physics()
        self._profiles[name] = {key: physics.GetParam(key) for key in PLACES}
        return name

    def RemoveProfile(self, name: str) -> None:
        """Take a profile out."""
        self._profiles.pop(name, None)

    def ProfileParam(self, name: str, key: str) -> Any:
        """A parameter of a profile."""
        return self._profile(name).get(key)

    def SetProfileParam(self, name: str, key: str, value: Any) -> bool:
        """Set a parameter of a profile, and of the engine if the profile is in force; true."""
        self._profile(name)[key] = value
        if name == self._current:
            self._world.Physics().SetParam(key, value)
        return True

    def CurrentProfileParam(self, key: str) -> Any:
        """A parameter of the profile in force."""
        return self.ProfileParam(self._current, key)

    def SetCurrentProfileParam(self, key: str, value: Any) -> bool:
        """Set a parameter of the profile in force; true."""
        return self.SetProfileParam(self._current, key, value)
