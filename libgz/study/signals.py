"""Signals: numbers of a world that a program reads or writes by name, in both eras.

A signal is a key and a field::

    laser.laser1          ranges            an interface of a legacy world, and a field or property of it
    position.robot1       pos[0]            one number of an array; pos[0:2] is several
    robot1                pos               a model, or one of its bodies: robot1::topPlate
    pendulum::shoulder    velocity          a joint
    pendulum::link::imu   angular_velocity  a sensor of an SDF world

Text that names one has both, as ``position.robot1/pos[0]``.
"""

from __future__ import annotations

import ctypes
import math
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.geometry import GzQuaternToEuler
from libgz.classic.sensors.sensor import Sensor
from libgz.front import World
from libgz.interfaces.catalog import INTERFACES
from libgz.models.pantilt import PanTiltCamera
from libgz.models.positionserver import LARGEST_COMMAND
from libgz.models.robot import MobileRobot
from libgz.physics.body import Body
from libgz.physics.joint import HingeJoint, Joint, SliderJoint
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint
from libgz.sdfworld.axis import UNLIMITED
from libgz.sdfworld.joint import SdfJoint
from libgz.simulation.entity import Entity
from libgz.transport.interface import Interface
from libgz.transport.layout import SERVER, Struct, fields_of

__all__ = ["Command", "Reading", "activate", "commands_of", "reading_of", "split_signal"]

Bounds: TypeAlias = tuple[Any, Any]
Get: TypeAlias = Callable[[], Any]

FREE: Bounds = (-math.inf, math.inf)
FLAG: Bounds = (0, 1)
UNIT: Bounds = (-1.0, 1.0)
_FIELD = re.compile(r"(\w+)((?:\[[^\[\]]*\]|\.\w+)*)")
_PART = re.compile(r"\[(-?\d{0,9})(:?)(-?\d{0,9})\]|\.(\w+)")
SLACK, LEAST_SLACK = 0.05, 0.01  # by which a joint may be beyond a limit: share of its range, [rad or m]
POSITION_MODE, SPEED_MODE = 0, 1  # of an actuator
INTERFACE_FLAGS = {  # fields that are 0 or 1
    "position": ("stall", "cmd_enable_motors"),
    "gripper": (
        *("lift_limit_reach", "grip_limit_reach", "outer_beam_obstruct", "inner_beam_obstruct"),
        *("left_paddle_open", "right_paddle_open", "paddles_opened", "paddles_closed", "paddles_moving"),
        *("paddles_error", "lift_up", "lift_down", "lift_moving", "lift_error"),
    ),
    "laser": ("intensity", "intensities", "all_intensities"),
    "sonar": ("cmd_enable_sonar",),
    "ir": ("cmd_enable_ir",),
    "sim": ("pause",),
}
INTERFACE_BOUNDS: dict[tuple[str, str], Bounds] = {
    ("truth", "rot"): UNIT,
    ("gps", "latitude"): (-90.0, 90.0),
    ("gps", "longitude"): (-180.0, 180.0),
    ("gripper", "cmd"): (1, 8),
    ("ptz", "pan"): (-math.pi, math.pi),
    ("ptz", "tilt"): (-math.pi, math.pi),
}
RANGES = ("ranges", "all_ranges", "sonar_ranges", "ir_ranges")
BODY_FIELDS = ("pos", "rot", "quat", "linear_vel", "angular_vel")
JOINT_FIELDS = ("position", "velocity", "effort")


