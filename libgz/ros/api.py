"""WorldApi: the services of /gazebo, with the answers of the original."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError
from libgz.classic.common import Color
from libgz.classic.physics.base import Base, Entity
from libgz.classic.physics.insertion import insert_document
from libgz.classic.physics.link import Link
from libgz.ros.packages import with_paths
from libgz.ros.plugin import set_pose, set_twist
from libgz.ros.reconfigure import Knob, Reconfigure
from libgz.ros.services import INERTIAL, RefusedError, Services, pose_of, vector
from libgz.ros.session import Later, Session, set_stamp
from libgz.ros.spawning import failure, prepare_model, root_tag
from libgz.ros.types import Message, service_type

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, World
    from libgz.ros.own_node import OwnNode

__all__ = ["SERVICES", "WorldApi"]

SPAWN_PATIENCE, DELETE_PATIENCE = 10.0, 60.0  # [s]

# Services of /gazebo -> their types.
SERVICES = {
    "apply_body_wrench": "gazebo_msgs/ApplyBodyWrench",
    "apply_joint_effort": "gazebo_msgs/ApplyJointEffort",
    "clear_body_wrenches": "gazebo_msgs/BodyRequest",
    "clear_joint_forces": "gazebo_msgs/JointRequest",
    "delete_light": "gazebo_msgs/DeleteLight",
    "delete_model": "gazebo_msgs/DeleteModel",
    "get_joint_properties": "gazebo_msgs/GetJointProperties",
    "get_light_properties": "gazebo_msgs/GetLightProperties",
    "get_link_properties": "gazebo_msgs/GetLinkProperties",
    "get_link_state": "gazebo_msgs/GetLinkState",
    "get_model_properties": "gazebo_msgs/GetModelProperties",
    "get_model_state": "gazebo_msgs/GetModelState",
    "get_physics_properties": "gazebo_msgs/GetPhysicsProperties",
    "get_world_properties": "gazebo_msgs/GetWorldProperties",
    "pause_physics": "std_srvs/Empty",
    "reset_simulation": "std_srvs/Empty",
    "reset_world": "std_srvs/Empty",
    "set_joint_properties": "gazebo_msgs/SetJointProperties",
    "set_light_properties": "gazebo_msgs/SetLightProperties",
    "set_link_properties": "gazebo_msgs/SetLinkProperties",
    "set_link_state": "gazebo_msgs/SetLinkState",
    "set_model_configuration": "gazebo_msgs/SetModelConfiguration",
    "set_model_state": "gazebo_msgs/SetModelState",
    "set_physics_properties": "gazebo_msgs/SetPhysicsProperties",
    "spawn_sdf_model": "gazebo_msgs/SpawnModel",
    "spawn_urdf_model": "gazebo_msgs/SpawnModel",
    "unpause_physics": "std_srvs/Empty",
}


class WorldApi(Services):
    """Serves the services of /gazebo for a world of SDF, and its topics set_model_state and set_link_state."""

    services = SERVICES
    topics = {"set_model_state": "gazebo_msgs/ModelState", "set_link_state": "gazebo_msgs/LinkState"}

    def __init__(self, session: Session, world: World, space: str = "", node: OwnNode | None = None) -> None:
        self._world = world
        super().__init__(session, world.core, space, node)
        self._knobs = None if session.version == 2 else self._offer_physics()

    def end(self) -> None:
        """Serve and subscribe no longer: the world ends."""
        super().end()
        if self._knobs is not None:
            self._knobs.end()

    # Models ------------------------------------------------------------------------------------------------------

    def _spawn_urdf_model(self, request: Any, answer: Any) -> Later:
        if root_tag(request.model_xml) != "robot":
            raise RefusedError("SpawnModel: Failure - entity format is invalid.")
        try:
            request.model_xml = with_paths(request.model_xml)
        except NotFoundError as error:
            raise RefusedError(f"urdf reference package name does not exist: {error}") from None
        return self._spawn_sdf_model(request, answer)

    def _spawn_sdf_model(self, request: Any, answer: Any) -> Later:
        world, name = self._world, request.model_name
        if root_tag(request.model_xml) not in ("robot", "sdf", "gazebo", "model", "light"):
            raise RefusedError(
                "GazeboRosApiPlugin SpawnModel Failure: input model_xml not SDF or URDF, or cannot be converted to"
                " Gazebo compatible format."
            )
        missing = "SpawnModel: reference reference_frame not found, did you forget to scope the link by model name?"
        frame = self._frame(request.reference_frame, missing)
        pose = pose_of(request.initial_pose)
        if frame is not None:
            pose = pose + frame.WorldPose()
        if world.BaseByName(name) is not None:
            raise RefusedError("SpawnModel: Failure - entity already exists.")
        document = prepare_model(request.model_xml, name, pose, request.robot_namespace)
        inserted = insert_document(world, document)

        def poll() -> Message | None:
            if error := failure(inserted):
                return self.refuse(answer, f"SpawnModel: {error}")
            if world.BaseByName(name) is None:
                return None
            answer.success, answer.status_message = True, "SpawnModel: Successfully spawned entity"
            return answer  # type: ignore[no-any-return]

        overdue = "SpawnModel: Entity pushed to spawn queue, but spawn service timed out waiting for entity to appear"
        late = service_type("gazebo_msgs/SpawnModel").response(
            status_message=f"{overdue} in simulation under the name {name}"
        )
        return Later(poll, SPAWN_PATIENCE, late)

    def _delete_model(self, request: Any, answer: Any) -> Later:
        world, name = self._world, request.model_name
        model = world.ModelByName(name)
        if model is None:
            raise RefusedError("DeleteModel: model does not exist")
        for link in model.GetLinks():
            self.clear(link.GetScopedName())
        for joint in model.GetJoints():
            self.clear(joint.GetName())
        world.RemoveModel(model)

        def poll() -> Message | None:
            if world.ModelByName(name) is not None:
                return None
            answer.success, answer.status_message = True, "DeleteModel: successfully deleted model"
            return answer  # type: ignore[no-any-return]

        overdue = "DeleteModel: Model pushed to delete queue, but delete service timed out waiting for model to"
        late = service_type("gazebo_msgs/DeleteModel").response(status_message=f"{overdue} disappear from simulation")
        return Later(poll, DELETE_PATIENCE, late)

    def _get_model_state(self, request: Any, answer: Any) -> None:
        world, name, relative = self._world, request.model_name, request.relative_entity_name
        model = world.ModelByName(name)
        if model is None:
            raise RefusedError("GetModelState: model does not exist")
        self._asked[name] = answer.header.seq = self._asked.get(name, 0) + 1
        set_stamp(answer.header.stamp, world.core.GetSimTime())
        answer.header.frame_id = relative
        missing = (
            "GetModelState: reference relative_entity_name not found, did you forget to scope the body by model name?"
        )
        fill_state(answer, model, self._frame(relative, missing))
        answer.success, answer.status_message = True, "GetModelState: got properties"

    def _get_model_properties(self, request: Any, answer: Any) -> None:
        model = self._world.ModelByName(request.model_name)
        if model is None:
            raise RefusedError("GetModelProperties: model does not exist")
        parent = model.GetParentModel()
        answer.parent_model_name = parent.GetName() if parent is not None and parent is not model else ""
        answer.body_names = [link.GetName() for link in model.GetLinks()]
        answer.geom_names = [one.GetName() for link in model.GetLinks() for one in link.GetCollisions()]
        answer.joint_names = [joint.GetName() for joint in model.GetJoints()]
        answer.child_model_names = [one.GetName() for one in model.NestedModels()]
        answer.is_static = model.IsStatic()
        answer.success, answer.status_message = True, "GetModelProperties: got properties"

    def _set_model_state(self, request: Any, answer: Any) -> None:
        state = request.model_state
        model = self._world.ModelByName(state.model_name)
        if model is None:
            raise RefusedError("SetModelState: model does not exist")
        frame = self._frame(state.reference_frame, "SetModelState: specified reference frame entity does not exist")
        pose, linear, angular = pose_of(state.pose), vector(state.twist.linear), vector(state.twist.angular)
        if frame is not None:
            place = frame.WorldPose()
            pose = pose + place
            linear, angular = place.Rot().RotateVector(linear), place.Rot().RotateVector(angular)
        model.SetWorldPose(pose)
        model.SetLinearVel(linear)
        model.SetAngularVel(angular)
        answer.success, answer.status_message = True, "SetModelState: set model state done"

    def _set_model_configuration(self, request: Any, answer: Any) -> None:
        model = self._world.ModelByName(request.model_name)
        if model is None:
            raise RefusedError("SetModelConfiguration: model does not exist")
        if len(request.joint_names) != len(request.joint_positions):
            raise RefusedError("SetModelConfiguration: joint name and position list have different lengths")
        known = [model.GetJoint(name) is not None for name in request.joint_names]
        positions = map(float, request.joint_positions)
        model.SetJointPositions(
            {name: at for name, at, good in zip(request.joint_names, positions, known, strict=True) if good}
        )
        answer.success, answer.status_message = True, "SetModelConfiguration: success"

    # Links -------------------------------------------------------------------------------------------------------

    def _link(self, name: str, missing: str) -> Link:
        found = self._world.EntityByName(name) if name else None
        if not isinstance(found, Link):
            raise RefusedError(missing)
        return found

    def _get_link_properties(self, request: Any, answer: Any) -> None:
        link = self._link(
            request.link_name, "GetLinkProperties: link not found, did you forget to scope the link by model name?"
        )
        inertial = link.GetInertial()
        answer.gravity_mode, answer.mass = link.GetGravityMode(), inertial.GetMass()
        for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
            setattr(answer, name, getattr(inertial, name.upper())())
        answer.com.position.x, answer.com.position.y, answer.com.position.z = inertial.CoG()
        answer.com.orientation.w = 1.0
        answer.success, answer.status_message = True, "GetLinkProperties: got properties"

    def _set_link_properties(self, request: Any, answer: Any) -> None:
        link = self._link(
            request.link_name, "SetLinkProperties: link not found, did you forget to scope the link by model name?"
        )
        inertial = link.GetInertial()
        inertial.SetCoG(vector(request.com.position))
        inertial.SetInertiaMatrix(request.ixx, request.iyy, request.izz, request.ixy, request.ixz, request.iyz)
        inertial.SetMass(request.mass)
        link.SetInertial(inertial)
        link.SetGravityMode(bool(request.gravity_mode))
        answer.success, answer.status_message = True, "SetLinkProperties: properties set"

    def _get_link_state(self, request: Any, answer: Any) -> None:
        missing = "GetLinkState: link not found, did you forget to scope the link by model name?"
        link = self._link(request.link_name, missing)
        missing = "GetLinkState: reference reference_frame not found, did you forget to scope the link by model name?"
        fill_state(answer.link_state, link, self._frame(request.reference_frame, missing))
        answer.link_state.link_name, answer.link_state.reference_frame = request.link_name, request.reference_frame
        answer.success, answer.status_message = True, "GetLinkState: got state"

    def _set_link_state(self, request: Any, answer: Any) -> None:
        state = request.link_state
        link = self._link(state.link_name, "SetLinkState: link does not exist")
        frame = self._frame(state.reference_frame, "SetLinkState: failed")
        pose, linear, angular = pose_of(state.pose), vector(state.twist.linear), vector(state.twist.angular)
        if frame is not None:
            pose = pose + frame.WorldPose()
            linear, angular = linear - frame.WorldLinearVel(), angular - frame.WorldAngularVel()
        link.SetWorldPose(pose)
        link.SetLinearVel(linear)
        link.SetAngularVel(angular)
        answer.success, answer.status_message = True, "SetLinkState: success"

    def _apply_body_wrench(self, request: Any, answer: Any) -> None:
        link = self._link(request.body_name, "ApplyBodyWrench: body does not exist")
        self._apply_wrench(link, request, "ApplyBodyWrench: reference_frame not found")
        answer.success = True

    def _apply_wrench(self, link: Link, request: Any, missing: str) -> None:
        """Apply the wrench of a request, which it gives in a frame."""
        force, torque = vector(request.wrench.force), vector(request.wrench.torque)
        torque = torque + vector(request.reference_point).Cross(force)
        frame = self._frame(request.reference_frame, missing)
        if frame is not None:
            way = frame.WorldPose() - link.WorldPose()
            force, torque = way.Rot().RotateVector(force), way.Rot().RotateVector(torque)
            torque = torque + way.Pos().Cross(force)

        def apply() -> None:
            link.SetForce(force)
            link.SetTorque(torque)

        self.add_job(link.GetScopedName(), apply, request)

    def _clear_body_wrenches(self, request: Any, _answer: Any) -> None:
        self.clear(request.body_name)

    # Joints ------------------------------------------------------------------------------------------------------

    def _joint(self, name: str, missing: str) -> Joint:
        for model in self._world.Models():
            joint: Joint | None = model.GetJoint(name)
            if joint is not None:
                return joint
        raise RefusedError(missing)

    def _get_joint_properties(self, request: Any, answer: Any) -> None:
        joint = self._joint(request.joint_name, "GetJointProperties: joint not found")
        answer.type = answer.REVOLUTE
        moves = joint.DOF() > 0
        answer.position = [joint.Position(0) if moves else math.nan]
        answer.rate = [joint.GetVelocity(0) if moves else 0.0]
        answer.success, answer.status_message = True, "GetJointProperties: got properties"

    def _set_joint_properties(self, request: Any, answer: Any) -> None:
        config = request.ode_joint_config
        self._set_joint(request.joint_name, config, config.hiStop, config.loStop)
        answer.success, answer.status_message = True, "SetJointProperties: properties set"

    def _set_joint(self, name: str, config: Any, high: Sequence[float], low: Sequence[float]) -> None:
        """Set parameters of a joint, and its stops, for each axis that has values."""
        joint = self._joint(name, "SetJointProperties: joint not found")
        axes = range(joint.DOF())
        for index, value in zip(axes, config.damping, strict=False):
            joint.SetDamping(index, float(value))
        fields = ("erp", "cfm", "stop_erp", "stop_cfm", "fudge_factor", "fmax", "vel")
        values = {"hi_stop": high, "lo_stop": low} | {field: getattr(config, field) for field in fields}
        for key, given in values.items():
            for index, value in zip(axes, given, strict=False):
                joint.SetParam(key, index, float(value))

    def _apply_joint_effort(self, request: Any, answer: Any) -> None:
        joint = self._joint(request.joint_name, "ApplyJointEffort: joint not found")
        effort = request.effort
        self.add_job(joint.GetName(), lambda: joint.SetForce(0, effort), request)
        answer.success, answer.status_message = True, "ApplyJointEffort: effort set"

    def _clear_joint_forces(self, request: Any, _answer: Any) -> None:
        self.clear(request.joint_name)

    # World -------------------------------------------------------------------------------------------------------

    def _get_world_properties(self, _request: Any, answer: Any) -> None:
        answer.sim_time = self._world.core.GetSimTime()
        answer.model_names = [model.GetName() for model in self._world.Models()]
        answer.rendering_enabled = answer.success = True
        answer.status_message = "GetWorldProperties: got properties"

    def _get_physics_properties(self, _request: Any, answer: Any) -> None:
        engine, config = self._world.Physics(), answer.ode_config
        answer.time_step, answer.pause = engine.GetMaxStepSize(), self._world.IsPaused()
        answer.max_update_rate = engine.GetRealTimeUpdateRate()
        answer.gravity.x, answer.gravity.y, answer.gravity.z = self._world.Gravity()
        config.auto_disable_bodies = engine.GetAutoDisableFlag()
        for field, key in _PHYSICS.items():
            value = engine.GetParam(key)
            setattr(config, field, int(value) if field in _WHOLE else float(value))
        answer.success, answer.status_message = True, "GetPhysicsProperties: got properties"

    def _set_physics_properties(self, request: Any, answer: Any) -> None:
        engine, config = self._world.Physics(), request.ode_config
        self._world.SetGravity(vector(request.gravity))
        engine.SetMaxStepSize(request.time_step)
        engine.SetRealTimeUpdateRate(request.max_update_rate)
        engine.SetAutoDisableFlag(bool(config.auto_disable_bodies))
        for field, key in _PHYSICS.items():
            value = getattr(config, field)
            engine.SetParam(key, int(value) if field in _WHOLE else value)
        answer.success, answer.status_message = True, "physics engine updated"

    def _offer_physics(self) -> Reconfigure:
        """Offer the properties of physics to tools of dynamic_reconfigure, as they are now."""
        present: Any = service_type(SERVICES["get_physics_properties"]).response()
        self._get_physics_properties(None, present)
        values = {knob.name: getattr(*_holder(present, knob.name)) for knob in KNOBS}
        return Reconfigure(self.session, "~", KNOBS, self._reconfigure_physics, values)

    def _reconfigure_physics(self, values: Mapping[str, Any]) -> None:
        name = "set_physics_properties"
        request: Any = service_type(SERVICES[name]).request()
        for key, value in values.items():
            setattr(*_holder(request, key), value)
        answer: Any = self.handler(name)(request)
        if not answer.success:
            raise RefusedError(answer.status_message)

    def _pause_physics(self, _request: Any, _answer: Any) -> None:
        self._world.SetPaused(True)

    def _unpause_physics(self, _request: Any, _answer: Any) -> None:
        self._world.SetPaused(False)

    def _reset_simulation(self, _request: Any, _answer: Any) -> None:
        """Reset the time and what there is: models that were spawned and properties of physics stay, as in Gazebo."""
        world = self._world
        self.jobs.clear()
        world.ResetTime()
        world.ResetEntities(Base.BASE)
        world.ResetPhysicsStates()
        world.server.plugins.reset_others()
        world.core.events["WorldReset"]()

    def _reset_world(self, _request: Any, _answer: Any) -> None:
        self._world.ResetEntities(Base.MODEL)

    # Lights ------------------------------------------------------------------------------------------------------

    def _light(self, name: str, missing: str) -> Any:
        light = self._world.LightByName(name)
        if light is None:
            raise RefusedError(missing)
        return light

    def _delete_light(self, request: Any, answer: Any) -> Later:
        world, name = self._world, request.light_name
        self._light(name, f"DeleteLight: Requested light {name} not found!")
        world.RemoveModel(name)

        def poll() -> Message | None:
            if world.LightByName(name) is not None:
                return None
            answer.success, answer.status_message = True, f"DeleteLight: {name} successfully deleted"
            return answer  # type: ignore[no-any-return]

        late = service_type("gazebo_msgs/DeleteLight").response(
            status_message=f'DeleteLight: Timeout reached while removing light "{name}"'
        )
        return Later(poll, SPAWN_PATIENCE, late)

    def _get_light_properties(self, request: Any, answer: Any) -> None:
        light = self._light(request.light_name, f"getLightProperties: Requested light {request.light_name} not found!")
        colour, fades = light.DiffuseColor(), light.Attenuation()
        answer.diffuse.r, answer.diffuse.g, answer.diffuse.b, answer.diffuse.a = colour
        answer.attenuation_constant, answer.attenuation_linear, answer.attenuation_quadratic = fades[:3]
        answer.success = True

    def _set_light_properties(self, request: Any, answer: Any) -> None:
        light = self._light(request.light_name, f"setLightProperties: Requested light {request.light_name} not found!")
        self._set_light(light, request)
        light.SetCastShadows(bool(request.cast_shadows))
        part = request.specular
        light.SetSpecularColor(Color(part.r, part.g, part.b, part.a))
        direction = vector(request.direction)
        if direction.Length() > 0.0:
            light.SetDirection(direction)
        light.SetWorldPose(pose_of(request.pose))
        answer.success = True

    def _set_light(self, light: Any, request: Any) -> None:
        """Set what the requests of both ROS have."""
        part = request.diffuse
        light.SetDiffuseColor(Color(part.r, part.g, part.b, part.a))
        light.SetAttenuation(request.attenuation_constant, request.attenuation_linear, request.attenuation_quadratic)

    # Frames ------------------------------------------------------------------------------------------------------

    def _frame(self, name: str, missing: str) -> Entity | None:
        """The entity of a name; None for the world's frame."""
        found = self._world.EntityByName(name) if name else None
        if isinstance(found, Entity):
            return found
        if name not in INERTIAL:
            raise RefusedError(missing)
        return None


