"""The air of a world: its wind, and how temperature, pressure and density change with altitude."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from libgz.base.errors import Diagnostics, ParameterError
from libgz.base.geometry import GzVector
from libgz.physics.check import finite_tuple
from libgz.sdf.element import Element

__all__ = ["Atmosphere", "Wind", "read_atmosphere", "read_wind"]

MOLAR_MASS = 0.0289644  # of dry air [kg/mol]
GAS_CONSTANT = 8.3144621  # [J/(mol K)]


@dataclass(eq=False, repr=False)
class Wind:
    """The wind of a world; links with `Body.in_wind` feel it by what asks for it, such as WindPlugin.

    Attributes:
        velocity: global [m/s].
        enabled: while it is not, there is no wind.
    """

    velocity: GzVector = field(default_factory=GzVector)
    enabled: bool = True
    facade: Any = None  # by which the API of a layer above presents it; set by that layer


@dataclass(eq=False, repr=False)
class Atmosphere:
    """Air whose temperature changes linearly with altitude (Manual of the ICAO Standard Atmosphere, eq. 17, 18, 33).

    Attributes:
        temperature: at altitude 0 [K].
        gradient: of the temperature [K/m].
        pressure: at altitude 0 [Pa].
        enabled: kept for what asks; the numbers do not depend on it.
    """

    temperature: float = 288.15
    gradient: float = -0.0065
    pressure: float = 101325.0
    enabled: bool = True
    facade: Any = None  # as that of the wind

    def temperature_at(self, altitude: float) -> float:
        """The temperature at an altitude [m] in K."""
        return self.temperature + self.gradient * altitude

    def pressure_at(self, altitude: float, gravity: float) -> float:
        """The pressure at an altitude [m] in Pa, with gravity [m/s^2]; 0 where there is no air any more."""
        return self.pressure * self._share(altitude, gravity, 0.0)

    def density_at(self, altitude: float, gravity: float) -> float:
        """The mass density at an altitude [m] in kg/m^3, with gravity [m/s^2]; 0 where there is no air any more."""
        if abs(self.temperature) < 1e-6:
            return 0.0
        ground = MOLAR_MASS * self.pressure / (GAS_CONSTANT * self.temperature)
        return ground * self._share(altitude, gravity, -1.0)

    def _share(self, altitude: float, gravity: float, more: float) -> float:
        """The share of the value at altitude 0: a power law, or the exponential that it becomes without a gradient."""
        if abs(self.temperature) < 1e-6:
            return 0.0
        if abs(self.gradient) < 1e-12:
            return math.exp(-MOLAR_MASS * gravity * altitude / (GAS_CONSTANT * self.temperature))
        base = 1.0 + self.gradient * altitude / self.temperature
        power = -MOLAR_MASS * gravity / (self.gradient * GAS_CONSTANT)
        return float(base ** (power + more)) if base > 0.0 else 0.0


def read_wind(world: Element) -> Wind:
    """The `<wind>` of a `<world>`.

    Raises:
        ParameterError: the velocity is not three finite numbers.
    """
    if not world.HasElement("wind"):
        return Wind()
    element = world.child("wind")
    if not element.HasElement("linear_velocity"):
        return Wind()
    velocity = element.Get(GzVector, "linear_velocity")
    return Wind(GzVector(*finite_tuple(velocity, 3, "linear_velocity [m/s]")))


def read_atmosphere(world: Element, diagnostics: Diagnostics) -> Atmosphere:
    """The `<atmosphere>` of a `<world>`.

    Raises:
        ParameterError: temperature or pressure is negative, or not finite.
    """
    if not world.HasElement("atmosphere"):
        return Atmosphere()
    element = world.child("atmosphere")
    kind = element.Get(str, "type")
    if kind != "adiabatic":
        diagnostics.warn(element, f"there is no atmosphere of type {kind!r}; it is adiabatic")
    keys = ("temperature", "temperature_gradient", "pressure")
    temperature, gradient, pressure = (element.Get(float, key) for key in keys)
    if not (0.0 <= temperature < math.inf and 0.0 <= pressure < math.inf and math.isfinite(gradient)):
        raise ParameterError(
            f"temperature {temperature:g} K, temperature_gradient {gradient:g} K/m and pressure {pressure:g} Pa must "
            "be finite, temperature and pressure not negative"
        )
    return Atmosphere(temperature, gradient, pressure)