@dataclass(frozen=True)
class Reading:
    """Numbers that are read.

    Attributes:
        label: key and field.
        fetch: returns the present numbers.
        low, high: bounds of each number, shape (...), of `dtype`.
        dtype: of the numbers.
        clipped: whether numbers beyond the bounds are read as the bounds.
    """

    label: str
    fetch: Get = field(repr=False)
    low: NDArray[Any]
    high: NDArray[Any]
    dtype: np.dtype[Any]
    clipped: bool = False

    @property
    def shape(self) -> tuple[int, ...]:
        """The numbers' shape; one number has (1,)."""
        return self.low.shape

    def value(self) -> NDArray[Any]:
        """The present numbers: a copy of shape `shape`."""
        numbers = np.array(self.fetch(), self.dtype, ndmin=1)
        return np.clip(numbers, self.low, self.high) if self.clipped else numbers

    def within(self, bounds: tuple[float, float]) -> Reading:
        """The same numbers, clipped to bounds.

        Raises:
            ParameterError: the lower bound is not below the upper one.
        """
        low, high = bounds
        if not low < high:
            raise ParameterError(f"{self.label!r}: the lower bound, {low:g}, must be below the upper one, {high:g}")
        ends = [np.clip(np.full(self.shape, end), self.low, self.high).astype(self.dtype) for end in bounds]
        return replace(self, low=ends[0], high=ends[1], clipped=True)


class Command(NamedTuple):
    """A number that is written.

    Attributes:
        label: key and field.
        write: sets the number.
        low, high: bounds.
        whole: whether it is an integer.
        lasts: whether it holds until the next one; else it is for one step.
        joint: on which it is an effort, if that can be held for several steps; see `write_held` of the joint.
    """

    label: str
    write: Callable[[Any], object]
    low: float
    high: float
    whole: bool = False
    lasts: bool = True
    joint: SdfJoint | HingeJoint | SliderJoint | None = None


def split_signal(text: str) -> tuple[str, str]:
    """Key and field of a signal.

    Raises:
        ParameterError: the text does not have both.
    """
    key, slash, name = text.rpartition("/")
    if not slash or not key or not name:
        raise ParameterError(f"{text!r} is no signal; write KEY/FIELD, such as position.robot1/pos[0]")
    return key.strip(), name.strip()


def activate(world: World, key: str, field: str) -> None:
    """Have the sensor measure that a signal comes from, if it is one of a sensor; `reading_of` does so, too."""
    name = field.partition("[")[0]
    for sensor in _sensors(world, key):
        if name in _sensor_methods(sensor):
            sensor.SetActive(True)


def reading_of(world: World, key: str, field: str) -> Reading:
    """What reads a signal.

    It belongs to the present objects of the world: make a new one after a reset.

    Raises:
        InterfaceError, NotFoundError: the world has nothing of this key.
        ParameterError: it has no such field, or the field is no number, or has no value yet.
    """
    label, match = f"{key}/{field}", _FIELD.fullmatch(field)
    if match is None:
        raise ParameterError(f"{label!r}: {field!r} is no field; write pos, pos[0], pos[0:2] or fids[0].pos[1]")
    name, parts = match[1], _parts(match[2], label)
    base, bounds = _source(world, key, name, label)
    get = _inside(base, parts)
    try:
        sample = np.array(get(), ndmin=1)
    except (IndexError, KeyError, TypeError, ValueError) as error:
        raise ParameterError(f"{label!r} cannot be read: {error}") from None
    if sample.dtype.kind not in "fiub":
        inside = f"; name one of {', '.join(sample.dtype.names)}" if sample.dtype.names else ""
        raise ParameterError(f"{label!r} is not of numbers{inside}")
    if not sample.size:
        raise ParameterError(f"{label!r} has no values yet: its model has not measured")
    dtype = np.dtype(np.int8) if sample.dtype.kind == "b" else sample.dtype
    low, high = (_bound(base, one, parts, sample, dtype) for one in (bounds or _natural(dtype)))
    return Reading(label, get, low, high, dtype)


def _natural(dtype: np.dtype[Any]) -> Bounds:
    """The bounds that a type has."""
    if dtype.kind == "f":
        return FREE
    limits = np.iinfo(dtype)
    return int(limits.min), int(limits.max)


def _bound(base: Get, bound: Any, parts: Sequence[Any], sample: NDArray[Any], dtype: np.dtype[Any]) -> NDArray[Any]:
    """A bound for each number; bounds of whole arrays are taken apart as these are."""
    if np.ndim(bound):
        bound = _inside(lambda: np.asarray(bound), parts)()
    return np.full(sample.shape, np.array(bound, dtype), dtype)


