"""Reading SDF files: parsed safely, checked against the description of their version, includes resolved."""

from __future__ import annotations

import functools
import itertools
import math
import os
from collections.abc import Iterator, Mapping
from pathlib import Path

from lxml import etree

from libgz.base.budget import Budget, BudgetError
from libgz.base.entities import encoded
from libgz.base.errors import Diagnostics, NotFoundError, ParameterError, Place, WorldFileError, advise, nearest
from libgz.base.files import read_limited
from libgz.base.geometry import GzPose, GzQuatern, GzQuaternFromEuler, GzVector
from libgz.sdf.bounds import in_bounds
from libgz.sdf.description import NEWEST, OLDEST, UNSET, VERSIONS, Description, describe
from libgz.sdf.element import Element, Param
from libgz.sdf.frames import MODEL, add_frame, merge, prefix_names, resolve_frames
from libgz.sdf.paths import find_model
from libgz.sdf.unsimulated import warn_of_unsimulated
from libgz.sdf.value import check, exact_pose, parse, repaired
from libgz.sdf.xacro.recognition import SUFFIX, has_macros
from libgz.sdf.xml import PLACE, ROBOT, ROOTS, copy_place, line_of, local_name, parse_document, place_of, tag_name

__all__ = ["SdfFile"]

DEEPEST_INCLUDE = 20
MOST_INCLUDED = 256 << 20  # [byte] of all includes of a file, with those of included files
EACH_INCLUDED = 4096  # [byte] that an include counts beside its file
UNIQUE = ("model", "actor", "light", "collision", "visual")  # whose names must differ in a world, or in a link
# (parent, child): all that occur have an effect, though the description of SDF allows one.
REPEATED = {
    ("contact", "collision"),
    ("geometry", "polyline"),
    ("multicamera", "camera"),
    ("script", "uri"),
    ("world", "physics"),
}
# Later names of sensors and of their elements -> those of Gazebo classic.
SENSORS = {"lidar": "ray", "gpu_lidar": "gpu_ray", "depth_camera": "depth", "navsat": "gps"}
# Other names of joints, which SDF has had or Gazebo classic accepted.
JOINTS = {"continuous": "revolute", "hinge": "revolute", "hinge2": "revolute2", "slider": "prismatic"}
# (parent, child) up to SDF 1.6 -> what 1.7 has in its place.
REPLACED = {(axis, "use_parent_model_frame"): "the attribute expressed_in of <xyz>" for axis in ("axis", "axis2")}
NEEDED = (("joint", "parent"), ("joint", "child"))  # without which an element has no meaning
FLAT = "1.7"  # the last version in which models that a model includes have no place of their own, as in Gazebo 11
HOLDERS = ("world", "model")  # of includes, in all versions


