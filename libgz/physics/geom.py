"""Geom: a shape of a body, with its mass, contact properties and appearance."""

from __future__ import annotations

import ctypes
import itertools
from pathlib import Path
from typing import Any, ClassVar

from libgz.base.errors import ClosedError, ParameterError
from libgz.base.files import is_file
from libgz.base.geometry import (
    GzColor,
    GzCoordPoseAdd,
    GzPose,
    GzPoseOf,
    GzQuatern,
    GzQuaternMul,
    GzQuaternNormal,
    GzVector,
    QuaternLike,
    VectorLike,
    place_of,
)
from libgz.ode.lib import ode
from libgz.ode.types import ContactRule, Surface
from libgz.physics import mass as mass_
from libgz.physics.appearance import RENDER_OPAQUE, RENDER_TRANSPARENT, Appearance
from libgz.physics.body import Body
from libgz.physics.check import LARGEST, WIDE, finite, finite_tuple, not_negative, positive, rotation_tuple
from libgz.physics.engine import Engine
from libgz.physics.lock import built, exclusive
from libgz.physics.space import Space

__all__ = ["Geom"]

MASSLESS = 1e-16  # [kg]; SetMass of less makes a geom weightless

Color = tuple[float, ...]  # red, green, blue, alpha

_CENTRE = GzPose()

_numbers = itertools.count(1)