def _parts(text: str, label: str) -> list[Any]:
    """What follows a field's name: indices, slices, names."""
    found: list[Any] = []
    for part in _PART.finditer(text):
        first, colon, second, name = part.groups()
        if name:
            found.append(name)
        elif colon:
            found.append(slice(*(int(number) if number else None for number in (first, second))))
        elif first:
            found.append(int(first))
    if "".join(match[0] for match in _PART.finditer(text)) != text or len(found) != len(_PART.findall(text)):
        raise ParameterError(f"{label!r}: {text!r} is no index; write [0] or [0:2]")
    return found


def _inside(base: Get, parts: Sequence[Any]) -> Get:
    if not parts:
        return base
    if len(parts) == 1 and not isinstance(parts[0], str):
        only = parts[0]
        return lambda: base()[only]

    def get() -> Any:
        value = base()
        for part in parts:
            value = value[part]
        return value

    return get


# Where values come from -----------------------------------------------------------------------------------------------


def _source(world: World, key: str, name: str, label: str) -> tuple[Get, Bounds | None]:
    """What returns the whole value of a field, and its bounds if they are not those of its type."""
    kind, dot, served = key.partition(".")
    if dot and kind in INTERFACES:
        return _interface_source(world, world.interface(kind, served), name, label)
    found = list(_objects(world, key))
    for thing in found:
        source = _object_source(thing, name)
        if source is not None:
            return source
    fields = dict.fromkeys(known for thing in found for known in _fields_of(thing))
    raise ParameterError(f"{label!r}: there is no {name!r}; there are {', '.join(fields)}{nearest(name, fields)}")


def _interface_source(world: World, interface: Interface[Any], name: str, label: str) -> tuple[Get, Bounds | None]:
    declared = fields_of(interface.layout)
    public = [
        known for known, value in vars(type(interface)).items() if not known.startswith("_") and not callable(value)
    ]
    if isinstance(getattr(type(interface), name, None), property) or name in public:
        get: Get = lambda: getattr(interface, name)  # noqa: E731
    elif name not in declared:
        known = [*declared, *(one for one in public if one not in ("type", "data_class", "older", "has_post"))]
        raise ParameterError(f"{label!r}: there is no {name!r}; there are {', '.join(known)}{nearest(name, known)}")
    elif declared[name].shape:
        get = lambda: interface.array(name)  # noqa: E731
    else:
        dtype = np.dtype(declared[name].ctype)
        get = lambda: np.array(getattr(interface.data, name), dtype)  # noqa: E731
    return get, _interface_bounds(world, interface, name)


def _interface_bounds(world: World, interface: Interface[Any], name: str) -> Bounds | None:
    kind = interface.type
    if name in INTERFACE_FLAGS.get(kind, ()):
        return FLAG
    if name in RANGES:
        offset = 0.0
        if kind == "laser" and "laserNoHitOffset" in world.engine.quirks:
            offset = float(getattr(world.model(interface.id), "rangeMin", 0.0))
        return 0.0, float(interface.data.max_range) + offset
    owner = next((model for model in world.models if model.GetId() == interface.id), None)
    if (kind, name) == ("position", "rot") and getattr(owner, "normaliseYaw", False):
        return np.full(3, -math.pi), np.full(3, math.pi)
    if (kind, name) == ("ptz", "zoom") and isinstance(owner, PanTiltCamera):
        return _views(owner)
    return INTERFACE_BOUNDS.get((kind, name))


def _views(camera: PanTiltCamera) -> Bounds:
    """The fields of view that its zoom reaches [rad]."""
    low, high = camera.zoomLimits
    return camera.values.hfov / high, camera.values.hfov / low