class SdfFile:
    """An SDF document, read and checked.

    ``SdfFile.load(path)`` reads a file; `root` is its `<sdf>` element, `diagnostics` its errors and warnings, `label`
    its name in messages. Unknown attributes are ignored and unknown elements kept, both with a warning.
    """

    def __init__(self) -> None:
        self.root = Element("sdf")
        self.diagnostics = Diagnostics()
        self.version = NEWEST
        self.label = "<string>"
        self._path: Path | None = None
        self._folder: Path | None = None
        self._text = b""
        self._around: frozenset[Path] = frozenset()  # files that include this one, in each other
        self._parts = False
        self._included = Budget(MOST_INCLUDED)  # which it shares with the files that it includes
        self._arguments: Mapping[str, str] = {}
        self._environment: Mapping[str, str] | None = None

    @classmethod
    def load(
        cls,
        filename: str | os.PathLike[str],
        *,
        arguments: Mapping[str, str] | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> SdfFile:
        """Read a file; its errors are in `diagnostics`.

        Args:
            filename: its name.
            arguments: values of the arguments of its macros (`<xacro:arg>`), instead of their defaults.
            environment: the variables that its macros find, and those of included files; by default those of this
                process.

        Raises:
            WorldFileError: it cannot be read, is not well-formed, or is not SDF.
        """
        file = cls()
        file._arguments, file._environment = arguments or {}, environment
        file._read_file(Path(filename))
        return file

    @classmethod
    def from_string(
        cls, text: str | bytes, label: str = "<string>", folder: Path | None = None, *, parts: bool = False
    ) -> SdfFile:
        """The same from text.

        Args:
            text: the document.
            label: its name in messages.
            folder: the base of its relative paths.
            parts: whether its root may hold any element of SDF, such as a `<joint>`, with its defaults.
        """
        file = cls()
        file.label, file._folder, file._parts = label, folder, parts
        file._read(encoded(text) if isinstance(text, str) else text)
        return file

    def _read_file(self, path: Path) -> None:
        try:
            data = read_limited(path)
        except OSError as error:
            raise WorldFileError(f"Unable to read sdf file[{path}]: {error.strerror}") from None
        self.label, self._path, self._folder = str(path), path, path.parent
        self._read(data)

    @property
    def text(self) -> bytes:
        """The text as it was read, its macros expanded."""
        return self._text

    def read_again(self, text: bytes | None = None) -> SdfFile:
        """The document as it was read, without what has been changed in its elements since; or one of another text."""
        return SdfFile.from_string(self._text if text is None else text, self.label, self._folder)

    @property
    def busy(self) -> bool:
        """Whether it has plugins or sensors."""
        return any(True for name in ("plugin", "sensor") for _ in self.root.find(name))

    def _read(self, data: bytes) -> None:
        self._text = data
        xml = parse_document(data, self.label, self.diagnostics)
        is_named_so = self._path is not None and self._path.suffix == SUFFIX
        if (is_named_so or local_name(xml) == ROBOT) and has_macros(xml, self._path):
            from libgz.sdf.xacro.expansion import expand  # files without macros do without it

            xml = expand(
                xml,
                self.label,
                self.diagnostics,
                path=self._path,
                folder=self._folder,
                arguments=self._arguments,
                environment=self._environment,
            )
            self._text = etree.tostring(xml)
        elif self._arguments:
            self._warn(xml, f"there are no macros: {', '.join(self._arguments)} has no effect")
        if local_name(xml) == ROBOT:
            from libgz.sdf.urdf import sdf_of  # other files do without it

            xml = sdf_of(xml, self.label, self.diagnostics)
        if local_name(xml) not in ROOTS:
            raise WorldFileError(
                f"{self.label}:{line_of(xml)}: <{local_name(xml)}>: the root of an SDF file must be <sdf version='...'>"
            )
        self.version = self._described_version(xml)
        blocks = describe(self.version)
        self.root = self._element(xml, blocks["sdf"])
        if self._around:
            return
        self._check_names()
        if not self.diagnostics.errors:
            try:
                resolve_frames(self.root, self.diagnostics)
            except RecursionError as error:
                self.diagnostics.failure(self.root, error)
        advise(warn_of_unsimulated, None, self.root, self.diagnostics)

    def _described_version(self, xml: etree._Element) -> str:
        """The version whose description applies: the file's, or the nearest one, with a warning."""
        given = xml.get("version", OLDEST if local_name(xml) == "gazebo" else None)
        if given is None:
            self._error(xml, "version is missing and must be given")
            return NEWEST
        given = given.strip()
        if given in VERSIONS:
            return given
        if not given:
            self._warn(xml, f"version is empty; {NEWEST} is used")
            return NEWEST
        try:
            number = tuple(map(int, given.split(".")))
        except ValueError:
            self._error(xml, f"version {given!r} is not allowed; {OLDEST} to {VERSIONS[-1]} are")
            return NEWEST
        if number < (1, 4):
            from libgz.sdf.conversion import convert  # few documents are that old

            convert(xml, given, VERSIONS[0], self.label)
            self._warn(xml, f"version {given} is read as {VERSIONS[0]}; `libgz upgrade` writes it as {NEWEST}")
            return VERSIONS[0]
        self._warn(xml, f"version {given} is read as {VERSIONS[-1]}; {OLDEST} to {VERSIONS[-1]} are known")
        return VERSIONS[-1]

    def _error(self, xml: etree._Element, message: str) -> None:
        self.diagnostics.error(self._place(xml), message)

    def _warn(self, xml: etree._Element, message: str) -> None:
        self.diagnostics.warn(self._place(xml), message)

    def _place(self, xml: etree._Element) -> Place:
        return place_of(xml, self.label)

    # Elements ----------------------------------------------------------------------------------------------------

    def _element(self, xml: etree._Element, description: Description | None) -> Element:
        """An element and all in it, checked against its description."""
        name = description.name if description is not None else tag_name(xml)
        place = self._place(xml)
        element = Element(name, description, file=place.file, line=place.line)
        self._read_attributes(xml, element)
        if name == "sensor" and "type" in element.attributes:
            kind = element.attributes["type"]
            kind.text = SENSORS.get(kind.text, kind.text)
        if name == "joint" and "type" in element.attributes:
            kind = element.attributes["type"]
            kind.text = JOINTS.get(kind.text, kind.text)
        self._read_value(xml, element)
        for child in xml:
            if isinstance(child.tag, str):
                self._read_child(child, element)
        if description is not None:
            self._check_required(xml, element, description)
        return element

    def _read_attributes(self, xml: etree._Element, element: Element) -> None:
        description = element.description
        for key, text in xml.attrib.items():
            if key == PLACE:
                continue
            name = str(key).rpartition("}")[2]
            if name in element.attributes or description is None or description.open:
                pass
            elif any(name in described.all_attributes for _, described in description.later(self.version)):
                self._warn(
                    xml, f"attribute {name!r} is of a later version than SDF {self.version}; it is read all the same"
                )
            else:
                self.diagnostics.no_effect(self._place(xml), functools.partial(self._unknown_attribute, name, element))
                continue
            if name == "frame" and not text.strip():
                continue  # of a pose: an empty frame is none
            param = element.attributes.setdefault(name, Param(name, "string", "", given=True))
            param.SetFromString(str(text))
            self._check_value(xml, param, param.text, name)
        for about in description.all_attributes.values() if description is not None else ():
            if about.required and about.default == UNSET and not element.attributes[about.name].given:
                self._error(xml, f"attribute {about.name!r} is missing and must be given")

    def _unknown_attribute(self, name: str, element: Element) -> str:
        known = nearest(name, element.attributes)
        return f"attribute {name!r} is not part of SDF {self.version} and is ignored{known}"

    def _read_value(self, xml: etree._Element, element: Element) -> None:
        text = "".join([xml.text or "", *(child.tail or "" for child in xml)]) if len(xml) else xml.text
        if not text or text.isspace():
            return
        element.value.SetFromString(text)
        kind = element.value.kind
        try:
            if kind == "pose" and self._in_other_units(element, text):
                return
        except ParameterError as error:
            self._error(xml, str(error))
            return
        self._check_value(xml, element.value, text)

    def _check_value(self, xml: etree._Element, param: Param, text: str, name: str = "") -> None:
        """Replace a value that is not of its kind by what Gazebo classic reads, with a warning; else it is an error."""
        allowed = check(param.kind, text)
        if not allowed:
            self._check_bounds(xml, param)
            return
        written = f"{name} {text.strip()!r}".lstrip()
        usable = repaired(param.kind, text, param.default)
        if usable:
            param.SetFromString(usable)
            self._warn(xml, f"{written} is read as {usable!r}; it should be {allowed}")
        else:
            self._error(xml, f"{written} is not allowed; it must be {allowed}")

    def _check_bounds(self, xml: etree._Element, param: Param) -> None:
        above = xml.getparent()
        if above is None or param.name != local_name(xml):
            return
        usable = in_bounds(local_name(above), param.name, param.kind, param.text, param.default)
        if usable != param.text:
            self._warn(xml, f"{param.text!r} is out of range; {usable!r} is used")
            param.SetFromString(usable)

    @staticmethod
    def _in_other_units(pose: Element, text: str) -> bool:
        """Replace a pose in degrees, or with a quaternion, by one in radians; whether it was one.

        Raises:
            ParameterError: it has not the numbers that it needs.
        """
        form = pose.attributes["rotation_format"].text if pose.HasAttribute("rotation_format") else "euler_rpy"
        degrees = pose.HasAttribute("degrees") and pose.attributes["degrees"].Get(bool)
        if form not in ("", "euler_rpy", "quat_xyzw"):
            raise ParameterError(f"rotation_format is {form!r}; euler_rpy and quat_xyzw are allowed")
        quaternion = form == "quat_xyzw"
        if not (quaternion or degrees):
            return False
        if quaternion and degrees:
            raise ParameterError("degrees have no meaning for rotation_format='quat_xyzw'")
        numbers = [parse(float, word) for word in text.split()]
        if len(numbers) != (7 if quaternion else 6):
            raise ParameterError(f"{text.strip()!r} is not allowed; it must be {7 if quaternion else 6} numbers")
        if quaternion:
            x, y, z, w = numbers[3:]
            size = math.sqrt(x * x + y * y + z * z + w * w)
            if not size > 0.0:
                raise ParameterError(f"{text.strip()!r} is not allowed; a quaternion must not be zero")
            rotation = GzQuatern(w / size, x / size, y / size, z / size)
        else:
            rotation = GzQuaternFromEuler(*map(math.radians, numbers[3:]))
        pose.value.SetFromString(exact_pose(GzPose(GzVector(*numbers[:3]), rotation)))
        for key in ("degrees", "rotation_format"):
            pose.attributes[key].given = False
        return True

    def _read_child(self, xml: etree._Element, parent: Element) -> None:
        description = parent.description
        name = tag_name(xml)
        if name == "include" and description is not None and parent.name in HOLDERS:
            self._include(xml, parent)
            return
        if parent.name == "sensor":
            name = SENSORS.get(name, name)
        if self.version >= "1.7" and (parent.name, name) in REPLACED:
            gone = f"is not part of SDF {self.version} and has no effect; {REPLACED[parent.name, name]} took its place"
            self.diagnostics.no_effect(self._place(xml), functools.partial(str, gone))
            return
        extension = ":" in name  # whose prefix says that it is not of SDF
        known = description.children.get(name) if description is not None and not description.open else None
        if known is None and self._parts and parent.name == "sdf":
            known = describe(self.version).get(name)
        if known is not None and known.count in ("0", "1") and parent.HasElement(name) and not _repeated(parent, name):
            again = f"occurs more than once in <{parent.name}>; only the first one has an effect"
            self.diagnostics.no_effect(self._place(xml), lambda: again)
        elif (
            known is None
            and not extension
            and description is not None
            and not description.open
            and description.children
            and (known := self._later(xml, name, parent)) is None
        ):
            names = description.children
            self.diagnostics.no_effect(
                self._place(xml),
                lambda: f"is not part of SDF {self.version} in <{parent.name}> and has no effect{nearest(name, names)}",
            )
        parent.InsertElement(self._element(xml, known))

    def _later(self, xml: etree._Element, name: str, parent: Element) -> Description | None:
        """What a later version has of that name, with a warning: Gazebo classic read older files as its own version."""
        if parent.description is None:
            return None
        for version, described in parent.description.later(self.version):
            if name in described.children:
                self._warn(xml, f"is part of SDF {version}, not of {self.version}; it is read all the same")
                return described.children[name]
        return None

    def _check_required(self, xml: etree._Element, element: Element, description: Description) -> None:
        """Create missing required children with their defaults; a missing one without a default is an error."""
        for name, about in description.children.items():
            if not about.required or element.HasElement(name):
                continue
            if element.name == "model" and name == "link":
                continue  # it is only a name then
            if element.name == "script" and "uri" in description.children:
                element.AddElement(name)  # of a material: many files have only one of both, or plain text
            elif (element.name, name) in NEEDED:
                self._error(xml, f"<{name}> is missing and must be given")
            elif element.name == "joint" and name == "axis" and element.attributes["type"].text in ("ball", "fixed"):
                continue
            else:
                axis = element.AddElement(name)
                if element.name == "joint" and name == "axis":
                    self._warn(xml, f"<axis> is missing; it is {axis.Get(str, 'xyz')}")
                elif (
                    about.default == UNSET and name != "uri"
                ):  # what lacks a file is left out with a warning of its own
                    self._warn(xml, f"<{name}> is missing")

    def _check_names(self) -> None:
        """Warn of two elements of one kind and name in one parent: only the first is found by its name.

        Of two models of a world, only the first is built, as in Gazebo.
        """
        for holder in (*self.root.find("world"), *self.root.find("link")):
            first: dict[tuple[str, str], Element] = {}
            built = []
            for element in holder.children:
                name = element.Get(str, "name") if element.name in UNIQUE else ""
                before = first.setdefault((element.name, name), element)
                if name and before is not element:
                    left = holder.name == "world" and element.name == "model"
                    end = "it is left out" if left else "names must differ"
                    message = f"{name!r} is the name of another <{element.name}>, at {before.where}; {end}"
                    self.diagnostics.warn(element, message)
                    if left:
                        element.parent = None
                        continue
                built.append(element)
            holder.children = built
        for model in self.root.find("model"):
            self._rename_parts(model)

    def _rename_parts(self, model: Element) -> None:
        """Give links and nested models of a name that is taken another one: the first is found by its name."""
        parts = [element for element in model.children if element.name in ("link", "model")]
        taken = {element.Get(str, "name") for element in parts}
        first: dict[str, Element] = {}
        numbers: dict[str, Iterator[int]] = {}
        for element in parts:
            name = element.Get(str, "name")
            before = first.setdefault(name, element)
            if name and before is not element:  # one without a name is an error already
                count = numbers.setdefault(name, itertools.count(1))
                free = next(free for number in count if (free := f"{name}_{number}") not in taken)
                taken.add(free)
                element.attributes["name"].Set(free)
                message = f"{name!r} is the name of another <{before.name}>, at {before.where}; it is {free!r} here"
                self.diagnostics.warn(element, message)

    # Includes ----------------------------------------------------------------------------------------------------

    def _include(self, xml: etree._Element, parent: Element) -> None:
        """Replace an include by its model, actor or light, with the name and pose that the include sets.

        One that cannot be read stays as it is, with a warning: the rest of the world runs.
        """
        given = {local_name(child): child for child in xml if isinstance(child.tag, str)}
        uri = (given["uri"].text or "").strip() if "uri" in given else xml.get("filename", "").strip()
        if not uri:
            self._warn(xml, "<uri> is missing; the include is left out")
            return
        if "model_pose" in xml.attrib and "pose" not in given:  # beside `filename`, in worlds of Gazebo 1
            given["pose"] = etree.SubElement(xml, "pose")
            given["pose"].text = xml.get("model_pose")
            copy_place(given["pose"], xml)
        if len(self._around) >= DEEPEST_INCLUDE:
            self._error(xml, f"includes are nested deeper than {DEEPEST_INCLUDE}")
            return
        around = self._around | {self._path.resolve() if self._path is not None else Path()}
        try:
            path = find_model(uri, self._folder)
            if path.resolve() in around:
                self._error(xml, f"{uri} includes itself")
                return
            included = SdfFile()
            included._environment = self._environment
            self._included.take(EACH_INCLUDED + path.stat().st_size)
            included._around, included._included = around, self._included
            included._read_file(path)
        except BudgetError:
            self._end_includes(xml)
            return
        except (NotFoundError, WorldFileError, OSError) as error:
            self._warn(xml, f"{error}; it is left out")
            parent.InsertElement(self._element(xml, describe(NEWEST)["world"].children["include"]))
            return
        known = (*describe(VERSIONS[-1])[parent.name].children["include"].children, "plugin")
        for key, child in given.items():
            if key not in known and child.prefix is None and ":" not in str(child.tag):
                message = f"is not part of SDF in <include> and has no effect{nearest(key, known)}"
                self.diagnostics.no_effect(self._place(child), functools.partial(str, message))
        self.diagnostics.include(included.diagnostics, included.label, self._place(xml).line)
        entity = next((e for e in included.root.children if e.name in ("model", "light", "actor")), None)
        if entity is None:
            self._warn(xml, f"{path} has no model, light or actor; the include is left out")
            return
        self._apply_include(xml, entity, given)
        included.root.RemoveChild(entity)
        if xml.get("merge", "").strip().lower() in ("true", "1") and entity.name == parent.name == "model":
            merge(entity, parent, self.diagnostics)
            return
        self._share_static(entity, parent)
        if parent.name == entity.name == "model" and self.version <= FLAT and next(entity.named("model"), None) is None:
            try:
                self._included.take(len(entity.Get(str, "name")) * len(entity.children))  # each part gets the name
            except BudgetError:
                self._end_includes(xml)
                return
            self._flatten(entity, parent)
        else:
            parent.InsertElement(entity)

    def _end_includes(self, xml: etree._Element) -> None:
        """Report that includes hold too much; further ones are not looked for."""
        self._included.used = self._included.limit
        self._error(xml, f"includes have more than {MOST_INCLUDED >> 20} MiB together")

    def _flatten(self, entity: Element, parent: Element) -> None:
        """Make the parts of an included model parts of the model around it, as Gazebo does: `included::link`.

        Two frames are where the included model is: that which has Gazebo's name, and one of the model's.
        """
        name = entity.Get(str, "name")
        prefix_names(entity)
        links = [link.Get(str, "name") for link in entity.named("link")]
        frame = merge(entity, parent, self.diagnostics, f"{name}::{MODEL}")
        if links:
            frame.set_attribute("attached_to", links[0])
        add_frame(parent, name, f"{name}::{MODEL}")
        for child in entity.children:  # such as <self_collide>
            if child.name != "pose" and next(parent.named(child.name), None) is None:
                parent.InsertElement(child.Clone())

    def _share_static(self, entity: Element, parent: Element) -> None:
        """Make a model static as a whole if one that it includes is, and itself states nothing, as in Gazebo."""
        given = next(entity.named("static"), None)
        if parent.name != "model" or any(True for _ in parent.named("static")) or given is None or not given.Get(bool):
            return
        self.diagnostics.warn(
            parent,
            f"is static as a whole, because the included model {entity.Get(str, 'name')!r} is; "
            "with <static>false</static> before the include nothing in it is",
        )
        parent.InsertElement(given.Clone())

    def _apply_include(self, xml: etree._Element, entity: Element, given: dict[str, etree._Element]) -> None:
        """Apply name, pose, static and plugins of an include to the included entity."""
        entity.include = self._place(xml)
        name = (given["name"].text or "").strip() if "name" in given else ""
        if name:
            entity.set_attribute("name", name)
        if "placement_frame" in given:
            entity.set_attribute("placement_frame", (given["placement_frame"].text or "").strip())
        described = describe(self.version)["model"].children
        for key in ("pose", "static"):
            old = next(entity.named(key), None)
            known = entity.description is None or key in entity.description.children
            if key not in given or not known:
                continue
            if old is not None:
                entity.RemoveChild(old)
            entity.InsertElement(self._element(given[key], described[key]))
        plugin = describe(self.version)["plugin"]
        for child in xml:
            if isinstance(child.tag, str) and local_name(child) == "plugin":
                entity.InsertElement(self._element(child, plugin))


def _repeated(parent: Element, name: str) -> bool:
    """Whether further elements of this name have an effect."""
    kind = parent.attributes.get("type") if parent.name == "sensor" else None
    what = kind.text if kind is not None else parent.name
    return (what, name) in REPEATED
