"""Write the figures that actors wear: libgz/sdf/media/models/walk.dae, run.dae, moonwalk.dae and stand.dae.

A person of 1.7 m of seventeen bones, made of tubes around them. In the frame of each bone x points to the left, y up
and z ahead; in the file the person looks along x, with z up, as SDF's models do.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FOLDER = Path(__file__).parent.parent / "libgz/sdf/media/models"
FRAMES = 24  # of an animation's cycle
SIDES = 10  # of a tube

# name: (parent, place in the parent's frame [m])
BONES: dict[str, tuple[str, tuple[float, float, float]]] = {
    "Hips": ("", (0.0, 0.0, 0.0)),
    "Spine": ("Hips", (0.0, 0.12, 0.0)),
    "Chest": ("Spine", (0.0, 0.18, 0.0)),
    "Neck": ("Chest", (0.0, 0.22, 0.0)),
    "Head": ("Neck", (0.0, 0.08, 0.01)),
}
for side, sign in (("Left", 1.0), ("Right", -1.0)):
    BONES |= {
        f"{side}UpLeg": ("Hips", (0.095 * sign, -0.05, 0.0)),
        f"{side}Leg": (f"{side}UpLeg", (0.0, -0.42, 0.0)),
        f"{side}Foot": (f"{side}Leg", (0.0, -0.41, 0.0)),
        f"{side}Arm": ("Chest", (0.19 * sign, 0.15, 0.0)),
        f"{side}ForeArm": (f"{side}Arm", (0.02 * sign, -0.28, 0.0)),
        f"{side}Hand": (f"{side}ForeArm", (0.0, -0.25, 0.0)),
    }
NAMES = list(BONES)
SOLE = 0.07  # [m] below a foot
HIP = 0.95  # [m] at rest
UPRIGHT = np.array([[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])

COLORS = {
    "skin": (0.80, 0.60, 0.47),
    "hair": (0.22, 0.15, 0.10),
    "shirt": (0.20, 0.38, 0.62),
    "trousers": (0.25, 0.25, 0.28),
    "shoes": (0.12, 0.10, 0.09),
}


def turned(axis: int, angle: float) -> Array:
    """The rotation about x, y or z."""
    c, s = math.cos(angle), math.sin(angle)
    result = np.eye(4)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    result[a, a], result[a, b], result[b, a], result[b, b] = c, -s, s, c
    return result


def world(local: dict[str, Array]) -> dict[str, Array]:
    """The frames of all bones in the file's frame."""
    found: dict[str, Array] = {}
    for name, (parent, _) in BONES.items():
        found[name] = found[parent] @ local[name] if parent else local[name]
    return found


def placed(turns: dict[str, Array], x: float = 0.0, height: float = HIP) -> dict[str, Array]:
    """The frames of all bones in those of their parents, with the given rotations."""
    local = {}
    for name, (parent, place) in BONES.items():
        matrix = np.eye(4)
        matrix[:3, 3] = place if parent else (x, 0.0, height)
        local[name] = matrix @ (turns.get(name, np.eye(4)) if parent else UPRIGHT @ turns.get(name, np.eye(4)))
    return local


# Animation -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Gait:
    """How the person moves: swing of thighs and arms [rad], of bent knees and elbows [rad], step [m], period [s]."""

    thigh: float
    knee: float
    arm: float
    elbow: float
    lean: float
    stride: float
    period: float


GAITS = {
    "walk": Gait(0.42, 0.85, 0.38, 0.25, 0.03, 1.44, 1.2),
    "run": Gait(0.75, 1.6, 0.75, 1.3, 0.18, 2.4, 0.8),
    "moonwalk": Gait(0.36, 0.75, 0.15, 0.3, 0.05, -1.2, 1.4),
    "stand": Gait(0.0, 0.0, 0.0, 0.15, 0.0, 0.0, 4.0),
}


