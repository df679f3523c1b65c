"""RosPlugin: what the plugins of ROS have in common: declared parameters and topics, names, rates, messages."""

from __future__ import annotations

import logging
import math
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from libgz.base.errors import ParameterError
from libgz.base.law import Number, constant, ends, floor, law, rarely, unrecorded
from libgz.classic.event import Events
from libgz.classic.math import Pose3d, Quaterniond, Rand, Vector3d
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.node_parameters import NodeParameters
from libgz.ros.own_node import OwnNode, remappings
from libgz.ros.reconfigure import Knob, Reconfigure
from libgz.ros.session import Publication, Service, Session, Subscription, session

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from libgz.classic.physics import World
    from libgz.sdf.element import Element
    from libgz.simulation.event import Connection

__all__ = [
    "NOISE",
    "OFFSETS",
    "SAME",
    "TICK_SLACK",
    "Endpoint",
    "Parameter",
    "Periodic",
    "Publishing",
    "Rate",
    "RosPlugin",
    "Ticks",
    "bounded_rate",
    "noise",
    "noisy",
    "set_point",
    "set_pose",
    "set_quaternion",
    "set_twist",
]

log = logging.getLogger("libgz.ros")

SAME = object()  # as in ROS 1
MOST_RATE = 1e9  # [Hz]; what is faster, or as fast, ticks at each call
TICK_SLACK = 1e-6  # periods; sim times are sums of steps
TRUE, FALSE = ("true", "1", "yes"), ("false", "0", "no")


class Rate(float):
    """A rate among parameters [Hz]; 0: no limit, or as the parameter says."""


class Parameter(NamedTuple):
    """An element that a plugin reads: its default has the type of its value, or is the type, if it must be given.

    Attributes:
        ros2: the default in ROS 2, where it is another one.
    """

    name: str
    default: Any
    meaning: str
    ros2: Any = SAME

    def default_of(self, version: int) -> Any:
        """The default in ROS 1 or 2."""
        return self.default if version == 1 or self.ros2 is SAME else self.ros2


class Endpoint(NamedTuple):
    """A topic or service of a plugin; in its name, ``<x>`` stands for the value of parameter x."""

    verb: str  # publishes, subscribes, serves
    name: str
    kind: str


NOISE = Parameter("gaussianNoise", 0.0, "standard deviation of the noise")
OFFSETS = (
    Parameter("xyzOffset", Vector3d(), "added to the position [m]"),
    Parameter("rpyOffset", Vector3d(), "rotation before that of the link [rad]"),
)


class Ticks:
    """Ticks at a rate of sim time [Hz], without drift; 0 or less, or faster than any step: at each call."""

    STATE = ("count",)

    count = Number()

    def __init__(self, rate: float) -> None:
        self.rate = rate

    @property
    @constant
    def endless(self) -> bool:
        """Whether it ticks at each call."""
        return not 0.0 < self.rate < MOST_RATE

    @law
    def is_due(self, now: Any) -> Any:
        """Whether a period has begun since the last tick, at sim time `now` [s]; `due` will say so."""
        return self.endless or floor(now * self.rate + TICK_SLACK) != self.count

    @law
    def tick(self, now: Any) -> None:
        """It has ticked at sim time `now` [s]."""
        if not self.endless:
            self.count = floor(now * self.rate + TICK_SLACK)

    def due(self, now: float) -> bool:
        """Whether a period has begun since the last tick, at sim time `now` [s]; if so, it ticks."""
        due = bool(self.is_due(now))
        if due:
            self.tick(now)
        return due


