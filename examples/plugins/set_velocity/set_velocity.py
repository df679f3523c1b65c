"""A Model plugin that shows three ways to make a joint turn with a velocity.

- `instantly`: the links get the velocity there and then, as if by magic. It holds until something slows them down.
- `motor`: ODE's joint motor brings the joint to the velocity with as much torque as it is given, and holds it there.
- `pid`: a PID controller applies an effort; settling time and precision depend on the gains.

Links and models have SetLinearVel and SetAngularVel, which are of the first kind.
"""

from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin, gzerr
from libgz.classic.common import PID


class SetVelocity(ModelPlugin):
    """Elements: `<joint>`, its name; `<velocity>` [rad/s]; `<how>`: instantly, motor or pid."""

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
