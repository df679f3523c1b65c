"""Commands: handlers of the messages that control a world."""

from __future__ import annotations

import functools
import logging
from collections.abc import Callable
from typing import Any

from libgz.base.errors import GazeboError, NotFoundError, ParameterError, nearest
from libgz.base.geometry import GzColor
from libgz.classic import msgs
from libgz.classic.common import PID
from libgz.classic.describe import (
    LIGHT_KINDS,
    entity_message,
    heights_message,
    model_message,
    physics_message,
    place_message,
    scene_message,
)
from libgz.classic.math import Pose3d, Quaterniond
from libgz.classic.physics.base import Base
from libgz.classic.physics.collision import Collision
from libgz.classic.physics.insertion import insert_now
from libgz.classic.physics.light import Light
from libgz.classic.physics.link import Link
from libgz.classic.physics.model import Model
from libgz.classic.physics.world import World
from libgz.classic.transport.manager import TopicManager
from libgz.sdf.element import Element
from libgz.sdf.paths import find_model
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import NEWEST, upgraded
from libgz.sdfworld.world import BUILT
from libgz.simulation.repeated import MOST_LINES, repeated
from libgz.simulation.world import World as CoreWorld
from libgz.transport.tally import Tally

__all__ = ["Commands", "PausedSteps", "reload_response"]

log = logging.getLogger("libgz.classic")

# Fields of msgs.Physics that are parameters of the engine by the same name.
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


LONGEST_NAME = 4096  # characters of what a message names


class PausedSteps:
    """Requested iterations of a paused world: the pause is lifted for them, so that a signal or a message can end them.

    Args:
        core: the engine's world.
    """

    STATE = ("_remaining", "_lifted")
    _remaining: int
    _lifted: bool  # whether the pause is lifted for them

    def __init__(self, core: CoreWorld) -> None:
        self._core = core
        self._remaining = 0
        self._lifted = False

    @property
    def requested(self) -> bool:
        """Whether there are any."""
        return bool(self._remaining or self._lifted)

    def add(self, count: int) -> None:
        """Request iterations."""
        self._remaining += count

    def replace_one(self) -> None:
        """A reset takes the place of one iteration, as in Gazebo."""
        self._remaining = max(self._remaining - 1, 0)

    def cancel(self) -> None:
        """Drop all requests: the world is not paused any more."""
        self._remaining, self._lifted = 0, False

    def update(self, paused: bool) -> None:
        """Lift or restore the pause; called after each iteration, `paused`: whether that one was paused."""
        if not self.requested:
            return
        if self._lifted and not paused:
            self._remaining -= 1
        if self._core.paused and self._remaining > 0:
            self._core.paused, self._lifted = False, True
        elif self._lifted and self._remaining <= 0:
            self._core.paused, self._lifted, self._remaining = True, False, 0
            self._core.events["Step"]()
        elif not self._lifted:
            self._remaining = 0  # the world is not paused


