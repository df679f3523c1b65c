"""Commands: what a world does when it is told to by messages."""

from __future__ import annotations

import functools
import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs
from libgz.classic.common import PID
from libgz.classic.describe import LIGHT_KINDS, entity_message, physics_message, scene_message
from libgz.classic.physics.base import Base
from libgz.classic.physics.insertion import insert_now
from libgz.classic.physics.light import Light
from libgz.classic.physics.model import Model
from libgz.classic.physics.state import world_text
from libgz.errors import GazeboError, NotFoundError, ParameterError, nearest
from libgz.sdf.paths import find_model
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import NEWEST, upgraded

if TYPE_CHECKING:
    from libgz.classic.server import WorldServer

__all__ = ["Commands"]

log = logging.getLogger("libgz.classic")

PHYSICS_KEYS = (
    "max_step_size",
    "real_time_update_rate",
    "real_time_factor",
    "solver_type",
    "min_step_size",
    "precon_iters",
    "iters",
    "sor",
    "erp",
    "cfm",
    "contact_max_correcting_vel",
    "contact_surface_layer",
)


class Commands:
    """Acts on messages, between iterations. What is wrong with one is logged, and nothing is done.

    Args:
        server: of the world.
        respond: sends answers to requests.
    """

    def __init__(self, server: WorldServer, respond: Callable[[Any], object]) -> None:
        self._server, self._world, self._respond = server, server.world, respond

    def guarded(self, topic: str, handler: Callable[[Any], None]) -> Callable[[Any], None]:
        """A subscriber's callback for a handler."""

        def on_message(message: Any) -> None:
            try:
                handler(message)
            except GazeboError as error:
                log.error("%s: %s", topic, error)
            except Exception:  # or the topic would be dead from now on
                log.exception("%s: a message could not be acted on", topic)

        return on_message

    # The world ---------------------------------------------------------------------------------------------------

    def world_control(self, message: Any) -> None:
        """~/world_control: pause, step, reset, seed."""
        if message.HasField("seed"):
            self._world.Physics().SetSeed(message.seed)
        if message.HasField("pause"):
            self._world.SetPaused(message.pause)
            if not message.pause:
                self._server.end_steps()
        steps = message.multi_step if message.HasField("multi_step") else int(message.step)
        if steps:
            self._server.step_paused(steps)
        if message.HasField("reset"):
            self._reset(message.reset)

    def _reset(self, reset: Any) -> None:
        if reset.time_only:
            self._world.ResetTime()
        elif reset.model_only:
            self._world.ResetEntities(Base.MODEL)
        else:
            self._world.Reset()

    def physics(self, message: Any) -> None:
        """~/physics: parameters of the engine."""
        if message.HasField("profile_name") and message.profile_name:
            self._world.PresetMgr().CurrentProfile(message.profile_name)
        if message.HasField("gravity"):
            self._world.SetGravity(msgs.ConvertIgn(message.gravity))
        if message.HasField("enable_physics"):
            self._world.SetPhysicsEnabled(message.enable_physics)
        if message.HasField("magnetic_field"):
            self._world.SetMagneticField(msgs.ConvertIgn(message.magnetic_field))
        for key in PHYSICS_KEYS:
            if message.HasField(key):
                self._world.Physics().SetParam(key, getattr(message, key))

    def server_control(self, message: Any) -> None:
        """/gazebo/server/control: stop, or save the world."""
        if message.save_world_name == self._world.Name() and message.save_filename:
            self._world.Save(message.save_filename)
        if message.stop:
            self._world.Stop()

    # Models and lights -------------------------------------------------------------------------------------------

    def factory(self, message: Any) -> None:
        """~/factory: a new model, from SDF, from a file, or as a copy."""
        self._between_steps("~/factory", self._make, message)

    def _between_steps(self, topic: str, handler: Callable[[Any], None], message: Any) -> None:
        """Handle a message when models may come: each sees what those before it have made."""
        self._world.core.after_step(functools.partial(self.guarded(topic, handler), message))

    def _make(self, message: Any) -> None:
        file = self._factory_sdf(message)
        root = next(file.root.named("world"), file.root)
        entities = [child for child in root.children if child.name in ("model", "light")]
        if not entities:
            raise ParameterError("there is no model or light in the message")
        for entity in entities:
            if message.HasField("pose"):
                place = next(entity.named("pose"), None) or entity.AddElement("pose")
                place.Set(msgs.ConvertIgn(message.pose))
            name = message.edit_name or entity.Get(str, "name")
            entity.set_attribute("name", self._unique(name) if message.allow_renaming else name)
        insert_now(self._world, file)

    def _unique(self, name: str) -> str:
        """A name that nothing has: itself, or with a number."""
        taken = {part.GetName() for part in self._world.children()}
        return next(one for one in (name, *(f"{name}_{i}" for i in range(len(taken)))) if one not in taken)

    def _factory_sdf(self, message: Any) -> SdfFile:
        if message.sdf:
            file = SdfFile.from_string(message.sdf)
        elif message.sdf_filename:
            file = SdfFile.load(find_model(message.sdf_filename))
        elif message.clone_model_name:
            sdf = self._find(message.clone_model_name, Model).GetSDF()
            text = upgraded(sdf).ToString() if sdf is not None else ""
            file = SdfFile.from_string(f"<sdf version='{NEWEST}'>{text}</sdf>")
            for entity in file.root.children:
                entity.set_attribute("name", self._unique(f"{message.clone_model_name}_clone"))
        else:
            raise ParameterError("it names neither sdf, sdf_filename nor clone_model_name")
        file.diagnostics.raise_errors()
        return file

    def factory_light(self, message: Any) -> None:
        """~/factory/light: a new light."""
        self._between_steps("~/factory/light", self._make_light, message)

    def _make_light(self, message: Any) -> None:
        if not message.name:
            raise ParameterError("a light needs a name")
        file = SdfFile.from_string("<sdf version='1.6'><light name='' type='point'/></sdf>")
        element = file.root.child("light")
        element.set_attribute("name", message.name)
        element.set_attribute("type", LIGHT_KINDS[max(0, message.type - 1)])
        insert_now(self._world, file)
        try:
            self.light_modify(message)
        except GazeboError:  # a whole light or none
            self._world.RemoveModel(message.name)
            raise

    def light_modify(self, message: Any) -> None:
        """~/light/modify: colours, place, reach of a light."""
        light = self._find(message.name, Light)
        for key, setter in (
            ("pose", light.SetWorldPose),
            ("diffuse", light.SetDiffuseColor),
            ("specular", light.SetSpecularColor),
            ("direction", light.SetDirection),
        ):
            if message.HasField(key):
                setter(msgs.ConvertIgn(getattr(message, key)))
        if message.HasField("range"):
            light.SetRange(message.range)
        fading = [f"attenuation_{key}" for key in ("constant", "linear", "quadratic")]
        if any(message.HasField(key) for key in fading):
            now = light.Attenuation()
            light.SetAttenuation(
                *(getattr(message, key) if message.HasField(key) else now[i] for i, key in enumerate(fading))
            )

    def model_modify(self, message: Any) -> None:
        """~/model/modify: place, scale and links of a model."""
        model = self._find(message.name, Model)
        if message.HasField("pose"):
            model.SetRelativePose(msgs.ConvertIgn(message.pose))
        if message.HasField("scale"):
            model.SetScale(msgs.ConvertIgn(message.scale))
        for part in message.link:
            link = model.GetLink(part.name.rpartition("::")[2])
            if link is None:
                raise NotFoundError(f"model {model.GetName()!r} has no link {part.name!r}")
            for key, setter in (
                ("gravity", link.SetGravityMode),
                ("kinematic", link.SetKinematic),
                ("self_collide", link.SetSelfCollide),
            ):
                if part.HasField(key):
                    setter(getattr(part, key))
            if part.HasField("pose"):
                link.SetRelativePose(msgs.ConvertIgn(part.pose))

    def joint(self, message: Any) -> None:
        """~/joint: force, or targets and gains, of a joint by scoped name."""
        found = self._world.BaseByName(message.name)
        model = found.GetParentModel() if found is not None and found.HasType(Base.JOINT) else None
        if model is None or found is None:
            raise NotFoundError(f"there is no joint {message.name!r}")
        controller, name = model.GetJointController(), found.GetScopedName()
        if message.reset:
            controller.Reset()
        if message.HasField("force"):
            controller.SetForce(name, message.force)
        for key, pids, set_pid, set_target in (
            ("position", controller.GetPositionPIDs, controller.SetPositionPID, controller.SetPositionTarget),
            ("velocity", controller.GetVelocityPIDs, controller.SetVelocityPID, controller.SetVelocityTarget),
        ):
            if message.HasField(key):
                told = getattr(message, key)
                set_pid(name, _gains(pids()[name], told))
                if told.HasField("target"):
                    set_target(name, told.target)

    def _find(self, name: str, kind: type[Any]) -> Any:
        found = self._world.EntityByName(name)
        if not isinstance(found, kind):
            names = [part.GetName() for part in self._world.children() if isinstance(part, kind)]
            raise NotFoundError(f"there is no {kind.__name__.lower()} {name!r}{nearest(name, names)}")
        return found

    # Requests ----------------------------------------------------------------------------------------------------

    def request(self, message: Any) -> None:
        """~/request: questions, answered on ~/response, and deletions."""
        answers: dict[str, Callable[[str], Any]] = {
            "entity_delete": self._delete,
            "entity_info": lambda name: entity_message(self._world.BaseByName(name)),
            "entity_list": self._list,
            "physics_info": lambda _name: physics_message(self._world),
            "scene_info": lambda _name: scene_message(self._world),
            "world_sdf": lambda _name: msgs.GzString(data=self._sdf()),
        }
        if message.request not in answers:
            return  # somebody else's
        answer = answers[message.request](message.data)
        response = msgs.Response(id=message.id, request=message.request, response="success")
        if answer is None:
            response.response = "nonexistent"
        elif answer is not True:
            response.type, response.serialized_data = answer.GetTypeName(), answer.SerializeToString()
        self._respond(response)

    def _delete(self, name: str) -> Any:
        if not isinstance(self._world.EntityByName(name), Model | Light):
            return None
        self._world.RemoveModel(name)
        return True

    def _list(self, _name: str) -> Any:
        return msgs.GzString_V(data=[part.GetScopedName() for part in self._world.children()])

    def _sdf(self) -> str:
        """The world as SDF, with everything that has come since it was loaded."""
        return world_text(self._world)


def _gains(pid: PID, told: Any) -> PID:
    """A PID with the gains that a message names."""
    for key, setter in (
        ("p_gain", pid.SetPGain),
        ("i_gain", pid.SetIGain),
        ("d_gain", pid.SetDGain),
        ("i_max", pid.SetIMax),
        ("i_min", pid.SetIMin),
    ):
        if told.HasField(key):
            setter(getattr(told, key))
    if told.HasField("limit"):
        pid.SetCmdMax(abs(told.limit))
        pid.SetCmdMin(-abs(told.limit))
    return pid
