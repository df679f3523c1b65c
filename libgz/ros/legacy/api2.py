"""LegacyApi2: the services of ROS 2 that make sense for a legacy world. Models are named by their ids."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from libgz.base.errors import NotFoundError
from libgz.ros.legacy.api import LegacyApi, fill_state
from libgz.ros.services import RefusedError
from libgz.ros.session import set_stamp

__all__ = ["SERVICES2", "LegacyApi2"]

# Services -> their types.
SERVICES2 = {
    "apply_link_wrench": "gazebo_msgs/ApplyLinkWrench",
    "clear_link_wrenches": "gazebo_msgs/LinkRequest",
    "delete_entity": "gazebo_msgs/DeleteEntity",
    "get_entity_state": "gazebo_msgs/GetEntityState",
    "get_joint_properties": "gazebo_msgs/GetJointProperties",
    "get_model_list": "gazebo_msgs/GetModelList",
    "get_model_properties": "gazebo_msgs/GetModelProperties",
    "pause_physics": "std_srvs/Empty",
    "reset_simulation": "std_srvs/Empty",
    "reset_world": "std_srvs/Empty",
    "set_entity_state": "gazebo_msgs/SetEntityState",
    "unpause_physics": "std_srvs/Empty",
}


class LegacyApi2(LegacyApi):
    """Serves the services of gazebo_ros for ROS 2, for a legacy world."""

    services = SERVICES2

    def _delete_entity(self, request: Any, answer: Any) -> None:
        self._delete_model(SimpleNamespace(model_name=request.name), answer)  # as in ROS 1
        answer.status_message = f"Successfully deleted entity [{request.name}]"

    def _get_model_list(self, _request: Any, answer: Any) -> None:
        set_stamp(answer.header.stamp, self.core.GetSimTime())
        answer.model_names = [model.GetId() for model in self.core.GetModels()]
        answer.success = True

    def _get_entity_state(self, request: Any, answer: Any) -> None:
        name = request.name
        body = self._frame(name, f"GetEntityState: entity [{name}] does not exist")
        if body is None:
            raise RefusedError(f"GetEntityState: entity [{name}] does not exist")
        frame = self._frame(request.reference_frame, "GetEntityState: reference_frame not found")
        set_stamp(answer.header.stamp, self.core.GetSimTime())
        answer.header.frame_id = answer.state.reference_frame = request.reference_frame
        answer.state.name = name
        fill_state(answer.state, body, frame)
        answer.success = True

    def _set_entity_state(self, request: Any, answer: Any) -> None:
        state = request.state
        try:
            model = self.core.model(state.name)
        except NotFoundError:
            raise RefusedError(f"SetEntityState: entity [{state.name}] does not exist") from None
        self._set_state(model, state, self._frame(state.reference_frame, "SetEntityState: reference_frame not found"))
        answer.success = True

    def _apply_link_wrench(self, request: Any, answer: Any) -> None:
        self._apply_wrench(request.link_name, request)
        answer.success = True

    def _clear_link_wrenches(self, request: Any, _answer: Any) -> None:
        self.clear(request.link_name)