class Commands:
    """Handles messages between iterations. An invalid message is logged, and has no effect.

    Args:
        world: the world.
        respond: publishes responses to requests.
        paused_steps: requested iterations of the paused world.
        changed: called with a model or light that a message has changed.
    """

    def __init__(
        self,
        world: World,
        respond: Callable[[Any], object],
        paused_steps: PausedSteps,
        changed: Callable[[Model | Light], object] = lambda _entity: None,
    ) -> None:
        self._world, self._respond, self._paused_steps, self._changed = world, respond, paused_steps, changed
        self._made: set[str] = set()  # lights of ~/factory/light, while they are inserted
        self._tally = Tally(MOST_LINES)

    def guarded(self, topic: str, handler: Callable[[Any], None]) -> Callable[[Any], None]:
        """A subscriber's callback for a handler."""

        agenda, manager = self._world.core.agenda, TopicManager.Instance()

        def on_message(message: Any) -> None:
            before = len(agenda.deferred)
            with repeated(self._tally):
                try:
                    handler(message)
                except GazeboError as error:
                    log.error("%s: %s", topic, error)
                except Exception as error:  # the subscription must not end
                    log.exception("%s: a message could not be handled: %r", topic, error)
            manager.allowance.changes += max(0, len(agenda.deferred) - before)

        return on_message

    def between_steps(self, topic: str, handler: Callable[[Any], None]) -> Callable[[Any], None]:
        """A handler that waits until entities can be inserted, and states restored."""
        return functools.partial(self._between_steps, topic, handler)

    # The world ---------------------------------------------------------------------------------------------------

    def world_control(self, message: Any) -> None:
        """~/world_control: pause, step, reset, seed.

        As in Gazebo, several steps pause the world, `step` is one, and a reset comes before the steps of its message.
        """
        if message.HasField("seed"):
            self._world.Physics().SetSeed(message.seed)
        if message.HasField("pause"):
            self._world.SetPaused(message.pause)
            if not message.pause:
                self._paused_steps.cancel()
        if message.HasField("multi_step"):  # then `step` beside it counts for nothing
            self._world.SetPaused(True)
            self._paused_steps.add(message.multi_step)
        elif message.HasField("step"):
            self._paused_steps.add(1)
        if message.HasField("reset"):
            self._reset(message.reset)

    def _reset(self, reset: Any) -> None:
        parts = reset.time_only or reset.model_only
        everything = not parts or (reset.HasField("all") and reset.all)
        if everything or reset.time_only:
            self._paused_steps.replace_one()
        if everything:
            self._world.Reset()
            return
        if reset.time_only:
            self._world.ResetTime()
        if reset.model_only:
            self._world.ResetEntities(Base.MODEL)

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
        if message.clone or message.open_filename or message.new_world:
            raise ParameterError(
                "a running gzserver neither opens, makes nor clones worlds; start another one, with a "
                "GAZEBO_MASTER_URI of its own"
            )

    # Models and lights -------------------------------------------------------------------------------------------

    def factory(self, message: Any) -> None:
        """~/factory: insert models or lights from SDF, from a file, or as a copy of a model."""
        self._between_steps("~/factory", self._make, message)

    def _between_steps(self, topic: str, handler: Callable[[Any], None], message: Any) -> None:
        """Handle a message when entities can be inserted: each handler finds the entities of those before it."""
        self._world.core.after_step(functools.partial(self.guarded(topic, handler), message))

    def _make(self, message: Any) -> None:
        file = self._factory_sdf(message)
        root = next(file.root.named("world"), file.root)
        entities = [child for child in root.children if child.name in BUILT]
        if not entities:
            raise ParameterError("there is no model, light or actor in the message")
        edited = self._edited(message, entities)
        for entity in entities:
            if message.HasField("pose"):
                _set_pose(entity, _pose_of(message))
            elif edited is not None and not entity.HasElement("pose"):
                _set_pose(entity, edited.RelativePose())
            name = message.edit_name or entity.Get(str, "name")
            entity.set_attribute("name", self._unique(name) if message.allow_renaming and edited is None else name)
        if edited is None:
            insert_now(self._world, file)
        else:
            self._replace(edited, file)

    def _edited(self, message: Any, entities: list[Element]) -> Model | Light | None:
        """The entity that a message edits; None if it makes a new one.

        Raises:
            ParameterError: the message has something else instead of it.
        """
        found = self._world.EntityByName(message.edit_name) if message.edit_name else None
        if not isinstance(found, Model | Light):
            return None
        if len(entities) != 1:
            raise ParameterError(
                f"{found.GetName()!r} is edited; there must be one element for it, not {len(entities)}"
            )
        if (entities[0].name == "light") != isinstance(found, Light):
            raise ParameterError(f"<{entities[0].name}> cannot replace {found.GetName()!r}, which is of another kind")
        return found

    def _replace(self, edited: Model | Light, file: SdfFile) -> None:
        """Build an entity again as a message describes it; if that fails, it stays.

        Raises:
            GazeboError: it cannot be built.
        """
        core = self._world.core
        before = core.snapshots.save()
        family = [part.core for part in edited.family()] if isinstance(edited, Model) else [edited.core]
        core.remove(list(reversed(family)))
        try:
            insert_now(self._world, file)
        except GazeboError:
            core.snapshots.restore(before)
            raise

    def _unique(self, name: str) -> str:
        """The name itself if it is free, else with a number."""
        taken = {part.GetName() for part in self._world.children()}
        return next(one for one in (name, *(f"{name}_{i}" for i in range(len(taken)))) if one not in taken)

    def _factory_sdf(self, message: Any) -> SdfFile:
        for name in (message.sdf_filename, message.clone_model_name, message.edit_name):
            if len(name) > LONGEST_NAME:
                raise ParameterError(f"a name has {len(name)} characters; at most {LONGEST_NAME} are allowed")
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
        """~/factory/light: insert a light."""
        self._between_steps("~/factory/light", self._make_light, message)

    def _make_light(self, message: Any) -> None:
        if not message.name:
            raise ParameterError("a light needs a name")
        file = SdfFile.from_string("<sdf version='1.6'><light name='' type='point'/></sdf>")
        element = file.root.child("light")
        element.set_attribute("name", message.name)
        element.set_attribute("type", LIGHT_KINDS[max(0, message.type - 1)])
        self._made.add(message.name)
        try:
            insert_now(self._world, file)
        finally:
            self._made.discard(message.name)
        try:
            self.light_modify(message)
        except GazeboError:  # no light with only some of its properties
            self._world.RemoveModel(message.name)
            raise

    def was_made(self, name: str) -> bool:
        """Whether a new light comes by ~/factory/light, where all clients have seen it."""
        return name in self._made

    def light_modify(self, message: Any) -> None:
        """~/light/modify: change pose, kind, colours, range, cone, shadows and attenuation of a light."""
        light = self._find(message.name, Light)
        if message.HasField("pose"):
            light.SetWorldPose(_pose_of(message))
        if message.HasField("diffuse"):
            light.SetDiffuseColor(msgs.ConvertIgn(message.diffuse))
        if message.HasField("specular"):
            light.SetSpecularColor(msgs.ConvertIgn(message.specular))
        if message.HasField("direction"):
            light.SetDirection(msgs.ConvertIgn(message.direction))
        if message.HasField("range"):
            light.SetRange(message.range)
        if message.HasField("cast_shadows"):
            light.SetCastShadows(message.cast_shadows)
        if message.HasField("type"):
            light.core.light.kind = LIGHT_KINDS[max(0, message.type - 1)]
        cone = zip(("inner_angle", "outer_angle", "falloff"), light.core.light.spot, strict=True)
        light.core.light.SetSpot(
            *(getattr(message, f"spot_{k}") if message.HasField(f"spot_{k}") else value for k, value in cone)
        )
        constant, linear, quadratic = light.Attenuation()
        if message.HasField("attenuation_constant"):
            constant = message.attenuation_constant
        if message.HasField("attenuation_linear"):
            linear = message.attenuation_linear
        if message.HasField("attenuation_quadratic"):
            quadratic = message.attenuation_quadratic
        if (constant, linear, quadratic) != light.Attenuation():
            light.SetAttenuation(constant, linear, quadratic)
        self._changed(light)

    def model_modify(self, message: Any) -> None:
        """~/model/modify: change a model, its links and their collisions."""
        model = self._find(message.name, Model)
        self._modify(model, message, model.SetWorldPose)
        self._changed(model)

    def _modify(self, model: Model, message: Any, place: Callable[[Pose3d], None]) -> None:
        """Change a model; `place` sets its pose: global for one that is named, relative for one within a message."""
        _check_number(model, message)
        if message.HasField("pose"):
            place(_pose_of(message))
        if message.HasField("scale"):
            model.SetScale(msgs.ConvertIgn(message.scale))
        for field, setter in (
            ("is_static", model.SetStatic),
            ("self_collide", model.SetSelfCollide),
            ("enable_wind", model.SetWindMode),
        ):
            if message.HasField(field):
                setter(getattr(message, field))
        for part in message.link:
            link = model.GetLink(part.name.rpartition("::")[2])
            if link is None:
                raise NotFoundError(f"model {model.GetName()!r} has no link {part.name!r}")
            self._modify_link(link, part)
        for nested in message.model:
            inner = model.NestedModel(nested.name.rpartition("::")[2])
            if inner is None:
                raise NotFoundError(f"model {model.GetName()!r} has no model {nested.name!r}")
            self._modify(inner, nested, inner.SetRelativePose)
        for visual in message.visual:
            self.visual(visual)

    def _modify_link(self, link: Link, message: Any) -> None:
        _check_number(link, message)
        _apply(
            message,
            gravity=link.SetGravityMode,
            kinematic=link.SetKinematic,
            self_collide=link.SetSelfCollide,
            enabled=link.SetEnabled,
            enable_wind=link.SetWindMode,
        )
        if message.HasField("inertial"):
            _set_inertial(link, message.inertial)
        if message.HasField("pose"):
            link.SetRelativePose(_pose_of(message))
        for part in message.collision:
            collision = link.GetCollision(part.name.rpartition("::")[2])
            if collision is None:
                raise NotFoundError(f"link {link.GetScopedName()!r} has no collision {part.name!r}")
            _modify_collision(collision, part)
        for visual in message.visual:
            self.visual(visual)

    def wrench(self, name: str, message: Any) -> None:
        """~/MODEL/LINK/wrench: apply a force and a torque in the link's frame, in the next step."""
        link = self._world.BaseByName(name)
        if not isinstance(link, Link):
            raise NotFoundError(f"there is no link {name!r}")
        offset = msgs.ConvertIgn(message.force_offset) if message.HasField("force_offset") else (0.0, 0.0, 0.0)
        link.AddLinkForce(msgs.ConvertIgn(message.force), offset)
        link.AddRelativeTorque(msgs.ConvertIgn(message.torque))

    def joint(self, message: Any) -> None:
        """~/MODEL/joint_cmd: set force, targets and gains of a joint by scoped name."""
        found = self._world.BaseByName(message.name)
        model = found.model_around() if found is not None and found.HasType(Base.JOINT) else None
        if model is None or found is None:
            raise NotFoundError(f"there is no joint {message.name!r}")
        controller, name = model.GetJointController(), found.GetScopedName()
        if message.reset:
            controller.drop_targets(name)
        if message.HasField("force"):
            controller.SetForce(name, message.force)
        if message.HasField("position"):
            controller.SetPositionPID(name, _with_gains(controller.GetPositionPIDs()[name], message.position))
            if message.position.HasField("target"):
                controller.SetPositionTarget(name, message.position.target)
        if message.HasField("velocity"):
            controller.SetVelocityPID(name, _with_gains(controller.GetVelocityPIDs()[name], message.velocity))
            if message.velocity.HasField("target"):
                controller.SetVelocityTarget(name, message.velocity.target)

    def _find(self, name: str, kind: type[Any]) -> Any:
        world = self._world  # which may have the same name, as may a link
        found = world.LightByName(name) if kind is Light else world.ModelByName(name)
        if not isinstance(found, kind):
            names = [part.GetName() for part in self._world.children() if isinstance(part, kind)]
            raise NotFoundError(f"there is no {kind.__name__.lower()} {name!r}{nearest(name, names)}")
        return found

    # What is rendered --------------------------------------------------------------------------------------------

    def scene(self, message: Any) -> None:
        """~/scene: change ambient light, background, shadows and fog."""
        core, backdrop, sdf = self._world.core, self._world.core.backdrop, self._world.SDF()
        element = next(sdf.named("scene"), None) or sdf.AddElement("scene") if sdf is not None else None
        for name in ("ambient", "background"):
            if message.HasField(name):
                color = GzColor(*msgs.ConvertIgn(getattr(message, name)))
                if name == "ambient":
                    backdrop.ambient = color
                else:
                    core.skyColor = color
                if element is not None:
                    element.child(name).Set(color)
        if message.HasField("shadows"):
            backdrop.shadows = message.shadows
            if element is not None:
                element.child("shadows").Set(message.shadows)
        if message.HasField("fog"):
            self._fog(message.fog)

    def _fog(self, fog: Any) -> None:
        core, kinds = self._world.core, type(fog)
        core.fogEnable = fog.type != kinds.NONE if fog.HasField("type") else core.fogEnable
        if fog.HasField("density"):
            core.fogDensity = max(0.0, fog.density)
        if fog.HasField("color"):
            core.backdrop.fog_color = GzColor(*msgs.ConvertIgn(fog.color))
        if fog.HasField("start") and fog.HasField("end"):
            core.backdrop.fog_start, core.backdrop.fog_end = fog.start, fog.end

    def visual(self, message: Any) -> None:
        """~/visual: change a visual of a world that is rendered: pose, scale, colours, transparency, visibility."""
        scene = self._world.server.scene
        found = scene.GetVisual(message.name) if scene is not None else None
        if found is None:
            return  # for a client's scene
        if message.delete_me:
            found.Fini()
            return
        if message.HasField("pose"):
            found.SetPose(_pose_of(message))
        if message.HasField("scale"):
            found.SetScale(msgs.ConvertIgn(message.scale))
        if message.HasField("visible"):
            found.SetVisible(message.visible)
        if message.HasField("transparency"):
            found.SetTransparency(message.transparency)
        if message.HasField("cast_shadows"):
            found.SetCastShadows(message.cast_shadows)
        material = message.material
        if material.script.name:
            found.SetMaterial(material.script.name)
        for name in ("ambient", "diffuse", "specular", "emissive"):
            if material.HasField(name):
                getattr(found, f"Set{name.capitalize()}")(msgs.ConvertIgn(getattr(material, name)))

    # Air ---------------------------------------------------------------------------------------------------------

    def wind(self, message: Any) -> None:
        """~/wind: velocity, and whether there is any."""
        if message.HasField("linear_velocity"):
            self._world.Wind().SetLinearVel(msgs.ConvertIgn(message.linear_velocity))
        if message.HasField("enable_wind"):
            self._world.SetWindEnabled(message.enable_wind)

    def atmosphere(self, message: Any) -> None:
        """~/atmosphere: temperature and pressure at altitude 0, and whether it is enabled."""
        air = self._world.Atmosphere()
        if message.HasField("temperature"):
            air.SetTemperature(message.temperature)
        if message.HasField("pressure"):
            air.SetPressure(message.pressure)
        if message.HasField("enable_atmosphere"):
            self._world.SetAtmosphereEnabled(message.enable_atmosphere)

    def _atmosphere_info(self, _name: str) -> Any:
        air = self._world.Atmosphere()
        return msgs.Atmosphere(
            type=msgs.Atmosphere.ADIABATIC,
            temperature=air.Temperature(),
            pressure=air.Pressure(),
            mass_density=air.MassDensity(),
            enable_atmosphere=self._world.AtmosphereEnabled(),
        )

    def _wind_info(self, _name: str) -> Any:
        message = msgs.Wind(enable_wind=self._world.WindEnabled())
        msgs.Set(message.linear_velocity, self._world.Wind().LinearVel())
        return message

    # Requests ----------------------------------------------------------------------------------------------------

    def request(self, message: Any) -> None:
        """~/request: answer on ~/response, or delete an entity."""
        answers: dict[str, Callable[[str], Any]] = {
            "atmosphere_info": self._atmosphere_info,
            "entity_delete": self._delete,
            "entity_info": lambda name: entity_message(self._world.BaseByName(name)),
            "entity_list": self._list,
            "heightmap_data": lambda _name: heights_message(self._world),
            "physics_info": lambda _name: physics_message(self._world),
            "scene_info": lambda _name: scene_message(self._world),
            "spherical_coordinates_info": lambda _name: place_message(self._world),
            "wind_info": self._wind_info,
            "world_sdf": lambda _name: msgs.GzString(data=self._sdf()),
        }
        if message.request not in answers:
            return  # for another subscriber
        answer = answers[message.request](message.data)
        response = msgs.Response(id=message.id, request=message.request, response="success")
        if answer is None:
            response.response, response.type = "nonexistent", "error"
        elif answer is not True:
            response.type, response.serialized_data = answer.GetTypeName(), answer.SerializeToString()
        self._respond(response)

    def plugin_reload(self, message: Any) -> None:
        """~/plugin/reload: load the edited file of a plugin again; answered on ~/response."""
        self._between_steps("~/plugin/reload", self._reload, message)

    def _reload(self, message: Any) -> None:
        from libgz.simulation.reloading import reload  # most worlds do without it

        core = self._world.core
        self._respond(reload_response(message, functools.partial(reload, core)))

    def _delete(self, name: str) -> Any:
        if not isinstance(self._world.EntityByName(name), Model | Light):
            return None
        self._world.RemoveModel(name)
        return True

    def _list(self, _name: str) -> Any:
        return msgs.Model_V(models=[model_message(model) for model in self._world.Models()])

    def _sdf(self) -> str:
        """The world as SDF, with all entities that were inserted."""
        from libgz.classic.physics.state import world_text  # most worlds do without it

        return world_text(self._world)


