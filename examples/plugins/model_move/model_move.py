"""A Model plugin that moves its model along waypoints in the world file, and prints when it has arrived.

An animation moves a model through obstacles; it is useful for models with a given motion, such as lifts or pedestrians.
"""

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin, gzerr, gzmsg
from libgz.classic.common import PoseAnimation
from libgz.classic.math import Pose3d


class ModelMove(ModelPlugin):
    """Elements: `<waypoint time="2.0">x y z roll pitch yaw</waypoint>` [s], [m], [rad], in the order of their times.

    The first leg begins where the model stands.
    """

    STATE = ()  # the world remembers where the animation is

    def Load(self, model, sdf):
        self.model = model
        waypoints = []
        element = sdf.GetElement("waypoint")
        while element is not None:  # until there are no more
            waypoints.append((element.Get(float, "time"), element.Get(Pose3d)))
            element = element.GetNextElement("waypoint")
        if not waypoints:
            gzerr(f"{self.GetHandle()}: there is no <waypoint>, so {model.GetName()} stays")
            return
        animation = PoseAnimation("waypoints", waypoints[-1][0], False)
        for time, pose in [(0.0, model.RelativePose()), *waypoints]:
            key = animation.CreateKeyFrame(time)
            key.Translation(pose.Pos())
            key.Rotation(pose.Rot())
        model.SetAnimation(animation, self.OnArrived)

    def OnArrived(self):
        gzmsg(f"{self.model.GetName()} has arrived at {self.model.WorldPose().Pos()}")


GZ_REGISTER_MODEL_PLUGIN(ModelMove)
