"""LegacyApi: the services of /gazebo that make sense for a legacy world. Models are named by their ids."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError
from libgz.base.geometry import (
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzPose,
    GzQuatern,
    GzQuaternInverse,
    GzVector,
    GzVectorSub,
    rotate,
)
from libgz.physics.joint import AxisJoint, SliderJoint
from libgz.ros.services import INERTIAL, RefusedError, Services
from libgz.ros.session import set_stamp
from libgz.ros.states import Listed

if TYPE_CHECKING:
    from libgz.physics.body import Body
    from libgz.physics.joint import Joint
    from libgz.simulation.entity import Entity
    from libgz.simulation.world import World

__all__ = ["SERVICES", "LegacyApi", "fill_state", "list_links", "list_models"]

# Services of /gazebo -> their types.
SERVICES = {
    "apply_body_wrench": "gazebo_msgs/ApplyBodyWrench",
    "clear_body_wrenches": "gazebo_msgs/BodyRequest",
    "delete_model": "gazebo_msgs/DeleteModel",
    "get_joint_properties": "gazebo_msgs/GetJointProperties",
    "get_link_state": "gazebo_msgs/GetLinkState",
    "get_model_properties": "gazebo_msgs/GetModelProperties",
    "get_model_state": "gazebo_msgs/GetModelState",
    "get_physics_properties": "gazebo_msgs/GetPhysicsProperties",
    "get_world_properties": "gazebo_msgs/GetWorldProperties",
    "pause_physics": "std_srvs/Empty",
    "reset_simulation": "std_srvs/Empty",
    "reset_world": "std_srvs/Empty",
    "set_model_state": "gazebo_msgs/SetModelState",
    "unpause_physics": "std_srvs/Empty",
}


def _scoped(model: Entity, body: Body) -> str:
    return f"{model.GetId()}::{body.bodyName}"


def list_models(core: World) -> Listed:
    """The models of a legacy world, with their canonical bodies."""
    models = core.GetModels()
    return Listed([model.GetId() for model in models], [model.GetBody() for model in models], [])


def list_links(core: World) -> Listed:
    """All bodies of a legacy world, named ``model::body``."""
    found = [(_scoped(model, body), body) for model in core.GetModels() for body in model.bodies]
    return Listed([name for name, _ in found], [body for _, body in found], [])


class LegacyApi(Services):
    """Serves the services of /gazebo for a legacy world, and its topic set_model_state."""

    services = SERVICES
    topics = {"set_model_state": "gazebo_msgs/ModelState"}

    # Finding -----------------------------------------------------------------------------------------------------

    def _model(self, name: str, missing: str) -> Entity:
        try:
            return self.core.model(name)
        except NotFoundError:
            raise RefusedError(missing) from None

    def _body(self, name: str, missing: str) -> Body:
        for model in self.core.GetModels():
            for body in model.bodies:
                if _scoped(model, body) == name:
                    return body
        raise RefusedError(missing)

    def _frame(self, name: str, missing: str) -> Body | None:
        """The body of a frame: a model's canonical one, or that of a link; None for the world's frame."""
        if name in INERTIAL:
            return None
        if "::" in name:
            return self._body(name, missing)
        return self._model(name, missing).GetBody()

    # Models ------------------------------------------------------------------------------------------------------

    def _get_world_properties(self, _request: Any, answer: Any) -> None:
        answer.sim_time = self.core.GetSimTime()
        answer.model_names = [model.GetId() for model in self.core.GetModels()]
        answer.rendering_enabled = answer.success = True
        answer.status_message = "GetWorldProperties: got properties"

    def _get_model_properties(self, request: Any, answer: Any) -> None:
        model = self._model(request.model_name, "GetModelProperties: model does not exist")
        answer.parent_model_name = model.parent.GetId() if model.parent is not None else ""
        answer.body_names = [body.bodyName for body in model.bodies]
        answer.geom_names = [type(geom).__name__ for body in model.bodies for geom in body.GetGeoms()]
        answer.joint_names = [joint.name for joint in model.joints if joint.name]
        answer.child_model_names = [child.GetId() for child in model.children]
        answer.is_static = all(body.dummy for body in model.bodies)
        answer.success, answer.status_message = True, "GetModelProperties: got properties"

    def _get_model_state(self, request: Any, answer: Any) -> None:
        name = request.model_name
        model = self._model(name, "GetModelState: model does not exist")
        missing = "GetModelState: reference relative_entity_name not found"
        frame = self._frame(request.relative_entity_name, missing)
        self._asked[name] = answer.header.seq = self._asked.get(name, 0) + 1
        set_stamp(answer.header.stamp, self.core.GetSimTime())
        answer.header.frame_id = request.relative_entity_name
        fill_state(answer, model.GetBody(), frame)
        answer.success, answer.status_message = True, "GetModelState: got properties"

    def _set_model_state(self, request: Any, answer: Any) -> None:
        state = request.model_state
        model = self._model(state.model_name, "SetModelState: model does not exist")
        frame = self._frame(state.reference_frame, "SetModelState: specified reference frame entity does not exist")
        self._set_state(model, state, frame)
        answer.success, answer.status_message = True, "SetModelState: set model state done"

    def _set_state(self, model: Entity, state: Any, frame: Body | None) -> None:
        """Set pose and velocities of a model, given in a frame."""
        pose, linear, angular = _pose(state.pose), _vector(state.twist.linear), _vector(state.twist.angular)
        if frame is not None:
            place = frame.GetPose()
            pose = GzCoordPoseAdd(pose, place)
            linear, angular = rotate(place.rot, linear), rotate(place.rot, angular)
        relative = GzCoordPoseSub(pose, model.parentBody.GetPose()) if model.parentBody is not None else pose
        self.core.SetModelPose(model, relative)
        for body in model.bodies:
            if not body.dummy:
                body.SetLinearVel(linear)
                body.SetAngularVel(angular)

    def _delete_model(self, request: Any, answer: Any) -> None:
        model = self._model(request.model_name, "DeleteModel: model does not exist")
        for body in model.bodies:
            self.clear(_scoped(model, body))
        self.core.DeleteModel(model)
        answer.success, answer.status_message = True, "DeleteModel: successfully deleted model"

    # Bodies and joints -------------------------------------------------------------------------------------------

    def _get_link_state(self, request: Any, answer: Any) -> None:
        body = self._body(request.link_name, "GetLinkState: link not found; links are named model::body")
        frame = self._frame(request.reference_frame, "GetLinkState: reference reference_frame not found")
        fill_state(answer.link_state, body, frame)
        answer.link_state.link_name, answer.link_state.reference_frame = request.link_name, request.reference_frame
        answer.success, answer.status_message = True, "GetLinkState: got state"

    def _apply_body_wrench(self, request: Any, answer: Any) -> None:
        self._apply_wrench(request.body_name, request)
        answer.success = True

    def _apply_wrench(self, name: str, request: Any) -> None:
        """Apply the wrench of a request to a body."""
        body = self._body(name, "ApplyBodyWrench: body does not exist; links are named model::body")
        frame = self._frame(request.reference_frame, "ApplyBodyWrench: reference_frame not found")
        place = frame.GetPose() if frame is not None else GzPose()
        force, torque = (rotate(place.rot, _vector(part)) for part in (request.wrench.force, request.wrench.torque))
        arm = rotate(place.rot, _vector(request.reference_point))

        def apply() -> None:
            body.Enable(True)
            here = body.GetPosition()
            body.AddForceAtPos(force.x, force.y, force.z, here.x + arm.x, here.y + arm.y, here.z + arm.z)
            body.AddTorque(*torque)

        self.add_job(name, apply, request)

    def _clear_body_wrenches(self, request: Any, _answer: Any) -> None:
        self.clear(request.body_name)

    def _get_joint_properties(self, request: Any, answer: Any) -> None:
        joint = self._joint(request.joint_name)
        if isinstance(joint, AxisJoint):
            answer.type, answer.position, answer.rate = answer.REVOLUTE, [joint.GetAngle()], [joint.GetAngleRate()]
        elif isinstance(joint, SliderJoint):
            answer.type = answer.PRISMATIC
            answer.position, answer.rate = [joint.GetPosition()], [joint.GetPositionRate()]
        else:
            answer.type = answer.UNIVERSAL
        answer.success, answer.status_message = True, "GetJointProperties: got properties"

    def _joint(self, name: str) -> Joint:
        """A joint named ``model::joint``, or the first one of a name."""
        for model in self.core.GetModels():
            for joint in model.joints:
                if joint.name and name in (joint.name, f"{model.GetId()}::{joint.name}"):
                    return joint
        raise RefusedError("GetJointProperties: joint not found")

    # World -------------------------------------------------------------------------------------------------------

    def _get_physics_properties(self, _request: Any, answer: Any) -> None:
        engine = self.core.engine
        answer.time_step, answer.pause = engine.step_time, self.core.paused
        answer.max_update_rate = self.core.simSpeed / engine.step_time
        answer.gravity.x, answer.gravity.y, answer.gravity.z = engine.gravity
        answer.success, answer.status_message = True, "GetPhysicsProperties: got properties"

    def _pause_physics(self, _request: Any, _answer: Any) -> None:
        self.core.paused = True

    def _unpause_physics(self, _request: Any, _answer: Any) -> None:
        self.core.paused = False

    def _reset_simulation(self, _request: Any, _answer: Any) -> None:
        self.core.Reset()

    def _reset_world(self, _request: Any, _answer: Any) -> None:
        self.core.ResetModelPoses()


def _vector(value: Any) -> GzVector:
    return GzVector(value.x, value.y, value.z)


def _pose(value: Any) -> GzPose:
    """A pose; a quaternion of zeros is no rotation."""
    turn = value.orientation
    length = math.hypot(turn.w, turn.x, turn.y, turn.z)
    parts = (
        (turn.w / length, turn.x / length, turn.y / length, turn.z / length) if length > 0.0 else (1.0, 0.0, 0.0, 0.0)
    )
    return GzPose(_vector(value.position), GzQuatern(*parts))


def fill_state(target: Any, body: Body, frame: Body | None) -> None:
    """Set pose and twist of a body, relative to another one if that is given."""
    pose, linear, angular = body.GetPose(), body.GetPointVel(body.GetPosition()), body.GetAngularRate()
    if frame is not None:
        place = frame.GetPose()
        back = GzQuaternInverse(place.rot)
        pose = GzCoordPoseSub(pose, place)
        linear = rotate(back, GzVectorSub(linear, frame.GetPointVel(place.pos)))
        angular = rotate(back, GzVectorSub(angular, frame.GetAngularRate()))
    place, turn = target.pose.position, target.pose.orientation
    place.x, place.y, place.z = pose.pos
    turn.w, turn.x, turn.y, turn.z = pose.rot
    for part, values in ((target.twist.linear, linear), (target.twist.angular, angular)):
        part.x, part.y, part.z = values
