"""The names of Gazebo 7 and before, as inline methods of C++ classes; the table of libgz's Python names has them."""

from __future__ import annotations

import functools
import re
from collections.abc import Iterator

from libgz.classic.api import classic_api
from libgz.classic_cxx.table import Class, Row, classes

__all__ = ["old_methods"]

# Names of Gazebo 7 whose present ones are not the same without Get.
RENAMED = {
    "EnablePhysicsEngine": "SetPhysicsEnabled",
    "GetAngleCount": "DOF",
    "GetAttribute": "GetParam",
    "GetByName": "BaseByName",
    "GetDampingCoefficient": "GetDamping",
    "GetEnablePhysicsEngine": "PhysicsEnabled",
    "GetEntity": "EntityByName",
    "GetHighStop": "UpperLimit",
    "GetLowStop": "LowerLimit",
    "GetPhysicsEngine": "Physics",
    "GetProductsofInertia": "ProductsOfInertia",
    "GetRunning": "Running",
    "GetSphericalCoordinates": "SphericalCoords",
    "SetAngle": "SetPosition",
    "SetAttribute": "SetParam",
    "SetHighStop": "SetUpperLimit",
    "SetLowStop": "SetLowerLimit",
    "StepWorld": "Step",
}
# Old methods that do more than rename.
OLD_METHODS = {
    ("physics::Joint", "GetAngle"): ("math::Angle", "unsigned int i", "Position(i)"),
    ("physics::Joint", "GetLowerLimit"): ("math::Angle", "unsigned int i", "LowerLimit(i)"),
    ("physics::Joint", "GetUpperLimit"): ("math::Angle", "unsigned int i", "UpperLimit(i)"),
    ("physics::Joint", "GetLowStop"): ("math::Angle", "unsigned int i", "LowerLimit(i)"),
    ("physics::Joint", "GetHighStop"): ("math::Angle", "unsigned int i", "UpperLimit(i)"),
    ("physics::Joint", "SetLowStop"): ("void", "unsigned int i, const math::Angle &a", "SetLowerLimit(i, a.Radian())"),
    ("physics::Joint", "SetHighStop"): ("void", "unsigned int i, const math::Angle &a", "SetUpperLimit(i, a.Radian())"),
    ("physics::Joint", "GetMaxForce"): ("double", "unsigned int i", 'GetParam("fmax", i)'),
    ("physics::Joint", "SetMaxForce"): ("void", "unsigned int i, double f", 'SetParam("fmax", i, f)'),
    ("physics::PhysicsEngine", "GetGravity"): ("math::Vector3", "", "libgz::gravity_of(this)"),
    ("common::PoseKeyFrame", "SetTranslation"): ("void", "const math::Vector3 &v", "Translation(v)"),
    ("common::PoseKeyFrame", "SetRotation"): ("void", "const math::Quaternion &q", "Rotation(q)"),
    ("physics::World", "Light"): ("LightPtr", "const std::string &name", "LightByName(name)"),
    ("physics::World", "GetModel"): ("ModelPtr", "const std::string &name", "ModelByName(name)"),
    ("physics::World", "GetModel "): ("ModelPtr", "unsigned int i", "ModelByIndex(i)"),
    ("physics::World", "GetLight"): ("LightPtr", "const std::string &name", "LightByName(name)"),
    ("physics::World", "GetModelBelowPoint"): ("ModelPtr", "const math::Vector3 &p", "ModelBelowPoint(p)"),
    ("physics::World", "GetEntityBelowPoint"): ("EntityPtr", "const math::Vector3 &p", "EntityBelowPoint(p)"),
}


def _names(one: Class) -> set[str]:
    """The names of the methods of a class and of its bases."""
    own = {row.name for row in one.methods}
    return own.union(*(_names(classes()[base]) for base in one.bases if base in classes()))


def old_methods(one: Class) -> Iterator[str]:
    """Inline methods under the names of Gazebo 7 and before, which the table of libgz's Python names has."""
    owner = f"{one.space}::{one.row.name}"
    known = _names(one)
    added = (name.strip() for holder, name in OLD_METHODS if holder == owner)
    for name in dict.fromkeys((*_old_of(one), *_hidden(one), *added, *_getters(one))):
        found = [method for key, method in OLD_METHODS.items() if (key[0], key[1].strip()) == (owner, name)]
        for result, parameters, call in found:
            const = " const" if result != "void" and "GetParam" not in call else ""
            yield f"  {result} {name}({parameters}){const} {{ {'' if result == 'void' else 'return '}{call}; }}"
        if found:
            continue
        new = RENAMED.get(name, name.removeprefix("Get"))
        if name not in known and new in known and new != one.row.name:
            const = " const" if any(row.name == new and "const" in row.flags for row in _all_methods(one)) else ""
            call = f"this->{new}(std::forward<A>(a)...)"
            if _is_void(one, new):
                yield f"  template <typename... A> void {name}(A &&...a){const} {{ {call}; }}"
            else:
                yield f"  template <typename... A> auto {name}(A &&...a){const} {{ return libgz::old({call}); }}"
    for row in one.methods:
        if re.fullmatch(r"Connect[A-Z]\w+", row.name):
            yield f"  void Dis{row.name[0].lower()}{row.name[1:]}(const event::ConnectionPtr &c) {{ event::end(c); }}"


def _getters(one: Class) -> Iterator[str]:
    """The names of sensors' getters, all of which began with Get."""
    if one.space == "sensors":
        for row in one.methods:
            if "const" in row.flags and not row.name.startswith(("Get", "Is", "~")):
                yield f"Get{row.name}"


def _old_of(one: Class) -> tuple[str, ...]:
    return _old().get(f"{one.space}.{one.row.name}", ())


def _hidden(one: Class) -> Iterator[str]:
    """The old names of bases whose present names have further forms in a class: GetWorldLinearVel of links."""
    for base in (classes()[name] for name in one.bases if name in classes()):
        known = {(row.name, row.parameters) for row in _all_methods(base)}
        further = {row.name for row in one.methods if (row.name, row.parameters) not in known}
        for name in dict.fromkeys((*_old_of(base), *_hidden(base))):
            if RENAMED.get(name, name.removeprefix("Get")) in further and name not in _old_of(one):
                yield name


def _all_methods(one: Class) -> Iterator[Row]:
    """The methods of a class and of its bases."""
    yield from one.methods
    for base in one.bases:
        if base in classes():
            yield from _all_methods(classes()[base])


def _is_void(one: Class, name: str) -> bool:
    return any(row.name == name and row.type == "void" for row in _all_methods(one))


@functools.cache
def _old() -> dict[str, tuple[str, ...]]:
    """The old names of each class such as physics.Link."""
    found: dict[str, list[str]] = {}
    for row in classic_api():
        if row.state == "old":
            found.setdefault(row.holder, []).append(row.name)
    return {holder: tuple(names) for holder, names in found.items()}
