"""Shared by gazebo and gzserver: what other processes can ask of a running world, beside its states."""

from __future__ import annotations

import contextlib
import json
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.apps.editing import Editing, in_parent, pose_of
from libgz.apps.probes import Probes
from libgz.apps.stock import SHAPES, Stock, sdf_shape
from libgz.base.errors import GazeboError, NotFoundError, ParameterError
from libgz.base.files import is_file
from libgz.base.geometry import GzColor, GzCoordPoseAdd, GzPose, GzVector
from libgz.base.numbers import whole_number
from libgz.front import World
from libgz.legacy.model import Model
from libgz.physics.geoms import LightGeom
from libgz.rendering.image import depth_text, jpeg_text
from libgz.sdf.paths import find_model, model_directories
from libgz.simulation.editor import numbers_of
from libgz.simulation.entity import Entity
from libgz.transport.control import Request

if TYPE_CHECKING:
    from libgz.apps.joint_servos import JointServos
    from libgz.sdf.reader import SdfFile

__all__ = ["WorldControl", "steps_of"]

MOST_STEPS = 100_000  # of one request
MOST_CONTACTS = 2000
MOST_PROBLEMS, LONGEST_PROBLEM = 200, 4000  # of one answer; characters of each
# Requests that only read.
READING = ("abilities", "catalogue", "portrait", "describe", "inventory", "contacts", "readings", "problems")
KEYS = "~/keyboard/keypress"
LONGEST_LABEL = 80  # characters of what was inserted, in the history, and of a world's name, in that of a file