def reload_response(message: Any, replace: Callable[[str], list[str]]) -> Any:
    """The response to a request to load a plugin again.

    Args:
        message: the request; its data are the name.
        replace: loads plugins of a name again; returns what was replaced.
    """
    response = msgs.Response(id=message.id, request=message.request, response="success")
    try:
        text = "\n".join(replace(message.data))
    except NotFoundError as error:
        response.response, text = "nonexistent", str(error)
    except GazeboError as error:
        response.response, text = "error", str(error)
    answer = msgs.GzString(data=text)
    response.type, response.serialized_data = answer.GetTypeName(), answer.SerializeToString()
    return response


def _pose_of(message: Any) -> Pose3d:
    """The pose of a message; a rotation of four zeros is none, as in Gazebo."""
    pose: Pose3d = msgs.ConvertIgn(message.pose)
    if not any(pose.rot):
        pose.rot = Quaterniond()
    return pose


def _set_pose(entity: Element, pose: Pose3d) -> None:
    place = next(entity.named("pose"), None) or entity.AddElement("pose")
    place.Set(pose)


def _check_number(entity: Model | Link | Collision, message: Any) -> None:
    """Raise ParameterError if a message has the number of another entity."""
    if message.HasField("id") and message.id != entity.GetId():
        raise ParameterError(f"{entity.GetScopedName()!r} has the number {entity.GetId()}, not {message.id}")


