"""Conversion of UTM coordinates to latitude and longitude on the WGS84 ellipsoid.

By Krueger's series to the third order in n; within a zone their error is about a tenth of a millimetre.
"""

from __future__ import annotations

import math

__all__ = ["utm_to_geodetic"]

SEMI_MAJOR = 6378137.0  # [m]
FLATTENING = 1.0 / 298.257223563
SCALE = 0.9996  # on the central meridian
FALSE_EASTING = 500000.0  # [m]
FALSE_NORTHING = 10000000.0  # [m] in the south

_N = FLATTENING / (2.0 - FLATTENING)
_RADIUS = SEMI_MAJOR / (1.0 + _N) * (1.0 + _N**2 / 4.0 + _N**4 / 64.0)
_BETA = (
    _N / 2.0 - 2.0 * _N**2 / 3.0 + 37.0 * _N**3 / 96.0,
    _N**2 / 48.0 + _N**3 / 15.0,
    17.0 * _N**3 / 480.0,
)
_DELTA = (
    2.0 * _N - 2.0 * _N**2 / 3.0 - 2.0 * _N**3,
    7.0 * _N**2 / 3.0 - 8.0 * _N**3 / 5.0,
    56.0 * _N**3 / 15.0,
)


def utm_to_geodetic(easting: float, northing: float, zone: int) -> tuple[float, float]:
    """(latitude, longitude) [deg], north and east positive.

    Args:
        easting: [m].
        northing: [m].
        zone: 1 to 60, negative for the southern hemisphere.
    """
    north = northing - (FALSE_NORTHING if zone < 0 else 0.0)
    xi, eta = north / (SCALE * _RADIUS), (easting - FALSE_EASTING) / (SCALE * _RADIUS)
    xi1, eta1 = xi, eta
    for j, beta in enumerate(_BETA, 1):
        xi1 -= beta * math.sin(2 * j * xi) * math.cosh(2 * j * eta)
        eta1 -= beta * math.cos(2 * j * xi) * math.sinh(2 * j * eta)
    chi = math.asin(max(-1.0, min(1.0, math.sin(xi1) / math.cosh(eta1))))
    latitude = chi + sum(delta * math.sin(2 * j * chi) for j, delta in enumerate(_DELTA, 1))
    longitude = math.atan2(math.sinh(eta1), math.cos(xi1))
    return math.degrees(latitude), math.degrees(longitude) + 6.0 * abs(zone) - 183.0
