"""Classic's messages as .proto files with classic's file names, for its C++ plugins and for .proto files of users."""

from __future__ import annotations

import re

from libgz.base.errors import ParameterError
from libgz.classic.msgs.declare import PREFIX, declarations

__all__ = ["file_of", "proto_files"]

PACKAGE = PREFIX.rstrip(".")
# Messages whose files are not called as the message is, in small letters with underscores.
FILES = {
    "BoxGeom": "boxgeom",
    "CameraSensor": "camerasensor",
    "ContactSensor": "contactsensor",
    "CylinderGeom": "cylindergeom",
    "ForceTorque": "joint_wrench_stamped",
    "GPSSensor": "gps_sensor",
    "GUICamera": "gui_camera",
    "GzString_V": "gz_string_v",
    "HeightmapGeom": "heightmapgeom",
    "IMUSensor": "imu_sensor",
    "ImageGeom": "imagegeom",
    "LaserScan": "laserscan",
    "LaserScanStamped": "laserscan_stamped",
    "LogPlaybackStatistics": "log_playback_stats",
    "MeshGeom": "meshgeom",
    "Model_V": "model_v",
    "Param_V": "param_v",
    "PlaneGeom": "planegeom",
    "PointCloud": "pointcloud",
    "Polyline": "polylinegeom",
    "Pose_V": "pose_v",
    "RaySensor": "raysensor",
    "SphereGeom": "spheregeom",
    "WorldStatistics": "world_stats",
}
_PART = re.compile(r",\s*(?=[\w.]+\s+[A-Za-z_])")
_FIELD = re.compile(
    r"(?P<kind>[\w.]+)\s+(?P<name>[A-Za-z_]\w*)\s*(?P<label>!|\[\])?\s*(?P<number>\d+)\s*(?:=\s*(?P<default>\S+))?"
)
LABELS = {None: "optional", "!": "required", "[]": "repeated"}


def file_of(message: str) -> str:
    """The name of a message's file without its ending: Vector3d is in `vector3d`, PosesStamped in `poses_stamped`."""
    return FILES.get(message) or re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", message).lower()


def proto_files() -> dict[str, str]:
    """The text of each .proto file by its name."""
    messages: dict[str, list[str]] = {}
    for name in declarations():
        if "." not in name:
            messages.setdefault(file_of(name), []).append(name)
    return {f"{file}.proto": _file_text(file, names) for file, names in messages.items()}


def _file_text(file: str, names: list[str]) -> str:
    used: set[str] = set()
    body = "".join(_type_text(name, "", used) for name in names)
    imports = sorted({file_of(name) for name in used if name in declarations()} - {file})
    lines = ['syntax = "proto2";', f"package {PACKAGE};", *(f'import "{name}.proto";' for name in imports)]
    return "\n".join(lines) + "\n" + body


def _type_text(name: str, indent: str, used: set[str]) -> str:
    """A message or an enumeration, with those inside it; adds the names of what its fields are to `used`."""
    declaration, short = declarations()[name], name.rpartition(".")[2]
    if declaration.startswith("enum "):
        rows = (word.split() for word in declaration.removeprefix("enum ").split(", "))
        values = "".join(f"{indent}  {word} = {number};\n" for word, number in rows)
        return f"{indent}enum {short} {{\n{values}{indent}}}\n"
    inner = [one for one in declarations() if one.rpartition(".")[0] == name]
    text = "".join(_type_text(one, indent + "  ", used) for one in inner)
    for part in _PART.split(declaration) if declaration else ():
        field = _FIELD.match(part.strip())
        if field is None:
            raise ParameterError(f"messages.txt: {name}: {part!r} is no field")
        used.add(field["kind"].partition(".")[0])
        default = field["default"]
        if default is not None:
            value = f'"{default.strip(chr(34))}"' if field["kind"] == "string" else default
            default = f" [default = {value}]"
        text += (
            f"{indent}  {LABELS[field['label']]} {field['kind']} {field['name']} = {field['number']}{default or ''};\n"
        )
    return f"{indent}message {short} {{\n{text}{indent}}}\n"