def pose(gait: Gait, phase: float) -> dict[str, Array]:
    """The frames of all bones in those of their parents at a phase of the cycle [rad]."""
    turns: dict[str, Array] = {}
    breath = 0.015 * math.sin(phase) if not gait.stride else 0.0
    twist = 0.2 * gait.thigh * math.sin(phase)
    turns["Spine"] = turned(0, gait.lean + breath)
    turns["Chest"] = turned(1, twist) @ turned(0, breath)
    turns["Head"] = turned(1, -twist) @ turned(0, -gait.lean)
    for side, shift, sign in (("Left", 0.0, 1.0), ("Right", math.pi, -1.0)):
        swing = phase + shift
        thigh = gait.thigh * math.sin(swing) + 0.12 * gait.thigh
        knee = 0.08 * bool(gait.stride) + gait.knee * max(0.0, math.cos(swing + 0.45)) ** 2
        turns[f"{side}UpLeg"] = turned(0, -thigh)
        turns[f"{side}Leg"] = turned(0, knee)
        turns[f"{side}Foot"] = turned(0, 0.75 * (thigh - knee))
        arm = -gait.arm * math.sin(swing)
        turns[f"{side}Arm"] = turned(2, 0.06 * sign) @ turned(0, -arm)
        turns[f"{side}ForeArm"] = turned(0, -gait.elbow * (1.0 + 0.4 * math.sin(swing + math.pi)))
    lowest = min(low_point(world(placed(turns)), side) for side in ("Left", "Right"))
    bounce = 0.03 * math.cos(2.0 * phase) if abs(gait.stride) > 2.0 else 0.0
    return placed(turns, gait.stride * phase / (2.0 * math.pi), HIP - lowest + max(bounce, 0.0))


def low_point(frames: dict[str, Array], side: str) -> float:
    """The height of the lowest point of a shoe [m]."""
    ends = np.array([[0.0, -SOLE, -0.05, 1.0], [0.0, -SOLE, 0.17, 1.0]])
    return float(min((frames[f"{side}Foot"] @ end)[2] for end in ends))


# Skin ----------------------------------------------------------------------------------------------------------------


@dataclass
class Skin:
    """Vertices in the file's frame, triangles by colour, and the bones of each vertex with their weights."""

    vertices: list[Array]
    weights: list[dict[str, float]]
    triangles: dict[str, list[tuple[int, int, int]]]


Ring = tuple[str, tuple[float, float, float], float, float, dict[str, float]]