class RosPlugin:
    """Mixin of plugins: reads the declared parameters, and opens topics and services in the robot's namespace.

    Elements have their names in ROS, or those of ROS 2 (`<update_rate>` for `<updateRate>`, `<ros>` with a namespace
    and remappings).

    Attributes:
        parameters, endpoints: declared; the tables in the documents are made from them.
        own_namespace: whether the model's name is the namespace where no `<robotNamespace>` is given.
        given: the values of the parameters, by name.
        ros: the session.
        space: the namespace.
        two: whether it is ROS 2.
        own_node, node_parameters: in ROS 2, the plugin's node and its parameters.
    """

    parameters: ClassVar[tuple[Parameter, ...]] = ()
    endpoints: ClassVar[tuple[Endpoint, ...]] = ()
    own_namespace: ClassVar[bool] = False

    ros: Session
    given: Any
    space: str
    two: bool
    own_node: OwnNode | None = None
    node_parameters: NodeParameters
    _prefix: str | None

    def open(self, sdf: Element, model: str) -> None:
        """Read the parameters.

        Args:
            sdf: the plugin's element.
            model: the name of its model.

        Raises:
            ParameterError: one is missing or invalid.
            StateError: there is no ROS in this process.
        """
        self.ros = session()
        self.two = self.ros.version == 2
        self._remapped = {old.removeprefix("~/"): new.removeprefix("~/") for old, new in remappings(sdf)}
        plugin, sdf = sdf, ros_elements(sdf)
        self.given = SimpleNamespace(**{one.name: _value(sdf, one, self.ros.version) for one in self.parameters})
        if self.two:
            space = sdf.Get(str, "robotNamespace", "")[0].strip()
            self.own_node = OwnNode.of_plugin(self.ros.names, plugin, space)
            self.node_parameters = NodeParameters(self.ros, self.own_node)
            self.space, self._prefix = self.own_node.settings.space, None
            return
        space = sdf.Get(str, "robotNamespace", "")[0].strip()
        if not sdf.HasElement("robotNamespace"):
            space = f"/{model}" if self.own_namespace else ""
        elif not space and self.own_namespace:
            space = f"/{model}"
        self.space = space.rstrip("/") or ("/" if space else "")
        self._prefix = None

    def publish(
        self,
        topic: str,
        kind: str,
        queue: int = 1,
        latch: bool = False,
        within: str = "",
        changed: Callable[[], object] | None = None,
    ) -> Publication:
        """Publish a topic; `within` is a namespace inside that of the robot."""
        name, space, node = self._place(topic, within)
        return self.ros.publish(name, kind, queue, latch, space, changed, node)

    def subscribe(
        self,
        topic: str,
        kind: str,
        callback: Callable[[Any], object],
        queue: int = 1,
        within: str = "",
        **qos: Any,
    ) -> Subscription:
        """Subscribe to a topic; `qos` are policies of ROS 2."""
        name, space, node = self._place(topic, within)
        return self.ros.subscribe(name, kind, callback, queue, space, node, **qos)

    def serve(self, name: str, kind: str, handler: Callable[[Any], Any], within: str = "") -> Service:
        """Serve a service."""
        name, space, node = self._place(name, within)
        return self.ros.serve(name, kind, handler, space, node)

    def offer(
        self, knobs: Sequence[Knob], changed: Callable[[Mapping[str, Any]], object], within: str = ""
    ) -> Reconfigure:
        """Offer values to the tools of dynamic_reconfigure, which ROS 2 does not have."""
        return Reconfigure(self.ros, self._place("", within)[1], knobs, changed)

    def frame(self, name: str) -> str:
        """A frame of TF with the robot's prefix."""
        if self._prefix is None:
            self._prefix = self.ros.frame("x", self.space).removesuffix("x")
        return name.lstrip("/") if name.startswith("/") else f"{self._prefix}{name}"

    def _place(self, name: str, within: str) -> tuple[str, str, OwnNode | None]:
        """(name of a topic or service, namespace, node)."""
        if self.own_node is not None:
            return name, within, self.own_node
        plain = name.removeprefix("~/")
        return self._remapped.get(plain, plain), f"{self.space}/{within}" if within else self.space, None


def bounded_rate(rate: float, what: str) -> float:
    """A rate that can be kept [Hz]: from 0 to 1e9, which is faster than any step; another one is replaced and reported.

    Args:
        rate: a number, even one that no float can hold [Hz].
        what: names the parameter, and where it is.
    """
    try:
        value = float(rate)
    except OverflowError:
        value = math.inf if rate > 0 else -math.inf
    taken = min(max(value, 0.0), MOST_RATE) if value == value else 0.0
    if taken != value:
        log.warning("%s is %g; %g Hz is taken", what, value, taken)
    return taken


