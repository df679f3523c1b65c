"""The page of SDF's elements: type, default, versions, and whether libgz acts on each."""

from __future__ import annotations

import csv
import re

from libgz.reference.markdown import NOTE, cell
from libgz.sdf.description import ABSENT, TABLE, UNITS, UNSET

__all__ = ["NO_EFFECT", "rows_of_sdf", "sdf_block", "sdf_blocks", "sdf_elements_page", "without_effect"]

# Path -> why libgz does not act on the element, and what is below it. The text "" stands for that of the path above.
NO_EFFECT: dict[str, str] = {
    "physics/real_time_factor": "kept; Gazebo did not use it, either",
    "physics/bullet": "ODE only",
    "physics/simbody": "ODE only",
    "physics/dart": "ODE only",
    "physics/ode/solver/min_step_size": "kept",
    "physics/ode/constraints/contact_surface_layer": "kept: as in Gazebo, surfaces have a min_depth",
    "physics/ode/solver/island_threads": "kept",
    "physics/ode/solver/precon_iters": "kept",
    "physics/ode/solver/thread_position_correction": "kept",
    "physics/ode/solver/use_dynamic_moi_rescaling": "kept",
    "scene/sky/sunrise": "the sky follows the time only",
    "scene/sky/sunset": "the sky follows the time only",
    "scene/sky/clouds": "the sky is rendered without clouds",
    "scene/origin_visual": "the origin is not shown",
    "spherical_coordinates/surface_model": "the Earth's WGS 84",
    "spherical_coordinates/world_frame_orientation": "east, north, up",
    "gui@fullscreen": "the client's window is a page",
    "gui/camera/projection_type": "perspective",
    "gui/camera/track_visual/min_dist": "kept",
    "gui/camera/track_visual/max_dist": "kept",
    "gui/camera/track_visual/use_model_frame": "kept",
    "gui/camera/track_visual/inherit_yaw": "kept",
    "link/must_be_base_link": "kept",
    "heightmap/texture/normal": "light follows the heights alone",
    "heightmap/use_terrain_paging": "kept",
    "heightmap/sampling": "each sample of the image is one of the height map",
    "image": "warning: the shape is not supported",
    "geometry/image": "warning: the shape is not supported",
    "surface/friction/bullet": "ODE only",
    "surface/contact/bullet": "ODE only",
    "surface/contact/category_bitmask": "collide_bitmask of both decides",
    "surface/contact/ode/soft_cfm": "kp and kd decide",
    "surface/contact/ode/soft_erp": "kp and kd decide",
    "surface/friction/torsional/ode/slip": "kept",
    "visual/meta": "kept",
    "material/shader": "rendered without it",
    "joint/axis/initial_position": "warning: as in Gazebo, poses of links decide",
    "joint/axis2/initial_position": "warning: as in Gazebo, poses of links decide",
    "joint/axis/limit/stiffness": "stops are hard",
    "joint/axis/limit/dissipation": "stops are hard",
    "joint/axis2/limit/stiffness": "stops are hard",
    "joint/axis2/limit/dissipation": "stops are hard",
    "camera/depth_camera/output": "a depth camera has all of them",
    "camera/distortion": "warning: images are rendered without it",
    "camera/lens": "warning: images are rendered without it",
}
VERSIONS = ("1.4", "1.5", "1.6")  # of the table


def rows_of_sdf() -> dict[str, dict[str, str]]:
    """Path -> row of the table that describes SDF 1.4 to 1.6."""
    with TABLE.open(encoding="utf-8", newline="") as table:
        return {row["path"]: row for row in csv.DictReader(table, delimiter="\t")}


def without_effect(path: str) -> str | None:
    """Why an element has no effect; None if it has one."""
    at = path
    while at:
        if at in NO_EFFECT:
            return NO_EFFECT[at]
        at = at[: max(at.rfind("/"), at.rfind("@"), 0)]
    return None


def sdf_elements_page() -> str:
    """Every element of SDF 1.4 to 1.6: type, default, versions, and whether libgz acts on it."""
    parts = [
        NOTE,
        "# Elements of SDF\n",
        "Every element and attribute (`@`) of SDF 1.4, 1.5 and 1.6, block by block, with its default in 1.6 and "
        "whether libgz acts on it. [SDF](sdf.md) says how older and newer versions are read. What is not part of a "
        "file's version is a warning with its line, and has no effect; `libgz sdf --check FILE` prints all of them.\n",
        "In brief: worlds, models, nested models, links, inertias, collisions, visuals, lights, joints of all kinds "
        "with dynamics, limits and springs, surfaces, sensors, plugins, scene, fog, includes, states, actors, "
        "populations, wind, atmosphere and grippers act. Other engines than ODE, shaders, lens models and distortion "
        "do not.\n",
    ]
    for block in sdf_blocks():
        parts += [f"## {block}\n", sdf_block(block)]
    return "\n".join(parts)


def sdf_blocks() -> list[str]:
    """The names of the blocks: `link`, `joint`, `camera`, ..."""
    return sorted({re.split("[/@]", path)[0] for path in rows_of_sdf()})


def sdf_block(block: str) -> str:
    """The table of one block's elements."""
    rows = ["| element | type | default | from | acts |", "|---|---|---|---|---|"]
    for path, row in rows_of_sdf().items():
        inside = path.removeprefix(block).removeprefix("/")
        if re.split("[/@]", path)[0] == block and inside:
            rows.append(sdf_row(inside, path, row))
    return "\n".join([*rows, ""])


def sdf_row(inside: str, path: str, row: dict[str, str]) -> str:
    """A row of an element."""
    kind, default = row["type"] or "", row["default_1.6"] or ""
    if kind.startswith("@"):
        kind = f"[{kind[1:]}](#{kind[1:]})"
    there = [version for version in VERSIONS if row[f"default_{version}"] != ABSENT and row[f"count_{version}"] != "-"]
    span = there[0] if there and there[-1] == VERSIONS[-1] else f"{there[0]} to {there[-1]}" if there else ""
    note, reason = row["note"] or "", without_effect(path)
    unit = f" [{note}]" if note in UNITS else ""
    acts = f"no: {reason}" if reason else "yes" if unit or not note else f"yes: {note}"
    shown = f"`{cell(default)}`" if default not in ("", ABSENT, UNSET) else ""
    return f"| `{inside}` | {kind}{unit} | {shown} | {span} | {cell(acts)} |"