def _set_inertial(link: Link, message: Any) -> None:
    """Set the values that a msgs.Inertial has; the others stay."""
    inertial = link.GetInertial()
    if message.HasField("mass"):
        inertial.SetMass(message.mass)
    if message.HasField("pose"):
        inertial.SetCoG(msgs.ConvertIgn(message.pose))
    moments = (
        (message.ixx if message.HasField("ixx") else inertial.IXX()),
        (message.iyy if message.HasField("iyy") else inertial.IYY()),
        (message.izz if message.HasField("izz") else inertial.IZZ()),
        (message.ixy if message.HasField("ixy") else inertial.IXY()),
        (message.ixz if message.HasField("ixz") else inertial.IXZ()),
        (message.iyz if message.HasField("iyz") else inertial.IYZ()),
    )
    inertial.SetInertiaMatrix(*moments)
    link.UpdateMass()


# Fields of msgs.Surface -> attributes of SurfaceParams.
SURFACE_FIELDS = {
    "restitution_coefficient": "bounce",
    "bounce_threshold": "bounceThreshold",
    "kp": "kp",
    "kd": "kd",
    "max_vel": "maxVel",
    "min_depth": "minDepth",
    "collide_bitmask": "collideBitmask",
    "collide_without_contact": "collideWithoutContact",
    "collide_without_contact_bitmask": "collideWithoutContactBitmask",
}