# Fields of gazebo_msgs/ODEPhysics -> parameters of the engine.
_PHYSICS = {
    "sor_pgs_precon_iters": "precon_iters",
    "sor_pgs_iters": "iters",
    "sor_pgs_w": "sor",
    "contact_surface_layer": "contact_surface_layer",
    "contact_max_correcting_vel": "contact_max_correcting_vel",
    "cfm": "cfm",
    "erp": "erp",
    "max_contacts": "max_contacts",
}
GRAVITY = (0.0, 0.0, -9.8)  # [m/s^2], by default
_WHOLE = ("sor_pgs_precon_iters", "sor_pgs_iters", "max_contacts")


# What tools of dynamic_reconfigure can set, with the defaults and limits of the original.
KNOBS = (
    Knob("time_step", 0.001, 0.0, 10.0, "Step of the simulation [s]", 1),
    Knob("max_update_rate", 60.0, 0.0, 1000.0, "Steps in a second of real time [Hz]; 0: as many as possible", 1),
    *(
        Knob(f"gravity_{axis}", value, -100.0, 100.0, f"Gravity along {axis} [m/s^2]", 1)
        for axis, value in zip("xyz", GRAVITY, strict=True)
    ),
    Knob("auto_disable_bodies", False, False, True, "Let bodies sleep that do not move", 1),
    Knob("sor_pgs_precon_iters", 0, 0, 10_000, "Iterations before those of the quick solver", 1),
    Knob("sor_pgs_iters", 20, 0, 10_000, "Iterations of the quick solver", 1),
    Knob("sor_pgs_w", 1.3, 0.0, 5.0, "Relaxation of the quick solver", 1),
    Knob("sor_pgs_rms_error_tol", -1.0, -1.0, 10_000.0, "Not used", 1),
    Knob("cfm", 0.0, 0.0, 10.0, "Constraint force mixing", 1),
    Knob("erp", 0.2, 0.0, 10.0, "Error reduction of constraints", 1),
    Knob("contact_surface_layer", 0.001, 0.0, 10.0, "Kept, without effect, as in Gazebo [m]", 1),
    Knob("contact_max_correcting_vel", 100.0, 0.0, 1e7, "Most speed with which contacts are corrected [m/s]", 1),
    Knob("max_contacts", 100, 0, 10_000_000, "Most contacts of two bodies", 1),
)


def _holder(physics: Any, name: str) -> tuple[Any, str]:
    """The part of a message about physics that has a value, and its name in that."""
    if name.startswith("gravity_"):
        return physics.gravity, name[-1]
    return (physics if hasattr(physics, name) else physics.ode_config), name


def fill_state(target: Any, entity: Any, frame: Any) -> None:
    """Set pose and twist of an entity, relative to another one if that is given."""
    pose, linear, angular = entity.WorldPose(), entity.WorldLinearVel(), entity.WorldAngularVel()
    if frame is not None:
        place = frame.WorldPose()
        pose = pose - place
        linear = place.Rot().RotateVectorReverse(linear - frame.WorldLinearVel())
        angular = place.Rot().RotateVectorReverse(angular - frame.WorldAngularVel())
    set_pose(target.pose, pose)
    set_twist(target.twist, linear, angular)
