"""A Model plugin that holds joints at a position or a velocity with PID controllers, and subscribes to new targets.

A model's JointController applies efforts to its joints in every iteration; a plugin sets targets and gains. Targets can
also be published by other programs:

    libgz topic -p '~/turret/vel_cmd' -t Vector3d -m 'x: 3'
"""

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin, gzmsg, transport
from libgz.classic.common import PID


class JointPid(ModelPlugin):
    """Any number of elements like

    `<joint name="elbow"><position>1.0</position><p>10</p><i>0.1</i><d>4.5</d></joint>`: a target `<position>` [rad] or
    [m], or `<velocity>` [rad/s] or [m/s]; gains `<p>`, `<i>`, `<d>`.

    The topics ~/<model>/pos_cmd and ~/<model>/vel_cmd take a Vector3d whose x is the new target of the first joint.
    """

    STATE = ()  # the world remembers targets and controllers

    def Load(self, model, sdf):
        self.model = model
        self.controller = model.GetJointController()
        self.names = []
        element = sdf.GetElement("joint")
        while element is not None:
            self.take(element)
            element = element.GetNextElement("joint")
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscribers = [
            self.node.Subscribe(f"~/{model.GetName()}/pos_cmd", self.OnPosition),
            self.node.Subscribe(f"~/{model.GetName()}/vel_cmd", self.OnVelocity),
        ]

    def take(self, element):
        joint = self.model.GetJoint(element.Get(str, "name"))
        # Controllers use the scoped names of joints: model::joint.
        name = joint.GetScopedName()
        gains = (element.Get(float, key) for key in ("p", "i", "d"))
        # The last two limit the integral term; the defaults, 0 and 0, disable it.
        pid = PID(*gains, 100.0, -100.0)
        if element.HasElement("position"):
            self.controller.SetPositionPID(name, pid)
            self.controller.SetPositionTarget(name, element.Get(float, "position"))
        else:
            self.controller.SetVelocityPID(name, pid)
            self.controller.SetVelocityTarget(name, element.Get(float, "velocity"))
        self.names.append(name)

    def OnPosition(self, message):
        gzmsg(f"{self.names[0]} shall go to {message.x}")
        self.controller.SetPositionTarget(self.names[0], message.x)

    def OnVelocity(self, message):
        gzmsg(f"{self.names[0]} shall turn with {message.x}")
        self.controller.SetVelocityTarget(self.names[0], message.x)


GZ_REGISTER_MODEL_PLUGIN(JointPid)