def _modify_collision(collision: Collision, message: Any) -> None:
    _check_number(collision, message)
    if message.HasField("laser_retro"):
        collision.SetLaserRetro(message.laser_retro)
    if message.HasField("max_contacts"):
        collision.SetMaxContacts(int(message.max_contacts))
    if message.HasField("pose"):
        collision.SetRelativePose(_pose_of(message))
    surface, given = collision.GetSurface(), message.surface
    for field, name in SURFACE_FIELDS.items():
        if given.HasField(field):
            setattr(surface, name, getattr(given, field))
    pyramid, friction = surface.FrictionPyramid(), given.friction
    for name in ("slip1", "slip2"):
        if friction.HasField(name):
            setattr(surface, name, getattr(friction, name))
    _apply(friction, mu=pyramid.SetMuPrimary, mu2=pyramid.SetMuSecondary)
    if friction.HasField("fdir1"):
        pyramid.direction1 = msgs.ConvertIgn(friction.fdir1)
    _apply(
        friction.torsional,
        coefficient=pyramid.SetMuTorsion,
        patch_radius=pyramid.SetPatchRadius,
        surface_radius=pyramid.SetSurfaceRadius,
        use_patch_radius=pyramid.SetUsePatchRadius,
    )


def _apply(message: Any, **setters: Callable[[Any], object]) -> None:
    """Call the setters of the fields that a message has."""
    for field, setter in setters.items():
        if message.HasField(field):
            setter(getattr(message, field))


def _with_gains(pid: PID, message: Any) -> PID:
    """A PID, with the gains that a message has set."""
    if message.HasField("p_gain"):
        pid.SetPGain(message.p_gain)
    if message.HasField("i_gain"):
        pid.SetIGain(message.i_gain)
    if message.HasField("d_gain"):
        pid.SetDGain(message.d_gain)
    if message.HasField("i_max"):
        pid.SetIMax(message.i_max)
    if message.HasField("i_min"):
        pid.SetIMin(message.i_min)
    if message.HasField("limit"):
        pid.SetCmdMax(abs(message.limit))
        pid.SetCmdMin(-abs(message.limit))
    return pid
