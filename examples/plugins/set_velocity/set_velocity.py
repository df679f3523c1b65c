"""A Model plugin that shows three ways to set the velocity of a joint.

- `instantly`: the links get the velocity at once. It lasts until forces slow them down.
- `motor`: ODE's joint motor drives the joint at the velocity, with a maximum torque.
- `pid`: a PID controller applies efforts to the joint; its accuracy depends on the gains.

Links and models have SetLinearVel and SetAngularVel, which set it at once, too.
"""

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin, gzerr
from libgz.classic.common import PID


class SetVelocity(ModelPlugin):
    """Elements: `<joint>`, its name; `<velocity>` [rad/s]; `<how>`: instantly, motor or pid."""

    STATE = ()  # nothing of its own to remember

    def Load(self, model, sdf):
        self.model = model
        self.joint = model.GetJoint(sdf.Get(str, "joint"))
        self.velocity = sdf.Get(float, "velocity")
        ways = {"instantly": self.instantly, "motor": self.motor, "pid": self.pid}
        how = sdf.Get(str, "how")
        if how not in ways:
            gzerr(f"<how> is {how!r}; it must be one of {', '.join(ways)}")
            return
        ways[how]()

    def instantly(self):
        self.joint.SetVelocity(0, self.velocity)

    def motor(self):
        self.joint.SetParam("fmax", 0, 100.0)  # [N m]
        self.joint.SetParam("vel", 0, self.velocity)

    def pid(self):
        controller = self.model.GetJointController()
        controller.SetVelocityPID(self.joint.GetScopedName(), PID(2.0, 0.5, 0.0, 10.0, -10.0))
        controller.SetVelocityTarget(self.joint.GetScopedName(), self.velocity)


GZ_REGISTER_MODEL_PLUGIN(SetVelocity)