def _objects(world: World, key: str) -> Iterable[Any]:
    """What a key names: a model, its joint, its body, or a sensor.

    Raises:
        NotFoundError: there is nothing of this name.
    """
    found: list[Any] = [entity for entity in world.entities if entity.GetId() == key]
    holder, _, name = key.rpartition("::")
    for entity in world.entities:
        if not holder or entity.GetId() == holder:
            joints = getattr(entity, "sdf_joints", None)
            named = joints if joints is not None else {joint.name: joint for joint in entity.joints if joint.name}
            if name in named:
                found.append(named[name])
        if holder and entity.GetId() == holder:
            found += [body for body in entity.bodies if body.bodyName == name]
    found += _sensors(world, key)
    if not found:
        known = list(_known(world))
        raise NotFoundError(
            f"the world has no interface, model, joint, body or sensor {key!r}; "
            f"there are {', '.join(known)}{nearest(key, known)}"
        )
    return found


def _known(world: World) -> Iterable[str]:
    yield from (".".join(key) for key in world.gz_server.interfaces)
    for entity in world.entities:
        own = entity.GetId()
        yield from [own] if own else []
        joints = getattr(entity, "sdf_joints", None)
        names = list(joints) if joints is not None else [joint.name for joint in entity.joints if joint.name]
        yield from (
            f"{own}::{name}" if own else name for name in [*names, *(body.bodyName or "" for body in entity.bodies)]
        )
    if world.sdf is not None and world.facade is not None and world.facade.server.sensors is not None:
        yield from (name.partition("::")[2] for name in world.facade.server.sensors.sensors)


def _sensors(world: World, key: str) -> list[Sensor]:
    manager = world.facade.server.sensors if world.facade is not None else None
    return list(manager.find(key)) if manager is not None else []


def _fields_of(thing: Any) -> Sequence[str]:
    if isinstance(thing, Sensor):
        return list(_sensor_methods(thing))
    return JOINT_FIELDS if isinstance(thing, SdfJoint | Joint) else BODY_FIELDS


def _object_source(thing: Any, name: str) -> tuple[Get, Bounds | None] | None:
    if isinstance(thing, Sensor):
        return _sensor_source(thing, name)
    if isinstance(thing, SdfJoint):
        return _sdf_joint_source(thing, name)
    if isinstance(thing, Joint):
        return _joint_source(thing, name)
    return _body_source(thing, name)


def _body_source(thing: Entity | Body, name: str) -> tuple[Get, Bounds | None] | None:
    body = thing if isinstance(thing, Body) else None

    def moving() -> Body:
        return body if body is not None else thing.GetBody()  # type: ignore[union-attr]

    if name == "pos":
        return (body.GetPosition if body is not None else lambda: thing.GetPose().pos), FREE
    if name == "rot":
        return lambda: tuple(GzQuaternToEuler(thing.GetPose().rot)), (-math.pi, math.pi)
    if name == "quat":
        return lambda: thing.GetPose().rot, UNIT
    if name == "linear_vel":
        return lambda: moving().GetLinearVel(), FREE
    if name == "angular_vel":
        return lambda: moving().GetAngularRate(), FREE
    return None


def _sdf_joint_source(joint: SdfJoint, name: str) -> tuple[Get, Bounds | None] | None:
    axes = range(joint.dof)
    if name == "position" and joint.dof:
        low, high = zip(*(_widened(*_limits(joint, index)) for index in axes), strict=True)
        return lambda: [joint.position(index) for index in axes], (np.array(low), np.array(high))
    if name == "velocity" and joint.dof:
        return lambda: [joint.velocity(index) for index in axes], FREE
    if name == "effort" and joint.dof:
        return lambda: [joint.force(index) for index in axes], FREE
    return None


def _limits(joint: SdfJoint, index: int) -> tuple[float, float]:
    axis = joint.axes[min(index, len(joint.axes) - 1)]
    return tuple(
        limit if abs(limit) < UNLIMITED else math.copysign(math.inf, limit) for limit in (axis.lower, axis.upper)
    )  # type: ignore[return-value]


def _widened(low: float, high: float) -> tuple[float, float]:
    """Limits of a joint as bounds: stops yield a little."""
    slack = SLACK * (high - low) + LEAST_SLACK if math.isfinite(high - low) else LEAST_SLACK
    return low - slack, high + slack


