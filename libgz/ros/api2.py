"""WorldApi2: the services of gazebo_ros for ROS 2, with the answers of the original."""

from __future__ import annotations

from typing import Any

from libgz.base.errors import NotFoundError
from libgz.classic.physics.base import Entity
from libgz.classic.physics.insertion import insert_document
from libgz.ros.api import DELETE_PATIENCE, SPAWN_PATIENCE, WorldApi, fill_state
from libgz.ros.packages import with_paths
from libgz.ros.services import RefusedError, pose_of, vector
from libgz.ros.session import Later, set_stamp
from libgz.ros.spawning import failure, prepare_model, root_tag
from libgz.ros.types import Message, service_type

__all__ = ["PROPERTIES", "SERVICES2", "STATES", "PropertiesApi", "StateApi", "WorldApi2"]

STATES = {"get_entity_state": "gazebo_msgs/GetEntityState", "set_entity_state": "gazebo_msgs/SetEntityState"}

PROPERTIES = {
    name: f"gazebo_msgs/{name.title().replace('_', '')}"
    for name in (
        "get_joint_properties",
        "get_light_properties",
        "get_link_properties",
        "get_model_properties",
        "set_joint_properties",
        "set_light_properties",
        "set_link_properties",
    )
}

# Services of ROS 2 -> their types.
SERVICES2 = {
    "apply_joint_effort": "gazebo_msgs/ApplyJointEffort",
    "apply_link_wrench": "gazebo_msgs/ApplyLinkWrench",
    "clear_joint_efforts": "gazebo_msgs/JointRequest",
    "clear_link_wrenches": "gazebo_msgs/LinkRequest",
    "delete_entity": "gazebo_msgs/DeleteEntity",
    "get_model_list": "gazebo_msgs/GetModelList",
    "pause_physics": "std_srvs/Empty",
    "reset_simulation": "std_srvs/Empty",
    "reset_world": "std_srvs/Empty",
    "spawn_entity": "gazebo_msgs/SpawnEntity",
    "unpause_physics": "std_srvs/Empty",
    **PROPERTIES,
    **STATES,
}