class WorldControl:
    """Does what requests ask for, between two steps. The content of a request is JSON; so is an answer.

    Args:
        world: it is initialized.
        watch_only: refuse what changes the world.

    Attributes:
        speed: simulated seconds per second of real time that was asked for; None before that.
    """

    def __init__(self, world: World, watch_only: bool = False) -> None:
        self.world = world
        self.speed: float | None = None
        self._steps = 0  # that the paused world is still to do
        self._nodes: dict[str, Any] = {}
        self._servos: JointServos | None = None
        self._verbs: dict[str, Callable[[str, dict[str, Any]], Any]] = {
            "abilities": self._abilities,
            "pause": self._pause,
            "step": self._step,
            "reset": self._reset,
            "speed": self._speed,
            "move": self._move,
            "delete": self._delete,
            "insert": self._insert,
            "catalogue": self._catalogue,
            "portrait": self._portrait,
            "mesh": self._mesh,
            "write": self._write,
            "keep": self._keep,
            "describe": self._describe,
            "inventory": self._inventory,
            "contacts": self._contacts,
            "light": self._light,
            "joint": self._joint,
            "release": self._release,
            "publish": self._publish,
            "reload": self._reload,
            "readings": self._readings,
            "problems": self._problems,
            "probes": lambda _argument, content: self._probes.listed(str(content.get("name", ""))),
            "values": self._values,
        }
        self._stock, self._probes = Stock(world), Probes(world, self._node)
        self._editing = Editing(world, self.replaced, self._insert_now)
        self._verbs |= self._editing.verbs
        self._watch_only = watch_only
        if watch_only:
            self._verbs = {verb: function for verb, function in self._verbs.items() if verb in READING}

    def obey(self, request: Request) -> bytes:
        """Do what a request asks for; its answer.

        Raises:
            GazeboError: there is no such request, or it cannot be fulfilled.
        """
        verb = self._verbs.get(request.verb)
        if verb is None:
            raise GazeboError(f"there is no request {request.verb!r}; there are {', '.join(self._verbs)}")
        try:
            content = json.loads(request.content) if request.content else {}
        except (ValueError, RecursionError) as error:
            raise GazeboError(f"the content of request {request.verb!r} is no JSON: {error}") from None
        if not isinstance(content, dict):
            raise GazeboError(f"the content of request {request.verb!r} is no JSON object")
        answer = verb(request.argument, content)
        return b"" if answer is None else json.dumps(answer).encode()

    @property
    def follows(self) -> bool:
        """Whether `stepped` has something to do after each step."""
        return (self._servos is not None and self._servos.active) or self._steps > 0 or self._editing.holds

    @contextlib.contextmanager
    def replaced(self) -> Iterator[None]:
        """While a state is set: joints are held as they were in it, and steps that were asked for are dropped."""
        with self._servos.replaced() if self._servos is not None else contextlib.nullcontext():
            yield
        self._steps = 0

    def stepped(self) -> None:
        """Pause again after the steps that were asked for, and set joints' motors; called after each step."""
        if self._servos is not None:
            self._servos.act()
        if self._editing.holds:
            self._editing.act()
        if self._steps:
            self._steps -= 1
            if not self._steps:
                self.world.paused = True

    def _abilities(self, _argument: str, _content: dict[str, Any]) -> list[str]:
        """What a viewer can offer: the requests that are answered, and whether robots obey their interfaces."""
        return [*self._verbs] if self._watch_only else [*self._verbs, "rewind", "interfaces"]

    # The world -------------------------------------------------------------------------------------------------------

    def _pause(self, argument: str, _content: dict[str, Any]) -> None:
        if argument not in ("on", "off"):
            raise ParameterError(f"pause is {argument!r}; allowed are on and off")
        self._steps = 0
        self.world.paused = argument == "on"

    def _step(self, argument: str, _content: dict[str, Any]) -> None:
        count = steps_of(argument)
        if self.world.paused or self._steps:
            self._steps += count
            self.world.paused = False

    def _reset(self, _argument: str, _content: dict[str, Any]) -> None:
        self._editing.change("reset", self._reset_now, begins=False)

    def _reset_now(self) -> None:
        paused = self.world.paused
        self._editing.release_all()
        self.world.Reset()
        if self._servos is not None:
            self._servos.clear()
        self.world.paused = paused  # a state has that, too

    def _speed(self, argument: str, _content: dict[str, Any]) -> None:
        speed = _number(argument, "speed")
        if speed < 0.0:
            raise ParameterError(f"speed is {speed:g}; it must not be negative")
        self.speed = self.world.simSpeed = speed

    def _keep(self, argument: str, _content: dict[str, Any]) -> None:
        self.world.keep_rewind(_number(argument, "seconds to keep"))

    def _write(self, argument: str, content: dict[str, Any]) -> str:
        """Save the world to its file; an SDF world that has none, or a file's name is given, as a new file."""
        world = self.world
        if world.sdf is None or (not content.get("file") and is_file(Path(world.era.saved_text(world)[0] or ""))):
            if world.Save(whole=True) != 0:
                raise GazeboError("the world could not be saved; the server's log says why")
            return str(world.era.saved_text(world)[0] or "")
        stem = re.sub(r"[^\w .-]+", "_", world.name)[:LONGEST_LABEL]  # names of worlds name no folders
        path = Path(content.get("file") or f"{stem}_saved.world").absolute()
        self._classic().Save(str(path))
        return str(path)

    # Entities --------------------------------------------------------------------------------------------------------

    def _entity(self, content: dict[str, Any]) -> Entity:
        entity: Entity = self.world.model(str(content.get("name", "")))
        return entity

    def _move(self, _argument: str, content: dict[str, Any]) -> None:
        entity, pose = self._entity(content), pose_of(content)
        self._editing.move(entity.GetId(), lambda: self.world.SetModelPose(entity, in_parent(entity, pose)))

    def _light(self, _argument: str, content: dict[str, Any]) -> None:
        """Set the colour of an entity's lights."""
        entity, parts = self._entity(content), numbers_of(content.get("color"), 3, 3)
        if not all(0.0 <= part <= 1.0 for part in parts):
            raise ParameterError(f"the colour is {parts}; it must be three numbers from 0 to 1")
        lights = [geom for body in entity.bodies for geom in body.geoms if isinstance(geom, LightGeom)]
        if not lights:
            raise NotFoundError(f"{entity.GetId()!r} has no light")

        def act() -> None:
            for light in lights:
                light.SetDiffuseColor(GzColor(*parts))

        self._editing.move(f"light {entity.GetId()}", act)

    def _joint_servos(self) -> JointServos:
        from libgz.apps.joint_servos import JointServos  # legacy worlds do without SDF

        self._servos = self.world.extension(JointServos)
        return self._servos

    def _joint(self, _argument: str, content: dict[str, Any]) -> None:
        """Move an axis of a joint of an SDF model to a position, and hold it there."""
        axis, position = content.get("axis", 0), content.get("position")
        if not isinstance(axis, int) or not isinstance(position, int | float):
            raise ParameterError(f"axis {axis!r} must be a whole number, position {position!r} a number")
        self._joint_servos().hold(str(content.get("name", "")), str(content.get("joint", "")), axis, float(position))

    def _release(self, _argument: str, content: dict[str, Any]) -> None:
        """Let the joints of a model move freely again."""
        self._joint_servos().release(str(content.get("name", "")))

    def _delete(self, _argument: str, content: dict[str, Any]) -> None:
        entity = self._entity(content)

        self._editing.change(f"delete {entity.GetId()}", lambda: self.world.DeleteModel(entity))

    def _insert(self, _argument: str, content: dict[str, Any]) -> list[str]:
        """Insert a text, or a model of the catalogue, at a pose; the names of what came."""
        label = f"insert {str(content.get('model') or 'a model')[:LONGEST_LABEL]}"
        names: list[str] = self._editing.change(label, lambda: self._insert_now(content))
        return names

    def _insert_now(self, content: dict[str, Any]) -> list[str]:
        before = {entity.GetId() for entity in self.world.entities}
        pose = pose_of(content) if "pose" in content else None
        if self.world.sdf is not None:
            self._insert_sdf(content, pose)
        else:
            name = str(content.get("model", ""))
            text = str(content.get("text") or self._stock.text(name))
            added = self.world.InsertModel(text, name[:LONGEST_LABEL] or "<inserted>")
            top = [model for model in added if model.parentBody is None]
            if pose is not None:
                for model in top:
                    self._put(model, added, pose)
        return [entity.GetId() for entity in self.world.entities if entity.GetId() not in before]

    def _put(self, model: Model, added: list[Model], pose: GzPose) -> None:
        """Place a new model, with its lowest point not below the pose."""
        lift = GzPose(GzVector(0.0, 0.0, model.GetPose().pos.z))
        place = GzCoordPoseAdd(lift, pose)
        self.world.SetModelPose(model, place)
        boxes = [geom.bounds() for one in added for body in one.bodies for geom in body.geoms]
        lows = [low[2] for low, high in boxes if all(map(math.isfinite, (*low, *high))) and tuple(low) != tuple(high)]
        missing = pose.pos.z - min(lows, default=pose.pos.z)
        if missing > 0.0:
            x, y, z = place.pos
            self.world.SetModelPose(model, GzPose(GzVector(x, y, z + missing), place.rot))

    def _insert_sdf(self, content: dict[str, Any], pose: GzPose | None) -> None:
        """Insert models and lights of SDF, or of a robot description, under names that are free."""
        from libgz.sdf.reader import SdfFile  # legacy worlds do without it
        from libgz.sdfworld.world import BUILT, SdfWorld

        world, text, uri = self.world, str(content.get("text") or ""), str(content.get("model", ""))
        if text:
            file = SdfFile.from_string(text, uri[:LONGEST_LABEL] or "<inserted>")
            if content.get("of_page"):
                _check_plugins(file)
        elif uri in SHAPES:
            file = SdfFile.from_string(f"<sdf version='1.6'>{sdf_shape(uri)}</sdf>")
        else:
            file = SdfFile.load(find_model(uri))
        file.diagnostics.raise_errors()
        taken = {entity.GetId() for entity in world.entities}
        for element in next(file.root.named("world"), file.root).children:
            if element.name in BUILT:
                name = element.Get(str, "name")
                free = next(one for one in (name, *(f"{name}_{i}" for i in range(len(taken)))) if one not in taken)
                taken.add(free)
                element.set_attribute("name", free)
                if pose is not None:
                    (next(element.named("pose"), None) or element.AddElement("pose")).Set(pose)
        if file.busy:
            world.attach_era()
        world.extension(SdfWorld).insert(file)
        self._editing.finish()

    def _catalogue(self, argument: str, _content: dict[str, Any]) -> list[Any]:
        """What `insert` knows by name; with the argument `full`, each with its title and where it is from."""
        return [vars(item) for item in self._stock.items()] if argument == "full" else self._stock.names()

    def _portrait(self, _argument: str, content: dict[str, Any]) -> dict[str, str]:
        """The text of a model of the catalogue, of which a viewer makes an image."""
        return {"text": self._stock.text(str(content.get("model", "")))}

    def _mesh(self, _argument: str, content: dict[str, Any]) -> list[str]:
        """Insert a model of a mesh file that comes with the request; the names of what came."""
        from libgz.apps.dropped_mesh import keep_mesh  # only worlds that get a mesh read meshes

        made = keep_mesh(str(content.get("file", "")), content.get("data"))
        text = made.sdf() if self.world.sdf is not None else made.legacy(self._stock.free(made.name))
        wanted = {"model": made.name, "text": text, **{k: v for k, v in content.items() if k == "pose"}}
        try:
            return self._insert("-", wanted)
        except BaseException:
            made.remove()
            raise

    # Knowledge -------------------------------------------------------------------------------------------------------

    def _describe(self, _argument: str, content: dict[str, Any]) -> dict[str, Any]:
        """What the tables and the scene do not say of an entity."""
        entity = self._entity(content)
        plugins = []
        if self.world.sdf is not None:
            element = getattr(entity, "GetSDF", lambda: None)()
            if element is not None:
                plugins = [[e.Get(str, "name"), e.Get(str, "filename")] for e in element.named("plugin")]
        mass = sum(body.GetMass().mass for body in entity.bodies if not body.dummy)
        return {"plugins": plugins, "mass": mass if math.isfinite(mass) else 0.0}

    def _inventory(self, _argument: str, _content: dict[str, Any]) -> dict[str, Any]:
        """What can be driven by topics, and whether somebody listens to keys."""
        if self.world.sdf is None:
            return {"drives": [], "keys": False}
        from libgz.classic.plugins._drive import DrivePlugin
        from libgz.classic.server import attach

        server = attach(self.world)
        drives = [
            model.GetName()
            for model in server.world.Models()
            if any(isinstance(plugin.plugin, DrivePlugin) for plugin in server.plugins.of_model(model))
        ]
        from libgz.classic.transport import TopicManager

        heard = TopicManager.Instance().TopicInfo(self._node().DecodeTopicName(KEYS)).subscriber
        return {"drives": drives, "keys": bool(list(heard))}

    def _contacts(self, _argument: str, _content: dict[str, Any]) -> list[list[float]]:
        """Position, normal and depth of the last step's contacts, which are recorded from the first request on."""
        engine = self.world.engine
        engine.record_contacts = True
        points = engine.contacts[:MOST_CONTACTS]
        found = (
            np.column_stack([points["position"], points["normal"], points["depth"]])
            if len(points)
            else np.zeros((0, 7))
        )
        rows: list[list[float]] = found[np.isfinite(found).all(axis=1)].tolist()
        return rows

    def _readings(self, _argument: str, content: dict[str, Any]) -> dict[str, Any]:
        """Of sensors named ``model::link::sensor``: last images, as JPEG in base64, and last ranges [m]."""
        wanted = content.get("names")
        images: dict[str, str] = {}
        ranges: dict[str, list[float]] = {}
        if self.world.sdf is not None and isinstance(wanted, list):
            from libgz.classic.sensors import SensorManager

            every: list[Any] = list(SensorManager.Instance().GetSensors())
            for sensor in every:
                name = f"{sensor.ParentName()}::{sensor.Name()}"
                if name not in wanted:
                    continue
                sensor.SetActive(True)
                if sensor.Type() == "camera":
                    image = jpeg_text(sensor.ImageData(), sensor.ImageHeight(), sensor.ImageWidth())
                    images |= {name: image} if image else {}
                elif sensor.Type() in ("depth", "depth_camera"):
                    image = depth_text(sensor.DepthData(), sensor.ImageHeight(), sensor.ImageWidth())
                    images |= {name: image} if image else {}
                elif sensor.Type() in ("ray", "gpu_ray"):
                    ranges[name] = [float(r) if math.isfinite(r) else -1.0 for r in sensor.Ranges()]
        return {"images": images, "ranges": ranges}

    def _problems(self, _argument: str, content: dict[str, Any]) -> dict[str, Any]:
        """Errors and warnings after number `since`, with the file and line that they name, and their sim time [s]."""
        since, problems = content.get("since"), self.world.problems
        last = since if isinstance(since, int) and 0 <= since <= problems.count else 0
        found = []
        for number, time, problem in [one for one in problems.recent if one[0] > last][:MOST_PROBLEMS]:
            last = number
            text = f"{problem.message}\n{problem.traceback}" if problem.traceback else problem.message
            place = _PLACE.match(f"{problem.where}: " if problem.where else text)
            file, line = (place["file"], int(place["line"])) if place is not None else ("", 0)
            if place is not None and not problem.where:
                text = text[place.end() :]
            what = {"text": text[:LONGEST_PROBLEM], "file": file, "line": line, "source": problem.source, "time": time}
            found.append({"number": number, "level": problem.severity, **what})
        return {"problems": found, "count": last if found else problems.count}

    def _values(self, _argument: str, content: dict[str, Any]) -> dict[str, Any]:
        """Numbers of topics and plugins by their keys, and their sim time [s]."""
        names = content.get("names")
        values = self._probes.values(names if isinstance(names, list) else [])
        return {"time": self.world.GetSimTime(), "values": values}

    def _publish(self, argument: str, content: dict[str, Any]) -> None:
        """Publish a message on a topic, as a client of classic would."""
        if self.world.sdf is None:
            raise GazeboError("this world has no topics")
        from libgz.classic import msgs

        message = msgs.message_type(str(content.get("type", "")))()
        values = content.get("message")
        message.FromDict(values if isinstance(values, dict) else {})
        topic = self._node().DecodeTopicName(argument)
        if topic not in self._nodes:
            self._nodes[topic] = self._node().Advertise(type(message), topic)
        self._nodes[topic].Publish(message)

    def _reload(self, _argument: str, content: dict[str, Any]) -> dict[str, str]:
        """Load the edited file of a plugin again: success, nonexistent or error, and what was replaced, or why not."""
        try:
            return {"result": "success", "text": "\n".join(self.world.reload_plugin(str(content.get("name", ""))))}
        except NotFoundError as error:
            return {"result": "nonexistent", "text": str(error)}
        except GazeboError as error:
            return {"result": "error", "text": str(error)}

    # Classic ---------------------------------------------------------------------------------------------------------

    def _classic(self) -> Any:
        from libgz.classic.server import attach

        return attach(self.world).world

    def _node(self) -> Any:
        if "" not in self._nodes:
            from libgz.classic.transport import Node

            self._nodes[""] = Node()
            self._nodes[""].Init(self._classic().Name())
        return self._nodes[""]


_PLACE = re.compile(r"(?P<file>[^\s:][^:\n]{0,4000}):(?P<line>\d{1,9}): ")


def _check_plugins(file: SdfFile) -> None:
    """Check that all plugins of what a page wrote are those of models that it may insert.

    Raises:
        ParameterError: one is of another file.
    """
    folders = [folder.resolve() for folder in model_directories()]
    for element in file.root.find("plugin"):
        path = Path(element.file).resolve()
        if not any(path.is_relative_to(folder) for folder in folders):
            raise ParameterError(
                f"{element.where}: a page inserts no plugins but those of models of the model directories"
            )


def steps_of(argument: str) -> int:
    """How many steps a request asks for.

    Raises:
        ParameterError: it is no number of them, or more than one request may ask for.
    """
    count = whole_number(argument, MOST_STEPS)
    if not count:
        raise ParameterError(f"step is {argument[:80]!r}; allowed are 1 to {MOST_STEPS}")
    return count


def _number(text: str, what: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ParameterError(f"{what} is {text!r}; it must be a finite number")
    return number