def _joint_source(joint: Joint, name: str) -> tuple[Get, Bounds | None] | None:
    kinds: tuple[tuple[type[Joint], tuple[str, ...], tuple[str, ...]], ...] = (
        (HingeJoint, ("GetAngle",), ("GetAngleRate",)),
        (SliderJoint, ("GetPosition",), ("GetPositionRate",)),
        (Hinge2Joint, ("GetAngle1", "GetAngle2"), ("GetAngle1Rate", "GetAngle2Rate")),
        (UniversalJoint, ("GetAngle1", "GetAngle2"), ("GetAngleRate1", "GetAngleRate2")),
    )
    for kind, positions, velocities in kinds:
        if isinstance(joint, kind) and name in ("position", "velocity"):
            return _all_of([getattr(joint, one) for one in (positions if name == "position" else velocities)]), FREE
    return None


def _all_of(getters: Sequence[Get]) -> Get:
    return lambda: [get() for get in getters]


def _sensor_methods(sensor: Sensor) -> dict[str, str]:
    """Names of fields -> methods of the sensor's own class that return a measurement."""
    found = {}
    for kind in type(sensor).__mro__:
        if kind is Sensor or not issubclass(kind, Sensor):
            continue
        for method, value in vars(kind).items():
            if (
                method[:1].isupper()
                and callable(value)
                and not method.startswith(("Get", "Set", "Connect", "Init", "Fini"))
            ):
                found[re.sub(r"(?<=[a-z])(?=[A-Z])", "_", method).lower()] = method
    special = [name for name, has in (("image", "Camera"), ("depth", "DepthData")) if hasattr(sensor, has)]
    return {**found, **dict.fromkeys(special, "")}


def _sensor_source(sensor: Sensor, name: str) -> tuple[Get, Bounds | None] | None:
    methods = _sensor_methods(sensor)
    if name not in methods:
        return None
    sensor.SetActive(True)
    any_sensor: Any = sensor
    if name == "image":
        return lambda: any_sensor.Camera().pixels, (0, 255)
    if name == "depth":
        return lambda: np.asarray(any_sensor.DepthData()), (0.0, math.inf)
    if name == "contacts":
        return lambda: len(any_sensor.Contacts().contact), (0, np.iinfo(np.int64).max)
    measure = getattr(any_sensor, methods[name])
    if name in ("ranges", "range") and hasattr(any_sensor, "RangeMax"):
        near, far = any_sensor.RangeMin(), any_sensor.RangeMax()
        if name == "range":
            return lambda: min(max(measure(), near), far), (near, far)
        count = any_sensor.RangeCount() * any_sensor.VerticalRangeCount()

        def ranges() -> Any:
            values = np.asarray(measure())
            return np.clip(values, near, far) if values.size else np.full(count, far)

        return ranges, (near, far)
    if name == "orientation":
        return lambda: tuple(measure()), UNIT

    def number() -> Any:
        value = measure()
        return tuple(value) if hasattr(value, "__iter__") else float(value)

    return number, FREE


# Commands -------------------------------------------------------------------------------------------------------------


def commands_of(world: World, key: str, field: str, bounds: tuple[float, float] | None = None) -> list[Command]:
    """What writes a signal: a command for each of its numbers.

    Clients' fields of interfaces hold until the next command. Of joints, `effort` [N m or N] is for one step, and
    `velocity` [rad/s or m/s] the target of a motor. Of bodies, `force` [N] and `torque` [N m] are global, for one step.

    Args:
        world: the world.
        key: an interface, joint or body.
        field: one of its commands.
        bounds: of each number; None for those of the world, if it has any.

    Raises:
        InterfaceError, NotFoundError: the world has nothing of this key.
        ParameterError: it has no such command, or a bound is missing or wrong.
    """
    label, match = f"{key}/{field}", _FIELD.fullmatch(field)
    if match is None:
        raise ParameterError(f"{label!r}: {field!r} is no command; write cmd_vel_pos[0] or effort")
    kind, dot, served = key.partition(".")
    if dot and kind in INTERFACES:
        found = _interface_commands(world, world.interface(kind, served), match[1], _parts(match[2], label), label)
    else:
        found = _object_commands(world, key, match[1], _parts(match[2], label), label)
    return [_bounded(command, bounds) for command in found]


