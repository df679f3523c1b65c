"""A Model plugin with an animation that runs in a loop."""

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.common import PoseAnimation
from libgz.classic.math import Quaterniond, Vector3d

LENGTH = 8.0  # of one loop [s]
SIDE = 2.0  # [m]


class AnimatedBox(ModelPlugin):
    STATE = ()  # the world remembers where the animation is

    def Load(self, model, sdf):
        animation = PoseAnimation("round", LENGTH, True)
        corners = [(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE), (0.0, 0.0)]
        for number, (x, y) in enumerate(corners):
            # Between the key frames the model follows a smooth curve.
            key = animation.CreateKeyFrame(LENGTH * number / 4)
            key.Translation(Vector3d(x, y, 0.5))
            key.Rotation(Quaterniond(0.0, 0.0, 0.0))
        model.SetAnimation(animation)


GZ_REGISTER_MODEL_PLUGIN(AnimatedBox)
