"""Contact properties of SDF collisions: `<surface>` as rows of the engine's table."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable

from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzVector, rotate
from libgz.ode.types import Surface
from libgz.physics.check import LARGEST
from libgz.physics.geom import Geom
from libgz.physics.geoms import CapsuleGeom, CylinderGeom, PlaneGeom, SphereGeom
from libgz.sdf.element import Element

__all__ = ["set_body_surface", "set_surface"]

log = logging.getLogger("libgz.simulation")

ALL_BITS = 0xFFFFFFFF
SOFTEST = 1e-9  # [N/m] in place of a <kp> that is not above zero
POISSON = (-1.0 + 1e-9, 0.5)


def set_surface(geom: Geom, element: Element) -> None:
    """Set the contact properties of a `<collision>`; negative friction coefficients mean infinite ones."""
    surface = element.child("surface")
    contact, bounce, all_friction = surface.child("contact"), surface.child("bounce"), surface.child("friction")
    ode, friction = contact.child("ode"), all_friction.child("ode")
    geom.SetFriction(_coefficient(friction, "mu"), _coefficient(friction, "mu2"))
    geom.SetHardness(_number(ode, "kp", SOFTEST, math.inf), abs(_number(ode, "kd", -LARGEST, LARGEST)))
    x, y, z = (max(-LARGEST, min(LARGEST, v)) for v in friction.Get(GzVector, "fdir1"))
    if isinstance(geom, PlaneGeom):  # which has no frame
        turned = GzCoordPoseAdd(element.Get(GzPose, "pose"), geom.body.GetPose()).rot
        x, y, z = rotate(turned, GzVector(x, y, z))
    values: dict[int, float] = {
        Surface.FDIR1: x,
        Surface.FDIR1 + 1: y,
        Surface.FDIR1 + 2: z,
        Surface.SLIP1: _size(friction, "slip1"),
        Surface.SLIP2: _size(friction, "slip2"),
        Surface.BOUNCE: _size(bounce, "restitution_coefficient"),
        Surface.BOUNCE_VEL: bounce.Get(float, "threshold"),
        Surface.MAX_CONTACTS: element.Get(int, "max_contacts"),
        Surface.BITS: contact.Get(int, "collide_bitmask") & ALL_BITS,
        Surface.GHOST: contact.Get(bool, "collide_without_contact"),
        Surface.GHOST_BITS: contact.Get(int, "collide_without_contact_bitmask") & ALL_BITS,
    }
    torsional = all_friction.find_or_imply("torsional")  # from 1.5 on
    if torsional is not None:
        values |= {
            Surface.TORSION: _coefficient(torsional, "coefficient"),
            Surface.BY_PATCH: torsional.Get(bool, "use_patch_radius"),
            Surface.PATCH_RADIUS: _size(torsional, "patch_radius"),
            Surface.RADIUS: _size(torsional, "surface_radius"),
        }
    values |= _elasticity(geom, contact, values.get(Surface.RADIUS, 0.0))
    for column, value in values.items():
        geom.set_surface(column, float(value))


def _elasticity(geom: Geom, contact: Element, radius: float) -> dict[int, float]:
    """Of an `elastic_modulus`: the compliance, and the curvature of the surface, or else of a round shape."""
    modulus, poisson = _size(contact, "elastic_modulus"), _number(contact, "poissons_ratio", *POISSON)
    if modulus <= 0.0:
        return {}
    if radius <= 0.0 and isinstance(geom, SphereGeom | CylinderGeom | CapsuleGeom):
        radius = geom.radius
    curvature = 1.0 / radius if radius > 0.0 else 0.0
    return {Surface.COMPLIANCE: (1.0 - poisson**2) / modulus, Surface.CURVATURE: curvature}


def _number(element: Element, key: str, least: float, most: float) -> float:
    """A number within bounds; one beyond them is replaced by the nearest bound, with a warning."""
    value = element.Get(float, key)
    usable = max(least, min(most, value))
    if usable != value:
        allowed = f"it must be {least:g} to {most:g}; {usable:g} is used"
        log.warning("%s: <%s>: is %g; %s", (next(element.named(key), None) or element).where, key, value, allowed)
    return usable


def _size(element: Element, key: str) -> float:
    """A number that is not negative."""
    return max(0.0, min(LARGEST, element.Get(float, key)))


def _coefficient(element: Element, key: str) -> float:
    value = element.Get(float, key)
    return value if value >= 0.0 else math.inf


def set_body_surface(geoms: Iterable[Geom], last: Element, *, still: bool) -> None:
    """What belongs to a link as a whole, and comes from its last collision: how fast and from where it is pushed out.

    `still` things, static models and height maps, have a speed of 0; a contact with them goes by the other body.
    """
    ode = last.child("surface").child("contact").child("ode")
    speed = 0.0 if still else max(0.0, ode.Get(float, "max_vel"))
    for geom in geoms:
        geom.set_surface(Surface.MAX_VEL, speed)
        geom.set_surface(Surface.MIN_DEPTH, _size(ode, "min_depth"))