def tube(skin: Skin, color: str, rings: list[Ring], along: int = 1) -> None:
    """Add a closed tube: each ring has a bone, its middle there, half lengths of its axes, and weights of bones.

    Rings lie at right angles to the axis `along` of their bones.
    """
    rest = world(placed({}))
    a, b = [axis for axis in (0, 1, 2) if axis != along]
    starts = []
    for bone, middle, first, second, weights in rings:
        starts.append(len(skin.vertices))
        for i in range(SIDES):
            angle = 2.0 * math.pi * i / SIDES
            point = np.array([*middle, 1.0])
            point[a] += first * math.cos(angle)
            point[b] += second * math.sin(angle)
            skin.vertices.append((rest[bone] @ point)[:3])
            skin.weights.append(weights)
    ends = []
    for bone, middle, _, _, weights in (rings[0], rings[-1]):
        ends.append(len(skin.vertices))
        skin.vertices.append((rest[bone] @ np.array([*middle, 1.0]))[:3])
        skin.weights.append(weights)
    group = skin.triangles.setdefault(color, [])
    faces: list[tuple[int, int, int]] = []
    for low, high in itertools.pairwise(starts):
        for i in range(SIDES):
            j = (i + 1) % SIDES
            faces += [(low + i, low + j, high + j), (low + i, high + j, high + i)]
    for i in range(SIDES):
        j = (i + 1) % SIDES
        faces += [(ends[0], starts[0] + j, starts[0] + i), (ends[1], starts[-1] + i, starts[-1] + j)]
    points = np.array(skin.vertices)
    middle_ = points[[*range(starts[0], ends[1] + 1)]].mean(axis=0)
    first_face = points[list(faces[len(faces) // 3])]
    outwards = np.cross(first_face[1] - first_face[0], first_face[2] - first_face[0]) @ (first_face[0] - middle_)
    group += faces if outwards > 0.0 else [(c, b_, a_) for a_, b_, c in faces]


def both(one: str, other: str, share: float = 0.5) -> dict[str, float]:
    """The weights of a vertex between two bones."""
    return {one: 1.0 - share, other: share}


def person() -> Skin:
    """The skin of the whole person."""
    skin = Skin([], [], {})
    tube(
        skin,
        "shirt",
        [
            ("Hips", (0.0, -0.04, 0.0), 0.155, 0.105, {"Hips": 1.0}),
            ("Hips", (0.0, 0.06, 0.0), 0.15, 0.105, both("Hips", "Spine", 0.3)),
            ("Spine", (0.0, 0.04, 0.0), 0.14, 0.10, both("Spine", "Hips", 0.2)),
            ("Spine", (0.0, 0.13, 0.0), 0.15, 0.105, both("Spine", "Chest")),
            ("Chest", (0.0, 0.05, 0.0), 0.17, 0.115, {"Chest": 1.0}),
            ("Chest", (0.0, 0.13, 0.0), 0.18, 0.11, {"Chest": 1.0}),
            ("Chest", (0.0, 0.18, 0.0), 0.145, 0.09, {"Chest": 1.0}),
            ("Chest", (0.0, 0.215, 0.0), 0.07, 0.06, both("Chest", "Neck", 0.3)),
        ],
    )
    tube(
        skin,
        "skin",
        [
            ("Neck", (0.0, -0.02, 0.0), 0.05, 0.05, both("Neck", "Chest", 0.4)),
            ("Neck", (0.0, 0.04, 0.0), 0.048, 0.05, both("Neck", "Head")),
            ("Head", (0.0, 0.0, 0.01), 0.055, 0.065, {"Head": 1.0}),
            ("Head", (0.0, 0.05, 0.015), 0.072, 0.09, {"Head": 1.0}),
            ("Head", (0.0, 0.11, 0.01), 0.078, 0.095, {"Head": 1.0}),
            ("Head", (0.0, 0.16, 0.0), 0.074, 0.09, {"Head": 1.0}),
        ],
    )
    tube(
        skin,
        "hair",
        [
            ("Head", (0.0, 0.13, -0.012), 0.083, 0.092, {"Head": 1.0}),
            ("Head", (0.0, 0.17, -0.008), 0.08, 0.093, {"Head": 1.0}),
            ("Head", (0.0, 0.205, -0.005), 0.06, 0.07, {"Head": 1.0}),
            ("Head", (0.0, 0.22, -0.005), 0.03, 0.035, {"Head": 1.0}),
        ],
    )
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        upper, lower, foot = f"{side}UpLeg", f"{side}Leg", f"{side}Foot"
        tube(
            skin,
            "trousers",
            [
                (upper, (0.0, 0.06, 0.0), 0.075, 0.09, both("Hips", upper, 0.3)),
                (upper, (0.0, -0.04, 0.0), 0.085, 0.095, both(upper, "Hips", 0.2)),
                (upper, (0.0, -0.2, 0.0), 0.073, 0.08, {upper: 1.0}),
                (upper, (0.0, -0.36, 0.0), 0.058, 0.062, both(upper, lower, 0.15)),
                (lower, (0.0, 0.0, 0.0), 0.055, 0.06, both(upper, lower)),
                (lower, (0.0, -0.06, -0.004), 0.054, 0.06, both(lower, upper, 0.15)),
                (lower, (0.0, -0.2, -0.008), 0.05, 0.055, {lower: 1.0}),
                (lower, (0.0, -0.39, 0.0), 0.042, 0.045, both(lower, foot, 0.2)),
            ],
        )
        tube(
            skin,
            "shoes",
            [
                (foot, (0.0, 0.01, -0.01), 0.042, 0.048, both(foot, lower, 0.3)),
                (foot, (0.0, -0.03, 0.02), 0.044, 0.075, {foot: 1.0}),
                (foot, (0.0, -0.05, 0.06), 0.046, 0.115, {foot: 1.0}),
                (foot, (0.0, -SOLE, 0.06), 0.045, 0.115, {foot: 1.0}),
            ],
        )
        arm, fore, hand = f"{side}Arm", f"{side}ForeArm", f"{side}Hand"
        tube(
            skin,
            "shirt",
            [
                (arm, (-0.04 * sign, 0.035, 0.0), 0.045, 0.05, both("Chest", arm)),
                (arm, (0.0, 0.01, 0.0), 0.055, 0.058, both(arm, "Chest", 0.3)),
                (arm, (0.008 * sign, -0.12, 0.0), 0.045, 0.048, {arm: 1.0}),
                (arm, (0.016 * sign, -0.24, 0.0), 0.04, 0.042, both(arm, fore, 0.2)),
                (fore, (0.0, 0.0, 0.0), 0.039, 0.041, both(arm, fore)),
                (fore, (0.0, -0.06, 0.0), 0.039, 0.04, both(fore, arm, 0.15)),
                (fore, (0.0, -0.22, 0.0), 0.031, 0.034, {fore: 1.0}),
            ],
        )
        tube(
            skin,
            "skin",
            [
                (fore, (0.0, -0.21, 0.0), 0.024, 0.028, {fore: 1.0}),
                (hand, (0.0, -0.01, 0.0), 0.022, 0.032, both(hand, fore, 0.4)),
                (hand, (0.0, -0.07, 0.005), 0.02, 0.043, {hand: 1.0}),
                (hand, (0.0, -0.16, 0.01), 0.014, 0.032, {hand: 1.0}),
                (hand, (0.0, -0.18, 0.01), 0.008, 0.015, {hand: 1.0}),
            ],
        )
    return skin


# COLLADA -------------------------------------------------------------------------------------------------------------


def numbers(values: Array, digits: int = 4) -> str:
    """Numbers as text."""
    return " ".join(f"{round(float(value), digits) + 0.0:g}" for value in np.ravel(values))


def source(name: str, values: Array, stride: int, params: str, kind: str = "float") -> str:
    """A `<source>` of numbers."""
    flat = np.ravel(values)
    return (
        f'<source id="{name}"><float_array id="{name}-array" count="{len(flat)}">{numbers(flat)}</float_array>'
        f'<technique_common><accessor source="#{name}-array" count="{len(flat) // stride}" stride="{stride}">'
        f'<param name="{params}" type="{kind}"/></accessor></technique_common></source>'
    )


def node(name: str, local: dict[str, Array]) -> str:
    """A bone as `<node>`, with those that hang on it."""
    inside = "".join(node(child, local) for child, (parent, _) in BONES.items() if parent == name)
    matrix = f'<matrix sid="transform">{numbers(local[name])}</matrix>'
    return f'<node id="{name}" name="{name}" sid="{name}" type="JOINT">{matrix}{inside}</node>'


def document(gait: Gait) -> str:
    """The whole file."""
    skin, rest = person(), placed({})
    frames = world(rest)
    effects = "".join(
        f'<effect id="{name}-effect"><profile_COMMON><technique sid="common"><lambert><diffuse>'
        f'<color sid="diffuse">{numbers(np.array((*color, 1.0)))}</color></diffuse></lambert></technique>'
        "</profile_COMMON></effect>"
        for name, color in COLORS.items()
    )
    materials = "".join(
        f'<material id="{name}" name="{name}"><instance_effect url="#{name}-effect"/></material>' for name in COLORS
    )
    groups = "".join(
        f'<triangles material="{name}" count="{len(rows)}">'
        f'<input semantic="VERTEX" source="#body-vertices" offset="0"/>'
        f"<p>{' '.join(str(i) for row in rows for i in row)}</p></triangles>"
        for name, rows in skin.triangles.items()
    )
    levels = sorted({weight for weights in skin.weights for weight in weights.values()})
    pairs = [
        f"{NAMES.index(bone)} {levels.index(weight)}" for weights in skin.weights for bone, weight in weights.items()
    ]
    binds = np.stack([np.linalg.inv(frames[name]) for name in NAMES])
    times = np.linspace(0.0, gait.period, FRAMES + 1)
    keys = [pose(gait, 2.0 * math.pi * i / FRAMES) for i in range(FRAMES + 1)]
    moved = [name for name in NAMES if any(not np.allclose(key[name], rest[name]) for key in keys)]
    animations = "".join(
        f'<animation id="{name}-animation">'
        + source(f"{name}-times", times, 1, "TIME")
        + source(f"{name}-poses", np.stack([key[name] for key in keys]), 16, "TRANSFORM", "float4x4")
        + f'<source id="{name}-ways"><Name_array id="{name}-ways-array" count="{len(times)}">'
        f'{" ".join(["LINEAR"] * len(times))}</Name_array><technique_common><accessor source="#{name}-ways-array" '
        f'count="{len(times)}" stride="1"><param name="INTERPOLATION" type="name"/></accessor></technique_common>'
        f'</source><sampler id="{name}-sampler"><input semantic="INPUT" source="#{name}-times"/><input '
        f'semantic="OUTPUT" source="#{name}-poses"/><input semantic="INTERPOLATION" source="#{name}-ways"/></sampler>'
        f'<channel source="#{name}-sampler" target="{name}/transform"/></animation>'
        for name in moved
    )
    bindings = "".join(f'<instance_material symbol="{name}" target="#{name}"/>' for name in COLORS)
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2026-11-22T00:00:00Z</created><modified>2026-11-22T00:00:00Z</modified>
<unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
<library_effects>{effects}</library_effects>
<library_materials>{materials}</library_materials>
<library_geometries><geometry id="body" name="body"><mesh>
{source("body-positions", np.array(skin.vertices), 3, "X")}
<vertices id="body-vertices"><input semantic="POSITION" source="#body-positions"/></vertices>
{groups}
</mesh></geometry></library_geometries>
<library_controllers><controller id="body-skin"><skin source="#body">
<bind_shape_matrix>{numbers(np.eye(4))}</bind_shape_matrix>
<source id="joints"><Name_array id="joints-array" count="{len(NAMES)}">{" ".join(NAMES)}</Name_array>
<technique_common><accessor source="#joints-array" count="{len(NAMES)}" stride="1"><param name="JOINT" type="name"/>
</accessor></technique_common></source>
{source("binds", binds, 16, "TRANSFORM", "float4x4")}
{source("weights", np.array(levels), 1, "WEIGHT")}
<joints><input semantic="JOINT" source="#joints"/><input semantic="INV_BIND_MATRIX" source="#binds"/></joints>
<vertex_weights count="{len(skin.weights)}"><input semantic="JOINT" source="#joints" offset="0"/>
<input semantic="WEIGHT" source="#weights" offset="1"/>
<vcount>{" ".join(str(len(weights)) for weights in skin.weights)}</vcount>
<v>{" ".join(pairs)}</v></vertex_weights>
</skin></controller></library_controllers>
<library_animations>{animations}</library_animations>
<library_visual_scenes><visual_scene id="scene" name="scene">
{node("Hips", rest)}
<node id="person" name="person" type="NODE"><instance_controller url="#body-skin"><skeleton>#Hips</skeleton>
<bind_material><technique_common>{bindings}</technique_common></bind_material></instance_controller></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
"""


def main() -> None:
    """Write all figures."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, gait in GAITS.items():
        (FOLDER / f"{name}.dae").write_text(document(gait))


if __name__ == "__main__":
    main()