def _bounded(command: Command, bounds: tuple[float, float] | None) -> Command:
    low, high = (command.low, command.high) if bounds is None else map(float, bounds)
    if not (math.isfinite(low) and math.isfinite(high)):
        raise ParameterError(f"{command.label!r} has no bounds of its own; give them: {{'FIELD': (low, high)}}")
    if not low < high:
        raise ParameterError(f"{command.label!r}: the lower bound, {low:g}, must be below the upper one, {high:g}")
    if bounds is not None and (low < command.low or high > command.high):
        raise ParameterError(
            f"{command.label!r}: bounds {low:g} to {high:g} are beyond {command.low:g} to {command.high:g}, "
            "which is what the world obeys"
        )
    return command._replace(low=low, high=high)


def _interface_commands(
    world: World, interface: Interface[Any], name: str, parts: list[Any], label: str
) -> list[Command]:
    declared = fields_of(interface.layout)
    writable = [known for known, about in declared.items() if about.writer != SERVER or issubclass(about.ctype, Struct)]
    if name not in writable:
        known = f"they write {', '.join(writable) or 'nothing'}{nearest(name, writable)}"
        raise ParameterError(f"{label!r}: clients cannot write {name!r}; {known}")
    places = _places(interface.data, declared[name], name, parts, label)
    owner = next((model for model in world.models if model.GetId() == interface.id), None)
    found = []
    for holder, part, whole, path in places:
        bounds = _command_bounds(interface.type, name, part, owner, label)
        write = _actuator_writer(interface, name, part) if interface.type == "actarray" else _writer(holder, part)
        found.append(Command(path, write, *bounds, whole=whole))
    return found


def _places(data: Any, about: Any, name: str, parts: list[Any], label: str) -> list[tuple[Any, Any, bool, str]]:
    """(object, index or name in it, whether it is an integer, label) of each number that a field means."""
    key = label.rpartition("/")[0]
    found: list[tuple[Any, Any, Any, str]] = [(data, name, about, f"{key}/{name}")]
    for part in [*parts, None]:
        opened: list[tuple[Any, Any, Any, str]] = []
        for holder, place, here, path in found:
            value = getattr(holder, place) if isinstance(place, str) else holder[place]
            if isinstance(part, str):
                inside = fields_of(type(value)) if isinstance(value, Struct) else {}
                if part not in inside or inside[part].writer == SERVER:
                    raise ParameterError(f"{label!r}: there is no command {part!r}{nearest(part, inside)}")
                opened.append((value, part, inside[part], f"{path}.{part}"))
            elif isinstance(value, ctypes.Array):
                indices = range(len(value))
                try:
                    chosen = indices if part is None else indices[part] if isinstance(part, slice) else [indices[part]]
                except IndexError:
                    raise ParameterError(f"{label!r}: there are {len(value)} numbers, counted from 0") from None
                opened += [(value, index, here, f"{path}[{index}]") for index in chosen]
            elif part is None:
                opened.append((holder, place, here, path))
            else:
                raise ParameterError(f"{label!r}: {path} is one number")
        found = opened
    for holder, place, _, path in found:
        value = getattr(holder, place) if isinstance(place, str) else holder[place]
        if not isinstance(value, int | float):
            raise ParameterError(f"{label!r}: {path} is no number, but a {type(value).__name__}")
    return [
        (holder, place, here.ctype not in (ctypes.c_double, ctypes.c_float), path)
        for holder, place, here, path in found
    ]


def _writer(holder: Any, place: Any) -> Callable[[Any], object]:
    if isinstance(place, str):
        return lambda value: setattr(holder, place, value)

    def write(value: Any) -> None:
        holder[place] = value

    return write


def _actuator_writer(interface: Interface[Any], name: str, place: Any) -> Callable[[Any], object]:
    """Commands of actuators also have a mode, and a number that is new each time."""
    mode = {"cmd_pos": POSITION_MODE, "cmd_speed": SPEED_MODE}.get(name)
    inner = _writer(getattr(interface.data, name), place)

    def write(value: Any) -> None:
        data: Any = interface.data
        inner(value)
        if mode is not None:
            data.joint_mode[place] = mode
        data.new_cmd = (data.new_cmd + 1) & 0xFFFFFFFF

    return write


