"""ActorCollisionsPlugin: the limbs of an actor, which things bump into and lasers see."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError, nearest
from libgz.base.geometry import GzPose
from libgz.classic.common import gzwarn
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.physics import Actor
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.physics.geoms import BoxGeom
from libgz.sdfworld.actor import SdfActor

if TYPE_CHECKING:
    from collections.abc import Iterator

    from libgz.classic.physics import Model
    from libgz.physics.body import Body
    from libgz.sdf.element import Element

THICKNESS = 0.02  # [m], as in Gazebo
LEAST = 1e-6  # [m] of a bone that has a limb
LARGEST = 100.0  # [m] of a limb's side


class ActorCollisionsPlugin(ModelPlugin):
    """Gives an actor a box along each of its bones, named `BONE_CHILD_collision`; without it only its joints collide.

    Boxes are 2 cm thick and as long as the bone, times the scale; they move with it, and nothing moves them.

    Elements:
        scaling: several, each with the attributes `collision`, the name of a box, `scale`, of its sides (1 1 1), the
            third one along the bone, and `pose` [m, rad], by which it is moved in its own frame.
    """

    STATE = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Make the boxes.

        Raises:
            ParameterError: the model is no actor with a skeleton.
        """
        core = model.core
        if not isinstance(model, Actor) or not isinstance(core, SdfActor) or core.figure is None:
            raise ParameterError(f"{sdf.where}: {model.GetName()!r} is no <actor> with a skeleton")
        given = {element.Get(str, "collision").strip(): element for element in sdf.named("scaling")}
        names = []
        for name, body, pose, length in _bones(core):
            names.append(name)
            element = given.pop(name, None)
            scale, offset = _scaling(element) if element is not None else (Vector3d.One, Pose3d())
            sides = [side * factor for side, factor in zip((THICKNESS, THICKNESS, length), scale, strict=True)]
            box = BoxGeom(body, core.modelSpaceId, *sides)
            box.appearance.visible = False
            place = offset + pose
            box.SetRelativePose(GzPose(place.Pos(), place.Rot()), updateCoM=False)
            core.geom_names[box] = name
        for name, element in given.items():
            gzwarn(f"{element.where}: <scaling>: the actor has no collision {name!r}{nearest(name, names)}")


def _bones(core: SdfActor) -> Iterator[tuple[str, Body, Pose3d, float]]:
    """(name, link, pose of the middle, length [m]) of each bone that leads to another one."""
    if core.figure is None:
        return
    for (name, local, _), parent in zip(core.bones(), core.figure.parents, strict=True):
        length = math.hypot(*local.pos)
        if parent < 0 or length < LEAST:
            continue
        way = Vector3d(*local.pos)
        turn = Quaterniond(0.0, math.acos(max(-1.0, min(1.0, way.Z() / length))), math.atan2(way.Y(), way.X()))
        yield f"{core.figure.names[parent]}_{name}_collision", core.frame_links[parent], Pose3d(way * 0.5, turn), length


def _scaling(element: Element) -> tuple[Vector3d, Pose3d]:
    """Scale and pose of an element.

    Raises:
        ParameterError: a scale is not positive, or makes a limb larger than 100 m.
    """
    scale = element.Get(Vector3d, "scale", Vector3d.One)[0]
    if not all(0.0 < factor <= LARGEST / THICKNESS for factor in scale):
        raise ParameterError(f"{element.where}: <scaling> has scale {scale}; its numbers must be above 0")
    return scale, element.Get(Pose3d, "pose", Pose3d())[0]


GZ_REGISTER_MODEL_PLUGIN(ActorCollisionsPlugin)
