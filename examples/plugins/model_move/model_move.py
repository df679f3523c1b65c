"""A Model plugin that moves its model along waypoints of the world's file, and logs its arrival.

An animation moves a model regardless of obstacles: use it for lifts, passers-by and other scripted motion.
"""

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin, gzerr, gzmsg
from libgz.classic.common import PoseAnimation
from libgz.classic.math import Pose3d


class ModelMove(ModelPlugin):
    """Elements: `<waypoint time="2.0">x y z roll pitch yaw</waypoint>` [s], [m], [rad], in the order of their times.

    The first leg begins where the model stands.
    """

    def Load(self, model, sdf):
        self.model = model
        waypoints = []
        element = sdf.GetElement("waypoint")
        while element is not None:  # one after the other, as long as there are some
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
