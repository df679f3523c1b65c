"""Atmosphere: temperature, pressure and density of the air of a world."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import ParameterError, nearest
from libgz.classic.names import takes_names
from libgz.physics.check import finite, not_negative
from libgz.sdfworld.air import GAS_CONSTANT, MOLAR_MASS
from libgz.sdfworld.world import SdfWorld

if TYPE_CHECKING:
    from libgz.classic.physics.world import World
    from libgz.sdfworld.air import Atmosphere as Air

__all__ = ["Atmosphere"]


@takes_names
class Atmosphere:
    """The air of a world: its temperature changes linearly with altitude, pressure and density as gravity asks."""

    MOLAR_MASS: ClassVar[float] = MOLAR_MASS  # [kg/mol]
    IDEAL_GAS_CONSTANT_R: ClassVar[float] = GAS_CONSTANT  # [J/(mol K)]
    KEYS: ClassVar[tuple[str, ...]] = ("type", "temperature", "temperature_gradient", "pressure", "mass_density")

    def __init__(self, world: World) -> None:
        self._world = world

    @property
    def _air(self) -> Air:
        return self._world.core.extension(SdfWorld).settings.atmosphere

    def _gravity(self) -> float:
        return math.hypot(*self._world.core.engine.gravity)

    def Type(self) -> str:
        """`adiabatic`."""
        return "adiabatic"

    def Temperature(self, altitude: float = 0.0) -> float:
        """The temperature at an altitude [m] in K."""
        return self._air.temperature_at(altitude)

    def SetTemperature(self, temperature: float) -> None:
        """Set the temperature at altitude 0 [K].

        Raises:
            ParameterError: it is negative, or not finite.
        """
        self._air.temperature = finite(not_negative(temperature, "temperature [K]"), "temperature [K]")

    def TemperatureGradient(self) -> float:
        """How the temperature changes with altitude [K/m]."""
        return self._air.gradient

    def SetTemperatureGradient(self, gradient: float) -> None:
        """Set how the temperature changes with altitude [K/m].

        Raises:
            ParameterError: it is not finite.
        """
        self._air.gradient = finite(gradient, "temperature gradient [K/m]")

    def Pressure(self, altitude: float = 0.0) -> float:
        """The pressure at an altitude [m] in Pa."""
        return self._air.pressure_at(altitude, self._gravity())

    def SetPressure(self, pressure: float) -> None:
        """Set the pressure at altitude 0 [Pa].

        Raises:
            ParameterError: it is negative, or not finite.
        """
        self._air.pressure = finite(not_negative(pressure, "pressure [Pa]"), "pressure [Pa]")

    def MassDensity(self, altitude: float = 0.0) -> float:
        """The mass density at an altitude [m] in kg/m^3."""
        return self._air.density_at(altitude, self._gravity())

    def SetParam(self, key: str, value: Any) -> bool:
        """Set `temperature`, `temperature_gradient` or `pressure`; false for another key."""
        setters = {
            "temperature": self.SetTemperature,
            "temperature_gradient": self.SetTemperatureGradient,
            "pressure": self.SetPressure,
        }
        if key not in setters:
            return False
        setters[key](value)
        return True

    def Param(self, key: str) -> Any:
        """A parameter: `type`, `temperature`, `temperature_gradient`, `pressure` or `mass_density`.

        Raises:
            ParameterError: another key.
        """
        values: tuple[Callable[[], Any], ...] = (
            self.Type,
            self.Temperature,
            self.TemperatureGradient,
            self.Pressure,
            self.MassDensity,
        )
        if key not in self.KEYS:
            raise ParameterError(
                f"atmosphere has no parameter {key!r}; it has {', '.join(self.KEYS)}{nearest(key, self.KEYS)}"
            )
        return dict(zip(self.KEYS, values, strict=True))[key]()

    GetParam = Param