def _command_bounds(kind: str, name: str, place: Any, owner: Entity | None, label: str) -> tuple[float, float]:
    if name in INTERFACE_FLAGS.get(kind, ()):
        return 0.0, 1.0
    if kind == "position" and name in ("cmd_vel_pos", "cmd_vel_rot"):
        return _drive_bounds(name, place, owner, label)
    if kind == "ptz" and isinstance(owner, PanTiltCamera):
        return {"cmd_pan": owner.panLimits, "cmd_tilt": owner.tiltLimits}.get(name) or _views(owner)
    low, high = INTERFACE_BOUNDS.get((kind, name), FREE)
    return float(low), float(high)


def _drive_bounds(name: str, place: Any, owner: Entity | None, label: str) -> tuple[float, float]:
    if not isinstance(owner, MobileRobot):
        return -LARGEST_COMMAND, LARGEST_COMMAND
    if (name, place) not in owner.commands:
        obeyed = ", ".join(f"{one}[{index}]" for one, index in owner.commands)
        raise ParameterError(f"{label!r}: {owner.GetName()} does not obey {name}[{place}]; it obeys {obeyed}")
    limit = owner.limits[owner.commands.index((name, place))] if owner.limits else LARGEST_COMMAND
    return -limit, limit


def _object_commands(world: World, key: str, name: str, parts: list[Any], label: str) -> list[Command]:
    for thing in _objects(world, key):
        found = _commands_on(thing, name, f"{key}/{name}")
        if found:
            if not parts:
                return found
            if len(parts) == 1 and not isinstance(parts[0], str):
                chosen = (
                    found[parts[0]]
                    if -len(found) <= (parts[0] if isinstance(parts[0], int) else 0) < len(found)
                    else []
                )
                return chosen if isinstance(chosen, list) else [chosen]
            raise ParameterError(f"{label!r}: write {name} or {name}[0]")
    raise ParameterError(
        f"{label!r}: there is no command {name!r}; joints take effort and velocity, bodies force and torque"
    )


def _commands_on(thing: Any, name: str, label: str) -> list[Command]:
    if isinstance(thing, SdfJoint) and name in ("effort", "velocity"):
        return [_sdf_joint_command(thing, name, index, f"{label}[{index}]") for index in range(thing.dof)]
    if isinstance(thing, HingeJoint) and name == "effort":
        return [Command(label, thing.SetTorque, *FREE, lasts=False, joint=thing)]
    if isinstance(thing, SliderJoint) and name == "effort":
        return [Command(label, thing.SetSliderForce, *FREE, lasts=False, joint=thing)]
    if isinstance(thing, Entity | Body) and name in ("force", "torque"):
        body = thing if isinstance(thing, Body) else thing.GetBody()
        add = body.AddForce if name == "force" else body.AddTorque
        return [Command(f"{label}[{i}]", _along(add, i), *FREE, lasts=False) for i in range(3)]
    return []


def _along(add: Callable[[float, float, float], object], axis: int) -> Callable[[Any], object]:
    def write(value: Any) -> None:
        if value:
            add(*(value if i == axis else 0.0 for i in range(3)))

    return write


def _sdf_joint_command(joint: SdfJoint, name: str, index: int, label: str) -> Command:
    axis = joint.axes[min(index, len(joint.axes) - 1)]
    if name == "effort":
        limit = axis.effort if axis.effort >= 0.0 else math.inf
        held = joint if joint.dof == 1 else None
        return Command(label, lambda value: joint.add_force(value, index), -limit, limit, lasts=False, joint=held)
    limit = axis.velocity if axis.velocity >= 0.0 else math.inf
    strength = axis.effort if 0.0 <= axis.effort < UNLIMITED else 1e6  # [N m or N]

    def run(value: Any) -> None:
        joint.set_param("fmax", strength, index)
        joint.set_param("vel", value, index)

    return Command(label, run, -limit, limit)
