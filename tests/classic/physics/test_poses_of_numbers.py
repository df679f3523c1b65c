"""Poses are taken as six numbers, too; what is no pose is named."""

import pytest

import libgz
from libgz.base.errors import ParameterError
from libgz.base.geometry import GzPoseOf
from libgz.classic import physics
from libgz.classic.math import Pose3d

MODEL = (
    "<sdf version='1.6'><world name='w'><model name='m'><link name='l'><visual name='v'><geometry><box>"
    "<size>1 1 1</size></box></geometry></visual></link></model></world></sdf>"
)
NUMBERS = (1, 2, 3, 0.1, 0.2, 0.3)


def test_all_setters_of_poses_take_six_numbers():
    with libgz.World.from_string(MODEL) as world:
        model = physics.get_world().ModelByName("m")
        for setter, getter in (
            (model.SetWorldPose, model.WorldPose),
            (model.SetRelativePose, model.RelativePose),
            (model.GetLink("l").SetWorldPose, model.GetLink("l").WorldPose),
            (world.models[0].SetPose, world.models[0].GetPose),
            (world.models[0].bodies[0].SetPose, world.models[0].bodies[0].GetPose),
            (lambda pose: world.SetModelPose(world.models[0], pose), world.models[0].GetPose),
        ):
            setter((0, 0, 0, 0, 0, 0))
            setter(NUMBERS)
            assert Pose3d(getter()) == Pose3d(*NUMBERS)
            setter(Pose3d(*NUMBERS))
            assert Pose3d(getter()) == Pose3d(*NUMBERS)
            for wrong in ((1, 2, 3), "here", None, (1, 2, 3, 4, 5, "six"), 7):
                with pytest.raises(ParameterError, match="it must be a GzPose or Pose3d, or six numbers: x y z"):
                    setter(wrong)


def test_a_pose_stays_the_object_that_it_is():
    pose = Pose3d(*NUMBERS)
    assert GzPoseOf(pose) is pose