class WorldApi2(WorldApi):
    """Serves what gazebo_ros's System plugins and gazebo_ros_state serve, in the namespace of the server's node."""

    services = SERVICES2

    # Entities ----------------------------------------------------------------------------------------------------

    def _spawn_entity(self, request: Any, answer: Any) -> Message | Later:
        world, name, text = self._world, request.name, request.xml
        if root_tag(text) not in ("robot", "sdf", "gazebo", "model", "light"):
            raise RefusedError("Failed to parse the entity's text: it is neither SDF nor URDF")
        if root_tag(text) == "robot":
            try:
                text = with_paths(text)
            except NotFoundError as error:
                raise RefusedError(f"urdf reference package name does not exist: {error}") from None
        frame = self._frame(
            request.reference_frame,
            f"Reference frame [{request.reference_frame}] not found, did you forget to scope the link by model name?",
        )
        pose = pose_of(request.initial_pose)
        if frame is not None:
            pose = pose + frame.WorldPose()
        if name and world.BaseByName(name) is not None:
            raise RefusedError(f"Entity [{name}] already exists.")
        document = prepare_model(text, name, pose, request.robot_namespace, self._free)
        inserted = insert_document(world, document)
        if not name:
            answer.success, answer.status_message = True, "Successfully sent factory message to Gazebo."
            return answer  # type: ignore[no-any-return]

        def poll() -> Message | None:
            if error := failure(inserted):
                return self.refuse(answer, f"SpawnEntity: {error}")
            if world.BaseByName(name) is None:
                return None
            answer.success, answer.status_message = True, f"SpawnEntity: Successfully spawned entity [{name}]"
            return answer  # type: ignore[no-any-return]

        late = "Entity pushed to spawn queue, but spawn service timed out waiting for entity to appear in simulation"
        kind = service_type("gazebo_msgs/SpawnEntity", 2).response
        return Later(poll, SPAWN_PATIENCE, kind(status_message=f"{late} under the name [{name}]"))

    def _free(self, name: str) -> str:
        """A name that no entity has: itself, or with a number."""
        number, found = 0, name
        while self._world.BaseByName(found) is not None:
            found, number = f"{name}_{number}", number + 1
        return found

    def _delete_entity(self, request: Any, answer: Any) -> Later:
        world, name = self._world, request.name
        model = world.ModelByName(name)
        if model is None and world.LightByName(name) is None:
            raise RefusedError(f"Entity [{name}] does not exist")
        for link in model.GetLinks() if model is not None else ():
            self.clear(link.GetScopedName())
        for joint in model.GetJoints() if model is not None else ():
            self.clear(joint.GetName())
        world.RemoveModel(model if model is not None else name)

        def poll() -> Message | None:
            if world.ModelByName(name) is not None or world.LightByName(name) is not None:
                return None
            answer.success, answer.status_message = True, f"Successfully deleted entity [{name}]"
            return answer  # type: ignore[no-any-return]

        late = "Delete service timed out waiting for entity to disappear from simulation"
        return Later(poll, DELETE_PATIENCE, service_type("gazebo_msgs/DeleteEntity", 2).response(status_message=late))

    def _get_model_list(self, _request: Any, answer: Any) -> None:
        set_stamp(answer.header.stamp, self._world.core.GetSimTime())
        answer.model_names = [model.GetName() for model in self._world.Models()]
        answer.success = True

    # States ------------------------------------------------------------------------------------------------------

    def _entity(self, name: str, service: str) -> Entity:
        found = self._world.EntityByName(name) if name else None
        if not isinstance(found, Entity):
            raise RefusedError(f"{service}: entity [{name}] does not exist")
        return found

    def _get_entity_state(self, request: Any, answer: Any) -> None:
        entity = self._entity(request.name, "GetEntityState")
        frame = self._frame(request.reference_frame, f"reference entity [{request.reference_frame}] not found")
        set_stamp(answer.header.stamp, self._world.core.GetSimTime())
        answer.header.frame_id = answer.state.reference_frame = request.reference_frame
        answer.state.name = request.name
        fill_state(answer.state, entity, frame)
        answer.success = True

    def _set_entity_state(self, request: Any, answer: Any) -> None:
        state = request.state
        entity: Any = self._entity(state.name, "SetEntityState")
        frame = self._frame(state.reference_frame, f"reference entity [{state.reference_frame}] not found")
        pose, linear, angular = pose_of(state.pose), vector(state.twist.linear), vector(state.twist.angular)
        if frame is not None:
            place = frame.WorldPose()
            pose = pose + place
            linear, angular = place.Rot().RotateVector(linear), place.Rot().RotateVector(angular)
        entity.SetWorldPose(pose)
        if hasattr(entity, "SetLinearVel"):
            entity.SetLinearVel(linear)
            entity.SetAngularVel(angular)
        answer.success = True

    # Properties --------------------------------------------------------------------------------------------------

    def _get_model_properties(self, request: Any, answer: Any) -> None:
        super()._get_model_properties(request, answer)
        if answer.body_names:
            answer.canonical_body_name = answer.body_names[0]

    def _set_joint_properties(self, request: Any, answer: Any) -> None:
        config = request.ode_joint_config
        self._set_joint(request.joint_name, config, config.hi_stop, config.lo_stop)
        answer.success, answer.status_message = True, "SetJointProperties: properties set"

    def _set_light_properties(self, request: Any, answer: Any) -> None:
        light = self._light(request.light_name, f"setLightProperties: Requested light {request.light_name} not found!")
        self._set_light(light, request)
        answer.success = True

    # Efforts -----------------------------------------------------------------------------------------------------

    def _apply_link_wrench(self, request: Any, answer: Any) -> None:
        link = self._link(request.link_name, "ApplyLinkWrench: link does not exist")
        self._apply_wrench(link, request, "Reference_frame not found")
        answer.success = True

    def _clear_link_wrenches(self, request: Any, _answer: Any) -> None:
        self.clear(request.link_name)

    def _apply_joint_effort(self, request: Any, answer: Any) -> None:
        super()._apply_joint_effort(request, answer)
        answer.status_message = f"Effort on joint [{request.joint_name}] set"

    def _clear_joint_efforts(self, request: Any, _answer: Any) -> None:
        self.clear(request.joint_name)


class PropertiesApi(WorldApi2):
    """The services of the world plugin gazebo_ros_properties, as its node has them."""

    services = PROPERTIES


class StateApi(WorldApi2):
    """The services of the world plugin gazebo_ros_state, as its node has them."""

    services = STATES
