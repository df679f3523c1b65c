"""Places on the globe, and the world's frame there."""

import math

import pytest
from hypothesis import given, strategies as st

from libgz.base.errors import ParameterError
from libgz.classic.common import (
    SphericalCoordinates,
)
from libgz.classic.math import Angle, Vector3d

ECEF, GLOBAL, LOCAL, SPHERICAL = (
    SphericalCoordinates.ECEF,
    SphericalCoordinates.GLOBAL,
    SphericalCoordinates.LOCAL,
    SphericalCoordinates.SPHERICAL,
)


def test_known_points_of_the_earth():
    """Two points of California; their earth-centred coordinates are as gdaltransform (EPSG:4978) gives them."""
    osrf = (math.radians(37.3877349), math.radians(-122.0651166), 32.0)
    sc = SphericalCoordinates(SphericalCoordinates.EARTH_WGS84, osrf[0], osrf[1], osrf[2])
    ecef = sc.PositionTransform(osrf, SPHERICAL, ECEF)
    assert ecef.Equal((-2693701.91434394, -4299942.14687992, 3851691.0393571), 1e-3)
    assert sc.PositionTransform(ecef, ECEF, SPHERICAL).Equal(osrf, 1e-8)
    other = sc.LocalFromSpherical((37.4216719, -122.0821853, 30.0))
    assert other.Equal((-1510.88, 3766.64, -3.29), 0.1)  # by transverse Mercator, which is no tangent plane
    assert sc.SphericalFromLocal(other).Equal((37.4216719, -122.0821853, 30.0), 1e-6)
    equator = SphericalCoordinates()
    assert equator.PositionTransform((0, 0, 0), LOCAL, ECEF) == Vector3d(6378137.0, 0, 0)
    pole = equator.PositionTransform((0, 0, 6356752.3142 + 100.0), ECEF, SPHERICAL)
    assert pole.Equal((math.pi / 2, 0, 100.0), 1e-3)


def test_the_heading_turns_the_world_from_east_towards_north():
    sc = SphericalCoordinates(1, Angle(0.3), Angle(-1.2), 354.1, Angle.HalfPi)
    assert sc.GlobalFromLocal((1, 0, 0)).Equal((0, 1, 0), 1e-12)
    assert sc.GlobalFromLocal((2243.5, 556.35, 435.7)).Equal((-556.35, 2243.5, 435.7), 1e-9)
    assert sc.LocalFromGlobal((0, 1, 0)).Equal((1, 0, 0), 1e-12)
    assert sc.SphericalFromLocal((0, 0, 0)).Equal((math.degrees(0.3), math.degrees(-1.2), 354.1), 1e-6)
    north = sc.SphericalFromLocal((2e5, 0, 0))  # on a flat plane, so 3 km higher
    assert north.x == pytest.approx(math.degrees(0.3) + 1.8, abs=0.01)
    assert north.y == pytest.approx(math.degrees(-1.2), abs=1e-9)
    assert north.z == pytest.approx(354.1 + 4e10 / (2 * 6.35e6), rel=0.01)
    assert sc.LocalFromSpherical(north).Equal((2e5, 0, 0), 1e-3)
    up = sc.VelocityTransform((0, 0, 1), LOCAL, ECEF)
    assert up.Equal((math.cos(0.3) * math.cos(-1.2), math.cos(0.3) * math.sin(-1.2), math.sin(0.3)), 1e-12)


latitudes, longitudes = st.floats(-1.57, 1.57), st.floats(-3.14, 3.14)
frames = st.sampled_from([ECEF, GLOBAL, LOCAL])


@given(latitudes, longitudes, st.floats(-100.0, 9000.0), longitudes, frames, frames)
def test_positions_and_velocities_come_back(latitude, longitude, elevation, heading, a, b):
    sc = SphericalCoordinates(1, latitude, longitude, elevation, heading)
    at_ecef = sc.PositionTransform((120.0, -40.0, 7.0), LOCAL, ECEF)
    in_a = sc.PositionTransform(at_ecef, ECEF, a)
    assert sc.PositionTransform(sc.PositionTransform(in_a, a, b), b, a).Equal(in_a, 1e-6)
    in_degrees = sc.SphericalFromLocal((120.0, -40.0, 7.0))
    assert sc.LocalFromSpherical(in_degrees).Equal((120.0, -40.0, 7.0), 1e-4)
    v = sc.VelocityTransform((1.0, 2.0, 3.0), a, b)
    assert v.Length() == pytest.approx(math.sqrt(14.0))
    assert sc.VelocityTransform(v, b, a).Equal((1.0, 2.0, 3.0), 1e-9)


def test_metres_on_the_ground_are_those_of_the_ellipsoids_radii():
    """Radii of curvature from south to north and from west to east, by their definition."""
    latitude, e2 = 0.8, 0.00669437999014
    w = math.sqrt(1 - e2 * math.sin(latitude) ** 2)
    meridian, normal = 6378137.0 * (1 - e2) / w**3, 6378137.0 / w
    sc = SphericalCoordinates(1, latitude, 0.5)
    moved = sc.PositionTransform((10.0, 10.0, 0.0), LOCAL, SPHERICAL)
    assert (moved.x - latitude) * meridian == pytest.approx(10.0, abs=1e-4)
    assert (moved.y - 0.5) * normal * math.cos(latitude) == pytest.approx(10.0, abs=1e-4)


def test_distances_on_the_globe():
    angles = [Angle(math.radians(a)) for a in (46.250944, -122.249972, 46.124953, -122.251683)]
    assert SphericalCoordinates.Distance(*angles) == pytest.approx(14002, abs=20)
    assert SphericalCoordinates.Distance(0.0, 0.0, 0.0, math.pi) == pytest.approx(math.pi * 6371000)


def test_the_reference_of_the_globe_can_be_set():
    sc = SphericalCoordinates()
    sc.SetLatitudeReference(Angle(0.3))
    sc.SetLongitudeReference(-1.2)
    sc.SetElevationReference(354.1)
    sc.SetHeadingOffset(0.5)
    assert sc == SphericalCoordinates(1, 0.3, -1.2, 354.1, 0.5)
    assert (sc.LatitudeReference(), sc.GetLongitudeReference(), sc.GetElevationReference()) == (0.3, -1.2, 354.1)
    assert sc.HeadingOffset() == 0.5
    assert sc.GetSurfaceType() == SphericalCoordinates.Convert("EARTH_WGS84") == SphericalCoordinates.EARTH_WGS84
    assert SphericalCoordinates.Convert(1) == "EARTH_WGS84"
    assert sc.SphericalFromLocal((0, 0, 0)).Equal((math.degrees(0.3), math.degrees(-1.2), 354.1), 1e-6)
    with pytest.raises(ParameterError, match="EARTH_WGS84"):
        SphericalCoordinates.Convert("MOON")
    with pytest.raises(ParameterError, match="surface 7"):
        SphericalCoordinates(7)
    with pytest.raises(ParameterError, match="frame 9"):
        sc.PositionTransform((0, 0, 0), 9, ECEF)
    with pytest.raises(ParameterError, match="no velocities"):
        sc.VelocityTransform((0, 0, 0), SPHERICAL, ECEF)
