"""Visual: a rendered shape, or a group of visuals: a model, a link."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.geometry import (
    GzColor,
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzPose,
    GzPoseOf,
    GzVector,
    QuaternLike,
    VectorLike,
    place_of,
)
from libgz.classic.math import AxisAlignedBox, Color, Pose3d, Quaterniond, Vector3d
from libgz.classic.names import takes_names
from libgz.classic.rendering.aids import edges_of
from libgz.classic.rendering.lines import DynamicLines
from libgz.classic.rendering.meshes import attach_mesh, base_size, corners_of
from libgz.physics.geom import Geom
from libgz.rendering.shot import Lines
from libgz.sdf.element import Element
from libgz.sdf.materials import Material
from libgz.sdfworld.visual import material_name, put_on, replaces_look, scripted_material, set_transparency
from libgz.simulation.state import encode, get_values, set_values

if TYPE_CHECKING:
    from libgz.classic.loading import LoadedPlugin
    from libgz.classic.rendering.scene import Scene
    from libgz.physics.body import Body

__all__ = ["Visual"]

log = logging.getLogger("libgz.classic")

SMALLEST = 1e-9  # scale in place of 0, which could not be undone
_ids = itertools.count(1)


@takes_names
class Visual:
    """A view on rendered geoms, or on a group of visuals.

    Moving, colouring or hiding it changes images only, not physics. A plugin makes its own with
    ``Visual("name", parent)``, where the parent is the scene or any visual, and gives it a shape with `AttachMesh`.
    """

    # Of the shapes' own looks and places the engine has the state.
    STATE = (
        *("_offset", "_scale", "_transparency", "_visible", "_shadows", "_highlighted", "_material"),
        *("_wireframe", "aids", "_colored"),
    )

    def __init__(self, name: str, parent: Visual | Scene) -> None:
        above = parent if isinstance(parent, Visual) else parent.WorldVisual()
        self._begin(above.GetScene(), name, above)
        above.made.append(self)
        self._scene.made.append(self)

    def _begin(self, scene: Scene, name: str, parent: Visual | None) -> None:
        self._scene, self._name, self._parent = scene, name, parent
        self._id = next(_ids)
        self.geoms: list[Geom] = []
        self.sdf: Element | None = None
        self.made: list[Visual] = []  # children that plugins made
        self.shapes: dict[Geom, Visual] = {}  # of a link: its visuals, by their first geom
        self.frame: Callable[[], GzPose] | None = None  # pose of its model or link; else the parent's
        self.body: Body | None = None  # that carries its shapes
        self.members: Callable[[], Sequence[Visual]] = tuple  # children from the world's file
        self._offset = GzPose()  # of a group, from its frame
        self._transparency, self._visible, self._highlighted = 0.0, True, False
        self._shadows, self._wireframe = True, False
        self.aids: list[str] = []  # names of `AIDS` that are shown
        self._scale = Vector3d(1.0, 1.0, 1.0)  # of a group
        self._material = ""
        self._colored = False  # whether a colour was set on the look of a mesh file
        self._lines: list[DynamicLines] = []
        self.meshes: list[str] = []  # that plugins attached
        self.plugins: list[LoadedPlugin] = []

    @classmethod
    def of(
        cls,
        scene: Scene,
        name: str,
        parent: Visual | None,
        *,
        frame: Callable[[], GzPose] | None = None,
        body: Body | None = None,
        members: Callable[[], Sequence[Visual]] = tuple,
        geoms: Sequence[Geom] = (),
        sdf: Element | None = None,
    ) -> Visual:
        """The visual of a model, a link, or geoms."""
        made = cls.__new__(cls)
        made._begin(scene, name, parent)
        made.frame, made.body, made.members, made.geoms, made.sdf = frame, body, members, list(geoms), sdf
        if geoms:
            made._transparency = geoms[0].appearance.transparency
            made._visible = geoms[0].appearance.visible
        if sdf is not None and sdf.HasElement("material"):
            made._material = material_name(sdf.child("material"))
        return made

    def __repr__(self) -> str:
        return f"<Visual {self._name!r}{place_of(self)}>"

    def Name(self) -> str:
        """Its full name: ``model::link::visual``."""
        return self._name

    GetName = Name

    def GetId(self) -> int:
        """A unique number."""
        return self._id

    def GetScene(self) -> Scene:
        """The scene."""
        return self._scene

    def GetSDF(self) -> Element | Any:
        """The `<visual>` element; None if there was none."""
        return self.sdf

    def GetParent(self) -> Visual | Any:
        """The visual that contains it; None at the top."""
        return self._parent

    def GetRootVisual(self) -> Visual:
        """The model that it belongs to: the highest visual below the world's."""
        found = self
        while found._parent is not None and found._parent._parent is not None:
            found = found._parent
        return found

    def GetDepth(self) -> int:
        """How many visuals contain it: 0 for that of the world."""
        return 0 if self._parent is None else self._parent.GetDepth() + 1

    def GetNthAncestor(self, n: int) -> Visual | Any:
        """The visual around it, or itself, whose depth is n; None if there is none."""
        found: Visual | None = self
        while found is not None and found.GetDepth() != n:
            found = found._parent
        return found

    def IsAncestorOf(self, visual: Visual) -> bool:
        """Whether it contains another one."""
        return visual.IsDescendantOf(self)

    def IsDescendantOf(self, visual: Visual) -> bool:
        """Whether another one contains it."""
        above = self._parent
        while above is not None and above is not visual:
            above = above._parent
        return above is not None

    def AttachVisual(self, visual: Visual) -> None:
        """Take a visual that a plugin made into this one; its pose in its parent stays.

        Raises:
            ParameterError: it is one of the world's file, or contains this one.
        """
        if visual._parent is None or visual not in visual._parent.made:
            raise ParameterError(f"visual {visual.Name()!r} was not made by a plugin; it stays where the file has it")
        if visual is self or visual.IsAncestorOf(self):
            raise ParameterError(f"visual {visual.Name()!r} contains {self._name!r}; it cannot become a part of it")
        pose, looks = visual.Pose(), [geom.appearance for geom in visual.geoms]
        visual._parent.made.remove(visual)
        visual._parent = self
        self.made.append(visual)
        visual.shape_again()
        for geom, look in zip(visual.geoms, looks, strict=True):
            geom.appearance = look
            look.version += 1
        visual.SetPose(pose)

    def DetachVisual(self, which: Visual | str) -> None:
        """Take a visual that a plugin made out of this one, into the world's; its pose in its parent stays.

        Raises:
            NotFoundError: there is none in it.
        """
        found = next((part for part in self.made if part is which or part.Name() == which), None)
        if found is None:
            names = [part.Name() for part in self.made]
            raise NotFoundError(
                f"visual {self._name!r} has no visual {which!r} of a plugin{nearest(str(which), names)}"
            )
        self._scene.WorldVisual().AttachVisual(found)

    def children(self) -> list[Visual]:
        """The visuals in it."""
        return [*self.members(), *self.made]

    def GetChildCount(self) -> int:
        """The number of visuals in it."""
        return len(self.children())

    ChildCount = GetChildCount

    def GetChild(self, index: int) -> Visual | Any:
        """One of the visuals in it; None if there is none of that number."""
        children = self.children()
        return children[index] if 0 <= index < len(children) else None

    def tree(self) -> Iterator[Visual]:
        """Itself and all visuals in it, parents first."""
        yield self
        for child in self.children():
            yield from child.tree()

    def leaves(self) -> Iterator[Geom]:
        """All geoms in it."""
        for part in self.tree():
            yield from part.geoms

    def Load(self, sdf: Element | None = None) -> None:
        """Accepted: the constructor has done all of it."""

    Init = Load

    def Fini(self) -> None:
        """Remove it, with everything in it that a plugin made."""
        for part in list(self.made):
            part.Fini()
        for line in list(self._lines):
            self.DeleteDynamicLine(line)
        self.SetHighlighted(False)
        if self._parent is not None and self in self._parent.made:
            self._parent.made.remove(self)
            self._scene.forget(self)
            for geom in self.geoms:
                geom.close()
            self.geoms.clear()

    # State -------------------------------------------------------------------------------------------------------

    def _edit(self) -> None:
        """Note what it was before its first change."""
        if self not in self._scene.edited:
            self._scene.edited[self] = self.save()

    def save(self) -> tuple[Any, ...]:
        """Its state and its lines, as plain data."""
        lines = [(get_values(line), {at: part.Name() for at, part in line.attached.items()}) for line in self._lines]
        return get_values(self), lines

    def load(self, state: Sequence[Any]) -> None:
        """Take what `save` returned: lines that came since go, those that went are made again."""
        if encode(state) == encode(self.save()):
            return
        own, lines = state
        set_values(self, own)
        self._scene.highlight(self, self._highlighted)
        self._scene.mark(self)
        for line in self._lines[len(lines) :]:
            self.DeleteDynamicLine(line)
        for _ in lines[len(self._lines) :]:
            self.CreateDynamicLine()
        for line, (kept, attached) in zip(self._lines, lines, strict=True):
            set_values(line, kept)
            found = {at: self._scene.GetVisual(name) for at, name in attached.items()}
            line.attached = {at: visual for at, visual in found.items() if visual is not None}

    # Plugins -----------------------------------------------------------------------------------------------------

    def begin_plugin(self, filename: str, name: str, sdf: Element) -> None:
        """Construct a plugin and Load it."""
        plugin = self._scene.world.server.plugins.new("Visual", filename, name, f"Visual[{self._name}]", sdf)
        if plugin is not None and plugin.load(self, sdf):
            self.plugins.append(plugin)

    def init_plugins(self) -> None:
        """Init all its plugins."""
        for plugin in list(self.plugins):
            plugin.init()

    def LoadPlugin(self, filename: str, name: str, sdf: Element | None = None) -> None:
        """Load one more plugin; then Init all of them, earlier ones a second time, as classic did."""
        self.begin_plugin(filename, name, sdf or Element("plugin"))
        self.init_plugins()
        self._scene.world.server.serve_visuals()

    def RemovePlugin(self, name: str) -> None:
        """Remove a plugin and disconnect its callbacks.

        Raises:
            NotFoundError: there is no such plugin.
        """
        plugin = next((plugin for plugin in self.plugins if plugin.name == name), None)
        if plugin is None:
            known = [plugin.name for plugin in self.plugins]
            raise NotFoundError(f"visual {self._name!r} has no plugin {name!r}{nearest(name, known)}")
        self.plugins.remove(plugin)
        plugin.drop()

    # Pose --------------------------------------------------------------------------------------------------------

    def _base(self) -> GzPose:
        if self.frame is not None:
            return self.frame()
        return self._parent.world_pose() if self._parent is not None else GzPose()

    def world_pose(self) -> GzPose:
        """Global pose [m], as the engine has it."""
        return self.geoms[0].GetPose() if self.geoms else GzCoordPoseAdd(self._offset, self._base())

    def _put(self, pose: GzPose) -> None:
        if not self.geoms:
            self._edit()
            self._offset = GzCoordPoseSub(pose, self._base())
        for geom in self.geoms:
            geom.SetRelativePose(GzCoordPoseSub(pose, geom.body.GetPose()), updateCoM=False)

    def WorldPose(self) -> Pose3d:
        """Global pose [m]."""
        return Pose3d(self.world_pose())

    GetWorldPose = WorldPose

    def SetWorldPose(self, pose: GzPose) -> None:
        """Move it, with all in it, to a global pose [m]; from there it moves with its link."""
        pose = GzPoseOf(pose)
        before = self.world_pose()
        moved = [(part, GzCoordPoseSub(part.world_pose(), before)) for part in self.tree()]
        for part, relative in moved:
            part._put(GzCoordPoseAdd(relative, pose))

    def Pose(self) -> Pose3d:
        """Pose in its parent [m]."""
        around = self._parent.world_pose() if self._parent is not None else GzPose()
        return Pose3d(GzCoordPoseSub(self.world_pose(), around))

    GetPose = Pose

    def SetPose(self, pose: GzPose) -> None:
        """Move it to a pose in its parent [m]."""
        pose = GzPoseOf(pose)
        around = self._parent.world_pose() if self._parent is not None else GzPose()
        self.SetWorldPose(GzCoordPoseAdd(pose, around))

    def Position(self) -> Vector3d:
        """Position in its parent [m]."""
        return self.Pose().Pos()

    GetPosition = Position

    def SetPosition(self, pos: VectorLike) -> None:
        """Move it in its parent [m]."""
        self.SetPose(GzPose(GzVector(*pos), self.Pose().rot))

    def Rotation(self) -> Quaterniond:
        """Rotation in its parent."""
        return self.Pose().Rot()

    GetRotation = Rotation

    def SetRotation(self, rot: QuaternLike) -> None:
        """Turn it in its parent."""
        self.SetPose(Pose3d(self.Pose().pos, rot))

    def SetWorldPosition(self, pos: VectorLike) -> None:
        """Move it to a global position [m]."""
        self.SetWorldPose(GzPose(GzVector(*pos), self.world_pose().rot))

    def SetWorldRotation(self, rot: QuaternLike) -> None:
        """Turn it to a global rotation."""
        self.SetWorldPose(Pose3d(self.world_pose().pos, rot))

    # Size --------------------------------------------------------------------------------------------------------

    def Scale(self) -> Vector3d:
        """The size [m] of a box, sphere, cylinder or plane, which are scaled unit shapes; of others the factors."""
        if not self.geoms:
            return Vector3d(self._scale)
        factors = self.geoms[0].appearance.scale
        return Vector3d(*(size * k for size, k in zip(base_size(self.geoms[0], self.sdf), factors, strict=True)))

    GetScale = Scale

    def SetScale(self, scale: VectorLike) -> None:
        """Set the scale; a group scales its parts and their distances. At 0 it is too small to be seen."""
        ratios = [(new or SMALLEST) / (old or 1.0) for new, old in zip(scale, self.Scale(), strict=True)]
        origin = self.world_pose()
        for part in self.tree():
            if part is not self:
                x, y, z = (p * k for p, k in zip(GzCoordPoseSub(part.world_pose(), origin).pos, ratios, strict=True))
                place = GzCoordPoseAdd(GzPose(GzVector(x, y, z)), origin)
                part._put(GzPose(place.pos, part.world_pose().rot))
            for geom in part.geoms:
                look = geom.appearance
                look.scale = GzVector(*(a * k for a, k in zip(look.scale, ratios, strict=True)))
                look.version += 1
        self._edit()
        self._scale = Vector3d(*(factor or SMALLEST for factor in scale))

    def DerivedScale(self) -> Vector3d:
        """The same, because a group scales its parts."""
        return self.Scale()

    def GetGeometryType(self) -> str:
        """box, sphere, cylinder, plane, mesh ...; empty for groups."""
        shape = self.sdf.child("geometry").GetFirstElement() if self.sdf is not None else None
        return shape.name if shape is not None else ""

    def GetMeshName(self) -> str:
        """The file of its mesh, or the shape that was attached; empty for none."""
        if self.meshes:
            return self.meshes[0]
        kind = self.GetGeometryType()
        if kind == "mesh" and self.sdf is not None:
            return self.sdf.child("geometry").child("mesh").Get(str, "uri")
        return {"box": "unit_box", "sphere": "unit_sphere", "cylinder": "unit_cylinder"}.get(kind, "")

    def IsPlane(self) -> bool:
        """Whether its shape is a plane."""
        return self.GetGeometryType() == "plane"

    def InitialRelativePose(self) -> Pose3d:
        """The pose in its parent that the file gives [m]."""
        return self.sdf.Get(Pose3d, "pose") if self.sdf is not None else Pose3d()

    def GetGeometrySize(self) -> Vector3d:
        """Size of its shape [m], as in `Scale`."""
        return self.Scale()

    def BoundingBox(self) -> AxisAlignedBox:
        """The smallest box around its shapes along its own axes [m], in its own frame."""
        corners = [corners_of(geom, self.world_pose()) for geom in self.leaves()]
        points = np.concatenate(corners) if corners else np.zeros((0, 3))
        if not len(points):
            return AxisAlignedBox()
        return AxisAlignedBox(points.min(axis=0).tolist(), points.max(axis=0).tolist())

    GetBoundingBox = BoundingBox

    # Appearance --------------------------------------------------------------------------------------------------

    def _set_color(self, name: str, color: GzColor, cascade: bool) -> None:
        for part in self.tree() if cascade else iter((self,)):
            part._leave_look_of_file()
            for geom in part.geoms:
                look = geom.appearance
                setattr(look, name, GzColor(*color))
                set_transparency(look, look.transparency)

    def _leave_look_of_file(self) -> None:
        """Be white before the first colour is set: as in Gazebo, it replaces the colours and images of a mesh file."""
        sdf, meshes = self.sdf, bool(self.meshes)
        if sdf is not None and sdf.HasElement("geometry"):
            meshes = meshes or sdf.child("geometry").HasElement("mesh")
        if not meshes or self._material or self._colored or (sdf is not None and replaces_look(sdf)):
            return
        self._edit()
        self._colored = True
        for geom in self.geoms:
            put_on(geom.appearance, Material())

    def _color(self, name: str) -> Color:
        geom = next(self.leaves(), None)
        return Color(*getattr(geom.appearance, name)) if geom is not None else Color()

    def Ambient(self) -> Color:
        """Colour in light from everywhere; of a group, that of the first in it."""
        return self._color("ambient")

    def SetAmbient(self, color: GzColor, cascade: bool = True) -> None:
        """Set the colour in light from everywhere; as all colours do, it replaces the look of a mesh file."""
        self._set_color("ambient", color, cascade)

    def Diffuse(self) -> Color:
        """Colour in direct light."""
        return self._color("diffuse")

    def SetDiffuse(self, color: GzColor, cascade: bool = True) -> None:
        """Set the colour in direct light; with an alpha below 1 it is transparent."""
        self._set_color("diffuse", color, cascade)

    def Specular(self) -> Color:
        """Colour of highlights."""
        return self._color("specular")

    def SetSpecular(self, color: GzColor, cascade: bool = True) -> None:
        """Set the colour of highlights; they show where shininess is above 0."""
        self._set_color("specular", color, cascade)

    def Emissive(self) -> Color:
        """Emitted colour."""
        return self._color("emission")

    def SetEmissive(self, color: GzColor, cascade: bool = True) -> None:
        """Set the emitted colour."""
        self._set_color("emission", color, cascade)

    GetAmbient, GetDiffuse, GetSpecular, GetEmissive = Ambient, Diffuse, Specular, Emissive

    def Shininess(self) -> float:
        """Sharpness of highlights."""
        geom = next(self.leaves(), None)
        return geom.appearance.shininess if geom is not None else 0.0

    def SetShininess(self, shininess: float, cascade: bool = True) -> None:
        """Set the sharpness of highlights, 0 to 128; at 0 there are none."""
        for geom in self.leaves() if cascade else iter(self.geoms):
            geom.SetShininess(shininess)

    def SetMaterial(self, materialName: str, unique: bool = True, cascade: bool = True) -> None:
        """Set a material by name, ``Gazebo/Red``; an unknown one is logged, and changes nothing."""
        if materialName in ("", "__default__"):
            return
        looks = next(self.sdf.named("material"), None) if self.sdf is not None else None
        material = scripted_material(materialName, looks)
        if material is None:
            log.warning("visual %r: there is no material %r", self._name, materialName)
            return
        for part in self.tree() if cascade else iter((self,)):
            part._edit()
            part._material = materialName
            for geom in part.geoms:
                put_on(geom.appearance, material)

    def GetMaterialName(self) -> str:
        """The material that was set by name; empty for none."""
        return self._material

    MaterialName = GetMaterialName

    def Transparency(self) -> float:
        """Transparency, 0 to 1."""
        return self._transparency

    GetTransparency = Transparency

    def SetTransparency(self, trans: float) -> None:
        """Set the transparency, 0 to 1; the parts of a group have their own on top."""
        self._edit()
        self._transparency = min(max(float(trans), 0.0), 1.0)
        for part in self.tree():
            derived = part.DerivedTransparency()
            for geom in part.geoms:
                set_transparency(geom.appearance, derived)

    def DerivedTransparency(self) -> float:
        """Transparency, including that of the groups around it."""
        above = self._parent.DerivedTransparency() if self._parent is not None else 0.0
        return 1.0 - (1.0 - above) * (1.0 - self._transparency)

    GetDerivedTransparency = DerivedTransparency

    def Visible(self) -> bool:
        """Whether it is shown."""
        return self._visible

    GetVisible = Visible

    def SetVisible(self, visible: bool, cascade: bool = True) -> None:
        """Show or hide it, and all in it."""
        for part in self.tree() if cascade else iter((self,)):
            part._edit()
            part._visible = bool(visible)
            part._show()

    def _show(self) -> None:
        """Render its shapes if it is visible, and not as wires."""
        for geom in self.geoms:
            geom.appearance.change(visible=self._visible and not self._wireframe)

    def ToggleVisible(self) -> None:
        """Show it if it is hidden, hide it if it is shown."""
        self.SetVisible(not self._visible)

    def SetCastShadows(self, shadows: bool) -> None:
        """Set whether it casts a shadow, where images have shadows."""
        self._edit()
        self._shadows = bool(shadows)
        for geom in self.geoms:
            geom.appearance.change(cast_shadows=self._shadows)

    def GetCastShadows(self) -> bool:
        """Whether it casts a shadow, where images have shadows."""
        return self._shadows

    CastShadows = GetCastShadows

    def SetHighlighted(self, highlighted: bool) -> None:
        """Show a white box around it, or hide it."""
        self._edit()
        self._highlighted = bool(highlighted)
        self._scene.highlight(self, self._highlighted)

    def GetHighlighted(self) -> bool:
        """Whether there is a box around it."""
        return self._highlighted

    Highlighted = GetHighlighted

    def SetWireframe(self, show: bool) -> None:
        """Render it, and all in it, as the edges of its triangles, or as faces again."""
        for part in self.tree():
            part._edit()
            part._wireframe = bool(show)
            part._show()
            self._scene.mark(part)

    def Wireframe(self) -> bool:
        """Whether it is rendered as the edges of its triangles."""
        return self._wireframe

    GetWireframe = Wireframe

    def wires(self) -> Iterator[Lines]:
        """The edges of its triangles, if it is rendered as them."""
        if self._wireframe and self._visible:
            color = self.Diffuse()
            for geom in self.geoms:
                yield Lines(edges_of(geom).astype(np.float32), (color.r, color.g, color.b))

    def _aid(self, name: str, show: bool) -> None:
        self._edit()
        self.aids = [aid for aid in self.aids if aid != name] + ([name] if show else [])
        self._scene.mark(self)

    def ShowCollision(self, show: bool) -> None:
        """Show the edges of the collisions of the links that it shows, or hide them."""
        self._aid("collision", show)

    def ShowJoints(self, show: bool) -> None:
        """Show frames and axes of joints, or hide them."""
        self._aid("joints", show)

    def ShowCOM(self, show: bool) -> None:
        """Show crosses at the centres of mass, or hide them."""
        self._aid("com", show)

    def ShowInertia(self, show: bool) -> None:
        """Show boxes of even density that have the links' moments of inertia, or hide them."""
        self._aid("inertia", show)

    def ShowLinkFrame(self, show: bool) -> None:
        """Show the axes of the links' frames, or hide them."""
        self._aid("frame", show)

    def ShowBoundingBox(self, show: bool = True) -> None:
        """Show the boxes of the links' collisions, along the world's axes, or hide them."""
        self._aid("box", show)

    # Shapes and lines --------------------------------------------------------------------------------------------

    def AttachMesh(self, meshName: str, subMesh: str = "", centerSubmesh: bool = False, objName: str = "") -> Any:
        """Give it a shape: unit_box, unit_sphere, unit_cylinder, or a mesh file.

        Raises:
            GazeboError: there is no such shape, or the file cannot be read.
        """
        pose = self.world_pose()
        geoms = attach_mesh(self._carrier(), meshName)
        for geom in geoms:
            geom.SetRelativePose(GzCoordPoseSub(pose, geom.body.GetPose()), updateCoM=False)
        self.geoms += geoms
        self.meshes.append(meshName)
        self.SetTransparency(self._transparency)
        return geoms[0]

    def shape_again(self) -> None:
        """Make the shapes again that were attached, after all other shapes that there are."""
        meshes, self.meshes = self.meshes, []
        for geom in self.geoms:
            geom.close()
        self.geoms.clear()
        for mesh in meshes:
            self.AttachMesh(mesh)

    def _carrier(self) -> Body:
        """The body of the nearest visual around it that has one."""
        part: Visual | None = self
        while part is not None:
            if part.body is not None:
                return part.body
            part = part._parent
        return self._scene.static_body()

    @property
    def deleted(self) -> bool:
        """Whether the body that carries it was deleted."""
        part: Visual | None = self
        while part is not None and part.body is None:
            part = part._parent
        return part is not None and part.body is not None and part.body.closed

    def CreateDynamicLine(self, type: int = DynamicLines.LINE_STRIP) -> DynamicLines:
        """New lines in its frame."""
        self._edit()
        line = DynamicLines(self, type)
        self._lines.append(line)
        self._scene.lines.append(line)
        return line

    def DeleteDynamicLine(self, line: DynamicLines) -> None:
        """Remove lines."""
        if line in self._lines:
            self._lines.remove(line)
            self._scene.lines = [other for other in self._scene.lines if other is not line]

    def AttachLineVertex(self, line: DynamicLines, index: int) -> None:
        """Attach a point of lines to this visual: it moves with the visual."""
        line.attach(index, self)