class Periodic(RosPlugin):
    """A plugin that works at a rate of sim time; native code leaves only those steps to Python, if any.

    Attributes:
        world: the world; `Load` sets it.
        ticks: when it works; `Load` sets it.
        lawful: whether its work is a law; `Load` sets it.
    """

    world: World
    ticks: Ticks
    lawful = False
    measuring: Connection | None = None
    connection: Connection | None = None

    def run(self) -> None:
        """Begin to work; `Load` ends with it."""
        if type(self).measure is not Periodic.measure:
            self.measuring = Events.ConnectWorldUpdateBegin(self._measure)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    @law
    def _measure(self) -> None:
        self.measure(self.world.core.clock.sim_time)

    @law
    def OnUpdate(self) -> None:
        """Work, if it is time."""
        now = self.world.core.clock.sim_time
        due = self.wanted() & self.ticks.is_due(now)
        if not self.lawful:
            if rarely(due):
                self._tick(now)
        elif not ends(due == 0.0):
            self.ticks.tick(now)
            self.work(now)

    @unrecorded
    def _tick(self, now: float) -> None:
        self.ticks.tick(now)
        self.work(now)

    @law
    def wanted(self) -> Any:
        """Whether there is something to do when it is time: a bool, or what laws have in its place."""
        return True

    @law
    def measure(self, now: Any) -> None:
        """What is done in each iteration, at sim time `now` [s]."""

    def work(self, now: float) -> None:
        """Do the work, at sim time `now` [s]."""
        raise NotImplementedError


class Publishing(Periodic):
    """A plugin whose work is to publish: steps need nothing of it while nobody listens.

    Attributes:
        publications: all that it publishes.
    """

    publications: tuple[Publication, ...] = ()

    def advertise(self, topic: str, kind: str, queue: int = 1) -> Publication:
        """Publish a topic, and work while somebody listens."""
        found = self.publish(topic, kind, queue, changed=self.match)
        self.publications = (*self.publications, found)
        return found

    def run(self) -> None:
        """Begin to work, if somebody listens."""
        self.match()

    def match(self) -> None:
        """Work while somebody listens."""
        listened = any(one.listened for one in self.publications)
        if listened and self.connection is None:
            super().run()
        elif not listened and self.connection is not None:
            self.connection.Disconnect()
            self.connection = None


def _value(sdf: Element, parameter: Parameter, version: int) -> Any:
    """The value of a parameter.

    Raises:
        ParameterError: it is missing, or no value of its type.
    """
    default = parameter.default_of(version)
    kind = default if isinstance(default, type) else type(default)
    if not sdf.HasElement(parameter.name):
        if isinstance(default, type):
            raise ParameterError(f"{sdf.where}: <plugin> has no <{parameter.name}>: {parameter.meaning}")
        return default
    text = sdf.Get(str, parameter.name).strip()
    if kind is bool:
        if text.lower() not in (*TRUE, *FALSE):
            raise ParameterError(f"{sdf.where}: <{parameter.name}> is {text!r}; it must be true or false")
        return text.lower() in TRUE
    if kind is Rate:
        return bounded_rate(
            _number(sdf, parameter.name, text), f"{sdf.child(parameter.name).where}: <{parameter.name}>"
        )
    if kind is str:
        return text
    if kind is list:
        return [part.strip() for one in sdf.named(parameter.name) for part in one.Get(str).split(",") if part.strip()]
    return sdf.Get(kind, parameter.name)


def _number(sdf: Element, name: str, text: str) -> float:
    """The number of an element.

    Raises:
        ParameterError: it is none.
    """
    return math.nan if text.lower().lstrip("+-") == "nan" else float(sdf.Get(float, name))


def noise(deviation: float) -> float:
    """A random number with a mean of 0; without a deviation above 0, 0, and no random number is used."""
    return Rand.DblNormal(0.0, deviation) if deviation > 0.0 else 0.0


def noisy(values: tuple[Any, ...], deviation: float) -> tuple[Any, ...]:
    """Numbers with noise; without a deviation above 0 they stay, and no random number is used."""
    return tuple(value + Rand.DblNormal(0.0, deviation) for value in values) if deviation > 0.0 else values


def set_point(target: Any, point: Vector3d, deviation: float = 0.0) -> None:
    """Set a Point or Vector3, with noise."""
    target.x, target.y, target.z = point
    if deviation > 0.0:
        target.x += noise(deviation)
        target.y += noise(deviation)
        target.z += noise(deviation)


def set_quaternion(target: Any, turn: Quaterniond) -> None:
    """Set a Quaternion."""
    target.w, target.x, target.y, target.z = turn


def set_pose(target: Any, pose: Pose3d) -> None:
    """Set a Pose."""
    set_point(target.position, pose.Pos())
    set_quaternion(target.orientation, pose.Rot())


def set_twist(target: Any, linear: Vector3d, angular: Vector3d, deviation: float = 0.0) -> None:
    """Set a Twist, with noise."""
    set_point(target.linear, linear, deviation)
    set_point(target.angular, angular, deviation)