class Geom:
    """Base of all kinds of geom.

    Attributes:
        appearance: how it looks, and how sensors see it.
        number: of this geom among all, never used again.
        facade: the object by which the API of a layer above presents this geom; set by that layer.

    Args:
        body: the body it belongs to.
        space: the model's space (`modelSpaceId`), or None for a geom that nothing touches.
        handle: ODE's geom, or None for one that is only rendered.
        volume_mass: its mass matrix at 1 kg/m^3 about its own centre, or None if it has no mass.
        placeable: whether it follows its body; a plane does not.
    """

    extra_rotation: GzQuatern | None = None  # between ODE's shape and this one
    scale: tuple[float, ...] = (1.0, 1.0, 1.0)  # multiple of its first size, as set by classic's SetScale

    SAVED: ClassVar[tuple[str, ...]] = ("_relative", "_mass", "volume_mass", "scale", "_slip")

    @built
    def __init__(
        self,
        body: Body,
        space: Space | None,
        handle: int | None = None,
        volume_mass: mass_.Mass | None = None,
        placeable: bool = True,
    ) -> None:
        body.GetBodyId()  # raises if it was closed
        self.body = body
        self.space = space
        self.placeableGeom = placeable
        self.appearance = Appearance()
        self.volume_mass = volume_mass
        self._mass = volume_mass
        self._relative = _CENTRE
        self._slip = (0.01, 0.01)
        self._closed = False
        self._id: int | None = None
        self.facade: Any = None
        self.number = next(_numbers)
        self._table = body.engine.tables.geoms
        self.row = body.engine.tables.add_geom(self, body.number)
        body.geoms.append(self)
        if handle is not None:
            self._adopt(handle)

    @exclusive
    def _adopt(self, handle: int) -> None:
        """Use this ODE geom, in place of the previous one, with what that collides with."""
        if self._id is not None:
            ode().dGeomSetCategoryBits(handle, ode().dGeomGetCategoryBits(self._id))
            ode().dGeomSetCollideBits(handle, ode().dGeomGetCollideBits(self._id))
        self._destroy_handle()
        self._id = handle
        ode().dGeomSetData(handle, self.row)
        if self.placeableGeom:
            if self.body.id:
                ode().dGeomSetBody(handle, self.body.id)
            self.place()

    def _destroy_handle(self) -> None:
        if self._id is not None:
            ode().dGeomDestroy(self._id)
            self._id = None

    def __repr__(self) -> str:
        return f"<{self.label}{place_of(self)}>"

    @property
    def label(self) -> str:
        """Its kind and body, for messages."""
        return f"{type(self).__name__} of {self.body.label}"

    def _of(self, what: str) -> str:
        """The name of a property in messages: which geom of which body has it.

        Raises:
            ClosedError: the geom was closed.
        """
        self._require_open()
        return f"{what} of {type(self).__name__} {self.body.geoms.index(self) + 1} of body {self.body.label!r}"

    @property
    def id(self) -> int:
        """The ODE handle; 0 if the geom is only rendered.

        Raises:
            ClosedError: the geom was closed.
        """
        self._require_open()
        return self._id or 0

    def _require_open(self) -> None:
        """Check that the geom was not closed: its row may belong to another one.

        Raises:
            ClosedError: it was.
        """
        if self._closed:
            raise ClosedError(f"{type(self).__name__} of body {self.body.bodyName or 'unnamed'!r} was closed")

    @property
    def engine(self) -> Engine:
        """The ODE world that it is in."""
        return self.body.engine

    def GetGeomId(self) -> int:
        """The ODE handle; 0 if the geom is only rendered."""
        return self.id

    @property
    def closed(self) -> bool:
        """Whether it was destroyed."""
        return self._closed

    @exclusive
    def close(self) -> None:
        """Destroy the geom."""
        if self._closed:
            return
        self._table.remove(self.row)
        self.body.engine.wake()
        self.body.geoms.remove(self)
        self._destroy_handle()
        self._closed = True

    # Place -------------------------------------------------------------------------------------------------------

    @exclusive
    def move_to(self, space: Space) -> None:
        """Move it to another space: geoms of one space never touch each other.

        Raises:
            ParameterError: that is no space of the geom's world.
            ClosedError: that space was closed.
        """
        if not (isinstance(space, Space) and space.engine is self.engine):
            raise ParameterError(f"{self.label} can be moved to a space of its world; {space!r} is none")
        if self.space is None or self.space is space:
            return
        old, new = self.space.id, space.id  # both open, before anything changes
        ode().dSpaceRemove(old, self.id)
        ode().dSpaceAdd(new, self.id)
        self.space = space

    @exclusive
    def place(self) -> None:
        """Place ODE's geom on its body, whose ODE origin is the centre of mass."""
        if not self.id or not self.placeableGeom:
            return
        if self.body.dummy:
            self.follow_dummy()
            return
        position = (p - c for p, c in zip(self._relative.pos, self.body.com, strict=True))
        ode().dGeomSetOffsetPosition(self.id, *position)
        ode().dGeomSetOffsetQuaternion(self.id, (ctypes.c_double * 4)(*self._turned(self._relative.rot)))

    @property
    def centred(self) -> int:
        """The handle of ODE's geom if that is where its body's frame is; else 0."""
        if self._id is None or not self.placeableGeom or self.extra_rotation is not None:
            return 0
        return self._id if self._relative is _CENTRE or self._relative == _CENTRE else 0

    @exclusive
    def follow_dummy(self) -> None:
        """Place ODE's geom at the global pose that results from its dummy body."""
        if self.id and self.placeableGeom:
            pose = self.GetPose()
            ode().dGeomSetPosition(self.id, *pose.pos)
            ode().dGeomSetQuaternion(self.id, (ctypes.c_double * 4)(*self._turned(pose.rot)))

    def _turned(self, rotation: GzQuatern) -> GzQuatern:
        return rotation if self.extra_rotation is None else GzQuaternMul(rotation, self.extra_rotation)

    @exclusive
    def SetRelativePose(self, pose: GzPose, updateCoM: bool = True) -> None:
        """Place the geom's centre in the body frame [m].

        Raises:
            ParameterError: a component is not finite.
        """
        pose = GzPoseOf(pose)
        position = finite_tuple(pose.pos, 3, "relative position [m]", LARGEST)
        rotation = rotation_tuple(pose.rot, "relative rotation")
        if max(map(abs, position)) > WIDE:
            self.body.engine.extend_range()
        self._relative = GzPose(GzVector(*position), GzQuaternNormal(rotation))
        self._reshaped()
        self.place()
        if updateCoM and self.placeableGeom:
            self.body.UpdateCoM()

    def SetRelativePosition(self, position: VectorLike) -> None:
        """Move the geom's centre in the body frame [m]."""
        self.SetRelativePose(GzPose(GzVector(*finite_tuple(position, 3, "relative position [m]")), self._relative.rot))

    def SetRelativeRotation(self, rotation: QuaternLike) -> None:
        """Turn the geom in the body frame."""
        self.SetRelativePose(GzPose(self._relative.pos, GzQuatern(*rotation_tuple(rotation, "relative rotation"))))

    def GetRelativePose(self) -> GzPose:
        """The pose in the body frame [m]."""
        return GzPose(GzVector(*self._relative.pos), GzQuatern(*self._relative.rot))

    def GetPose(self) -> GzPose:
        """The global pose of the geom's centre [m]."""
        return GzCoordPoseAdd(self._relative, self.body.GetPose())

    # Mass --------------------------------------------------------------------------------------------------------

    @exclusive
    def SetMass(self, kilograms: float) -> None:
        """Set the geom's total mass [kg]; 0 makes it weightless.

        A new geom has the mass of its volume at 1 kg/m^3. With the quirk setMassZero, 0 leaves it at that, as in the
        legacy server.

        Raises:
            ParameterError: the mass is negative or not finite.
        """
        if self.volume_mass is None:
            return
        if not_negative(kilograms, self._of("mass [kg]")) < MASSLESS:
            if "setMassZero" in self.body.engine.quirks:
                return
            self._mass = None
        else:
            self._mass = mass_.scaled(self.volume_mass, kilograms)
        self.body.UpdateCoM()

    def GetBodyMassMatrix(self) -> mass_.Mass | None:
        """The mass matrix seen from the body frame, or None if the geom is massless."""
        return self.body_mass(self._mass)

    def body_mass(self, own: mass_.Mass | None) -> mass_.Mass | None:
        """A mass matrix about the geom's centre, seen from the body frame."""
        return mass_.moved(own, self._relative) if own is not None and self.placeableGeom else None

    @exclusive
    def bounds(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Lowest and highest corner of the box around it [m], global; twice its place if it touches nothing."""
        if not self.id:
            x, y, z = self.GetPose().pos
            return (x, y, z), (x, y, z)
        box = (ctypes.c_double * 6)()
        ode().dGeomGetAABB(self.id, box)
        return (box[0], box[2], box[4]), (box[1], box[3], box[5])

    def _reshaped(self) -> None:
        """Note a new shape or place: the renderer must rebuild it, and bodies that sleep on it must wake."""
        self.appearance.version += 1
        self.body.engine.wake()

    # Contact -----------------------------------------------------------------------------------------------------

    def surface(self, column: int) -> float:
        """One contact property; see `Surface`."""
        self._require_open()
        return float(self._table.surface[self.row, column])

    @exclusive
    def set_surface(self, column: int, value: float) -> None:
        """Change one contact property, unchecked; see `Surface`."""
        self._require_open()
        self._table.set_surface(self.row, column, value)

    def SetHardness(self, kp: float, kd: float) -> None:
        """Spring [N/m] and damper [N s/m] of contacts with this geom; kp may be infinite.

        Raises:
            ParameterError: kp is not above zero, or kd is negative.
        """
        if not kp > 0.0:
            raise ParameterError(f"{self._of('hardness kp')} is {kp:g} N/m; it must be above zero")
        damper = not_negative(kd, self._of("hardness kd [N s/m]"))
        self.set_surface(Surface.KP, float(kp))
        self.set_surface(Surface.KD, damper)

    def SetFriction(self, mu1: float, mu2: float | None = None) -> None:
        """Coulomb coefficient; the smaller one of two geoms applies. `mu2` is used by the classic contact rule only."""
        first = not_negative(mu1, self._of("friction mu1"))
        second = not_negative(mu1 if mu2 is None else mu2, self._of("friction mu2"))
        self.set_surface(Surface.MU, first)
        self.set_surface(Surface.MU2, second)

    def SetBounce(self, bounce: float) -> None:
        """Coefficient of restitution, 0 to 1; ignored with the quirk noBounce."""
        what = self._of("bounce")
        value = finite(not_negative(bounce, what), what)
        if "noBounce" not in self.body.engine.quirks:
            self.set_surface(Surface.BOUNCE, value)

    def GetBounce(self) -> float:
        """The bounce in force."""
        return self.surface(Surface.BOUNCE)

    def SetSlip1(self, slip: float) -> None:
        """Stored without effect: the old default would change every world."""
        self._slip = (float(slip), self._slip[1])

    def SetSlip2(self, slip: float) -> None:
        """Stored without effect."""
        self._slip = (self._slip[0], float(slip))

    def GetSlip1(self) -> float:
        """The value last set."""
        return self._slip[0]

    def GetSlip2(self) -> float:
        """The value last set."""
        return self._slip[1]

    @exclusive
    def SetCategoryBits(self, bits: int) -> None:
        """Set the collision category."""
        if self.id:
            ode().dGeomSetCategoryBits(self.id, bits)
            self.body.engine.wake()

    @exclusive
    def SetCollideBits(self, bits: int) -> None:
        """Set the categories that this geom collides with."""
        if self.id:
            ode().dGeomSetCollideBits(self.id, bits)
            self.body.engine.wake()

    # Appearance --------------------------------------------------------------------------------------------------

    def SetColor(self, color: GzColor) -> None:
        """Derive the whole material from one colour."""
        self.appearance.set_color(GzColor(*color))

    def SetAmbientColor(self, color: GzColor) -> None:
        """Colour in ambient light."""
        self.appearance.change(ambient=GzColor(*color))

    def SetDiffuseColor(self, color: GzColor) -> None:
        """Colour in direct light; its alpha applies to transparent geoms."""
        self.appearance.change(diffuse=GzColor(*color))

    def SetSpecularColor(self, color: GzColor) -> None:
        """Colour of highlights."""
        self.appearance.change(specular=GzColor(*color))

    def SetEmissionColor(self, color: GzColor) -> None:
        """Colour that the geom emits."""
        self.appearance.change(emission=GzColor(*color))

    def GetAmbientColor(self) -> GzColor:
        """Colour in ambient light."""
        return self.appearance.ambient

    def GetDiffuseColor(self) -> GzColor:
        """Colour in direct light."""
        return self.appearance.diffuse

    def GetSpecularColor(self) -> GzColor:
        """Colour of highlights."""
        return self.appearance.specular

    def material(self) -> tuple[Color, Color, Color, Color, float]:
        """As rendered: ambient, diffuse, specular colour, emission, shininess. Diffuse alpha includes transparency.

        In classic worlds, no shininess means no highlights.
        """
        look, (red, green, blue, alpha) = self.appearance, self.appearance.diffuse
        dull = self.body.engine.contact_rule is ContactRule.CLASSIC and look.shininess <= 0.0
        return (
            tuple(look.ambient),
            (red, green, blue, alpha * (1.0 - look.transparency)),
            (0.0, 0.0, 0.0, 1.0) if dull else tuple(look.specular),
            tuple(look.emission),
            look.shininess,
        )

    def SetTransparency(self, transparent: bool) -> None:
        """Render in the transparent pass, where the alpha of the diffuse colour applies."""
        self.appearance.change(render_order=RENDER_TRANSPARENT if transparent else RENDER_OPAQUE)

    def GetTransparency(self) -> bool:
        """Whether the geom is rendered in the transparent pass."""
        return self.appearance.render_order == RENDER_TRANSPARENT

    def SetShininess(self, exponent: float) -> None:
        """Sharpness of highlights, 0 to 128."""
        self.appearance.change(shininess=float(exponent))

    def GetShininess(self) -> float:
        """Sharpness of highlights."""
        return self.appearance.shininess

    def SetTexture2DFile(self, path: str | Path | None) -> int:
        """Cover the geom with an image; 0, or -1 if there is no such file."""
        file, known = _existing(path)
        if known:
            self.appearance.change(texture_file=file)
        return 0 if known else -1

    def SetTexture2DSize(self, size: VectorLike) -> None:
        """How many metres one image covers, for planes and roads."""
        x, y, *_ = size
        texture_size = GzVector(positive(x, "texture size [m]"), positive(y, "texture size [m]"), 0.0)
        self.appearance.change(texture_size=texture_size)

    def SetSkinFile(self, path: str | Path | None) -> int:
        """Render a mesh instead of the shape while skins are shown; 0, or -1 if there is no such file."""
        file, known = _existing(path)
        if known:
            self.appearance.change(skin_file=file)
        return 0 if known else -1

    def SetSkinPose(self, pose: GzPose) -> None:
        """Place the skin in the frame of the geom's centre [m]."""
        self.appearance.change(skin_pose=pose)

    def SetSkinScale(self, scale: VectorLike) -> None:
        """Scale the skin along its own axes."""
        self.appearance.change(skin_scale=GzVector(*finite_tuple(scale, 3, "skin scale")))

    def SetSkinNull(self, null: bool, instead: Path | None = None) -> None:
        """While skins are shown, do not render this geom; with `instead`, only if that skin can be read."""
        self.appearance.change(skin_null=bool(null), skin_instead=instead)

    def HasSkin(self) -> bool:
        """Whether a skin was set."""
        return self.appearance.skin_file is not None

    def HasSkinNull(self) -> bool:
        """Whether the geom is not rendered while skins are shown."""
        return self.appearance.skin_null

    def SetShadeModel(self, model: str) -> None:
        """Accepted without effect, as in the legacy server."""

    def SetPolygonMode(self, mode: str) -> None:
        """Accepted without effect, as in the legacy server."""

    def SetLaser(self, value: float) -> None:
        """Stored; no sensor uses it."""
        self.appearance.laser = float(value)

    def GetLaser(self) -> float:
        """The value last set."""
        return self.appearance.laser

    def SetRetro(self, value: float) -> None:
        """How much a laser beam is reflected back, 0 to 1: from 0.5 on a laser reports intensity 1."""
        self.appearance.retro = float(value)
        self.mark()

    def GetRetro(self) -> float:
        """How much a laser beam is reflected back."""
        return self.appearance.retro

    def mark(self) -> None:
        """Note whether laser scanners detect more of it than its distance."""
        if not self._closed:
            self._table.marks[self.row] = self.appearance.retro != 0.0 or self.appearance.fiducial >= 0

    def SetFiducial(self, number: int) -> None:
        """The number that a fiducial finder reports for this geom; -1 for none."""
        self.appearance.fiducial = int(number)
        self.mark()

    def GetFiducial(self) -> int:
        """The fiducial number, or -1."""
        return self.appearance.fiducial

    def SetPickId(self, number: int) -> None:
        """A number by which a user interface identifies this geom."""
        self.appearance.pick_id = int(number)

    def GetPickId(self) -> int:
        """The pick number."""
        return self.appearance.pick_id


def _existing(path: str | Path | None) -> tuple[Path | None, bool]:
    """(path, whether it is None or a file)."""
    file = Path(path) if path is not None else None
    return file, file is None or is_file(file)
